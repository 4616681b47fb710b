"""A socket takes what fits, and says of anything else what it is and what is wanted."""

import copy
import pickle
from dataclasses import dataclass

import casadi as ca
import numpy as np
import pytest

from workbench.arms.dynamics import AbstractArm, Dynamics
from workbench.arms.laws import AdaptiveSlidingMode, AosmcRgs, ArmPID, LeakageAdaptation, SlidingMode
from workbench.arms.manipulator import Friction, Manipulator
from workbench.arms.mechanics import PlanarArm, paper_arm
from workbench.arms.mechanics.planar_arm import PointMass
from workbench.arms.observers import ArmFullState, OracleFilter, StateAndDisturbanceObserver
from workbench.blocks.loop import ClosedLoop, open_loop
from workbench.blocks.signals import Constant, Sines
from workbench.core import block, lift, parameter, rk4

ARM = paper_arm()
LINK = PointMass(1.0, 1.0)
PLANT = Manipulator(ARM, q=[0.1, 0.2])
LAW = ArmPID([1.0, 1.0], [0.0, 0.0], [1.0, 1.0], ARM)
WANTED = Sines("q", "rad", [1.0, 1.0], [1.0, 1.0])
STATE = ArmFullState(2)


@dataclass(frozen=True)
class Letters(AbstractArm):
    """An arm that is no block."""

    @property
    def dof(self):
        return 1

    def mass_matrix(self, q):
        return ca.SX(2)

    def coriolis_matrix(self, q, qd):
        return ca.SX(1, 1)

    def gravity_vector(self, q):
        return ca.sin(q)


@block
class Mixed:
    """A field of each plain kind, and tuples of both kinds."""

    count: int = 1
    on: bool = True
    name: str = "x"
    pair: tuple[int, str] = (1, "a")
    several: tuple[PointMass, ...] | None = None
    number: float = 0.5


def loop():
    return ClosedLoop(PLANT, STATE, LAW, WANTED)


SAID = [
    (lambda: Manipulator(paper_arm, q=[0.0]), "got the function `paper_arm` itself: call it."),
    (lambda: Manipulator(PlanarArm, q=[0.0]), "got the class `PlanarArm` itself: make one with `PlanarArm(...)`."),
    (
        lambda: ClosedLoop(PLANT, LAW, STATE, WANTED),
        "`ClosedLoop(observer=...)` must be an `AbstractObserver`; got an `ArmPID`, which is an "
        "`AbstractArmController`.",
    ),
    (
        lambda: StateAndDisturbanceObserver(STATE, STATE),
        "`StateAndDisturbanceObserver(disturbance=...)` must be an `AbstractDisturbanceObserver`; got an "
        "`ArmFullState`, which is an `AbstractArmObserver`.",
    ),
    (
        lambda: PlanarArm((ARM, ARM)),
        "`PlanarArm(links=...)` must be a tuple of `Link` or `PointMass`; got a `PlanarArm`, which is an "
        "`AbstractArm` at [0].",
    ),
    (lambda: PlanarArm((LINK, 1.0)), "got 1.0 at [1]."),
    (lambda: Mixed(on=1), "`Mixed(on=...)` must be True or False; got 1."),
    (lambda: Mixed(name=3), "must be text; got 3."),
    (lambda: Mixed(number=True), "must be a number; got True."),
    (lambda: Mixed(pair=(1, 2)), "got 2 at [1]."),
    (lambda: Mixed(pair=(1,)), "got 1 of them."),
    (lambda: Mixed(several=(LINK, None)), "must be a tuple of `PointMass` or None; got None at [1]."),
    (lambda: lift(3.0), "`lift(block=...)` must be a block, an instance of a class made by `@block`; got 3.0."),
    (lambda: lift(loop().ode()), "got an `Ode`."),
    (lambda: rk4(loop(), 0.1), "must be an `Ode`; got a `ClosedLoop`: a loop becomes one by its method `ode()`."),
    (lambda: PlanarArm((LINK,), zero=["down"]), "is one of 'down', 'right', 'up'; got ['down']."),
    (lambda: ArmPID([], [], []), "`ArmPID(Kp=...)` needs at least one number; got none."),
    (lambda: Sines("q", "rad", [], []), "`Sines(amplitude=...)` needs at least one number"),
    (lambda: Constant("q", "rad", []), "needs at least one number"),
    (lambda: Friction([], []), "needs at least one number"),
    (lambda: PlanarArm(()), "must be a tuple of at least one `Link` or `PointMass`; got none."),
]


