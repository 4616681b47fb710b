"""Sobol bars, indices over time, bands of quantiles, fronts and ranks show the numbers that they are made of."""

import re
from dataclasses import replace

import numpy as np
import pytest

from tests.support.sensitivity_pictures import (
    NOTE,
    bar_ends,
    indices,
    line,
    words,
)
from workbench.core.notation.formula import symbol
from workbench.report.pictures import (
    budget_curves,
    indices_over_time,
    pareto_fronts,
    quantile_bands,
    rank_figure,
    sobol_bars,
)
from workbench.study.document.document import Band, Series
from workbench.study.uncertainty import MonteCarlo, SobolDesign, quantiles, sobol


def test_sobol_bars_are_the_indices_in_the_order_of_the_largest_total():
    found = indices(lambda u: u @ [1, -4, 2])
    figure = sobol_bars("f", "", found, NOTE)
    (panel,) = figure.panels
    assert panel.ynames == ("b", "c", "a")
    first, total = panel.series
    np.testing.assert_array_equal(first.ends, found.S1.value[0, [1, 2, 0]])
    np.testing.assert_array_equal(total.low, found.ST.low[0, [1, 2, 0]])


def test_several_outputs_share_rows_and_scale_and_a_refused_one_is_named_instead_of_drawn():
    def outputs(u):
        failed = u[:, 0].copy()
        failed[3] = np.nan
        return np.column_stack([u @ [1, -4, 2], failed, u @ [5, 1, 1]])

    figure = sobol_bars("f", "", indices(outputs, names=("rmse", "tv", "effort")), NOTE)
    assert [panel.title for panel in figure.panels] == ["rmse", "effort"]
    assert len({(panel.ynames, panel.xlim) for panel in figure.panels}) == 1
    assert "'tv' is not drawn: 1 of 320 runs failed" in words(figure.caption)


@pytest.mark.parametrize(("outputs", "columns"), [(1, 1), (2, 2), (3, 3), (4, 2), (5, 3)])
def test_outputs_stand_side_by_side_without_a_straggler_where_that_can_be(outputs, columns):
    names = tuple("abcde"[:outputs])
    found = indices(lambda u: np.stack([u @ [1, -4, k] for k in range(outputs)], axis=1), names=names)
    assert sobol_bars("f", "", found, NOTE).columns == columns


def test_a_wide_interval_does_not_squeeze_the_bars():
    found = indices(lambda u: u @ [1, -4, 2])
    wide = replace(found, S1=replace(found.S1, half=np.array([[50.0, 0.01, 0.01]])))
    figure = sobol_bars("f", "", wide, NOTE)
    low, high = figure.panels[0].xlim
    assert (low, high) == pytest.approx((-0.25, 1.25), abs=0.05)
    assert "arrow" in words(figure.caption)
    assert "arrow" not in words(sobol_bars("f", "", found, NOTE).caption)


def test_a_bar_without_an_interval_is_said_to_have_none():
    found = indices(lambda u: u @ [1, -4, 2])
    without = replace(found, ST=replace(found.ST, half=np.array([[np.nan, 0.01, 0.01]])))
    assert "A bar without an interval has an unknown one." in words(sobol_bars("f", "", without, NOTE).caption)
    assert "arrow" not in words(sobol_bars("f", "", without, NOTE).caption)


def test_a_name_may_be_written_as_a_formula():
    found = indices(lambda u: u @ [1, -4, 2])
    figure = sobol_bars("f", "", found, NOTE, labels={"b": symbol("Lambda_1"), "drawn elsewhere": "x"})
    assert figure.panels[0].ynames == (symbol("Lambda_1"), "c", "a")


T = np.linspace(0.5, 4, 8)


def over_time(u):
    return np.stack([u @ np.arange(len(u.T)) + t * u[:, 0] for t in T], axis=1)


