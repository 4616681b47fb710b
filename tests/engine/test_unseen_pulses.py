"""A metric that looks at the ends of steps alone says where it may miss a pulse."""

import pytest

import workbench as wb
from tests.support.motors import PI, Motor
from workbench.engine.metrics import peak


def peak_of_reference(h, reference):
    loop = wb.ClosedLoop(Motor(), controller=PI(), reference=reference)
    return wb.measure(loop.ode(), [peak("omega_ref"), wb.rmse()], until=1.0, h=h)


def pulses(time):
    return wb.PulseTrain("omega", "rad/s", level=10.0, period=0.1, width=0.001, time=time)


@pytest.mark.parametrize("h", [0.02, 0.005])
def test_a_pulse_between_two_steps_is_said(h):
    found = peak_of_reference(h, pulses(0.0512))
    assert found.score("peak of omega_ref").value.max() == 0.0  # 10 rad/s, which no end of a step sees
    (said,) = (line for line in found.warnings if "pulse" in line)
    assert said.startswith("'peak of omega_ref' looks at the ends of steps")
    assert said in repr(found)


def test_a_pulse_as_long_as_the_steps_and_a_single_jump_are_seen_and_not_said():
    seen = peak_of_reference(1e-3, pulses(0.0512))
    assert seen.score("peak of omega_ref").value.max() == 10.0
    jump = peak_of_reference(0.02, wb.Step("omega", "rad/s", level=10.0, time=0.0512))
    assert not [line for one in (seen, jump) for line in one.warnings if "pulse" in line]


def test_a_command_of_time_and_of_states_behind_the_first_is_watched():
    loop = wb.ClosedLoop(Motor(), controller=PI(), reference=pulses(0.0512))
    found = wb.measure(loop.ode(), [peak("v"), peak("e_omega")], until=1.0, h=0.02)
    assert len([line for line in found.warnings if "pulse" in line]) == 2


def test_a_pulse_within_a_period_of_a_computer_is_said_whatever_the_substeps():
    loop = wb.ClosedLoop(Motor(), controller=PI(), reference=pulses(0.0512))
    found = wb.measure(loop.digital(0.02), [peak("omega_ref")], until=1.0, h=1e-3)
    assert found.score("peak of omega_ref").value.max() == 0.0
    assert any("pulse" in line for line in found.warnings)
