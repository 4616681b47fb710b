import re
from itertools import pairwise

import matplotlib
import numpy as np
import pytest
from scipy import stats

from workbench.core.notation.formula import Matrix, Number, symbol
from workbench.report.figures.curves import crop_curves, thin_curves, thin_dots
from workbench.report.figures.figure_sheet import draw
from workbench.report.figures.pen import Pen
from workbench.report.figures.rulers import Ruler
from workbench.report.figures.style import LINES
from workbench.study.document.document import Band, Figure, Panel, Series

T = np.linspace(0, 10, 20_001)


def figure(*series, name="torque", **panel):
    panel = {"ylabel": (symbol("tau_1"), " [N m]")} | panel
    return Figure(name, "Torque.", (Panel(series=series or (Series("PID", T, np.sin(T)),), **panel),))


def chatter(t):
    return np.sin(t) + np.sign(np.sin(2 * np.pi * 400 * t + 0.3))


def test_dots_scatter_as_the_points_do_of_which_they_are_some():
    x, logs = np.arange(20_000.0), [np.random.default_rng(seed).standard_normal(20_000) for seed in range(40)]
    drawn = [thin_dots((x, y), 600) for y in logs]
    assert all(590 <= len(some) <= 602 for _, some in drawn)
    assert all({y.min(), y.max()} <= {*some} for y, (_, some) in zip(logs, drawn, strict=True))
    p_values = [stats.kstest(some, "norm").pvalue for _, some in drawn]
    assert stats.kstest(p_values, "uniform").pvalue > 1e-3  # as those of normal numbers are
    extremes = thin_curves((x, logs[0]), 600)[1]
    assert stats.kstest(extremes, "norm").pvalue < 1e-9  # a hole about zero


def test_the_dots_of_a_sine_are_its_own_at_any_period():
    t = np.arange(12_000.0)
    for period in (20.0, 40.0, 7.3):
        _, some = thin_dots((t, np.sin(2 * np.pi * t / period)), 600)
        assert abs(np.std(some) - np.sqrt(0.5)) < 0.05  # evenly spaced points would show a straight line


def test_the_same_figure_gives_the_same_bytes():
    assert draw(figure()) == draw(figure())


def test_a_machines_own_settings_of_matplotlib_do_not_matter():
    plain = draw(figure())
    with matplotlib.rc_context({"lines.linewidth": 9, "axes.facecolor": "red", "svg.fonttype": "none"}):
        assert draw(figure()) == plain
        assert matplotlib.rcParams["lines.linewidth"] == 9


def test_ids_begin_with_the_name_so_that_figures_share_a_page():
    svg = draw(figure(name="first"))
    ids = re.findall(r'\bid="([^"]*)"', svg)
    links = re.findall(r'href="#([^"]*)"', svg) + re.findall(r"url\(#([^)]*)\)", svg)
    assert ids
    assert all(i.startswith("first-") for i in ids)
    assert len(set(ids)) == len(ids)
    assert set(links) <= set(ids)


def test_nothing_is_fetched_dated_or_scripted():
    svg = draw(figure())
    assert "<metadata" not in svg
    assert "<script" not in svg
    assert not re.search(r'(href|src)="(?!#)', svg)
    assert not re.search(r"20\d\d-\d\d-\d\d", svg)


def test_a_figure_of_six_chattering_laws_is_small():
    laws = tuple(Series(f"law {k}", T, (k + 1) * chatter(T), k) for k in range(6))
    assert len(draw(figure(*laws))) < 120_000


def test_thinning_keeps_the_envelope_of_a_chattering_signal():
    t, y = thin_curves((T, chatter(T)), 600)
    assert len(t) <= 602
    assert set(zip(t, y, strict=True)) <= set(zip(T, chatter(T), strict=True))
    for cut in np.array_split(np.arange(T.size), 100):
        here = y[(t >= T[cut[0]]) & (t <= T[cut[-1]])]
        assert here.max() == pytest.approx(chatter(T)[cut].max(), abs=0.05)
        assert here.min() == pytest.approx(chatter(T)[cut].min(), abs=0.05)


def test_thinning_keeps_ends_gaps_and_extremes_of_a_phase_curve():
    circle = np.cos(T), np.sin(T)
    x, y = thin_curves(circle, 600)
    assert (x[0], y[0], x[-1], y[-1]) == (circle[0][0], circle[1][0], circle[0][-1], circle[1][-1])
    assert x.min() == circle[0].min()
    holed = np.where((T > 4) & (T < 6), np.nan, np.sin(T))
    t, y = thin_curves((T, holed), 600)
    assert np.isnan(y[(t > 4.1) & (t < 5.9)]).all()
    assert not np.isnan(y[(t < 3.9) | (t > 6.1)]).any()


