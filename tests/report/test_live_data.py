"""The data of a live page: which numbers can be turned, which curves and cells move, and the loops that move them."""

import json
import re
from base64 import b64encode
from dataclasses import replace
from hashlib import sha256

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from studies.paper.comparison import comparison
from tests.support.wasm_runs import Kernel, unpacked
from workbench.core.equations import equations_of
from workbench.engine.metrics.contract import Integral
from workbench.engine.metrics.value_program import Program
from workbench.report.html_page import html
from workbench.report.live.live_data import live_data
from workbench.report.live.loop_study import loop_study
from workbench.report.live.marches import plain, switches
from workbench.report.number_text import measured
from workbench.report.pictures.traces import Window, curve, loops_section
from workbench.study import case_runs, writeup
from workbench.study.document.document import Bars, Column, Figure, Panel, Points, Section, Series, Table
from workbench.study.knob import Knob
from workbench.study.result_marks import bars, cell, points
from workbench.study.study import Case, Study

MOTOR = wb.DCMotor()
KP = Knob("Kp", "controller.Kp", 10.0, 1000.0, log=True)


def loop(Kp=100.0):
    law = wb.PID2(MOTOR.outputs, MOTOR.inputs, Kp=Kp, Ki=200.0, low=-24.0, high=24.0)
    return wb.ClosedLoop(MOTOR, controller=law, reference=wb.Step("omega", "rad/s", 1.0, time=0.1))


def case(law="PI", Kp=100.0, metrics=(wb.rmse(), wb.effort(), wb.overshoot())):
    return Case("speed", law, wb.Run(loop(Kp), metrics, until=1.0, every=0.01, h=1e-3))


def page(results):
    outcome = results.outcomes[0]
    omega = outcome.signal("omega", 0)
    lines = (
        curve(outcome, "omega", label="omega"),
        curve(outcome, "omega", window=Window(0.5, 1.0), label="late"),
        curve(outcome, "omega", label="in rev/min", unit=(30 / np.pi, "1/min")),
        curve(outcome, "v_applied", label="v over i", over=("plant.i", 0)),
        Series("by hand", outcome.t, omega),
    )
    rows = [(o.label, cell(o, "RMSE"), cell(o, "effort"), 0.123) for o in results.outcomes]
    table = Table("scores", "Scores.", tuple(map(Column, ("law", "RMSE", "effort", "other"))), tuple(rows))
    return [Section("All", (Figure("speed", "Speed.", (Panel("omega", lines),)), table))]


def data_of(*cases, live=(KP,), sections=page, **more):
    study = Study("small", "T", "Q?", "M.", sections, cases=cases or (case(),), live=live, **more)
    results = case_runs.run(study)
    return live_data(study, results, writeup.document(study, results, "command"), "small.py")


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


def test_a_browser_finds_the_scores_and_errors_of_the_portable_arithmetic_at_any_knob():
    data = data_of()
    made, value = data["loops"][0], 321.5
    p = np.array([float(x) for x in made["p"]])
    for move in made["moves"]:
        p[move["p"]] = value
    x0 = np.array([float(x) for x in made["x0"]])
    study = Study("small", "T", "Q?", "M.", page, cases=(case(),), live=(KP,))
    told = wb.turned(study, "speed: PI", {"Kp": value})
    found = []
    for march in (made["whole"], made["half"]):
        kernel = Kernel(unpacked(data["modules"][march["module"]]), march, made["rows"])
        x = kernel.run(p, x0, made["rows"])[-1:]
        z = kernel.run(p, x[0], 1, begin=made["rows"] * march["stride"], stride=1)
        found.append([program_from(metric["program"]).evaluate(x, z)[0] for metric in made["metrics"]])
    for metric, whole, half in zip(made["metrics"], *found, strict=True):
        pairs = [score.pair for score in told.scores_of(metric["name"])]
        assert [*zip(whole.tolist(), (2 * np.abs(whole - half)).tolist(), strict=True)] == pairs


def program_from(plain):
    return Program(*(tuple(map(tuple, plain[name])) for name in ("inputs", "nodes")), tuple(plain["results"]))


def test_a_metric_that_no_program_can_hold_stays_printed():
    odd = Integral("odd", "1", "odd", lambda t, y: y["omega"] ** 2, lambda integral, T: np.exp(integral), ("omega",))
    data = data_of(case(metrics=(wb.rmse(), wb.effort(), odd)))
    assert [metric["program"] is None for metric in data["loops"][0]["metrics"]] == [False, False, True]


def test_a_loop_that_no_browser_can_run_stays_printed_and_the_page_says_why():
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x"), ca.SX.sym("a")
    odd = wb.Ode("odd", wb.layout(x="1"), wb.layout(a=("1", 1.0)), wb.layout(y="1"), t, x, p, ca.erf(p - x), x)
    run = wb.Run(odd, (wb.effort("y"),), until=1.0, every=0.02, h=1e-2)

    def sections(results):
        outcome = results.outcomes[0]
        return [Section("All", (Figure("x", "x.", (Panel("x", (curve(outcome, "x"),)),)),))]

    data = data_of(Case("s", "odd", run), live=(Knob("a", "a", 0.5, 2.0),), sections=sections)
    assert data["loops"] == data["curves"] == []
    assert "ERF" in data["refused"]["s: odd"]


