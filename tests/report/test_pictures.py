"""Pictures as data: what they show are the numbers that were found, and what they say of them."""

from dataclasses import replace

import numpy as np
import pytest

from tests.support.sensitivity_pictures import (
    NOTE,
    made,
    morris_effects,
    points_of,
    tornado_of,
    words,
)
from workbench.report.pictures import (
    morris_plane,
    tornado_figure,
)
from workbench.report.table_text import to_csv


@pytest.mark.parametrize("kind", made(NOTE), ids=lambda kind: kind)
def test_every_caption_ends_with_the_note(kind):
    assert words(made(NOTE)[kind]().caption).endswith(f"{NOTE}.")


@pytest.mark.parametrize("empty", ["", " ", ()])
@pytest.mark.parametrize("kind", made(NOTE), ids=lambda kind: kind)
def test_a_figure_that_does_not_say_its_runs_is_refused(kind, empty):
    with pytest.raises(ValueError, match=r"note=\.\.\.\)` must say how many runs"):
        made(empty)[kind]()


@pytest.mark.parametrize("kind", made(NOTE), ids=lambda kind: kind)
def test_every_figure_has_its_numbers_for_a_file(kind):
    figure = made(NOTE)[kind]()
    _, *rows = to_csv(figure.numbers).split("\r\n")[:-1]
    assert len(rows) > 0
    assert "nan" not in "".join(rows)


def test_a_tornado_has_its_widest_bar_on_top_and_both_ends_about_the_base():
    figure = tornado_figure("f", "", tornado_of(lambda u: 3 + u @ [1, -4, 2]), NOTE, "rad")
    (panel,) = figure.panels
    assert panel.ynames == ("b", "c", "a")
    low, high = panel.series
    base = 3 + 0.5 * (1 - 4 + 2)
    np.testing.assert_allclose(low.starts, base)
    # levels of 5 % and 95 %: 0.45 of each slope to either side
    np.testing.assert_allclose(low.ends - base, [1.8, -0.9, -0.45])
    np.testing.assert_allclose(high.ends - base, [-1.8, 0.9, 0.45])
    assert panel.vlines == pytest.approx((base,))
    assert panel.xlabel == ("y", " [rad]")


def test_both_levels_of_a_factor_are_seen_on_the_same_side_of_the_base():
    (panel,) = tornado_figure("f", "", tornado_of(lambda u: (u[:, 0] - 0.5) ** 2), NOTE).panels
    low, high = panel.series
    assert low.ends[0] == pytest.approx(high.ends[0])
    gap = np.asarray(high.places) - np.asarray(low.places)
    assert (gap >= low.thick / 2 + high.thick / 2 - 1e-12).all()


def test_one_level_alone_has_one_bar():
    assert len(tornado_figure("f", "", tornado_of(lambda u: u[:, 0], levels=(0.9,)), NOTE).panels[0].series) == 1


def test_the_ends_of_a_range_are_called_so():
    panel = tornado_figure("f", "", tornado_of(lambda u: u[:, 0], levels=(1.0, 0.0)), NOTE).panels[0]
    assert [mark.label for mark in panel.series] == ["at the low end of its range", "at the high end of its range"]


def test_the_plane_of_morris_has_each_factor_at_its_mu_star_and_sigma():
    effects = morris_effects(lambda u: u @ [1, -4, 2] + 5 * u[:, 0] * u[:, 1])
    points, diagonal = morris_plane("f", "", effects, NOTE).panels[0].series
    np.testing.assert_array_equal(points.x, effects.mu_star.value[0])
    np.testing.assert_array_equal(points.y, effects.sigma.value[0])
    np.testing.assert_array_equal(points.xhigh, effects.mu_star.high[0])
    assert (np.asarray(points.xlow) >= 0).all()
    np.testing.assert_array_equal(diagonal.x, diagonal.y)


def test_an_interval_that_nothing_bounds_is_said_to_go_on():
    effects = morris_effects(lambda u: u @ [1, -4, 2] + 5 * u[:, 0] * u[:, 1], trajectories=2)
    assert np.isinf(effects.sigma.half).any()
    figure = morris_plane("f", "", effects, NOTE)
    assert "An interval with an arrow goes on beyond the axes." in words(figure.caption)
    assert all(np.isfinite(figure.panels[0].xlim + figure.panels[0].ylim))
    assert "arrow" not in words(morris_plane("f", "", morris_effects(lambda u: u @ [1, -4, 2]), NOTE).caption)


def test_many_long_names_become_numbers_by_falling_mu_star_with_a_key():
    names = tuple(f"controller.model.links[{k}].centre_of_mass" for k in range(8))
    effects = morris_effects(lambda u: u @ np.arange(1.0, 9), factors=names)
    figure = morris_plane("f", "", effects, NOTE)
    assert points_of(figure).names == tuple("87654321")
    assert f"In the order of falling mu_star: {names[7]} (1); {names[6]} (2)" in words(figure.caption)
    short = replace(effects, factors=tuple("abcdefgh"))
    assert points_of(morris_plane("f", "", short, NOTE)).names == tuple("abcdefgh")


def test_factors_that_crowd_next_to_zero_are_named_in_the_caption():
    factors = ("a", "b", "c", "d")
    effects = morris_effects(lambda u: u @ [0, 5, 1e-9, 3], factors=factors)
    figure = morris_plane("f", "", effects, NOTE)
    assert points_of(figure).names == ("", "b", "", "d")
    assert "Factors near 0: a, c." in words(figure.caption)
    apart = morris_plane("f", "", morris_effects(lambda u: u @ [2, 5, 1e-9, 3], factors=factors), NOTE)
    assert points_of(apart).names == factors


def test_two_factors_far_beyond_all_others_make_the_plane_logarithmic_and_said_so():
    factors = tuple("abcdefg")

    def outliers(u):
        return u @ [100, 80, 1, 2, 1, 2, 1e-9] + 50 * u[:, 0] * u[:, 1] + u[:, 2] * u[:, 3] + u[:, 4] * u[:, 5]

    figure = morris_plane("f", "", morris_effects(outliers, factors), NOTE)
    (panel,) = figure.panels
    assert (panel.xscale, panel.yscale) == ("log", "log")
    assert "Both axes are logarithmic" in words(figure.caption)
    assert "Factors below 0.001 of the largest number: g." in words(figure.caption)
    # those that are not the two outliers have room of their own: more than a tenth of the axis from its end
    x = np.asarray(points_of(figure).x)[2:6]
    share = np.log(x / panel.xlim[0]) / np.log(panel.xlim[1] / panel.xlim[0])
    assert ((share > 0.1) & (share < 0.9)).all()
    alike = morris_plane("f", "", morris_effects(lambda u: u @ [1, -4, 2]), NOTE)
    assert alike.panels[0].xscale == "linear"
