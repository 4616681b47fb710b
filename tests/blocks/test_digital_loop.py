"""A loop that is declared with its computer: it is the loop of `ClosedLoop.digital`, built when a run asks for it."""

from dataclasses import replace

import numpy as np
import pytest

import workbench as wb
from tests.support.motors import PI, Level, Motor
from workbench.blocks.loop import ClosedLoop, DigitalLoop, Instruments
from workbench.core.equations import equations_of

LOOP = ClosedLoop(Motor(), controller=PI(), reference=Level())
ROUGH = Instruments.of(LOOP.plant, noise={"omega": 1e-3}, quantum={"omega": 1e-3}, limit={"v": (-60.0, 60.0)})


def end(loop, seed=0):
    run = wb.simulate(loop, until=0.2, every=0.2, seed=seed)
    return run["omega"][0, -1, 0]


@pytest.mark.parametrize("delay", [False, True, 2, {"v": 1}])
def test_it_runs_as_the_loop_that_is_built_at_once_to_the_last_bit(delay):
    late = DigitalLoop(LOOP, 1e-2, ROUGH, delay)
    at_once = LOOP.digital(1e-2, ROUGH, delay=delay)
    assert late.ode().fingerprint == at_once.fingerprint
    assert end(late, 3) == end(at_once, 3)


def test_its_equations_carry_the_name_that_is_asked_for_and_its_integrator():
    fine = DigitalLoop(LOOP, 1e-2, integrator="fine")
    assert equations_of(fine, "mine").name == "mine"
    assert fine.ode().fingerprint == LOOP.digital(1e-2, integrator="fine").fingerprint
    assert fine.ode().fingerprint != DigitalLoop(LOOP, 1e-2).ode().fingerprint


def test_a_run_takes_it_and_builds_nothing(monkeypatch):
    monkeypatch.setattr(ClosedLoop, "digital", lambda *_, **__: pytest.fail("built too early"))
    wb.Case("late", "PI", wb.Run(DigitalLoop(LOOP, 1e-2), (wb.rmse(),), until=0.2, h=5e-3))


def test_a_loop_less_a_part_keeps_its_computer():
    law = wb.PID(Motor().outputs, Motor().inputs, Kp=50.0, Ki=100.0)
    whole = DigitalLoop(replace(LOOP, controller=law), 1e-2, ROUGH, 2)
    parts = whole.ablations()
    assert parts.keys() == whole.loop.ablations().keys() != set()
    for name, less in parts.items():
        alone = whole.loop.ablations()[name].digital(1e-2, ROUGH, delay=2)
        assert less.ode().fingerprint == alone.fingerprint


# Commands that wait at the start


def test_the_commands_that_wait_at_the_start_act_first():
    late = DigitalLoop(LOOP, 1e-2, delay=2, initial_commands={"v": 7.0})
    run = wb.simulate(late, until=4e-2, every=1e-2)
    # each period ends with the command that was held in it
    np.testing.assert_array_equal(run["v"][0, :2, 0], [7.0, 7.0])
    assert run["v"][0, 2, 0] == LOOP.ode().outputs_at(0.0, LOOP.ode().states.default)["v"][0]


def test_a_delay_whose_first_command_waits_already_loses_no_time_at_the_start():
    ode = LOOP.ode()
    first = ode.outputs_at(0.0, ode.states.default)["v"]
    held = LOOP.digital(1e-2, delay=True, initial_commands={"v": first})
    plain = wb.simulate(LOOP.digital(1e-2), until=1e-2, every=1e-2)["omega"]
    np.testing.assert_array_equal(wb.simulate(held, until=1e-2, every=1e-2)["omega"], plain)


def test_the_law_alone_is_handed_over_with_the_same_commands_in_its_queue():
    law = DigitalLoop(LOOP, 1e-2, delay=True, initial_commands={"v": 7.0}).ode().law()
    assert law.memory["hold.next"].default == 7.0
    recorded = wb.record(DigitalLoop(LOOP, 1e-2, delay=True, initial_commands={"v": 7.0}).ode(), law, 3)
    assert recorded.u[0, 0] == 7.0


# Refusals


@pytest.mark.parametrize(
    ("change", "kind", "words"),
    [
        ({"period": 0.0}, ValueError, r"`DigitalLoop\(period=...\)` must be"),
        ({"integrator": "Euler"}, (ValueError, LookupError), "Euler"),
        ({"delay": 0.5}, ValueError, "whole number of periods"),
        ({"delay": {"w": 1}}, LookupError, "inputs of the plant"),
        ({"initial_commands": {"v": 1.0}}, ValueError, "acts at once"),
        ({"delay": True, "initial_commands": {"w": 1.0}}, LookupError, "inputs of the plant"),
        (
            {"delay": True, "initial_commands": {"v": [1.0, 2.0]}},
            ValueError,
            r"must be finite numbers of the shape \(\)",
        ),
        ({"delay": True, "initial_commands": {"v": np.nan}}, ValueError, "must be finite numbers"),
    ],
)
def test_a_computer_that_is_none_is_refused_where_it_is_declared(change, kind, words):
    with pytest.raises(kind, match=words):
        DigitalLoop(**{"loop": LOOP, "period": 1e-2} | change)