@pytest.mark.parametrize(("make", "says"), SAID)
def test_what_does_not_fit_a_socket_is_refused_with_what_it_is(make, says):
    with pytest.raises(ValueError) as error:
        make()
    assert says in str(error.value)


def test_an_arm_that_is_no_block_fits_every_socket_for_arms():
    assert SlidingMode(Letters(), [1.0], [1.0], 0.1).dof == 1
    assert open_loop(Manipulator(Letters(), q=[0.0])).states.size == 2
    M, _, G = Dynamics.of(Letters()).matrices([np.pi / 2], [0.0])
    assert (M.item(), G.item()) == (2.0, 1.0)


def test_a_list_becomes_a_tuple_and_numpys_whole_numbers_become_pythons():
    assert PlanarArm([LINK, LINK]).dof == 2
    assert isinstance(PlanarArm([LINK]).links, tuple)
    assert type(ArmFullState(np.int64(2)).joints) is int
    assert Mixed(on=np.True_).on is True
    assert Mixed(several=[LINK]).several == (LINK,)


def test_a_field_whose_type_is_out_of_sight_refuses_nothing():
    class Hidden:
        """Known within this function only."""

    @block
    class Holder:
        part: "Hidden"  # text, which is not found from outside
        k: float = parameter(1.0, unit="")

    assert Holder(part=3).part == 3


@pytest.mark.parametrize("again", [copy.deepcopy, copy.copy, lambda thing: pickle.loads(pickle.dumps(thing))])
def test_a_copy_of_a_block_is_as_frozen_as_the_block(again):
    with pytest.raises(ValueError, match="read-only"):
        again(loop()).controller.Kp[0] = -5
    with pytest.raises(ValueError, match="read-only"):
        again(PLANT.states)["q"].default[0] = -5
    np.testing.assert_array_equal(again(loop()).ode().parameters.default, loop().ode().parameters.default)


def test_a_lifted_block_shows_its_symbols_and_a_block_its_plain_fields():
    assert "controller.Kp[0]" in lift(loop()).block.controller._repr_html_()
    assert "<td>joints</td><td>2</td>" in OracleFilter(2, 1.0)._repr_html_()


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"controller.R": -np.eye(2)}, "'controller.R' must be positive definite; got a smallest eigenvalue of -1."),
        ({"controller.R": [[0.0, 0.0], [0.0, 1.0]]}, "'controller.R' must be positive definite"),
        ({"controller.Q": [np.eye(2), -np.eye(2)]}, "must be positive semidefinite.*of -1 in run 1"),
    ],
)
def test_a_weight_that_the_constructor_refuses_is_refused_for_a_run_too(values, says):
    eye = np.eye(2)
    law = AosmcRgs(ARM, [1.0, 1.0], 0.1, K=eye, P=eye, Q=0 * eye, R=eye)
    parameters = ClosedLoop(PLANT, STATE, law, WANTED).ode().parameters
    assert parameters.pack({"controller.Q": np.diag([0.0, 1.0])}).shape == (1, parameters.size)
    with pytest.raises(ValueError, match=says):
        parameters.pack(values)


def test_a_part_is_checked_before_it_is_asked_for_its_size():
    with pytest.raises(ValueError, match=r"`AdaptiveSlidingMode\(adaptation=...\)` must be an `AbstractAdaptation`"):
        AdaptiveSlidingMode(ARM, [1.0, 1.0], 0.1, 1.0, [1.0, 1.0], adaptation=LeakageAdaptation)
