"""The torque of an arm as a matrix times the numbers of its bodies, and the fewest of them that matter."""

import casadi as ca
import numpy as np
import pytest
from arms import random_tree

from workbench.core import lift
from workbench.robots import SpatialArm, SpatialLink, named
from workbench.robots.base_parameters import base_parameters
from workbench.robots.regressor import names, parameters, regressor

ROUNDING = 1e-12  # a few hundred terms of a double each, relative to the largest


def symbols(arm):
    return [ca.SX.sym(letter, arm.dof) for letter in ("q", "qd", "qdd")]


@pytest.mark.parametrize("extras", [{}, {"viscous": 0.4, "coulomb": 0.3, "rotor": 1e-3, "gear": 20.0}])
def test_the_regressor_times_the_parameters_is_the_torque(extras):
    rng = np.random.default_rng(4)
    arm = random_tree(5, rng, **extras)
    state = symbols(arm)
    both = ca.Function("tau", state, [regressor(arm, *state) @ parameters(arm), arm.torque(*state)])
    for numbers in rng.uniform(-3, 3, (20, 3, 5)):
        ours, theirs = map(np.array, both(*numbers))
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=ROUNDING * np.abs(theirs).max())


def test_the_regressor_knows_no_mass_and_theta_is_symbolic_where_the_arm_is():
    arm = random_tree(3, np.random.default_rng(1), viscous=0.1)
    lifted = lift(arm)
    state = symbols(arm)
    masses = ca.vertcat(*[link.mass for link in lifted.block.links])
    assert not ca.depends_on(regressor(lifted.block, *state), masses)
    theta = parameters(lifted.block)
    assert ca.depends_on(theta, masses)
    assert theta.shape == (len(names(arm)), 1) == (33, 1)
    at = dict(zip(names(arm), np.array(ca.evalf(parameters(arm))).ravel(), strict=True))
    assert at["joint 1.m"] == arm.links[1].mass
    assert at["joint 2.viscous"] == 0.1


def test_the_panda_has_as_many_base_parameters_as_its_identification_found():
    # Gaz et al. (2019): 43 dynamic coefficients without friction
    found = base_parameters(named("panda"), np.random.default_rng(0))
    assert len(found.kept) == 43
    assert found.gap > 1e12
    assert found.condition < 100


@pytest.mark.parametrize("make", [lambda: named("scara"), lambda: random_tree(4, np.random.default_rng(2), rotor=0.1)])
def test_the_base_parameters_make_the_same_torque(make):
    arm = make()
    found = base_parameters(arm, np.random.default_rng(5))
    state = symbols(arm)
    both = ca.Function("tau", state, [regressor(arm, *state), arm.torque(*state)])
    theta = found.K @ np.array(ca.evalf(parameters(arm))).ravel()
    for numbers in np.random.default_rng(6).uniform(-3, 3, (20, 3, arm.dof)):
        Y, tau = map(np.array, both(*numbers))
        np.testing.assert_allclose(Y[:, found.kept] @ theta, tau.ravel(), rtol=0, atol=ROUNDING * np.abs(tau).max())
    assert found.residual < ROUNDING


def test_the_base_parameters_of_a_two_link_arm_are_those_of_the_book():
    # Siciliano et al., section 7.3: with the centre of mass anywhere on the plane, six; the far mass acts at l1
    flat = {"inertia": (0.1, 0, 0, 0.1, 0, 0.1), "axis": (0, 1, 0)}
    arm = SpatialArm(
        (
            SpatialLink("near", 2.0, (0.3, 0.0, 0.1), **flat),
            SpatialLink("far", 1.0, (0.2, 0.0, 0.0), position=(0.7, 0.0, 0.0), parent=0, **flat),
        )
    )
    found = base_parameters(arm, np.random.default_rng(0))
    assert found.names == ("near.mc_x", "near.mc_z", "near.I_yy", "far.mc_x", "far.mc_z", "far.I_yy")
    by_name = dict(zip(found.names, found.K, strict=True))
    far_mass = names(arm).index("far.m")
    np.testing.assert_allclose([by_name["near.mc_x"][far_mass], by_name["near.I_yy"][far_mass]], [0.7, 0.49], rtol=1e-9)


def test_a_number_of_base_parameters_in_doubt_is_refused():
    # a joint that is 1e-8 off parallel: two entries differ by that much only
    tilt = 1e-8
    axis = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    body = {"mass": 1.0, "com": (0.2, 0.1, 0.3), "inertia": (0.1, 0, 0, 0.1, 0, 0.1)}
    links = (SpatialLink("near", **body), SpatialLink("far", axis=axis, position=(0.5, 0, 0), parent=0, **body))
    with pytest.raises(ValueError, match="too close to one of a special shape to count them"):
        base_parameters(SpatialArm(links), np.random.default_rng(0))