def test_indices_over_time_have_a_gap_where_an_output_is_refused():
    design = SobolDesign(3, 16)
    outputs = over_time(design.points())
    outputs[0, 3] = np.nan
    figure = indices_over_time("f", "", T, sobol(design, outputs), NOTE)
    assert "No indices at 1 of 8 times, the first of them 2 s: 1 of 80 runs failed" in words(figure.caption)
    for panel in figure.panels:
        curve = line(panel, "x1")
        assert np.isnan(curve).tolist() == [k == 3 for k in range(8)]
        assert all(2.0 not in band.x for band in panel.series if isinstance(band, Band))


def test_a_wide_interval_over_time_does_not_squeeze_the_curves():
    design = SobolDesign(3, 16)
    found = sobol(design, over_time(design.points()))
    wide = replace(
        found, S1=replace(found.S1, half=np.inf + found.S1.half), ST=replace(found.ST, half=0 * found.ST.half)
    )
    figure = indices_over_time("f", "", T, wide, NOTE)
    limits = figure.panels[0].ylim
    assert -0.25 <= limits[0] < limits[1] <= 1.25
    assert {(*band.low, *band.high) for band in figure.panels[0].series if isinstance(band, Band)} == {
        (limits[0],) * 8 + (limits[1],) * 8
    }
    assert "goes on beyond the axes" in words(figure.caption)
    narrow = replace(wide, S1=replace(found.S1, half=0 * found.S1.half))
    assert "beyond" not in words(indices_over_time("f", "", T, narrow, NOTE).caption)


def test_of_many_factors_seven_are_drawn_and_the_others_bounded():
    design = SobolDesign(9, 16)
    figure = indices_over_time("f", "", T, sobol(design, over_time(design.points())), NOTE)
    assert len([mark for mark in figure.panels[1].series if isinstance(mark, Series)]) == 7
    assert {mark.style for mark in figure.panels[1].series if isinstance(mark, Band)} == {0, 1, 2}
    assert "Intervals are drawn only for the three factors" in words(figure.caption)
    (said,) = re.findall(r"The ST of the 2 factors that are not drawn is at most ([\d.]+)\.", words(figure.caption))
    largest = sobol(design, over_time(design.points())).ST.value.max(axis=0)
    assert np.sort(largest)[1] <= float(said) <= 1.1 * np.sort(largest)[1]


def test_times_are_as_many_as_outputs():
    with pytest.raises(ValueError, match=r"`indices_over_time\(t\)` must be the finite time of each of the 1 outputs"):
        indices_over_time("f", "", T, indices(lambda u: u[:, 0]), NOTE)


def banded(shift=0.0, failed=None, levels=(0.05, 0.5, 0.95)):
    design = MonteCarlo(1, 200)
    outputs = shift + np.stack([t * design.points()[:, 0] for t in T], axis=1)
    if failed is not None:
        outputs[0, failed:] = np.nan
    return quantiles(design, outputs, levels=levels)


def test_bands_lie_between_the_outer_levels_and_the_line_at_the_middle_one():
    one = banded()
    (panel,) = quantile_bands("f", "", T, {"PID": one}, NOTE, "e [rad]").panels
    curve, band = panel.series
    np.testing.assert_array_equal(curve.y, one.value[:, 1])
    np.testing.assert_array_equal((band.low, band.high), one.value.T[[0, 2]])


def test_from_the_first_failed_run_on_there_is_no_band_and_the_caption_says_so():
    figure = quantile_bands("f", "", T, {"PID": banded(), "SMC": banded(1, failed=5)}, NOTE, "e [rad]")
    bands = [mark for mark in figure.panels[0].series if isinstance(mark, Band)]
    assert [len(band.x) for band in bands] == [8, 5]
    assert "SMC has no quantiles from 3 s on (failed runs: 1)." in words(figure.caption)


def test_more_than_three_laws_have_panels_on_one_scale():
    figure = quantile_bands("f", "", T, {f"law {k}": banded(k) for k in range(4)}, NOTE, "e [rad]")
    assert [panel.title for panel in figure.panels] == [f"law {k}" for k in range(4)]
    assert len({panel.ylim for panel in figure.panels}) == 1


