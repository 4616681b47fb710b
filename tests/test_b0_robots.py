"""The roads that the study of the catalogue holds our arms against."""

import casadi as ca
import numpy as np
import pytest

from studies.b0_robots import measurements
from workbench.core import Dynamics
from workbench.robots import CATALOGUE, PlanarArm, named
from workbench.robots.arm_catalogue import planar


def test_equal_operations_are_counted_once():
    x, y = ca.SX.sym("x"), ca.SX.sym("y")
    # sin(x), times y, and the square of that; x itself and a constant are no operations
    entries = ca.horzcat(ca.sin(x) * y, (ca.sin(x) * y) ** 2, x, 3)
    assert measurements.operations(entries) == 3


@pytest.mark.parametrize("name", CATALOGUE)
def test_the_catalogue_obeys_lagranges_equation_of_its_energies(name):
    arm = named(name)
    # rounding of some hundred operations, relative to the largest term
    assert measurements.by_energies(arm, Dynamics.of(arm, symbolic=False)) < 1e-14


@pytest.mark.parametrize("name", CATALOGUE)
def test_the_catalogue_moves_as_in_mujoco(name):
    pytest.importorskip("mujoco")
    arm = named(name)
    # rounding, and the moments of 2e-15 kg m^2 that a point mass is given there
    assert measurements.by_mujoco(arm, Dynamics.of(arm, symbolic=False)) < 1e-13


def test_an_error_in_the_equations_would_be_seen():
    heavier = PlanarArm(planar(2).links, gravity=9.82)
    assert measurements.by_energies(heavier, Dynamics.of(planar(2), symbolic=False)) > 1e-4


@pytest.mark.parametrize("method", ["kane", "lagrange"])
def test_sympy_derives_the_same_chain(method):
    pytest.importorskip("sympy")
    from studies.b0_robots import sympy_chain as chain

    found = chain.measure(method, 2)
    for letter, ours in zip("MCG", Dynamics.of(planar(2)).matrices(*chain.values(2)), strict=True):
        # numbers of size 1 to 20, a dozen operations each
        np.testing.assert_allclose(found["at"][letter], ours, rtol=0, atol=1e-13)
    bias = np.array(found["at"]["C"]) @ chain.values(2)[1] + found["at"]["G"]
    np.testing.assert_allclose(found["at"]["bias"], bias, rtol=0, atol=1e-13)
