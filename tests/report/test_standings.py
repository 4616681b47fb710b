"""Standings: laws by scenarios, each tile with its statistic, and who is best, tied or failed."""

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from tests.support.drawn_pictures import told
from tests.support.sensitivity_pictures import words
from workbench.report.figures.boxes import ink_over, tone
from workbench.report.figures.figure_sheet import draw
from workbench.report.figures.rulers import size_of
from workbench.report.pictures import standings_figure
from workbench.report.pictures.standings_pictures import BEYOND
from workbench.study.evidence import Mean, Median, Quantile, Success, Tail, compare, judge, pair_samples

RNG = np.random.default_rng(0)
MEDIAN = Median()
NOISE = RNG.normal(size=60)


def comparison(failed=0, estimand=MEDIAN, **middles):
    """Laws whose values lie about their middles, the last with so many failed runs."""
    values = {law: middle + 0.05 * NOISE * (k + 1) for k, (law, middle) in enumerate(middles.items())}
    values[list(middles)[-1]][:failed] = np.nan
    return compare(pair_samples(values, metric="cost", unit="rad"), estimand, resamples=200)


def tiles(figure, panel=0):
    return figure.panels[panel].series[0]


def test_the_best_is_framed_a_tie_is_marked_and_a_failed_law_is_hatched():
    apart, level = comparison(PID=1.0, SMC=2.0, ASMC=3.0), comparison(40, PID=1.0, SMC=1.0, ASMC=9.0)
    figure = standings_figure("f", "c", {"s": {"median": apart}, "hard": {"median": level}}, "median")
    held = tiles(figure)
    assert held.has_frame.tolist() == [[True, False], [False, False], [False, False]]
    assert held.has_mark.tolist() == [[False, True], [False, True], [False, False]]
    assert held.has_hatch.tolist() == [[False, False], [False, False], [False, True]]
    assert held.texts[2][1] == ("–", "40 failed")
    assert np.isnan(held.shades[2, 1])
    assert [key.label for key in held.keys][1:] == [
        *("significantly better than all others", "tied with the best", "some or all runs failed"),
    ]


def test_a_law_with_some_failed_runs_shows_its_level_and_how_many():
    held = tiles(standings_figure("f", "c", {"s": {"median": comparison(3, PID=1.0, SMC=2.0)}}, "median"))
    level, interval, failed = held.texts[1][0]
    assert float(level) == pytest.approx(2.0, abs=0.05)
    assert float(interval.split("–")[0]) < float(level) < float(interval.split("–")[1])
    assert failed == "3 failed"
    assert held.has_hatch[1, 0]


def test_darkness_is_the_logarithm_of_the_ratio_to_the_best_of_the_column():
    one = comparison(PID=1.0, SMC=2.0, ASMC=50.0)
    shades = tiles(standings_figure("f", "c", {"s": {"median": one}}, "median")).shades[:, 0]
    ratio = one.level.value[1] / one.level.value[0]
    np.testing.assert_allclose(shades, [0, np.log(ratio) / np.log(BEYOND), 1])


def test_of_successes_which_are_shown_in_percent_the_largest_is_the_lightest():
    values = {"PID": np.arange(60.0), "SMC": np.arange(60.0) - 30, "ASMC": np.arange(60.0) + 90}
    one = compare(pair_samples(values, metric="cost"), Success(29.5), resamples=200)
    held = tiles(standings_figure("f", "c", {"s": {"success": one}}, "success"))
    assert [text[0] for (text,) in held.texts] == ["50.0", "100", "0"]
    low, high = map(float, held.texts[0][0][1].split("–"))
    assert 30 < low < 50 < high < 70
    np.testing.assert_allclose(held.shades[:, 0], [np.log(2) / np.log(BEYOND), 0, 1])
    assert held.has_frame[:, 0].tolist() == [False, True, False]


def test_the_statistic_that_was_asked_for_leads_and_it_alone_has_intervals():
    both = {"mean": comparison(estimand=Mean(), PID=1.0, SMC=2.0), "median": comparison(PID=1.0, SMC=2.0)}
    figure = standings_figure("f", "c", {"s": both}, "median")
    assert [str(panel.title).split(",")[0] for panel in figure.panels] == ["median", "mean"]
    assert [tiles(figure, k).lines for k in range(2)] == [2, 1]
    assert figure.lead
    assert "60 draws" in words(figure.caption)


def test_a_statistic_that_is_not_drawn_stays_among_the_numbers():
    both = {"mean": comparison(estimand=Mean(), PID=1.0, SMC=2.0), "median": comparison(PID=1.0, SMC=2.0)}
    figure = standings_figure("f", "c", {"s": both}, "median", ())
    assert len(figure.panels) == 1
    assert {row[0] for row in figure.numbers.rows} == {"mean", "median"}
    with pytest.raises(LookupError, match="'mode'.*statistics"):
        standings_figure("f", "c", {"s": both}, "median", ("mode",))