def test_quantiles_over_decades_have_a_logarithmic_axis():
    def scales(laws, shift):
        design = MonteCarlo(1, 200)
        outputs = shift + np.exp(-np.outer(design.points()[:, 0] + 1, T) * 2)
        bands = {f"law {k}": quantiles(design, outputs) for k in range(laws)}
        return {panel.yscale for panel in quantile_bands("f", "", T, bands, NOTE, "e [rad]").panels}

    assert (scales(1, 0.0), scales(5, 0.0)) == ({"log"}, {"log"})
    assert (scales(1, -0.1), scales(5, 0.1)) == ({"linear"}, {"linear"})


def test_bands_of_unlike_levels_are_not_compared():
    with pytest.raises(ValueError, match="all with the same levels and times"):
        quantile_bands("f", "", T, {"a": banded(), "b": banded(levels=(0.1, 0.9))}, NOTE, "e")


def test_a_front_is_what_no_other_point_dominates():
    points = np.array([[1, 5], [2, 3], [2, 4], [3, 3], [4, 1], [np.nan, 0], [0.5, np.inf]])
    figure = pareto_fronts("f", "", {"PID": points}, NOTE, "x", "y")
    steps, marks = figure.panels[0].series
    assert np.column_stack([steps.x, steps.y]).tolist() == [[1, 5], [2, 3], [4, 1]]
    assert (steps.look, marks.look, marks.label) == ("steps", "marks", "")
    assert "PID: 2 of 7 points have no numbers and are not drawn." in words(figure.caption)


def test_of_a_long_front_some_points_are_marked_its_ends_among_them():
    x = np.linspace(1, 2, 100)
    figure = pareto_fronts("f", "", {"PID": np.stack([x, 1 / x], axis=1)}, NOTE, "x", "y")
    steps, marks = figure.panels[0].series
    assert (len(steps.x), len(marks.x)) == (100, 15)
    assert (marks.x[0], marks.x[-1]) == (1, 2)
    assert "At most 15 points of each front are marked." in words(figure.caption)


def test_fronts_over_decades_have_logarithmic_axes():
    (panel,) = pareto_fronts("f", "", {"PID": [[1e-3, 2], [1, 1]]}, NOTE, "x", "y").panels
    assert (panel.xscale, panel.yscale) == ("log", "linear")
    (panel,) = pareto_fronts("f", "", {"PID": [[-1e-3, 2], [1, 1]]}, NOTE, "x", "y").panels
    assert panel.xscale == "linear"


def test_a_budget_curve_is_the_median_between_the_best_and_the_worst_search():
    best = np.array([[np.inf, 5, 1], [4, 3, 2], [9, 4, 3]])
    (panel,) = budget_curves("f", "", {"PID": ([10, 20, 30], best)}, NOTE, "objective").panels
    curve, band = panel.series
    assert np.asarray(curve.y).tolist() == [9, 4, 2]
    # nothing bounds the first stretch, as a search has found nothing yet; the band is held like its line
    assert np.column_stack([band.x, band.low, band.high]).tolist() == [[20, 3, 5], [30, 3, 5], [30, 1, 3]]


def test_a_single_search_has_no_band():
    figure = budget_curves("f", "", {"PID": ([10, 20], [np.nan, 2.0])}, NOTE, "objective")
    (curve,) = figure.panels[0].series
    assert np.isnan(curve.y).tolist() == [True, False]
    assert "medians" not in words(figure.caption)


MANY = ("AOSMC-RGS", "PID", "SMC", "RISE")


def test_more_than_three_budget_curves_have_a_panel_each_between_the_least_cost_and_four_times_that():
    curves = {law: ([10, 20, 30], np.array([[40.0, 5.0 + k, 2.0 + k]])) for k, law in enumerate(MANY)}
    figure = budget_curves("f", "", curves, NOTE, "objective")
    assert [panel.title for panel in figure.panels] == list(MANY)
    assert {panel.hlines for panel in figure.panels} == {(2.0,)}
    assert {panel.ylim[1] for panel in figure.panels} == {8.0}
    assert len({(panel.xlim, panel.ylim, panel.yscale) for panel in figure.panels}) == 1
    said = "The thin line is the least value of all laws, 2; values above 4 times that are cut off."
    assert said in words(figure.caption)
    near = {law: ([10, 20], np.array([3.0, 2.0])) for law in MANY}
    figure = budget_curves("f", "", near, NOTE, "objective")
    assert figure.panels[0].ylim[1] > 3.0
    assert "cut off" not in words(figure.caption)