def test_a_close_view_spends_its_points_on_what_it_shows():
    t, _ = crop_curves((T, chatter(T)), (2.00025, 2.10025))
    assert (t[0], t[-1]) == pytest.approx((2.0, 2.1005))
    assert len(t) == 202


@pytest.mark.parametrize("limits", [(-5.0, -1.0), (20.0, 30.0), (-1.0, 11.0), None])
def test_a_window_beside_the_data_is_no_error(limits):
    assert len(crop_curves((T, T), limits)[0]) >= 1


def test_dollars_in_a_label_are_dollars(monkeypatch):
    words = words_of(
        figure(Series("costs $5 or $6", T, T), ylabel="50 % of $x_1$ [a^b]", title=r"\frac{1}"), monkeypatch
    )
    texts = {given[0] for given in words}
    assert texts >= {r"costs \$5 or \$6", r"50 % of \$x_1\$ [a^b]", r"\frac{1}"}


def test_a_formula_that_matplotlib_cannot_set_is_written_out(monkeypatch):
    words = words_of(figure(ylabel=Matrix(((Number(1.0), Number(2.0)),))), monkeypatch)
    assert any("1" in given[0] and "2" in given[0] and "$" not in given[0] for given in words)


def words_of(figure, monkeypatch):
    """Each piece of text with its place and its size, as the pen is told to write it."""
    told = []
    monkeypatch.setattr(Pen, "words", lambda pen, *given, upwards=False: told.append((*given, upwards)))
    draw(figure)
    return [given for given in told if given[0]]


def test_numbers_have_true_minus_signs_and_share_a_power_of_ten(monkeypatch):
    texts = [given[0] for given in words_of(figure(Series("a", T, 2e5 * np.sin(T))), monkeypatch)]
    assert {"−2", "−1", "0", "1", "2"} <= set(texts)
    assert any("10^{5}" in text for text in texts)


def test_a_short_logarithmic_ruler_has_numbers_between_the_powers_of_ten():
    assert Ruler("log", 3.0, 5.0).ticks(9).numbers == ("3", "4", "5")
    assert set(Ruler("log", 0.2, 3.0).ticks(9).numbers) >= {"0.2", "1", "2"}
    assert "10" in Ruler("log", 3e-7, 5e-7).ticks(9).numbers[0]
    decades = Ruler("log", 1e-4, 1.0).ticks(9)
    assert decades.places == pytest.approx((1e-4, 1e-3, 1e-2, 1e-1, 1))
    assert len(decades.minor) == 4 * 8


def test_a_law_looks_the_same_alone_and_among_others():
    def colours(series):
        return set(re.findall(r"stroke: (#\w{6})", draw(figure(*series))))

    laws = tuple(Series(f"law {k}", T, T + k, k) for k in range(12))
    assert colours(laws) >= {LINES[k]["color"].lower() for k in range(12)} - {"#000000"}
    assert colours(laws[3:4]) & {LINES[k]["color"].lower() for k in range(12)} == {LINES[3]["color"].lower(), "#000000"}


def test_each_style_has_a_colour_and_a_dash_or_a_width_of_its_own():
    assert len({LINES[k]["color"] for k in range(12)}) == 12
    assert len({(str(LINES[k]["linestyle"]), LINES[k]["linewidth"]) for k in range(12)}) == 12


def test_the_legend_is_above_all_panels_and_names_each_law_once(monkeypatch):
    series = (Series("PID", T, T, 0), Series("SMC", T, T, 1), Band("10 % to 90 %", T, T, T + 1, 1))
    words = words_of(Figure("two", "", (Panel("a", series), Panel("b", series))), monkeypatch)
    assert [given[0] for given in words[:3]] == ["PID", "SMC", "10 % to 90 %"]
    assert [given[0] for given in words].count("PID") == 1
    assert min(given[2] for given in words[:3]) > max(given[2] for given in words[3:])


def test_what_a_panel_is_titled_needs_no_legend(monkeypatch):
    panels = tuple(Panel("a", (Series(law, T, T, k),), title=law) for k, law in enumerate(("PID", "SMC")))
    texts = [given[0] for given in words_of(Figure("two", "", panels, columns=2), monkeypatch)]
    assert "PID" not in texts
    assert "(a) PID" in texts


