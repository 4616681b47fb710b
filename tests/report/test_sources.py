"""The source of a mark: curves, cells, bars and points name the results from which they were made."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from tests.support.speed_cases import case
from tests.support.wasm_runs import Kernel, unpacked
from workbench.report.live.live_data import live_data
from workbench.report.live.loop_study import loop_study
from workbench.report.pictures.traces import Window, components, curve, traces
from workbench.study import case_runs, writeup
from workbench.study.document.document import (
    Figure,
    MissingCell,
    Panel,
    ReportTable,
    Section,
    TableColumn,
    ValueWithError,
)
from workbench.study.document.figure import Band
from workbench.study.document.phrases_and_tables import bare
from workbench.study.document.source import Source
from workbench.study.evidence.law_tables import PublishedColumn, against_published, side_by_side
from workbench.study.result_marks import bars, cell, labels_of, metric_source, points, signal_source
from workbench.study.study import Case, Results, Study

TWINS = (case("first"), case("second"), case("first", scenario="again"), case("stiff", 200.0))  # three of equal bits
KNOB = (wb.Knob("K", "controller.Kp", 0.1, 10.0, share=True),)


@pytest.fixture(scope="module")
def results():
    return case_runs.run(Study("s", "T", "Q?", "M.", lambda results: [], cases=TWINS))


def data_of(results, *blocks):
    study = Study("s", "T", "Q?", "M.", lambda results: [Section("All", blocks)], cases=TWINS, live=KNOB)
    return live_data(study, results, writeup.document(study, results, "command"))


def names(data, kind):
    loops = [(loop["scenario"], loop["law"]) for loop in data["loops"]]
    return [loops[mark["loop"]] for mark in sorted(data[kind], key=lambda mark: mark.get("series", 0))]


ALL = [("speed", "first"), ("speed", "second"), ("again", "first"), ("speed", "stiff")]


def test_curves_of_equal_bits_are_linked_each_to_the_law_and_scenario_of_which_it_was_made(results):
    order = [2, 3, 1, 0]
    mixed = [results.outcomes[k] for k in order]
    assert np.array_equal(mixed[0].signal("omega", 0), mixed[2].signal("omega", 0))
    lines = tuple(curve(o, "omega", label="one and the same") for o in mixed)
    data = data_of(results, Figure("f", "F.", (Panel("omega", lines),)))
    assert names(data, "curves") == [ALL[k] for k in order]


def test_cells_of_equal_numbers_are_linked_by_their_source_whatever_the_heads_say(results):
    rows = tuple((o.label, cell(o, "effort"), cell(o, "RMSE")) for o in reversed(results.outcomes))
    wrong = tuple((name, *row[1:]) for name, row in zip(("first", "second", "stiff", "x"), rows, strict=True))
    data = data_of(
        results, ReportTable("t", "T.", (TableColumn("law"), TableColumn("RMSE"), TableColumn("effort")), wrong)
    )
    assert names(data, "cells") == [one for one in reversed(ALL) for _ in range(2)]
    assert [mark["metric"] for mark in data["cells"]] == [1, 0] * 4


def test_a_number_that_another_one_equals_by_chance_is_not_taken_for_it(results):
    value, error = (float(part) for part in results.outcomes[0].score("RMSE").pair)
    rows = (("first", ValueWithError(value, error)), ("RMSE", value))
    mine = side_by_side("mine", "M.", results.outcomes[:1])
    data = data_of(results, ReportTable("t", "T.", (TableColumn("law"), TableColumn("RMSE")), rows), mine)
    assert {mark["table"] for mark in data["cells"]} == {"mine"}


def test_a_curve_and_a_cell_in_another_unit_move_by_their_scale(results):
    outcome = results.outcomes[3]
    line = curve(outcome, "omega", window=Window(0.2, 0.4), seconds=(1e3, "ms"), unit=(60 / (2 * np.pi), "1/min"))
    assert line.x[0] == pytest.approx(200.0, rel=1e-12)
    shown = cell(outcome, "RMSE", scale=1e3, unit="mrad/s")
    rows = ((shown,), (cell(outcome, "RMSE", scale=-2.0),))
    data = data_of(
        results, Figure("f", "F.", (Panel("omega", (line,)),)), ReportTable("t", "T.", (TableColumn("RMSE"),), rows)
    )
    assert data["curves"][0]["scales"] == (1e3, 60 / (2 * np.pi))
    assert data["curves"][0]["rows"] == (20, 41)
    assert [mark["scale"] for mark in data["cells"]] == [1e3, -2.0]
    assert shown == ValueWithError(*(1e3 * part for part in outcome.score("RMSE").pair))
    assert shown.source.unit == "mrad/s"
    assert line.sources[1].unit == "1/min"


def test_a_mark_of_another_study_with_a_case_of_the_same_name_does_not_move(results):
    other = case_runs.run(Study("o", "T", "Q?", "M.", lambda results: [], cases=(case("first", 300.0),))).outcomes[0]
    mine = results.outcomes[0]
    assert other.case.name == mine.case.name
    table = ReportTable("t", "T.", (TableColumn("RMSE"),), ((cell(other, "RMSE"),), (cell(mine, "RMSE"),)))
    data = data_of(results, table)
    assert [mark["row"] for mark in data["cells"]] == [1]


def test_bars_and_points_carry_a_source_each(results):
    row = bars("ours", results.outcomes, "peak error", style=2)
    assert [one.law for one in row.sources] == [law for _, law in ALL]
    assert row.ends.tolist() == [outcome.score("peak error").pair[0] for outcome in results.outcomes]
    cloud = points("", results.outcomes, "RMSE", "effort")
    assert [(x.name, y.name) for x, y in cloud.sources] == [("RMSE", "effort")] * 4
    with pytest.raises(ValueError, match=r"`Bars\('ours', sources=...\)` must have a source, or None, for each of 4"):
        replace(row, sources=row.sources[:2])


def test_every_maker_of_pictures_and_tables_of_cases_gives_its_marks_a_source(results):
    held, window = results.outcomes, Window(0.0, 1.0)
    figures = (
        traces("t", "T.", held, "omega", 0, "omega", [window], reference="omega_ref"),
        components("c", "C.", held[0], [("omega", "omega", 0), ("i", "plant.i", 0)], "signals", [window]),
    )
    series = [mark for figure in figures for panel in figure.panels for mark in panel.series]
    assert all(mark.sources is not None for mark in series if not isinstance(mark, Band))  # the range of all laws
    assert sum(isinstance(mark, Band) for mark in series) == len(held) == 4
    laws = {o.case.law: o for o in held}
    published = PublishedColumn("Table 1", "RMSE", 0, dict.fromkeys(laws, 0.2), 3)
    tables = side_by_side("s", "S.", held), against_published("a", "A.", published, laws)
    shown = [bare(value) for table in tables for row in table.rows for value in row]
    assert all(value.source is not None for value in shown if isinstance(value, ValueWithError))
    assert sum(isinstance(value, ValueWithError) for value in shown) == 4 * 3 + 3


def test_the_rows_of_an_emphasised_cell_keep_their_source(results):
    table = side_by_side("s", "S.", [results.outcomes[0], results.outcomes[3]], ("RMSE",))
    bold = [bare(row[1]) for row in table.rows if bare(row[1]) is not row[1]]
    assert [value.source.law for value in bold] == ["stiff"]


def test_a_matrix_counts_row_by_row_and_is_found_column_by_column():
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x"), ca.SX.sym("a")
    y = ca.vertcat(2 * x, 3 * x, 4 * x, 5 * x, 6 * x)  # of K = [[2, 4], [3, 5]] x, column by column
    outputs = wb.layout(K=("1", np.zeros((2, 2))), v="V")
    ode = wb.Ode("m", wb.layout(x=("1", 1.0)), wb.layout(a=("1", 1.0)), outputs, t, x, p, -p * x, y)
    run = wb.Run(ode, (wb.effort("v"),), until=1.0, every=0.02, h=1e-2)
    study = Study("s", "T", "Q?", "M.", lambda results: [], cases=(Case("s", "m", run),))
    results = case_runs.run(study)
    outcome = results.outcomes[0]
    assert labels_of(outcome, "K") == ("K[0,0]", "K[0,1]", "K[1,0]", "K[1,1]")
    assert signal_source(outcome, "K", "K[0,1]").place == 1
    line = curve(outcome, "K", "K[0,1]")
    assert line.y[0] == 4.0
    study = replace(study, sections=lambda results: [Section("All", (Figure("f", "F.", (Panel("K", (line,)),)),))])
    study = replace(study, live=(wb.Knob("a", "a", 0.5, 2.0),))
    data = live_data(study, results, writeup.document(study, results, "command"))
    assert data["curves"][0]["y"] == ("y", 0)  # the only output that the page computes
    made = data["loops"][0]
    outputs = Kernel(unpacked(data["modules"][made["outputs"]["module"]]), made["outputs"], 1)
    state = np.concatenate([outcome.measurement.trajectories.x[0, 0], [0.0]])
    assert outputs.run(np.array(made["p"]), state, 1)[-1][-1] == 4.0


def test_a_signal_or_a_metric_that_is_not_there_is_refused_by_name(results):
    outcome = results.outcomes[0]
    with pytest.raises(LookupError, match="Did you mean 'RMSE'"):
        metric_source(outcome, "RMSF")
    with pytest.raises(LookupError, match="Did you mean 'omega'"):
        metric_source(outcome, "RMSE", "omgea")
    with pytest.raises(LookupError, match="There is no 'speed'"):
        curve(outcome, "speed")
    for number in (1, -1):
        with pytest.raises(
            LookupError, match=rf"signal 'omega' of 'speed: first'` has the numbers 0 to 0, omega; got {number}"
        ):
            curve(outcome, "omega", number)
    with pytest.raises(
        ValueError, match=r"must hold a kept time of 'speed: first', which are from 0 s to 1 s; got 2 s to 3 s"
    ):
        curve(outcome, "omega", window=Window(2.0, 3.0))


def test_a_table_that_a_study_makes_of_cells_says_below_what_must_be_said_of_their_laws(results):
    ode = replace(results.outcomes[0].ode, notes=("the observer\nuses the truth",))
    honest, *oracles = results.outcomes[1], *(replace(results.outcomes[k], ode=ode) for k in (3, 0))
    rows = tuple((o.case.law, cell(o, "RMSE"), cell(o, "effort")) for o in (*oracles, honest))
    columns = tuple(map(TableColumn, ("law", "RMSE", "effort")))
    table = ReportTable("t", "T.", columns, rows, ("A note.",))
    below = ("A note.", "stiff \N{DAGGER}, first \N{DAGGER}: the observer uses the truth.")
    assert table.notes == below
    assert replace(table, caption="Other.").notes == below  # once
    page = writeup.document(
        Study("s", "T", "Q?", "M.", lambda _: [Section("All", (table,))], cases=TWINS), results, "c"
    )
    assert page.tables[0].notes == below


def test_a_law_of_which_two_things_must_be_said_in_two_scenarios_is_named_with_each(results):
    ode = replace(results.outcomes[0].ode, notes=("a truth",))
    other = replace(results.outcomes[2], ode=replace(ode, notes=("a truth", "a long step")))
    rows = tuple((cell(o, "RMSE"), cell(o, "effort")) for o in (replace(results.outcomes[0], ode=ode), other))
    table = ReportTable("t", "T.", (TableColumn("RMSE"), TableColumn("effort")), rows)
    dagger = "first \N{DAGGER}"
    assert table.notes == (f"{dagger} (speed): a truth.", f"{dagger} (again): a truth; a long step.")


def test_a_note_that_most_laws_share_is_said_of_all_rows_or_of_all_others(results):
    ode = replace(results.outcomes[0].ode, notes=("a truth",))
    one, two, three = (replace(results.outcomes[k], ode=ode) for k in (0, 1, 3))
    other = replace(two, ode=replace(ode, notes=("a long step",)))

    def notes(*outcomes, printed=False):
        rows = (*((cell(o, "RMSE"),) for o in outcomes), *([("0.1",)] if printed else []))
        return ReportTable("t", "T.", (TableColumn("RMSE"),), rows).notes

    assert notes(one, two, three) == ("All rows: a truth.",)
    assert notes(one, two, three, printed=True) == ("All rows with runs: a truth.",)
    long = f"{other.label}: a long step."
    assert notes(one, other, three) == (long, "All other rows: a truth.")


def test_a_cell_in_place_of_a_number_says_why_and_moves_too():
    never = case("slow", 1.0)
    run = replace(never.run, metrics=(wb.settling_time(band=1e-9),))
    held = case_runs.run(Study("s", "T", "Q?", "M.", lambda results: [], cases=(replace(never, run=run),)))
    shown = cell(held.outcomes[0], "settling time")
    assert (shown, shown.source.name) == (MissingCell("never"), "settling time")
    data = data_of(held, ReportTable("t", "T.", (TableColumn("settling"),), ((shown,),)))
    assert [(mark["metric"], mark["loop"]) for mark in data["cells"]] == [(0, 0)]


def test_a_source_says_what_a_mark_is_in_words():
    one = Source("PID", "FS", "signal", "e", 1, "joint 2", "rad", 20 * "0123")
    assert one.words == "e of joint 2"
    assert replace(one, name="omega", label="omega").words == "omega"
    assert replace(one, name="K", label="K[0,1]").words == "K[0,1]"
    assert replace(one, name="RMSE of x", label="x").words == "RMSE of x"
    assert one.times(1e3, "mrad").times(2.0) == replace(one, scale=2e3, unit="mrad")


def test_a_page_of_a_loop_alone_moves_in_all_its_curves_and_cells():
    study = loop_study(TWINS[0].run.loop, until=1.0, h=1e-3)
    results: Results = case_runs.run(study)
    document = writeup.document(study, results, "command")
    data = live_data(study, results, document)
    moving = (panel for figure in document.figures if figure.name.startswith("signal_") for panel in figure.panels)
    assert len(data["curves"]) == sum(len(panel.series) for panel in moving)
    assert len([cell for cell in data["cells"] if cell["table"] == document.tables[0].name]) == sum(
        isinstance(bare(value), ValueWithError) for row in document.tables[0].rows for value in row
    )