def test_without_knobs_the_factors_of_the_sweeps_are_offered():
    factors = (
        wb.Factor("gain", ("controller.Kp",), wb.LogUniform(50.0, 200.0), "stated"),
        wb.Factor("inertia", ("plant.J",), wb.Uniform(0.5, 2.0), share=True),
    )
    sweep = wb.Sweep("s", case().run, factors, wb.SobolDesign(2, 16))
    study = Study("small", "T", "Q?", "M.", page, cases=(case(),), sweeps=(sweep,))
    results = case_runs.run(study)
    data = live_data(study, results, writeup.document(study, results, "command"))
    gain, inertia = data["knobs"]
    assert (gain["low"], gain["high"], gain["log"], gain["value"], gain["origin"]) == (50, 200, True, 100, "stated")
    assert (inertia["value"], inertia["share"], inertia["unit"]) == (1.0, True, "1")


def test_a_study_may_stay_as_printed():
    assert data_of(live=None) is None
    assert data_of(live=()) is None  # nothing is offered


@pytest.mark.parametrize(
    ("knobs", "says"),
    [
        ((Knob("K", "controller.Kq", 1.0, 2.0),), r"no 'controller\.Kq', which the knob 'K' turns, .* Did you mean"),
        ((Knob("Kp", "controller.Kp", 200.0, 300.0),), "must hold the number of the loops, 100; got 200 to 300"),
        ((Knob("J", "plant.J", -1.0, 1.0),), "'J' goes from -1 to 1, too far"),
        ((KP, KP), "distinct names"),
    ],
)
def test_a_knob_that_fits_no_loop_is_refused_in_one_sentence(knobs, says):
    with pytest.raises((ValueError, LookupError), match=says):
        data_of(live=knobs)


def test_a_knob_of_two_different_numbers_must_be_a_share():
    cases = case(), case("stiffer", 200.0)
    with pytest.raises(ValueError, match="'controller.Kp' is 100 or 200 in different loops: turn a share"):
        data_of(*cases)
    assert data_of(*cases, live=(Knob("K", "controller.Kp", 0.5, 2.0, share=True),))["knobs"][0]["value"] == 1.0


def test_the_lines_in_python_name_the_study_and_the_case():
    lines = data_of()["python"].format(case="'speed: PI'", values={"Kp": 20.0}, seed=None)
    assert lines == (
        "import workbench as wb\n\nstudy = wb.load('small.py')\n"
        "found = wb.turned(study, 'speed: PI', {'Kp': 20.0}, seed=None)\n"
    )


def test_a_loop_alone_has_a_page_with_a_knob_for_every_number():
    study = loop_study(loop(), until=1.0, h=1e-3)
    results = case_runs.run(study)
    data = live_data(study, results, writeup.document(study, results, "command"))
    assert {"controller.Kp", "plant.J", "reference.level"} <= {knob["name"] for knob in data["knobs"]}
    assert len(data["curves"]) == 3  # speed, its reference, and the voltage
    assert {cell["metric"] for cell in data["cells"] if "metric" in cell} == {0, 1, 2}
    with pytest.raises(ValueError, match=r"live\(until=...\)"):
        loop_study(loop(), until=1.0005, h=1e-3)


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


def test_a_turned_case_refuses_what_it_does_not_have():
    study = Study("small", "T", "Q?", "M.", page, cases=(case(),), live=(KP,))
    with pytest.raises(LookupError, match="no 'kp' among the 1 knobs of this study. They are: Kp"):
        wb.turned(study, "speed: PI", {"kp": 1.0})
    with pytest.raises(LookupError, match="cases of this study"):
        wb.turned(study, "speed: PID", {})


SMOOTH = ("PID", "SMC", "super-twisting")


@pytest.mark.parametrize("law", SMOOTH)
def test_the_numbers_of_a_page_are_those_of_the_fused_arithmetic_to_a_billionth_where_nothing_jumps(law):
    made = next(one for one in comparison("FS") if one.law == law)
    ode = equations_of(made.run.loop, law)
    how, metrics = {"until": 4.0, "h": 1e-3, "every": 0.01}, (wb.rmse(), wb.effort(), wb.peak_error())
    fused, portable = (wb.measure(ode, metrics, **how, arithmetic=name).scores for name in ("fused", "portable"))
    assert not switches(ode)
    for one, other in zip(fused, portable, strict=True):
        assert one.value == pytest.approx(other.value, rel=1e-9)  # in truth some 1e-14


def test_a_law_that_jumps_is_said_to():
    made = comparison("FS")[0]
    assert switches(equations_of(made.run.loop, "aosmc"))
    square = next(one for one in comparison("SS") if one.law == "PID")
    assert not switches(equations_of(square.run.loop, "pid"))  # whose reference jumps, at its own times


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


def test_a_page_without_knobs_has_no_script():
    study = Study("small", "T", "Q?", "M.", page, cases=(case(),), live=None)
    results = case_runs.run(study)
    text = html(writeup.document(study, results, "command"), live=None)
    assert "<script" not in text
    assert "data-cell" not in text


# The laws that jump: where nothing does, the numbers agree to a billionth, as is tested above.
@pytest.mark.heavy
@pytest.mark.parametrize(
    "made", [made for made in comparison("FS") if made.law not in SMOOTH], ids=lambda made: made.law
)
def test_the_printed_digits_are_those_of_the_portable_arithmetic_too(made):
    ode = equations_of(made.run.loop, made.law)
    how = {"until": made.run.until, "h": made.run.h, "every": made.run.every}
    printed, live = (
        [str(measured(*score.pair)) for score in wb.measure(ode, made.run.metrics, **how, arithmetic=name).scores]
        for name in ("fused", "portable")
    )
    assert live == printed


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
