"""Arms with a name."""

import numpy as np
import pytest

from workbench.core import Dynamics
from workbench.robots import CATALOGUE, named, paper_arm


@pytest.mark.parametrize("name", CATALOGUE)
def test_every_arm_of_the_catalogue_has_a_positive_definite_mass_matrix(name):
    dynamics = Dynamics.of(named(name), name)
    M, C, G = dynamics.matrices(np.full(dynamics.dof, 0.5), np.ones(dynamics.dof))
    assert np.linalg.eigvalsh(M).min() > 0
    assert np.isfinite(C).all()
    assert np.isfinite(G).all()
    assert dynamics.name == name


def test_the_paper_arm_is_that_of_section_5():
    arm = paper_arm()
    assert [(link.mass, link.length) for link in arm.links] == [(1.0, 1.0), (1.0, 1.0)]
    assert (arm.gravity, arm.zero) == (9.81, "down")


def test_a_slender_rod_swings_with_its_known_inertia():
    M, _, G = Dynamics.of(named("planar-1r")).matrices([np.pi / 2], [0.0])
    np.testing.assert_allclose(M, [[1 / 3]], rtol=1e-15)
    np.testing.assert_allclose(G, [9.81 / 2], rtol=1e-15)


def test_an_unknown_arm_is_answered_with_the_nearest_or_with_all():
    with pytest.raises(LookupError, match=r"There is no robot 'planar-5r'.*Did you mean 'planar-\dr'\?"):
        named("planar-5r")
    with pytest.raises(LookupError, match="The catalogue holds: paper-arm, planar-1r"):
        named("zzz")


@pytest.mark.parametrize("name", [None, 3, ["planar-1r"]])
def test_a_name_that_is_no_text_is_refused(name):
    with pytest.raises(LookupError, match=r"`named\(name=...\)` must be the name of a robot, such as 'paper-arm'; got"):
        named(name)
