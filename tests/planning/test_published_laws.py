"""Laws that are printed elsewhere, with all their data."""

import numpy as np
import pytest
from scipy.linalg import expm, solve_discrete_lyapunov

from workbench.planning.linear_mpc import MpcLimits, exact_mpc, mpc_problem

DIGITS = 6e-5  # half of the last digit of the printed gains, and some rounding


def explicit_law(weight):
    """The example of section 7.1 of Bemporad, Morari, Dua and Pistikopoulos (2002): y = 2/(s^2 + 3 s + 2) u.

    It is sampled every 0.1 s and looks two samples ahead, with Q = 1, R = 0.01 and |u| <= 2.
    """
    model = expm(0.1 * np.array([[-3.0, -1.0, 0.5**0.5], [2.0, 0.0, 0.0], [0.0, 0.0, 0.0]]))
    A, B = model[:2, :2], model[:2, 2:]
    return exact_mpc(mpc_problem(A, B, np.eye(2), [[0.01]], 2, MpcLimits(inputs=(-2.0, 2.0)), P=weight(A)))


def affine_law(exact, x):
    """The gain (2,) and the offset of the move at a state within a region of the law."""
    x, step = np.array(x), 1e-4  # a law of straight pieces has no error of differences
    u = exact.first_move(x)[0]
    gain = np.array([(exact.first_move(x + step * v)[0] - u) / step for v in np.eye(2)])
    return gain, u - gain @ x


@pytest.mark.parametrize(
    ("x", "gain", "offset"),
    [
        ((-0.1, 0.0), (-5.9220, -6.8883), 0.0),
        ((0.25, -0.5), (-6.4159, -4.6953), 0.6423),
        ((-0.25, 0.5), (-6.4159, -4.6953), -0.6423),
        ((1.0, 1.0), (0.0, 0.0), -2.0),
    ],
)
def test_the_explicit_law_of_a_paper_has_its_printed_gains(x, gain, offset):
    exact = explicit_law(lambda A: solve_discrete_lyapunov(A, np.eye(2)))
    found = affine_law(exact, x)
    np.testing.assert_allclose(found[0], gain, rtol=0, atol=DIGITS)
    assert found[1] == pytest.approx(offset, abs=DIGITS)


def test_the_printed_gains_belong_to_a_weight_with_a_transposed_matrix():
    right = affine_law(explicit_law(lambda A: solve_discrete_lyapunov(A.T, np.eye(2))), (-0.01, 0.0))
    assert np.abs(right[0] - (-5.9220, -6.8883)).max() > 0.9  # P = A'PA + Q is the cost without inputs
