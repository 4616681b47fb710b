"""Where the links of a planar arm are."""

import casadi as ca
import numpy as np
import pytest
from arms import moving_arms
from hypothesis import given
from hypothesis import strategies as st

from workbench.robots import Link, PlanarArm, kinematics, named, paper_arm


def numbers(expression) -> np.ndarray:
    return np.array(ca.evalf(ca.densify(expression)))


@pytest.mark.parametrize(("zero", "tip"), [("down", (0, -2)), ("right", (2, 0)), ("up", (0, 2))])
def test_a_straight_arm_points_where_its_zero_says(zero, tip):
    arm = PlanarArm(paper_arm().links, zero=zero)
    np.testing.assert_array_equal(numbers(arm.tip(ca.SX([0, 0]))).ravel(), tip)


def test_angles_are_counted_counter_clockwise_from_the_link_before():
    tip = numbers(paper_arm().tip(ca.SX([np.pi / 2, np.pi / 2]))).ravel()
    np.testing.assert_allclose(tip, [1, 1], atol=1e-15)  # out to the right, then up


def test_the_offset_lies_to_the_left_of_the_link():
    links = (Link(1.0, 1.0, 0.5, 0.2, 0.0),)
    com = numbers(kinematics.centres_of_mass(links, "right", ca.SX([0.0]))[0]).ravel()
    np.testing.assert_array_equal(com, [0.5, 0.2])


@given(moving_arms())
def test_the_tip_jacobian_is_the_derivative_of_the_tip(drawn):
    arm, q, _ = drawn
    J = numbers(arm.tip_jacobian(ca.SX(q)))
    h, reach = 1e-5, sum(link.length for link in arm.links)
    for i, step in enumerate(h * np.eye(arm.dof)):
        difference = (numbers(arm.tip(ca.SX(q + step))) - numbers(arm.tip(ca.SX(q - step)))).ravel() / (2 * h)
        # h^2/6 = 2e-11 of the third derivative and eps/h = 2e-11 of the value, both at most the reach
        np.testing.assert_allclose(J[:, i], difference, atol=1e-9 * reach)


@given(moving_arms())
def test_the_kinetic_energy_is_that_of_the_bodies_velocities(drawn):
    arm, q, qd = drawn
    angle = ca.SX.sym("q", arm.dof)
    energy = 0.0
    for k, link in enumerate(arm.links):
        com = kinematics.centres_of_mass(arm.links, arm.zero, angle)[k]
        v = numbers(ca.substitute(ca.jacobian(com, angle), angle, ca.SX(q))) @ qd
        energy += link.mass * v @ v / 2 + link.inertia * qd[: k + 1].sum() ** 2 / 2
    # two roads to one sum of squares: no more than a hundred roundings of the largest term
    assert float(arm.kinetic_energy(ca.SX(q), ca.SX(qd))) == pytest.approx(energy, rel=1e-12, abs=1e-12)


@given(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6))
def test_an_arm_that_has_turned_many_times_is_as_exact_as_one_that_has_not(a, b):
    rounded = a + b
    part = rounded - a
    lost = (a - (rounded - part)) + (b - part)  # what the sum of two doubles drops, exactly (Knuth)
    c, s = (float(number) for number in kinematics.turn(ca.SX([a, b]), 0, 1))
    # lost is below 1e-10, so the next term of the series is below rounding; a few roundings are left
    np.testing.assert_allclose(c, np.cos(rounded) - lost * np.sin(rounded), rtol=0, atol=1e-15)
    np.testing.assert_allclose(s, np.sin(rounded) + lost * np.cos(rounded), rtol=0, atol=1e-15)


@pytest.mark.parametrize("name", ["ur5", "panda", "scara", "cart-pole"])
def test_the_jacobian_of_a_frame_is_the_derivative_of_its_pose(name):
    arm, rng = named(name), np.random.default_rng(3)
    q = ca.SX.sym("q", arm.dof)
    for frame in ["", *(frame.name for frame in arm.frames)]:
        pose, J = arm.pose(q, frame), arm.jacobian(q, frame)
        turns = [
            ca.reshape(ca.jacobian(ca.vec(ca.densify(pose.rotation)), q[i]), 3, 3) @ pose.rotation.T
            for i in range(arm.dof)
        ]
        angular = ca.horzcat(*[ca.vertcat(S[2, 1], S[0, 2], S[1, 0]) for S in turns])
        expected = ca.vertcat(ca.jacobian(pose.position, q), angular)
        both = ca.Function("J", [q], [J, ca.densify(expected)])
        for _ in range(5):
            ours, theirs = map(np.array, both(rng.uniform(-3, 3, arm.dof)))
            np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-14)  # a dozen turns of lengths of a metre


def test_the_pose_of_a_frame_at_the_base_moves_with_no_joint():
    arm = named("panda")
    q = ca.SX.sym("q", 7)
    assert not ca.depends_on(ca.densify(arm.pose(q, "panda_link0").position), q)
    assert arm.jacobian(q, "panda_link0").is_zero()


def test_an_unknown_frame_is_answered_with_the_nearest():
    with pytest.raises(LookupError, match="There is no 'tool' among the 14 frames of this arm. Did you mean 'tool0'?"):
        named("ur5").pose(ca.SX.zeros(6), "tool")
    with pytest.raises(LookupError, match="no .x. among the 4 frames.* They are: shoulder, elbow, quill, spindle."):
        named("scara").jacobian(ca.SX.zeros(4), "x")
