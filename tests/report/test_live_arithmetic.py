"""The numbers of a live page are those of the portable arithmetic, and where nothing jumps of the fused one."""

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from studies.paper.comparison import comparison
from tests.support.live_study import KP, case, data_of, page
from tests.support.wasm_runs import Kernel, unpacked
from workbench.core.equations import equations_of
from workbench.engine.metrics.contract import Integral
from workbench.engine.metrics.value_program import MetricProgram
from workbench.report.live.marches import switches
from workbench.report.number_text import number_text_with_error
from workbench.report.pictures.traces import curve
from workbench.study.document.document import Figure, Panel, Section
from workbench.study.knob import Knob
from workbench.study.study import Case, Study


def test_a_browser_finds_the_scores_and_errors_of_the_portable_arithmetic_at_any_knob():
    data = data_of()
    made, value = data["loops"][0], 321.5
    p = np.array([float(x) for x in made["p"]])
    for move in made["moves"]:
        p[move["p"]] = value
    x0 = np.array([float(x) for x in made["x0"]])
    study = Study("small", "T", "Q?", "M.", page, cases=(case(),), live=(KP,))
    told = wb.turn_knobs(study, "speed: PI", {"Kp": value})
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
    return MetricProgram(*(tuple(map(tuple, plain[name])) for name in ("inputs", "nodes")), tuple(plain["results"]))


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


# The laws that jump: where nothing does, the numbers agree to a billionth, as is tested above.
@pytest.mark.heavy
@pytest.mark.parametrize(
    "made", [made for made in comparison("FS") if made.law not in SMOOTH], ids=lambda made: made.law
)
def test_the_printed_digits_are_those_of_the_portable_arithmetic_too(made):
    ode = equations_of(made.run.loop, made.law)
    how = {"until": made.run.until, "h": made.run.h, "every": made.run.every}
    printed, live = (
        [
            str(number_text_with_error(*score.pair))
            for score in wb.measure(ode, made.run.metrics, **how, arithmetic=name).scores
        ]
        for name in ("fused", "portable")
    )
    assert live == printed
