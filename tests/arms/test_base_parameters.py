"""The torque of an arm as a matrix times the numbers of its bodies, and the fewest combinations of them that matter."""

import json
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from hypothesis import given as example
from hypothesis import settings

import workbench as wb
from tests.support.arms import moving_arms, random_tree
from workbench.arms.mechanics import Link, PlanarArm, SpatialArm, SpatialLink

ROUNDING = 1e-12  # a few hundred terms of a double each, relative to the largest
EXAM = Path(__file__).parents[3] / "shared" / "exams" / "dynamics"


def torque_of(arm):
    """The torque of an arm as a function of numbers."""
    state = [ca.SX.sym(name, arm.dof) for name in ("q", "qd", "qdd")]
    function = ca.Function("torque", state, [ca.densify(arm.torque(*state))])
    return lambda *numbers: np.array(function(*numbers)).ravel()


@pytest.mark.parametrize("extras", [{}, {"viscous": 0.4, "coulomb": 0.3, "rotor": 1e-3, "gear": 20.0, "speed": 0.1}])
def test_the_regressor_times_the_parameters_is_the_torque(extras):
    rng = np.random.default_rng(4)
    arm = random_tree(5, rng, **extras)
    Y = wb.regressor(arm)
    assert len(Y.theta) == 5 * (10 + (3 if extras else 0))
    torque = torque_of(arm)
    for state in rng.uniform(-3, 3, (20, 3, 5)):
        theirs = torque(*state)
        np.testing.assert_allclose(Y.at(*state) @ Y.theta, theirs, rtol=0, atol=ROUNDING * np.abs(theirs).max())


@settings(max_examples=6)
@example(moving_arms())
def test_the_regressor_of_a_planar_arm_agrees_with_the_equation_of_lagrange(moving):
    arm, q, qd = moving
    qdd = np.cos(np.arange(arm.dof))
    Y, theirs = wb.regressor(arm), torque_of(arm)(q, qd, qdd)
    size = np.abs(Y.at(q, qd, qdd)) @ np.abs(Y.theta)
    assert np.all(np.abs(Y.at(q, qd, qdd) @ Y.theta - theirs) <= ROUNDING * (size.max() + np.abs(theirs).max()))


def test_every_entry_has_a_name_a_unit_and_a_value():
    rng = np.random.default_rng(1)
    arm = random_tree(3, rng, viscous=0.1, rotor=2e-3, gear=10.0)
    Y = wb.regressor(arm)
    entries = dict(zip(Y.names, zip(Y.units, Y.theta, strict=True), strict=True))
    assert entries["joint 1.m"] == ("kg", arm.links[1].mass)
    assert entries["joint 2.viscous"][1] == 0.1
    assert entries["joint 0.drive"] == (arm.links[0].rotor_unit, pytest.approx(0.2))
    c, m = arm.links[1].com, arm.links[1].mass
    np.testing.assert_allclose([entries[f"joint 1.mc_{axis}"][1] for axis in "xyz"], m * c, rtol=1e-15)
    assert entries["joint 1.I_zz"][1] == pytest.approx(arm.links[1].inertia[5] + m * (c[0] ** 2 + c[1] ** 2))


def test_states_below_one_another_make_rows_below_one_another():
    arm = wb.paper_arm()
    base, states = wb.base_parameters(arm), np.random.default_rng(0).uniform(-1, 1, (3, 7, 2))
    rows = base.at(*states)
    assert rows.shape == (14, len(base.theta))
    np.testing.assert_array_equal(rows[6:8], base.at(*states[:, 3]))


# Known sets


def test_the_base_parameters_of_a_two_link_arm_are_those_of_the_book():
    # Siciliano et al., section 7.3.2: the far mass acts at the length l_1 of the near link
    near, far = Link(2.0, 0.7, 0.3, 0.1, 0.4), Link(1.0, 0.5, 0.2, -0.05, 0.1)
    base = wb.base_parameters(PlanarArm((near, far), 9.81, "right"))
    assert base.combinations == (
        "link1.mc_x + 0.7 link2.m",
        "link1.mc_y",
        "link1.I_zz + 0.49 link2.m",
        "link2.mc_x",
        "link2.mc_y",
        "link2.I_zz",
    )
    assert base.units == ("kg m", "kg m", "kg m^2", "kg m", "kg m", "kg m^2")
    inertias = [0.4 + 2.0 * (0.3**2 + 0.1**2) + 1.0 * 0.7**2, 0.1 + 1.0 * (0.2**2 + 0.05**2)]
    want = [2.0 * 0.3 + 1.0 * 0.7, 2.0 * 0.1, inertias[0], 0.2, -0.05, inertias[1]]
    np.testing.assert_allclose(base.theta, want, rtol=1e-12)