def test_each_panel_has_the_names_of_its_columns(monkeypatch):
    """Five panels in three rows: a reader of one needs no other."""
    found = [word for word, _ in told(full(), monkeypatch)]
    assert found.count("payload") == 5


def test_the_numbers_of_the_figure_are_all_levels_with_their_intervals():
    one = comparison(3, PID=1.0, SMC=2.0)
    first, second = standings_figure("f", "c", {"s": {"median": one}}, "median").numbers.rows
    level = one.level
    assert first == (
        "median",
        "s",
        "PID",
        level.value[0],
        level.low[0],
        level.high[0],
        "best",
        0,
        None,
    )  # a comparison without its samples has no source
    assert second[-3:] == ("beaten", 3, None)


def test_scenarios_with_other_laws_or_statistics_are_refused():
    one, other = comparison(PID=1.0, SMC=2.0), comparison(PID=1.0, ASMC=2.0)
    for odd in ({"median": other}, {"mean": one}, {}):
        with pytest.raises(ValueError, match="the same laws by the same statistics"):
            standings_figure("f", "c", {"a": {"median": one}, "b": odd}, "median")
    with pytest.raises(LookupError, match="'mode'.*statistics"):
        standings_figure("f", "c", {"a": {"median": one}}, "mode")
    with pytest.raises(ValueError, match="must not be negative; the least is -0.99"):
        standings_figure("f", "c", {"a": {"median": comparison(PID=-1.0, SMC=2.0)}}, "median")


def full():
    """As large as a page has the room for: 12 laws, 10 scenarios, 5 statistics, failures, ties and long names."""
    laws = ("AOSMC-RGS", "nonsingular terminal", "computed torque + DO", *(f"law {k}" for k in range(9)))
    names = ("paper", "payload", "coarse encoder", "torque limit", *(f"scenario {k}" for k in range(6)))
    found = {}
    for k, name in enumerate(names):
        middles = {law: 1.0 + (k + i) % 12 * (1 + 20 * (k == 3)) for i, law in enumerate(laws)}
        values = {law: middle + 0.05 * NOISE for law, middle in middles.items()}
        values[laws[-1]][: 40 * (k % 2)] = np.nan
        asked = (Mean(), Quantile(0.8), Tail(0.8), Success(5.0))
        found[name] = judge(pair_samples(values, metric="cost"), MEDIAN, asked, resamples=100).by
    return standings_figure("f", "Cost.", found, "median")


@pytest.mark.heavy
def test_twelve_laws_in_ten_scenarios_fit_a_page_and_no_words_overlap(monkeypatch):
    figure = full()
    width, height = (72 * inches for inches in size_of(figure))
    assert height <= 72 * 7.6
    found = told(figure, monkeypatch)
    assert len(found) > 5 * 120
    for _, (left, bottom, right, top) in found:
        assert 0 <= left < right <= width
        assert 0 <= bottom < top <= height
    boxes = np.array([box for _, box in found])
    for k, (left, bottom, right, top) in enumerate(boxes):
        l2, b2, r2, t2 = boxes[:k].T
        clear = (np.minimum(right, r2) <= np.maximum(left, l2)) | (np.minimum(top, t2) <= np.maximum(bottom, b2))
        assert clear.all(), [found[k][0], *(found[j][0] for j in np.flatnonzero(~clear))]


def test_the_same_standings_give_the_same_bytes():
    few = [standings_figure("f", "c", {"s": {"median": comparison(PID=1.0, SMC=2.0)}}, "median") for _ in range(2)]
    assert draw(few[0]) == draw(few[1])


def lightness(color):
    parts = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in to_rgb(color)]
    return float(np.dot(parts, (0.2126, 0.7152, 0.0722)))


def test_equal_steps_of_a_shade_are_equal_steps_of_lightness_so_that_grey_prints_keep_them():
    """CIELAB's L* of the luminance; a colour has 256 steps, so L* is known to about 0.5."""
    steps = [116 * np.cbrt(lightness(tone(shade))) - 16 for shade in np.linspace(0, 1, 8)]
    np.testing.assert_allclose(np.diff(steps), -10, atol=0.6)


def test_letters_stand_out_from_their_tiles():
    """By WCAG's contrast, which asks 4.5 of small letters."""
    for shade in np.linspace(0, 1, 41):
        low, high = sorted((lightness(tone(shade)), lightness(ink_over(shade))))
        assert (high + 0.05) / (low + 0.05) >= 4.4  # the two inks change places at L* of 50, where both have 4.5
