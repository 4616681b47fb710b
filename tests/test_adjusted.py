"""A loop with other numbers."""

import numpy as np
import pytest
from sweeps import Decay
from workbench.study.adjusted import adjusted

from workbench.controllers import SlidingMode
from workbench.loop import ClosedLoop
from workbench.metrics import iae, measure
from workbench.observers import FullState
from workbench.plants import Manipulator
from workbench.robots import paper_arm
from workbench.signals import Sines


def closed(width=0.05, start=(0.1, 0.2)):
    """An arm under sliding mode control."""
    arm = paper_arm()
    law = SlidingMode(arm, Lambda=5.0, phi=width, K=[20.0, 10.0])
    return ClosedLoop(Manipulator(arm, q=np.array(start)), FullState(2), law, Sines((1.0, 1.0), (1.0, 1.0)))


def test_an_adjusted_loop_is_the_loop_that_was_built_with_those_numbers():
    theirs = closed(0.2, (0.5, 0.2)).ode()
    ours = adjusted(closed(), {"controller.phi": 0.2, "plant.q[0]": 0.5}).ode()
    assert ours.fingerprint == theirs.fingerprint
    np.testing.assert_array_equal(ours.parameters.default, theirs.parameters.default)
    np.testing.assert_array_equal(ours.states.default, theirs.states.default)


def test_a_run_takes_the_adjusted_numbers():
    found = measure(adjusted(Decay(), {"rate": 2.0, "x": [3.0]}).ode(), (iae(),), until=2.0, h=0.01)
    # RK4 at 10 ms: the error is (rate h)^4 / 120 of the value
    assert found.scores["IAE"].value[0, 0] == pytest.approx(3 * (1 - np.exp(-4)) / 2, rel=1e-8)


def test_the_computer_of_a_loop_keeps_its_jump_when_its_numbers_change():
    class Digital:
        def ode(self, name="loop"):
            return closed().digital(0.01, name=name)

    ours, theirs = adjusted(Digital(), {"controller.phi": 0.2}).ode(), closed(0.2).digital(0.01)
    assert ours.fingerprint == theirs.fingerprint
    np.testing.assert_array_equal(ours.parameters.default, theirs.parameters.default)


@pytest.mark.parametrize(
    ("numbers", "kind", "said"),
    [
        ({"rat": 1.0}, LookupError, "no 'rat' among the 3 parameters and 1 states of 'loop'. Did you mean 'rate'?"),
        ({"rate": -1.0}, ValueError, "'rate' must be finite, with 0 <= value <= 10"),
        ({"gains": [1.0, 2.0, 3.0]}, ValueError, "shape"),
        ({"rate": [1.0, 2.0]}, ValueError, "one value a path, not those of 2 runs"),
    ],
)
def test_numbers_that_a_loop_does_not_have_or_allow_are_refused(numbers, kind, said):
    with pytest.raises(kind) as refusal:
        adjusted(Decay(), numbers).ode()
    assert said in str(refusal.value)


def test_what_is_no_loop_is_refused():
    with pytest.raises(ValueError, match="or a loop, whose `ode\\(name\\)` gives its equations.*; got 3"):
        adjusted(3, {"a": 1.0})


def test_what_maps_no_paths_is_refused():
    with pytest.raises(ValueError, match="must be a mapping .* as a dict is; got"):
        adjusted(Decay(), [1.0])
