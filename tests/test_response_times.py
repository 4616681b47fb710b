"""The times of step responses: fast and slow modes are both drawn, and each value is exact."""

import control
import numpy as np
import pytest

from workbench.design.linear.response_times import exact_responses, response_times, times_of
from workbench.design.linear.system_answers import step_answers

STIFF = control.tf([0.5], [20, 1]) + control.tf([50], [1, 1, 100])  # 1/20 1/s beside 10 rad/s
ROOT = np.sqrt(100 - 0.25)


def closed_form(t):
    slow, turning = 1 - np.exp(-t / 20), np.exp(-t / 2) * (np.cos(ROOT * t) + 0.5 / ROOT * np.sin(ROOT * t))
    return 0.5 * slow + 0.5 * (1 - turning)


def test_a_fast_mode_beside_a_slow_one_is_drawn_with_its_turns():
    t, y, (final,) = step_answers(STIFF)
    assert final == pytest.approx(1.0)
    assert (t[0], t[-1]) == (0, pytest.approx(160.0, rel=1e-12))
    np.testing.assert_allclose(y[0, 0], closed_form(t), atol=1e-13)  # some ten thousand roundings
    fast = t < 8  # in which the fast mode falls to 2 % of its start
    assert np.diff(t[fast]).max() < 2 * np.pi / ROOT / 40
    middle = (t[:-1] + t[1:]) / 2
    bend = np.abs(closed_form(middle) - (y[0, 0, :-1] + y[0, 0, 1:]) / 2)
    assert bend.max() < 2e-3  # of the step: less than the width of a line


def test_the_impulse_response_is_the_slope_of_the_step_response():
    t, y, _ = step_answers(STIFF, until=10.0, impulse=True)
    slope = (closed_form(t + 1e-6) - closed_form(t - 1e-6)) / 2e-6
    np.testing.assert_allclose(y[0, 0], slope, atol=1e-8)  # the error of the difference


@pytest.mark.parametrize("poles", [[-1.0], [-1e-9, -1e9], [2.0, -50.0], [0.0, 300j, -300j], [-0.05, -0.01 + 100j]])
def test_times_begin_at_zero_end_at_the_horizon_and_are_not_too_many(poles):
    steps = response_times(np.array(poles, dtype=complex), 7.0)
    t = times_of(steps)
    assert (t[0], t[-1]) == (0.0, pytest.approx(7.0, rel=1e-12))
    assert (np.diff(t) > 0).all()
    assert 1000 <= len(t) < 50_000


def test_many_rows_have_the_values_of_each_alone():
    random = np.random.default_rng(0)
    A, B = random.normal(size=(3, 4, 4)) - 3 * np.eye(4), random.normal(size=(3, 4, 2))
    C, D = random.normal(size=(3, 1, 4)), random.normal(size=(3, 1, 2))
    steps = response_times(np.linalg.eigvals(A).ravel(), 3.0, 100)
    together = exact_responses(A, B, C, D, steps)
    for k in range(3):
        alone = exact_responses(A[k], B[k], C[k], D[k], steps)
        np.testing.assert_allclose(together[:, k], alone, atol=1e-13)
