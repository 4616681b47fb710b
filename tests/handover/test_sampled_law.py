"""The law of a loop alone: the same equations as in the loop, and what it refuses to be without."""

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from tests.support.c_runs import recorded
from tests.support.digital_laws import digital
from workbench.core import SampledSystem
from workbench.handover.law_graph import graph_of_law


def test_a_law_with_its_reference_built_in_needs_time_and_no_reference():
    sampled, _ = digital("SMC")
    law = sampled.law("built in", truths=())
    assert (law.references.size, law.uses_time) == (0, True)
    assert not sampled.law().uses_time


def test_the_stages_of_a_law_name_values_that_its_graph_has():
    _, law = digital("AOSMC-RGS")
    places = {name: part for stage in graph_of_law(law).values for name, part in stage.items()}
    assert None not in places["s"] + places["tau"] + places["controller.K"]
    assert law.stages[0].title.startswith("Observer")


def test_a_delay_is_part_of_the_law():
    sampled, law = digital("SMC")
    assert law.delay == {"tau": 1}
    assert "hold.next" in law.memory.names
    _, _, u, _ = recorded(sampled, law, 3)
    np.testing.assert_array_equal(u[0], 0.0)  # what waits at the start


def test_a_law_that_uses_the_truth_is_refused_unless_the_truth_is_an_input_by_name():
    from studies.paper.laws import proposed_repaired

    sampled = proposed_repaired("FS").digital(1e-3)
    with pytest.raises(
        ValueError, match=r"uses the truth: `StateAndDisturbanceObserver` reads 'd'.*law\(truths=\('d',\)\)"
    ):
        sampled.law()
    assert "d" in sampled.law(truths=("d",)).readings
    with pytest.raises(LookupError, match=r"'e'"):
        sampled.law(truths=("e",))


def test_a_sampled_equation_without_blocks_has_no_law():
    flow = wb.open_loop(wb.DCMotor())
    alone = SampledSystem(flow, 0.1, ca.SX.sym("k"), ca.SX(0, 1), ca.SX(0, 1))
    with pytest.raises(ValueError, match=r"needs a loop that `ClosedLoop.digital` has made"):
        alone.law()


def test_the_fingerprint_of_a_law_changes_with_a_number():
    motor = wb.DCMotor()

    def law(gain):
        pid = wb.PID(motor.outputs, motor.inputs, Kp=gain)
        return wb.ClosedLoop(motor, controller=pid, reference=wb.Step("omega", "rad/s", 1.0)).digital(0.01).law()

    assert law(1.0).fingerprint == law(1.0).fingerprint != law(1.0 + 2**-52).fingerprint
