"""The proposed law at rest on the pages of a1, a7 and a8: a case apart from theirs, which their knobs move."""

import re
from importlib import import_module
from types import SimpleNamespace

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from studies.d0_frequency.loops import AtPose, linear
from studies.paper.card import PROPOSED_LAW, SCENARIOS
from studies.paper.rest import POSE, REST, rest_case
from studies.paper.scenarios import HELD_OUT, uncertain
from workbench.core import SampledSystem
from workbench.report.live.linear_data import baseline_of
from workbench.study.case_runs import run
from workbench.study.knob import Knob
from workbench.study.study import Results, Study

NAME = f"{REST}: {PROPOSED_LAW}"
LONGEST = 25  # words of a sentence
NO_PART = "l of (24)", "Q of AOSMC-RGS", "R of AOSMC-RGS"
TURNED = ("Lambda", "first gain K", "mass of link 2", "observer (10)")  # with all tests, and phi with each


def outcomes_of(*cases):
    return run(Study("s", "T", "Q?", "M.", lambda results: [], cases=cases)).outcomes


@pytest.fixture(scope="module")
def a1():
    """The study, whose loops are built as it is loaded: here, and not in each worker that collects this file."""
    return import_module("studies.a1_paper_tables.study")


@pytest.fixture(scope="module")
def a7():
    return import_module("studies.a7_sensitivity.study")


@pytest.fixture(scope="module")
def a8():
    return import_module("studies.a8_fair_comparison.study")


@pytest.fixture(scope="module")
def cases_of_a8(a8):
    """The cases of a8 with numbers amid the ranges of its searches."""
    from studies.paper.entrants import BOTH, ENTRANTS

    middle = {
        one.key: SimpleNamespace(
            best={sought.name: float(np.sqrt(sought.low * sought.high)) for sought in one.tuned_numbers}
        )
        for one in ENTRANTS[BOTH.key]
    }
    return a8.cases(middle)


@pytest.fixture(scope="module")
def outcomes_of_a8(cases_of_a8):
    """Those of the proposed law."""
    return outcomes_of(*(case for case in cases_of_a8 if case.law == PROPOSED_LAW))


@pytest.fixture(scope="module")
def unturned(a1):
    return wb.linear_loop_at_knobs(a1.study, NAME, {})


def test_the_case_at_rest_has_a_scenario_of_its_own_on_each_page(a1, a7, cases_of_a8):
    pages = (a1.study.cases, set(SCENARIOS)), (a7.study.cases, {a7.SCENARIO}), (cases_of_a8, {HELD_OUT[0].name})
    for cases, tracking in pages:
        assert [case.name for case in cases if case.scenario == REST] == [NAME]
        assert cases[-1].name == NAME  # the first loop of a page is the one that its animation shows
        assert tracking <= {case.scenario for case in cases}
    assert REST not in SCENARIOS


@pytest.mark.parametrize("place", ["continuous", "computer"])
def test_at_rest_no_state_moves_but_the_gains_that_are_held(place, cases_of_a8):
    loop = (rest_case(1e-4) if place == "continuous" else cases_of_a8[-1]).run.loop
    equation = loop.ode()
    flow = equation.flow if isinstance(equation, SampledSystem) else equation
    rate = ca.Function("f", [flow.t, flow.x, flow.p], [flow.rate])
    moved = np.array(rate(0.0, flow.states.default, flow.parameters.default)).ravel()
    names = [name for name in flow.states.names if name not in ("controller.K", "controller.P")]
    assert {"plant.q", "plant.qd"} <= set(names)
    for name in names:
        np.testing.assert_allclose(
            moved[flow.states.slice(name)], 0.0, atol=1e-12, err_msg=name
        )  # of 10 N m of gravity


