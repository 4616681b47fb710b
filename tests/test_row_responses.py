"""Frequency answers of many rows at once are those of python-control for each; a bad row is flagged alone."""

import control
import numpy as np
import pytest

from workbench.design.frequency import row_responses

RNG = np.random.default_rng(3)
N, NX = 40, 9
A = RNG.normal(size=(N, NX, NX)) - 4 * np.eye(NX)
B, C, D = (RNG.normal(size=(N, *shape)) for shape in ((NX, 2), (3, NX), (3, 2)))
OMEGA = np.geomspace(1e-2, 1e2, 20)


def peer(i, period=0):
    response = control.frequency_response(control.ss(A[i], B[i], C[i], D[i], period), OMEGA, squeeze=False)
    return np.moveaxis(response.frdata, -1, 0)


@pytest.mark.parametrize("period", [None, 0.03])
def test_each_row_is_that_of_python_control(period):
    answers = row_responses(A, B, C, D, OMEGA, period)
    assert not answers.flagged.any()
    for i in range(N):
        np.testing.assert_allclose(answers.values[i], peer(i, period or 0), rtol=1e-10)


def test_a_row_that_is_not_finite_is_flagged_and_the_others_keep_their_bits():
    broken, whole = B.copy(), row_responses(A, B, C, D, OMEGA).values
    broken[5, 0, 0], broken[7, 1, 1] = np.nan, np.inf
    answers = row_responses(A, broken, C, D, OMEGA)
    assert list(np.flatnonzero(answers.flagged)) == [5, 7]
    assert np.isnan(answers.values[5]).all()
    rest = ~answers.flagged
    np.testing.assert_allclose(answers.values[rest], whole[rest], rtol=1e-12)


def test_states_that_the_input_does_not_reach_cost_no_digits():
    hidden = A.copy()
    hidden[:, 4:, :4] = 0  # states 4 to 8 move the others and are not moved by them
    reach = B.copy()
    reach[:, 4:] = 0
    answers = row_responses(hidden, reach, C, D, OMEGA)
    for i in range(N):
        system = control.ss(hidden[i, :4, :4], reach[i, :4], C[i, :, :4], D[i])
        expected = np.moveaxis(control.frequency_response(system, OMEGA, squeeze=False).frdata, -1, 0)
        np.testing.assert_allclose(answers.values[i], expected, rtol=1e-10)


def test_a_row_with_a_pole_at_a_frequency_is_flagged():
    oscillators = np.array([[[0.0, 1.0], [-4.0, 0.0]], [[0.0, 1.0], [-5.0, 0.0]]])
    b, c = np.array(2 * [[[0.0], [1.0]]]), np.array(2 * [[[1.0, 0.0]]])
    answers = row_responses(oscillators, b, c, np.zeros((2, 1, 1)), [1.0, 2.0])
    assert list(answers.flagged) == [True, False]
    np.testing.assert_allclose(answers.values[1, :, 0, 0], [1 / 4, 1.0], rtol=1e-14)


def test_rows_without_states_are_their_feedthrough():
    answers = row_responses(np.zeros((2, 0, 0)), np.zeros((2, 0, 1)), np.zeros((2, 1, 0)), np.ones((2, 1, 1)), [1.0])
    assert (answers.values == 1).all()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((A, B[:, 1:], C, D, OMEGA), "must have shapes"),
        ((A[0], B, C, D, OMEGA), "must have shapes"),
        ((A, B, C, D, OMEGA[::-1]), "must rise"),
        ((A, B, C, D, []), "at least one"),
        ((A, B, C, D, [np.nan]), "finite"),
        ((A, B, C, D, OMEGA, 0.1), "Nyquist"),
        ((A, B, C, D, OMEGA, -0.1), "positive"),
    ],
)
def test_what_does_not_fit_is_refused(arguments, words):
    with pytest.raises(ValueError, match=words):
        row_responses(*arguments)
