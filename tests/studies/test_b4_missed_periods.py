"""Missed periods in b4: which loop stands the fewest, at its own period and at that of AOSMC-RGS."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import workbench as wb
from studies.b4_handover import missed_periods
from studies.b4_handover.loops import EKF, LQG, PID, SMC, TWISTING, handover_loops
from studies.b4_handover.margins import effects_of
from studies.b4_handover.missed_periods import EFFECT, SHARED_PERIOD, SMC_WITH_OBSERVER, observed_smc, shared_period
from studies.paper.card import PROPOSED_LAW
from studies.paper.laws import RIVALS
from studies.paper.quiet_periods import momentum_loop
from workbench.study.evidence.computer_margins import ComputerMargin, ComputerMargins

ERRORS = 1e-4  # rad or m, without missed periods


def test_all_laws_of_the_arm_are_run_at_the_period_of_aosmc_rgs():
    own = [one.name for one in handover_loops() if one.period == SHARED_PERIOD]
    assert own == [PROPOSED_LAW, SMC]
    assert [one.name for one in shared_period()] == [TWISTING, PID, LQG, SMC_WITH_OBSERVER]
    assert {one.period for one in shared_period()} == {SHARED_PERIOD}
    assert len({missed_periods.missed_period_effect(one).levels for one in (*handover_loops(), *shared_period())}) == 1


def test_smc_with_the_observer_of_aosmc_rgs_adds_the_estimate_to_its_torque():
    loop, alone = observed_smc(), replace(momentum_loop(), controller=RIVALS[SMC])
    ode, plain = loop.ode(), alone.ode()
    states = np.array(ode.states.default)
    states += 0.01 * np.arange(1, states.size + 1)  # an observer of the momentum that is off has an estimate
    seen, other = (one.outputs_at(0.0, states) for one in (ode, plain))
    estimate = seen["d"] - seen["d_error"]
    assert np.abs(estimate).min() > 0.01
    np.testing.assert_allclose(seen["tau"] - other["tau"], estimate, rtol=1e-9)  # of torques of some hundred N m


def margin_of(effect, kept, factor=3.0):
    """The margin of an effect that keeps the error up to a level and makes it `factor` times as large beyond."""
    ratios = np.array([[1.0 if level <= kept else factor] * 2 for level in effect.levels])
    return ComputerMargin(effect, ERRORS * ratios[:, :, np.newaxis], ratios)


@pytest.fixture
def given(monkeypatch):
    """The levels up to which loops keep their errors, at their own periods and at the shared one."""
    own, shared, base = {}, {}, np.full((2, 1), ERRORS)

    def margins(results, one, *way, **asked):
        each = (margin_of(e, own.get(one.name, 1.0) if e.name == EFFECT else 1e3) for e in effects_of(one))
        return ComputerMargins(tuple(each), base, base)

    def computer_margins(sample, effects, metric):
        return ComputerMargins((margin_of(effects[0], shared.get(sample, 1.0)),), base, base)

    monkeypatch.setattr(missed_periods, "margins", margins)
    monkeypatch.setattr(wb.evidence, "computer_margins", computer_margins)
    return own, shared


RESULTS = SimpleNamespace(sample=lambda name: name)  # a sample is known by its name alone


def test_the_frailest_loop_is_compared_with_the_others_at_its_own_period(given):
    own, shared = given
    own |= {PROPOSED_LAW: 0.0, SMC: 0.125, EKF: 0.0625}
    shared |= {"pid_shared_period": 0.25, f"{shared_period()[-1].key}_shared_period": 0.0}
    found = missed_periods.clock_finding(RESULTS)
    assert found.answer == PROPOSED_LAW
    assert "AOSMC-RGS does not keep its settled error within 10 % at any level tried, from 0.1 % on." in found.statement
    assert (
        "At 0.25 ms, the period of AOSMC-RGS, the limits are: SMC 12.5 %, super-twisting 50 %, PID 25 % and LQG "
        "50 %." in (found.statement)
    )
    assert (
        "does not keep its error of 100 µrad at any level tried, from 0.1 % on. AOSMC-RGS, whose error"
        in found.evidence
    )
    assert "from the observer, not from the law" in found.evidence
    shared |= {f"{shared_period()[-1].key}_shared_period": 0.125}
    assert "not from the law" not in missed_periods.clock_finding(RESULTS).evidence
    answers = {one.words: one.answer for one in found.variations}
    assert answers["the laws of the arm at 0.25 ms"] == PROPOSED_LAW
    assert (
        answers[f"the laws of the arm at 0.25 ms, {SMC_WITH_OBSERVER} in place of {PROPOSED_LAW}"] == SMC_WITH_OBSERVER
    )


def test_an_error_may_grow_by_a_part_of_a_step_of_the_readings_too(given):
    own, _ = given
    own |= {PROPOSED_LAW: 0.0, SMC: 0.125}
    reach = missed_periods.reach_in_steps(RESULTS)
    # three times 100 microradians or micrometres is more than a tenth of a step of 96 or 100
    assert (reach[PROPOSED_LAW], reach[SMC], reach[EKF]) == (0.0, 0.125, 0.5)


def test_a_row_has_the_ends_and_the_growths_of_its_law(given):
    own, _ = given
    own |= {PROPOSED_LAW: 0.0, SMC: 1.0}
    rows = {row[0]: row[1:] for row in missed_periods.shared_table(RESULTS).rows}
    assert list(rows) == [PROPOSED_LAW, SMC, TWISTING, PID, LQG, SMC_WITH_OBSERVER]
    assert rows[PROPOSED_LAW][:3] == ("100 µrad", 0.0, 0.1)
    assert rows[PROPOSED_LAW][3:] == pytest.approx((200.0,) * 3)
    assert rows[SMC][1:3] == (50.0, "none tried")