def test_a_two_link_arm_in_space_has_the_same_set():
    flat = {"inertia": (0.1, 0, 0, 0.1, 0, 0.1), "axis": (0, 1, 0)}
    arm = SpatialArm(
        (
            SpatialLink("near", 2.0, (0.3, 0.0, 0.1), **flat),
            SpatialLink("far", 1.0, (0.2, 0.0, 0.0), position=(0.7, 0.0, 0.0), parent=0, **flat),
        )
    )
    base = wb.base_parameters(arm)
    assert base.names == ("near.mc_x", "near.mc_z", "near.I_yy", "far.mc_x", "far.mc_z", "far.I_yy")
    assert base.combinations[::2] == ("near.mc_x + 0.7 far.m", "near.I_yy + 0.49 far.m", "far.mc_z")


@pytest.mark.parametrize("n", [1, 2, 3, 6])
def test_a_planar_arm_has_three_base_parameters_a_link(n):
    # Gautier and Khalil (1990), Direct calculation of minimum set of inertial parameters, IEEE Trans. Robotics 6(3):
    # of parallel axes the mass of each link is grouped with the link before, and m and I_zz of the first one vanish
    assert len(wb.base_parameters(wb.robot(f"planar-{n}r")).theta) == 3 * n


def test_the_panda_has_as_many_base_parameters_as_its_identification_found():
    # Gaz et al. (2019), Dynamic identification of the Franka Emika Panda robot: 43 coefficients without friction
    base = wb.base_parameters(wb.robot("panda"))
    assert len(base.theta) == 43
    assert base.gap > 1e12
    assert base.residual < ROUNDING
    assert base.condition < 100


# Certificates


@pytest.mark.parametrize(
    "make",
    [
        lambda: wb.robot("scara"),
        lambda: wb.robot("cart-pole"),
        lambda: random_tree(4, np.random.default_rng(2), rotor=0.1),
    ],
)
@pytest.mark.parametrize("seed", [0, 7])
def test_the_base_parameters_make_the_same_torque_and_no_fewer_do(make, seed):
    arm = make()
    base = wb.base_parameters(arm, seed=seed)
    rng, torque = np.random.default_rng(6), torque_of(arm)
    for state in rng.uniform(-3, 3, (20, 3, arm.dof)):
        tau = torque(*state)
        np.testing.assert_allclose(base.at(*state) @ base.theta, tau, rtol=0, atol=ROUNDING * np.abs(tau).max())
    rows = base.at(*rng.uniform(-3, 3, (3, 200, arm.dof)))
    assert np.linalg.matrix_rank(rows / np.linalg.norm(rows, axis=0)) == len(base.theta)
    np.testing.assert_array_equal(base.K[:, base.kept_columns], np.eye(len(base.theta)))


def test_the_base_parameters_are_what_a_fit_of_torques_finds():
    arm = random_tree(3, np.random.default_rng(8), viscous=0.2, coulomb=0.1)
    base, rng = wb.base_parameters(arm), np.random.default_rng(3)
    states, torque = rng.uniform(-2, 2, (3, 300, 3)), torque_of(arm)
    tau = np.concatenate([torque(*state) for state in states.transpose(1, 0, 2)])
    found = np.linalg.lstsq(base.at(*states), tau, rcond=None)[0]
    size = np.abs(base.theta).max()
    np.testing.assert_allclose(found, base.theta, rtol=0, atol=base.condition * 1e-12 * size)


@pytest.mark.parametrize(("gravity", "tilt"), [(9.81, 1e-9), (9.81, 1e-6), (0.0, 1e-5)])
def test_a_number_of_base_parameters_in_doubt_is_refused(gravity, tilt):
    # a joint that is so little off the parallel: with gravity two entries differ by that much only
    axis = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    body = {"mass": 1.0, "com": (0.2, 0.1, 0.3), "inertia": (0.1, 0, 0, 0.1, 0, 0.1)}
    links = SpatialLink("near", **body), SpatialLink("far", axis=axis, position=(0.5, 0, 0), parent=0, **body)
    with pytest.raises(ValueError, match=r"where the rank of Y ends.*too near to one of a special shape"):
        wb.base_parameters(SpatialArm(links, gravity))


def test_another_kind_of_arm_is_refused_by_name():
    with pytest.raises(ValueError, match=r"`regressor\(arm=...\)` must be"):
        wb.regressor(wb.DCMotor())


@pytest.mark.skipif(not EXAM.is_dir(), reason="needs the exams beside the repository")
@pytest.mark.parametrize("name", json.loads((EXAM / "index.json").read_text()) if EXAM.is_dir() else [])
def test_the_regressor_gives_the_torques_of_the_exam_with_sixty_digits(name):
    about = json.loads((EXAM / "index.json").read_text())[name]
    data = np.load(EXAM / about["data"])
    arm = wb.read_urdf(EXAM / about["urdf"])
    base, want = wb.base_parameters(arm), data["tau_id"]
    for q, qd, qdd, tau in zip(data["q"], data["qd"], data["qdd_in"], want, strict=True):
        np.testing.assert_allclose(base.at(q, qd, qdd) @ base.theta, tau, rtol=0, atol=ROUNDING * np.abs(want).max())
