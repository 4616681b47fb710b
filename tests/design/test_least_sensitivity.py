"""The least peaks of S and T against closed forms, the matrix of Pick, and controllers that come near them."""

import control
import numpy as np
import pytest
from scipy import linalg

import workbench as wb
from workbench.design.matrices import DesignError
from workbench.design.synthesis import least_complementary_sensitivity, least_sensitivity

WEIGHT = control.tf([0.5, 1.0], [1.0, 0.01])


def by_pick(points, values):
    """The least norm of a stable function with these values at simple points, by the pencil of Pick's matrix."""
    z, v = np.array(points, dtype=complex), np.array(values, dtype=complex)
    across = z[:, None] + z.conj()[None, :]
    return np.sqrt(linalg.eigvalsh(np.outer(v, v.conj()) / across, 1 / across)[-1])


def blaschke(s, roots):
    return np.prod([(s - r) / (s + np.conj(r)) for r in roots])


def test_one_zero_and_one_pole_have_the_closed_form():
    for z, p in ((4.0, 1.0), (1.1, 1.0), (1.0, 7.0)):
        for least in (least_sensitivity, least_complementary_sensitivity):
            assert least([1.0, -z], [1.0, -p]).gamma == pytest.approx(abs((z + p) / (z - p)), rel=1e-13)


def test_simple_points_agree_with_the_matrix_of_pick():
    zeros, poles = [1.0 + 2.0j, 1.0 - 2.0j, 3.0], [0.5, 6.0]
    num, den = np.poly(zeros).real, np.poly([*poles, -1.0]).real
    values = [WEIGHT(z) / blaschke(z, poles) for z in zeros]
    assert least_sensitivity(num, den, WEIGHT).interpolation == pytest.approx(by_pick(zeros, values), rel=1e-9)
    values = [WEIGHT(p) / blaschke(p, zeros) for p in poles]
    assert least_complementary_sensitivity(num, den, WEIGHT).gamma == pytest.approx(by_pick(poles, values), rel=1e-9)


def test_a_multiple_zero_is_the_limit_of_two_near_ones():
    double = least_sensitivity(np.poly([2.0, 2.0]), np.poly([0.5, -1.0]), WEIGHT).gamma
    # the difference is even in the distance of the two zeros
    gaps = (1e-2, 1e-3)
    near = [least_sensitivity(np.poly([2.0 + d, 2.0 - d]), np.poly([0.5, -1.0]), WEIGHT).gamma - double for d in gaps]
    assert abs(near[1]) < 1e-5 * double
    assert near[0] / near[1] == pytest.approx(100, rel=0.05)


def test_the_boundary_decides_where_the_plant_is_strictly_proper_or_has_a_zero_on_the_axis():
    assert least_sensitivity([1.0], [1.0, 1.0]).gamma == 1.0
    assert least_sensitivity([1.0, 1.0], [1.0, 2.0]).gamma == 0.0
    on_axis = least_sensitivity([1.0, 0.0, 4.0], [1.0, 2.0, 1.0], WEIGHT)
    assert on_axis.gamma == pytest.approx(abs(WEIGHT(2j)), rel=1e-12)
    assert least_complementary_sensitivity([1.0], [1.0, 1.0]).gamma == 0.0
    assert least_complementary_sensitivity([1.0], [1.0, 0.0]).gamma == 1.0


def test_a_zero_of_the_weight_may_lie_on_either_side():
    right, left = (control.tf([1.0, -c], [1.0, 2.0]) for c in (0.7, -0.7))
    one, other = (least_sensitivity([1.0, -3.0], [1.0, -1.0], W).gamma for W in (right, left))
    assert one == pytest.approx(other, rel=1e-13)


def test_a_controller_of_mixed_sensitivity_comes_near_the_least_peak():
    G = control.tf([1.0, -4.0], [1.0, 1.0, -2.0])
    least = least_sensitivity([1.0, -4.0], [1.0, 1.0, -2.0]).gamma
    gammas = [wb.hinf_controller(wb.mixed_sensitivity(G, W1=1.0, W2=w)).gamma.value for w in (1e-2, 1e-4)]
    assert least < gammas[1] < gammas[0]
    assert gammas[1] == pytest.approx(least, rel=1e-3)


@pytest.mark.parametrize(
    ("num", "den", "weight", "error", "words"),
    [
        ([1.0, -1.0], [1.0, 0.0, -1.0], None, DesignError, "not stabilisable: its unstable pole 1"),
        ([1.0, 0.0, 0.0], [1.0, 1.0], None, ValueError, "the plant must be proper"),
        ([1.0], [1.0, 1.0], control.tf([1.0, 0.0], [1.0]), ValueError, "weight must be proper"),
        ([1.0], [1.0, 1.0], control.tf([1.0], [1.0, -2.0]), ValueError, "weight must be stable.*pole 2"),
        ([1.0, 0.0], [1.0, 1.0], control.tf([1.0], [1.0, 0.0]), DesignError, "the norm is infinite"),
        ([np.nan], [1.0, 1.0], None, ValueError, "num of the plant must be finite"),
    ],
)
def test_what_has_no_least_peak_is_refused(num, den, weight, error, words):
    with pytest.raises(error, match=words):
        least_sensitivity(num, den, weight)
