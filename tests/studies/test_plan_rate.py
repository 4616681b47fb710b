"""The rows of the time of a plan; no time is asserted."""

from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("llvmlite", reason="the study of speed is that of the compiled march")

from studies.performance import plan_rate
from studies.performance.measurements import Effort

SMALL = Effort(repetitions=1, processes=1)


def plan(until, is_passed=True):
    """What the rows ask of a plan."""
    return SimpleNamespace(t=np.linspace(0.0, until, 13), until=until, certificate=SimpleNamespace(is_passed=is_passed))


def test_the_program_by_hand_finds_the_least_time():
    assert plan_rate.by_hand(np.ones(24)) == pytest.approx(0.415661, rel=2e-3)  # of `wb.plan`; held inputs cost this


@pytest.mark.parametrize(("until", "is_measured"), [(2.0, True), (2.1, False)])
def test_times_are_compared_only_at_the_same_least_time(monkeypatch, until, is_measured):
    monkeypatch.setattr(plan_rate, "least_time_plan", lambda: plan(until, is_passed=False))
    monkeypatch.setattr(plan_rate, "by_hand", lambda h: 2.0)
    monkeypatch.setattr(plan_rate, "in_a_process", lambda probe, cache: {"wall": 1.5, "cpu": 1.0})
    time, ratio = plan_rate.plan_rows(SMALL)
    assert (time.value, time.is_reached) == (1.5, True)
    assert "WITHOUT A CERTIFICATE" in time.note
    assert (ratio.value is not None) is is_measured
    assert "mesh of 12 intervals" in ratio.note


@pytest.mark.heavy
def test_a_process_of_its_own_plans_the_motion():
    assert plan_rate.in_a_process(plan_rate.processes.least_time, cache="off")["cpu"] > 0.0