def test_the_loop_is_that_of_d0_at_the_same_pose(unturned):
    own, other = (
        sorted(pole.value.real for pole in one.poles) for one in (unturned, linear(AtPose(PROPOSED_LAW, "start of FS")))
    )
    np.testing.assert_allclose(own, other, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize(
    "knob",
    ["phi", *(pytest.param(knob, marks=pytest.mark.heavy) for knob in TURNED)],
)
def test_a_knob_of_a1_moves_the_loop_gain(knob, a1, unturned):
    high = next(one.high for one in a1.LIVE if one.name == knob)
    omega = np.geomspace(0.1, 1000.0, 30)
    before = unturned.response(omega, "L").values
    after = wb.linear_loop_at_knobs(a1.study, NAME, {knob: high}).response(omega, "L").values
    assert np.abs(after - before).max() > 1e-3 * np.abs(before).max()


def test_the_knobs_that_the_page_says_have_no_part_leave_the_loop_gain(a1, unturned):
    """l is a pole of the observer of the disturbance, once for each joint, and Q and R move no pole."""
    omega = np.geomspace(0.1, 1000.0, 30)
    high = {one.name: one.high for one in a1.LIVE}
    turned = wb.linear_loop_at_knobs(a1.study, NAME, {name: high[name] for name in NO_PART})
    np.testing.assert_array_equal(turned.response(omega, "L").values, unturned.response(omega, "L").values)
    own, others = (np.array([pole.value for pole in one.poles]) for one in (turned, unturned))
    gone = [pole for pole in others if np.abs(own - pole).min() > 1e-6 * (1 + abs(pole))]
    assert len(gone) == 2


@pytest.mark.heavy
def test_the_sections_say_the_state_in_short_sentences(a1, a7, outcomes_of_a8):
    from studies.a8_fair_comparison.pages import rest as rest_of_a8

    results = Results(outcomes_of_a8)
    of_a8 = rest_of_a8(results)
    assert baseline_of(results[REST, PROPOSED_LAW]).frozen_states == ("controller.K", "controller.P")
    short = rest_case(1e-4), wb.Case("FS", PROPOSED_LAW, wb.Run(a7.loop(PROPOSED_LAW), (wb.rmse(),), 0.05, 0.01, 1e-4))
    results = Results(outcomes_of(*short))
    of_a1 = a1.rest(results)
    for section in (of_a8, of_a1, a7.rest(results)):
        text = section.blocks[0].text
        assert "The gain K is constant at K(0), with" in text
        assert "track a moving reference" in text
        assert [sentence for sentence in re.split(r"(?<=[.])\s", text) if len(sentence.split()) > LONGEST] == []
        assert [type(block).__name__ for block in section.blocks[2:]] == ["ReportTable", *(4 * ["Figure"])]
    last = results["FS", PROPOSED_LAW].measurement.trajectories["controller.K"][0, -1]
    assert f"the diagonal has {last[0, 0]:.3g} and {last[1, 1]:.3g} N m" in of_a1.blocks[0].text
    assert of_a1.heading == f"The loop gain of {PROPOSED_LAW} at rest"


def test_the_case_at_rest_is_no_run_beyond_the_limit_of_its_step(a1):
    (outcome,) = outcomes_of(rest_case(1e-2))  # a pole at -500 1/s decays with steps below 5.6 ms alone
    assert not outcome.measurement.limit.holds
    assert "The step is beyond the limit in: no run." in a1.trust_section(Results((outcome,))).blocks[0].text


@pytest.mark.heavy
def test_the_factors_of_a8_are_knobs_of_the_case_at_rest_and_of_the_others(outcomes_of_a8):
    """They stand at one number in all: the arm is therefore held where the scenario starts, and nothing is zero."""
    from studies.paper.entrants import PROPOSAL

    factors = uncertain(HELD_OUT[0], PROPOSAL.loop(HELD_OUT[0]))
    runs = [one.measurement.trajectories for one in outcomes_of_a8]
    for knob in map(Knob.of, factors):
        numbers = {knob.value(one.step, one.p[0], one.x[0, 0]) for one in runs if knob.places(one.step)}
        assert len(numbers) == 1
        disturbs = knob.name.partition(" ")[0] in ("disturbance", "phase")
        assert bool(knob.places(runs[-1].step)) != disturbs
    assert HELD_OUT[0].start == POSE
