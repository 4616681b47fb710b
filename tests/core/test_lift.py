"""The twin of symbols says the same as the block of numbers."""

import casadi as ca
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.arms.manipulator import Friction, Manipulator
from workbench.arms.mechanics import Link, PlanarArm, paper_arm
from workbench.blocks.signals import SineTorque
from workbench.core import Signals, block, lift, option, parameter
from workbench.core.block import Scalar, Vector


@block
class Two:
    """Two sockets for arms, one number, one choice."""

    true: PlanarArm
    model: PlanarArm
    Lambda: Vector = parameter(unit="1/s", shape=("n",))
    k: Scalar | None = parameter(None, unit="N m")
    reading: str = option({"a": "one", "b": "other"}, default="a")


def test_parameters_are_keyed_by_their_paths():
    names = lift(Two(paper_arm(), paper_arm(), [6.0, 6.0])).layout.names
    assert names == (
        "true.links[0].mass",
        "true.links[0].length",
        "true.links[1].mass",
        "true.links[1].length",
        "true.gravity",
        "model.links[0].mass",
        "model.links[0].length",
        "model.links[1].mass",
        "model.links[1].length",
        "model.gravity",
        "Lambda",
    )


def test_an_arm_met_twice_gets_two_sets_of_symbols():
    arm = paper_arm()
    twin = lift(Two(arm, arm, [6.0, 6.0])).block
    assert not ca.depends_on(twin.true.links[0].mass, twin.model.links[0].mass)
    assert twin.true.links[0].mass.name() == "true.links[0].mass"


def test_what_is_left_out_and_what_is_chosen_stay_as_they_are():
    twin = lift(Two(paper_arm(), paper_arm(), [6.0, 6.0], reading="b")).block
    assert twin.k is None
    assert twin.reading == "b"
    assert type(twin) is Two
    assert type(twin.true) is PlanarArm


def test_starts_of_memory_are_no_parameters():
    names = lift(Manipulator(paper_arm(), q=[1.0, 2.0])).layout.names
    assert not [name for name in names if name.endswith((".q", ".qd")) or name in ("q", "qd")]


def test_the_layout_carries_defaults_units_bounds_and_printed_symbols():
    layout = lift(paper_arm()).layout
    entry = layout["links[1].mass"]
    assert (entry.unit, float(entry.default), entry.bounds.low, entry.bounds.strict) == ("kg", 1.0, 0, True)
    assert layout.printed_names()["links[1].mass"] == "m_2"
    assert layout.printed_names()["gravity"] == "g"


def test_an_unlifted_block_is_untouched():
    arm = paper_arm()
    lift(arm)
    assert arm.links[0].mass == 1.0


positive = st.floats(0.1, 5.0)


@settings(max_examples=5)
@given(st.tuples(positive, positive, positive, positive, st.floats(-1, 1)), st.floats(-3, 3), st.floats(-3, 3))
def test_the_twin_with_default_numbers_is_the_block_itself(numbers, q2, qd2):
    mass, length, com, inertia, offset = numbers
    arm = PlanarArm((Link(mass, length, com, offset, inertia), Link(1.0, 0.5, 0.2, -offset, 0.1)))
    plant = Manipulator(
        arm, [0.0, 0.0], disturbance=SineTorque([1.0, 2.0], [3.0, 4.0]), friction=Friction([0.1, 0.2], [0.3, 0.4])
    )
    lifted = lift(plant)
    z = {"q": ca.SX([0.4, q2]), "qd": ca.SX([-1.0, qd2])}
    tau = Signals(tau=ca.SX([5.0, -3.0]))
    plain = plant.rate(ca.SX(0.7), z, tau)["qd"]
    twin = lifted.block.rate(ca.SX(0.7), z, tau)["qd"]
    value = ca.Function("twin", [lifted.symbols], [twin])(lifted.layout.default)
    # the same formula; CasADi folds the constants of the plain one in another order
    np.testing.assert_allclose(np.array(value), np.array(ca.evalf(plain)), rtol=1e-10, atol=1e-10)
