"""The data of a live page: which numbers can be turned, which curves and cells move, and the loops that move them."""

import json
import re
from base64 import b64encode
from dataclasses import replace
from hashlib import sha256

import numpy as np
import pytest

import workbench as wb
from studies.paper.comparison import comparison
from tests.support.live_study import KP, MOTOR, case, data_of, loop, page
from workbench.report.html_page import html
from workbench.report.live.live_data import live_data
from workbench.report.live.loop_study import loop_study
from workbench.report.live.marches import plain
from workbench.report.pictures.traces import loops_section
from workbench.study import case_runs, writeup
from workbench.study.document.document import Bars, Figure, Panel, Points, Section
from workbench.study.knob import Knob
from workbench.study.result_marks import bars, points
from workbench.study.study import Study


def test_a_curve_is_live_if_it_was_made_of_a_signal():
    curves = {curve["series"]: curve for curve in data_of()["curves"]}
    assert sorted(curves) == [0, 1, 2, 3]  # not the one that a study wrote by hand, although it has the same bits
    assert (curves[0]["x"], curves[0]["scales"]) == ("t", (1.0, 1.0))
    assert curves[1]["rows"] == (50, 101)
    assert curves[2]["scales"] == (1.0, 30 / np.pi)
    assert (curves[3]["x"][0], curves[3]["y"]) == ("x", ("y", 0))  # the only output that is no state


def test_a_cell_is_live_if_it_was_made_of_a_score():
    data = data_of(case(), case("stiffer PI", 100.0), live=(Knob("K", "controller.Kp", 0.1, 10.0, share=True),))
    # both laws have the same bits
    assert [(cell["row"], cell["column"], cell["loop"], cell["metric"]) for cell in data["cells"]] == [
        (0, 1, 0, 0),
        (0, 2, 0, 1),
        (1, 1, 1, 0),
        (1, 2, 1, 1),
    ]


def panels_of(*panels):
    """The sections of a page with one figure of panels, each made from the outcomes."""
    return lambda results: [Section("All", (Figure("f", "F.", tuple(make(results.outcomes) for make in panels)),))]


def bars_of(order, *names, metric="RMSE"):
    """A panel with a bar of a score for each law in an order, and another bar beside it that is none."""

    def panel(outcomes):
        ordered = [outcomes[k] for k in order]
        mine = bars("ours", ordered, metric, places=np.arange(len(order)) + 0.2)
        marks = Bars("printed", mine.places - 0.4, mine.ends, mine.starts), mine
        return Panel("", marks, f"{metric} [1]", ynames=names)

    return panel


TWINS = (case(), case("stiffer PI", 100.0))  # whose scores have the same bits
SHARE = (Knob("K", "controller.Kp", 0.1, 10.0, share=True),)


def test_a_bar_is_live_if_it_was_made_of_a_score_whatever_stands_beside_it():
    data = data_of(*TWINS, live=SHARE, sections=panels_of(bars_of((1, 0), "PI", "one of many names")))
    assert [(mark["series"], mark["index"], mark["loop"]) for mark in data["marks"]] == [(1, 0, 1), (1, 1, 0)]
    assert {(mark["figure"], mark["panel"], mark["axis"], mark["metric"]) for mark in data["marks"]} == {
        ("f", 0, "x", 0)
    }
    assert len(data["loops"]) == 2  # which no curve and no cell asks for


def test_a_whole_number_is_live_by_its_source_and_never_without():
    jump = case(metrics=(wb.peak_error(),))  # 1 rad/s, as much else may be
    assert len(data_of(jump, sections=panels_of(bars_of((0,), "one", metric="peak error")))["marks"]) == 1
    by_hand = [Panel("", (Bars("ours", [0.0], [1.0], [0.0]),), "peak error", ynames=("PI",))]
    assert data_of(jump, sections=panels_of(lambda outcomes: by_hand[0])) is None  # no loop is shown


def test_a_point_is_live_along_each_axis_that_was_made_of_a_score():
    def panel(outcomes):
        both = points("", outcomes, "RMSE", "effort", names=("stiffer PI", "PI"))  # which says nothing
        x_alone = tuple((pair[0], None) for pair in both.sources[:1])
        marks = both, Points("PI", both.x[:1], 2 * both.y[:1], sources=x_alone), Points("by hand", both.x, both.y)
        return Panel("effort [V]", marks, "RMSE")

    data = data_of(*TWINS, live=SHARE, sections=panels_of(panel))
    found = [tuple(mark[key] for key in ("series", "index", "axis", "loop", "metric")) for mark in data["marks"]]
    assert found == [(0, 0, "x", 0, 0), (0, 1, "x", 1, 0), (0, 0, "y", 0, 1), (0, 1, "y", 1, 1), (1, 0, "x", 0, 0)]


