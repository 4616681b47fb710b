"""The curves of a report as numbers beside their pictures."""

import csv
import io

import numpy as np
import pytest

from tests.support.documents import document
from tests.support.equations import decay
from workbench.core.notation.formula import symbol
from workbench.engine.metrics import rmse
from workbench.report.figures.figure_csv import figure_csv
from workbench.report.folder import write
from workbench.report.pictures.traces import Window, curve, traces
from workbench.study.case_runs import run
from workbench.study.document.document import Band, Bars, Figure, Panel, Series
from workbench.study.document.figure import Tiles
from workbench.study.result_marks import bars, points
from workbench.study.run_and_sweep import Run
from workbench.study.study import Case, Study

T = np.array([0.0, 0.1, 0.2])
THIRD = 1 / 3


class Loop:
    def ode(self, name="loop"):
        return decay()


def columns(figure):
    head, *rows = csv.reader(io.StringIO(figure_csv(figure)))
    return {name: [row[i] for row in rows] for i, name in enumerate(head)}


def test_a_column_says_panel_curve_and_unit_and_keeps_all_digits():
    one = Panel(
        (symbol("tau_1"), " [N m]"),
        (Series("PID", T, T * THIRD), Series("=SMC", T, [1.0, np.nan, 3.0]), Band("", T, T, T + 1)),
    )
    two = Panel("h [m]", (Series("PID", T[:2], T[:2]),), xlabel="level [m]")
    found = columns(Figure("f", "", (one, two)))
    assert list(found) == [
        "(a) time [s]",
        "(a) PID: tau_1 [N m]",
        "(a) =SMC: tau_1 [N m]",
        "(a) tau_1 [N m] (low)",
        "(a) tau_1 [N m] (high)",
        "(b) level [m]",
        "(b) PID: h [m]",
    ]
    assert [float(cell) for cell in found["(a) PID: tau_1 [N m]"]] == (T * THIRD).tolist()
    assert found["(a) =SMC: tau_1 [N m]"] == ["1.0", "", "3.0"]
    assert found["(b) PID: h [m]"] == ["0.0", "0.1", ""]


def test_curves_of_other_times_have_a_column_of_theirs_and_one_of_many_points_is_thinned_as_drawn():
    t = np.linspace(0, 10, 20_001)
    found = list(
        csv.reader(
            io.StringIO(figure_csv(Figure("f", "", (Panel("y", (Series("a", t, np.sin(t)), Series("b", T, T))),))))
        )
    )
    assert found[0] == ["time [s]", "a: y", "time [s]", "b: y"]
    assert 500 < len(found) < 700
    assert found[4][2:] == ["", ""]


def test_no_head_is_run_as_a_formula():
    assert figure_csv(Figure("f", "", (Panel("y", (Series("=1+1", T, T),)),))).startswith("time [s],'=1+1: y")


def test_bars_have_a_column_of_names_beside_their_numbers_and_tiles_have_none():
    bars = Bars("ours", [0.2, 1.2], [1.0, np.nan], [0.0, 0.0])
    found = columns(Figure("f", "", (Panel("", (bars,), "RMSE [rad]", ynames=("=a", "b")),)))
    assert found == {"ours: RMSE [rad], of": ["'=a", "b"], "ours: RMSE [rad]": ["1.0", ""]}
    tiles = Tiles("", ((("1",), ("2",)),), np.zeros((1, 2)))
    assert figure_csv(Figure("f", "", (Panel("", (tiles,), ynames=("a",)),))) == ""


def test_a_report_writes_the_curves_beside_the_picture_and_is_replaced_with_them(tmp_path):
    target = write(document(), tmp_path / "report")
    first = (target / "figures" / "errors.csv").read_bytes()
    assert first.count(b"\r\n") > 2
    assert (write(document(), target) / "figures" / "errors.csv").read_bytes() == first


def laws(count, style=0):
    cases = tuple(Case("S", f"law {k}", Run(Loop(), (rmse(),), 1.0, 0.1, 0.05), style) for k in range(count))
    return run(Study("s", "t", "q", "m", sections=lambda r: (), cases=cases)).outcomes


def drawn(outcomes):
    panels = traces("f", "", outcomes, "e", 0, "e", [Window(0.0, 1.0)]).panels
    return panels[0].series if len(panels) == 1 else [panel.series[0] for panel in panels]


def test_the_head_of_a_result_says_law_scenario_signal_unit_and_run():
    outcome = laws(1)[0]
    window = Window(0.0, 0.5)
    lines = (
        curve(outcome, "e", 0, window, "any label"),
        curve(outcome, "x", 0, window, over=("e", 0), unit=(1e3, "mm")),
        curve(outcome, "x", 0, window, seconds=(1e3, "ms")),
    )
    run = f"run {outcome.digest[:16]}"
    panels = tuple(Panel("y", (line,), "time [s]") for line in lines)
    assert list(columns(Figure("f", "", panels, columns=3))) == [
        *("(a) time [s]", f"(a) law 0 | S | e | {run}"),
        *(f"(b) law 0 | S | e | {run}", f"(b) law 0 | S | x [mm] | {run}"),
        *("(c) time [s]", f"(c) law 0 | S | x | {run}"),
    ]


def test_bars_and_points_of_results_say_law_scenario_metric_unit_and_run_one_by_one():
    outcomes = laws(2)
    of = [f"law {k} | S | RMSE of e | run {outcomes[k].digest[:16]}" for k in range(2)]
    row = columns(Figure("f", "", (Panel("", (bars("", outcomes, "RMSE"),), "RMSE", ynames=("a", "b")),)))
    assert row == {"RMSE, of": of, "RMSE": [repr(o.score("RMSE").pair[0]) for o in outcomes]}
    cloud = columns(Figure("f", "", (Panel("up", (points("", outcomes, "RMSE", "RMSE"),), "across"),)))
    assert [*cloud] == ["across, of", "across", "up, of", "up"]
    assert cloud["up, of"] == of


def test_many_laws_have_a_panel_each_before_the_range_of_all_on_an_axis_cut_where_a_window_ends():
    outcomes = laws(4)
    windows = [Window(0.0, 0.2), Window(0.2, 1.0)]
    figure = traces("f", "", outcomes, "e", 0, "e", windows, reference="e")
    assert [panel.title for panel in figure.panels] == [f"law {k}" for k in range(4)]
    assert {(panel.xlim, panel.xcut) for panel in figure.panels} == {((0.0, 1.0), 0.2)}
    every = np.array([outcome.signal("e", 0) for outcome in outcomes])
    for panel, outcome in zip(figure.panels, outcomes, strict=True):
        law, wanted, band = panel.series
        assert np.array_equal(law.y, outcome.signal("e", 0))
        assert wanted.style == "reference"
        assert np.array_equal(band.low, every.min(axis=0))
        assert np.array_equal(band.high, every.max(axis=0))
    apart = traces("f", "", outcomes, "e", 0, "e", [Window(0.0, 0.2), Window(0.5, 1.0)])  # nothing to join
    assert [panel.xlim for panel in apart.panels] == [(0.0, 0.2)] * 4 + [(0.5, 1.0)] * 4


def test_two_laws_in_one_figure_never_share_a_style():
    assert [series.style for series in drawn(laws(12, style=3))] == [3, 0, 1, 2, 4, 5, 6, 7, 8, 9, 10, 11]
    with pytest.raises(ValueError, match=r"at most 12 laws, as no two of a figure share a style; got 13: draw fewer"):
        drawn(laws(13))
