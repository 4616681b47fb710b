"""Arms with a name."""

import numpy as np
import pytest

from workbench.arms.dynamics import Dynamics
from workbench.arms.mechanics import CATALOGUE, paper_arm, robot


@pytest.mark.parametrize("name", CATALOGUE)
def test_every_arm_of_the_catalogue_has_a_positive_definite_mass_matrix(name):
    dynamics = Dynamics.of(robot(name), name)
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
    M, _, G = Dynamics.of(robot("planar-1r")).matrices([np.pi / 2], [0.0])
    np.testing.assert_allclose(M, [[1 / 3]], rtol=1e-15)
    np.testing.assert_allclose(G, [9.81 / 2], rtol=1e-15)


def test_an_unknown_arm_is_answered_with_the_nearest_or_with_all():
    with pytest.raises(LookupError, match=r"There is no 'planar-5r' among the 12 robots.*Did you mean 'planar-\dr'\?"):
        robot("planar-5r")
    with pytest.raises(LookupError, match="They are: paper-arm, planar-1r"):
        robot("zzz")


@pytest.mark.parametrize("name", [None, 3, ["planar-1r"]])
def test_a_name_that_is_no_text_is_refused(name):
    with pytest.raises(LookupError, match=r"The robots of the catalogue go by names, which are text; got"):
        robot(name)


def test_the_pelican_has_the_mass_matrix_that_its_book_prints():
    d = Dynamics.of(robot("pelican"))
    for q2 in (0.0, 1.0, 2.5):
        M, _, _ = d.matrices([0.7, q2], [0.0, 0.0])
        c = np.cos(q2)
        printed = [[0.3353 + 0.0244 * c, 0.0127 + 0.0122 * c], [0.0127 + 0.0122 * c, 0.0127]]
        np.testing.assert_allclose(M, printed, rtol=0, atol=1e-4)  # four digits are printed


def test_the_arm_of_slotine_and_li_has_the_four_numbers_of_its_book():
    d = Dynamics.of(robot("slotine-li"))
    a1, a2, a3, a4 = 3.34, 0.97, 1.2 * np.cos(np.pi / 6), 0.6  # the book rounds them to 3.3, 0.97, 1.04 and 0.6
    for q2 in (0.0, 1.0, 2.5):
        M, C, G = d.matrices([0.7, q2], [0.4, -0.9])
        s, c = np.sin(q2), np.cos(q2)
        coupled = a2 + a3 * c + a4 * s
        h = a3 * s - a4 * c
        np.testing.assert_allclose(M, [[a1 + 2 * a3 * c + 2 * a4 * s, coupled], [coupled, a2]], rtol=1e-14)
        np.testing.assert_allclose(C, [[0.9 * h, -h * (0.4 - 0.9)], [h * 0.4, 0.0]], rtol=1e-14, atol=1e-15)
        np.testing.assert_array_equal(G, 0)


def test_the_cart_pole_moves_as_its_equations_say():
    d = Dynamics.of(robot("cart-pole"))
    cart, pole, half, g = 1.0, 0.1, 0.5, 9.8
    force, angle, rate = 3.0, 0.3, -0.7
    M, C, G = d.matrices([1.0, angle], [0.5, rate])
    s, c = np.sin(angle), np.cos(angle)
    np.testing.assert_allclose(
        M, [[cart + pole, pole * half * c], [pole * half * c, pole * half**2 * 4 / 3]], rtol=1e-14
    )
    np.testing.assert_allclose(C, [[0, -pole * half * s * rate], [0, 0]], rtol=1e-14, atol=1e-16)
    np.testing.assert_allclose(G, [0, -pole * g * half * s], rtol=1e-14, atol=1e-16)
    # the accelerations as Barto, Sutton and Anderson print them, without friction
    push = (force + pole * half * rate**2 * s) / (cart + pole)
    turn = (g * s - c * push) / (half * (4 / 3 - pole * c**2 / (cart + pole)))
    slide = push - pole * half * turn * c / (cart + pole)
    np.testing.assert_allclose(d.acceleration([1.0, angle], [0.5, rate], [force, 0.0]), [slide, turn], rtol=1e-13)


def test_the_hand_of_the_panda_is_part_of_its_last_link():
    last = robot("panda").links[6]
    np.testing.assert_allclose(last.mass, 0.735522 + 0.73 + 2 * 0.015, rtol=1e-15)
    # along the axis: the link's own centre, and hand and fingers beyond the flange at 0.107
    heights = 0.735522 * 0.061597 + 0.73 * (0.107 + 0.03) + 0.03 * (0.107 + 0.0584)
    np.testing.assert_allclose(last.com[2], heights / last.mass, rtol=1e-14)