@pytest.mark.parametrize(
    ("series", "more", "spans"),
    [
        (Series("a", T, np.sin(T)), {"xlim": (2, 3), "ylim": (-5, 5)}, [(2, 3), (-5, 5)]),
        (Series("a", T, T), {"hlines": (30,), "vlines": (-10,)}, [(-10, 10), (-1.5, 31.5)]),
        (Series("a", T + 1, np.exp(T)), {"xscale": "log"}, [(1, 11), (1 - 1101.2732897, 22026.4657948 + 1101.2732897)]),
        (Series("a", T, T, look="marks"), {}, [(-0.5, 10.5), (-0.5, 10.5)]),
        (Series("a", T, T * 0 + 2), {}, [(0, 10), (1.89, 2.11)]),
    ],
)
def test_a_drawn_panel_spans_its_limits_or_all_that_it_shows_with_a_margin(series, more, spans, monkeypatch):
    found = []
    around = Ruler.around
    monkeypatch.setattr(Ruler, "around", lambda *given, **named: found.append(around(*given, **named)) or found[-1])
    draw(figure(series, **more))
    assert [(ruler.low, ruler.high) for ruler in found] == [pytest.approx(span, rel=1e-6) for span in spans]


@pytest.mark.parametrize("columns", [1, 2, 3])
def test_no_word_leaves_the_sheet_and_the_abscissa_is_named_below_the_last_row_alone(columns, monkeypatch):
    laws = tuple(Series(f"a law of many words, the {k}th", T, 1e-3 * T * (k - 3), k) for k in range(8))
    panels = tuple(Panel("a long name [N m]", laws, title="a panel") for _ in range(6))
    words = words_of(Figure("many", "", panels, columns=columns), monkeypatch)
    width, height = 6.3 * 72, 72 * ({1: 2.4, 2: 2.0, 3: 1.8}[columns] * 0.86 * (6 // columns) + 0.35)
    assert all(0 < x < width and 0 < y < height for _, x, y, *_ in words)
    assert sum(given[0] == "time [s]" for given in words) == columns


def test_a_gap_stays_a_gap_and_a_held_value_makes_steps():
    def path(**look):
        series = Series("a", [0.0, 1.0, 2.0, 3.0, 4.0, 5.0], [0.0, 1.0, np.nan, 1.0, 2.0, 2.0], **look)
        (drawn,) = re.findall(r'<path d="([^"]*)" clip-path', draw(figure(series)))
        return drawn

    assert path().count("M") == 2
    steps = [tuple(map(float, point)) for point in re.findall(r"[ML] ([-\d.]+) ([-\d.]+)", path(look="steps"))]
    assert len(steps) > 5
    assert all(a[0] == b[0] or a[1] == b[1] for a, b in pairwise(steps[:4]))


def test_a_narrow_figure_has_letters_of_the_same_size_on_a_narrow_sheet():
    panel = Panel("y", (Series("a", np.arange(3.0), np.arange(3.0)),))
    wide, narrow = (draw(Figure("f", "c", (panel,), width=width)) for width in (1.0, 0.6))
    widths = [float(re.search(r'width="([\d.]+)pt"', svg)[1]) for svg in (wide, narrow)]
    assert widths[1] == pytest.approx(0.6 * widths[0])
    scales = [set(re.findall(r"scale\((0\.\d+) ", svg)) for svg in (wide, narrow)]
    assert scales[0] == scales[1] != set()


@pytest.mark.parametrize("width", [0.3, 1.1, float("nan"), 0.0, -1.0])
def test_a_width_without_room_for_letters_is_refused(width):
    with pytest.raises(ValueError, match=r"`Figure\('f', width=...\)` must be a share of the text's width from 0.4"):
        Figure("f", "c", (Panel("y", (Series("a", np.arange(3.0), np.arange(3.0)),)),), width=width)


def test_what_is_counted_is_marked_at_whole_numbers():
    links = np.arange(2.0, 7.0)
    assert Ruler.around("linear", None, [links], 0.05).ticks(9).numbers == ("2", "3", "4", "5", "6")
    assert "2.5" in Ruler.around("linear", None, [links + 0.1], 0.05).ticks(9).numbers


def test_a_panel_that_leads_without_names_of_rows_is_refused():
    panels = figure().panels * 2
    with pytest.raises(ValueError, match=r"lead=...\)` must be False where a panel has no row names"):
        Figure("torque", "Torque.", panels, lead=True)
