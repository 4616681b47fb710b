"""Mistakes that Riccati equations in time refuse by name."""

import numpy as np
import pytest

from workbench.design.riccati_flow import fpre, rde, sdre

I2 = np.eye(2)


@pytest.mark.filterwarnings("error")
def test_a_start_as_large_as_is_allowed_is_followed_without_overflow():
    # from infinity p = sqrt(2) coth(sqrt(2) t) - 1
    flow = fpre(-I2, I2, I2, I2, 1e80 * I2, [0.0, 1.0])
    assert flow.rest[0] == pytest.approx(1.0)  # P G P alone
    np.testing.assert_allclose(flow.P[-1], (1 + 2 / np.expm1(2 * np.sqrt(2))) * np.sqrt(2) * I2 - I2, rtol=1e-10)


def test_coefficients_that_change_their_shape_are_refused_by_name():
    def size(t):
        return 2 if t < 0.5 else 3

    with pytest.raises(ValueError, match=r"`fpre.* at t = .* s`: B must have the same shape"):
        fpre(lambda t: -np.eye(size(t)), lambda t: np.ones((size(t), 1)), lambda t: np.eye(size(t)), 1.0, I2, [0, 1])
    with pytest.raises(ValueError, match="B must have the same shape"):
        fpre(-I2, lambda t: np.ones((2, size(t))), I2, lambda t: np.eye(size(t)), I2, [0.0, 1.0])


@pytest.mark.parametrize("states", ["abc", [1j, 2.0], [[1.0], [1.0, 2.0]]])
def test_states_that_are_no_real_numbers_are_refused_by_name(states):
    with pytest.raises(ValueError, match=r"`sdre\(states=...\)` must be numbers"):
        sdre(lambda x: (I2, I2), states, I2, I2)


def test_factors_that_give_no_pair_or_no_numbers_are_refused_with_the_state():
    for factors, words in [
        (lambda x: I2[0, 0], "factors must give A and B"),
        (lambda x: (np.nan * I2, I2), "A must hold finite numbers"),
        (lambda x: (I2, np.eye(2) if x[0] < 2 else np.ones((2, 3))), "must"),
    ]:
        with pytest.raises(ValueError, match=rf"`sdre.*`, at state \d, .*{words}"):
            sdre(factors, [[1.0], [2.0]], I2, I2)


def test_words_in_place_of_numbers_are_refused_by_name():
    with pytest.raises(ValueError, match=r"`rde\(rtol=...\)` must be a number; got 'tight'"):
        rde(0.0, 1.0, 1.0, 1.0, 0.0, [0, 1], rtol="tight")