def test_the_data_are_plain_and_say_what_is_not_finite_in_words():
    assert json.loads(json.dumps(data_of(), allow_nan=False))["format"] == 2
    assert plain(np.array([1.5, np.inf, -np.inf, np.nan])) == [1.5, "Infinity", "-Infinity", "NaN"]


def test_the_lines_in_python_name_the_study_and_the_case():
    lines = data_of()["python"].format(case="'speed: PI'", values={"Kp": 20.0}, seed=None)
    assert lines == (
        "import workbench as wb\n\nstudy = wb.load('small.py')\n"
        "found = wb.turn_knobs(study, 'speed: PI', {'Kp': 20.0}, seed=None)\n"
    )


def test_a_computers_loop_is_live_too():
    computer = loop().digital(0.01, wb.Instruments.of(MOTOR, noise={"omega": 1e-3}))
    study = loop_study(computer, until=1.0, h=0.005)
    results = case_runs.run(study)
    made = live_data(study, results, writeup.document(study, results, "command"))["loops"][0]
    assert made["normals"] == 1
    assert made["whole"]["stride"] == made["half"]["stride"]  # substeps are within a period
    assert made["whole"]["module"] != made["half"]["module"]


def test_runs_lead_to_a_page_only_where_they_are_the_loop_at_its_own_numbers():
    step = wb.rk4(loop().ode(), 1e-3)
    several = wb.simulate(step, np.tile(step.parameters.default, (2, 1)), until=0.1)
    with pytest.raises(ValueError, match="one run of a loop in continuous time, at the loop's own numbers"):
        several.live()


def test_the_names_of_a_live_page_are_data_and_end_no_element():
    hostile = "</script><script>alert(1)</script><!--"
    study = Study("small", "T", "Q?", "M.", page, cases=(case(hostile),), live=(replace(KP, name=hostile),))
    results = case_runs.run(study)
    document = writeup.document(study, results, "command")
    text = html(document, live=live_data(study, results, document, script=hostile))
    assert text.count("<script") == text.count("</script>") == 3
    held = json.loads(re.search(r'<script type="application/json" id="live">(.*?)</script>', text, re.DOTALL)[1])
    assert held["knobs"][0]["name"] == held["loops"][0]["law"] == hostile
    digest = b64encode(sha256(re.search(r"<script>(.*?)</script>", text, re.DOTALL)[1].encode()).digest()).decode()
    assert f"script-src 'sha256-{digest}' 'wasm-unsafe-eval' blob:; worker-src blob:" in text
    assert re.search(r"\son[a-z]+=|javascript:|https?://(?!www\.w3\.org)", text) is None


def test_a_section_of_laws_has_a_panel_and_a_table_for_each_joint_and_all_of_it_is_live():
    short = [replace(made, run=replace(made.run, until=1.0, metrics=(wb.rmse(),))) for made in comparison("FS")[1:3]]
    mass = Knob("mass", "plant.arm.links[1].mass", 0.5, 2.0)
    made = Study(
        "small",
        "T",
        "Q?",
        "M.",
        lambda results: [loops_section("Laws", "All.", results.outcomes)],
        cases=tuple(short),
        live=(mass,),
    )
    results = case_runs.run(made)
    document = writeup.document(made, results, "command")
    data = live_data(made, results, document)
    assert [panel.ylabel for panel in document.figures[0].panels] == ["e of joint 1 [rad]", "e of joint 2 [rad]"]
    assert (len(data["curves"]), len(data["cells"])) == (4, 4)
    cut = loops_section("Laws", "All.", results.outcomes, caption="Errors.", cut=0.25).blocks[1]
    assert (cut.caption, {(panel.xlim, panel.xcut) for panel in cut.panels}) == ("Errors.", {((0.0, 1.0), 0.25)})
    with pytest.raises(ValueError, match=r"between the two of `xlim`"):
        loops_section("Laws", "All.", results.outcomes, cut=2.0)
    with pytest.raises(ValueError, match="at least one outcome"):
        loops_section("Laws", "All.", [])