def test_more_than_three_fronts_have_a_panel_each_before_the_front_of_all_laws():
    fronts = {law: [[1.0 + k, 4.0 - k], [9.0, 0.5 + k]] for k, law in enumerate(MANY)}
    figure = pareto_fronts("f", "", fronts, NOTE, "x", "y")
    assert [panel.title for panel in figure.panels] == list(MANY)
    for panel in figure.panels:
        behind = panel.series[-1]
        assert behind.style == "reference"
        # that of all eight points: (1, 4), (2, 3), (3, 2), (4, 1) and (9, 0.5), as no other is below in both
        assert np.column_stack([behind.x, behind.y]).tolist() == [[1, 4], [2, 3], [3, 2], [4, 1], [9, 0.5]]
    assert len({(panel.xlim, panel.ylim) for panel in figure.panels}) == 1


def test_ranks_are_stacked_to_one_the_least_mean_rank_on_top():
    ranks = {"PID": [0.0, 0.25, 0.75], "SMC": [0.6, 0.4, 0.0], "ASMC": [0.4, 0.35, 0.25]}
    (panel,) = rank_figure("f", "", ranks, NOTE).panels
    assert panel.ynames == ("SMC", "ASMC", "PID")
    np.testing.assert_allclose(bar_ends(panel)[-1], 1)
    first, second, _ = panel.series
    np.testing.assert_array_equal(second.starts, first.ends)
    assert first.texts == ("60 %", "40 %", "0 %")
    assert first.shade > second.shade


EIGHT = quantiles(MonteCarlo(1, 20), np.outer(np.arange(20.0), T))
WRONG = {
    "no ranks": (lambda: rank_figure("f", "", {}, NOTE), "each law's ranks; got {}"),
    "a sum below one": (lambda: rank_figure("f", "", {"a": [0.5, 0.4], "b": [0.5, 0.5]}, NOTE), "add up to 1"),
    "a NaN": (lambda: rank_figure("f", "", {"a": [np.nan, 1.0], "b": [1.0, 0.0]}, NOTE), "add up to 1"),
    "no fronts": (lambda: pareto_fronts("f", "", {}, NOTE, "x", "y"), "two finite numbers"),
    "three measures": (lambda: pareto_fronts("f", "", {"a": [[1, 2, 3]]}, NOTE, "x", "y"), r"an array \(B, 2\)"),
    "no point": (lambda: pareto_fronts("f", "", {"a": [[np.nan, 1]]}, NOTE, "x", "y"), "two finite numbers"),
    "a curve of words": (lambda: budget_curves("f", "", {"a": (["x"], [1.0])}, NOTE, "y"), r"\['x'\] at \['a'\]\[0\]"),
    "a curve alone": (lambda: budget_curves("f", "", {"a": [1.0]}, NOTE, "y"), r"got 1 of them at \['a'\]"),
    "unlike lengths": (
        lambda: budget_curves("f", "", {"a": ([1, 2], [1.0])}, NOTE, "y"),
        "the best so far",
    ),
    "an endless time": (lambda: quantile_bands("f", "", T * np.inf, {"a": EIGHT}, NOTE, "y"), "finite time of each"),
    "nothing found": (lambda: budget_curves("f", "", {"a": ([1], [np.inf])}, NOTE, "y"), "something admissible"),
    "no bands": (lambda: quantile_bands("f", "", T, {}, NOTE, "y"), "a law or more"),
    "no quantiles": (lambda: quantile_bands("f", "", T, {"a": 1}, NOTE, "y"), "Quantiles"),
}


@pytest.mark.parametrize(("drawn", "why"), WRONG.values(), ids=WRONG.keys())
def test_what_is_no_such_result_is_refused_in_a_sentence(drawn, why):
    with pytest.raises(ValueError, match=why):
        drawn()
