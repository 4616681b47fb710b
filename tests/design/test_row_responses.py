"""Frequency answers of many rows at once are exact within their errors; a bad row is flagged alone."""

import control
import numpy as np
import pytest

from workbench.design.frequency import response_kernel, row_responses

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
    assert not answers.flagged_rows.any()
    for i in range(N):
        np.testing.assert_allclose(answers.values[i], peer(i, period or 0), rtol=1e-10)


def exact(A, B, C, D, s):
    """The answer at a point from 300 bits, rounded."""
    flint = pytest.importorskip("flint")
    before, flint.ctx.prec = flint.ctx.prec, 300
    try:
        n = len(A)
        point = flint.acb(s.real, s.imag)
        M = flint.acb_mat([[point * (i == j) - flint.acb(A[i, j]) for j in range(n)] for i in range(n)])
        X = M.solve(flint.acb_mat([[flint.acb(v) for v in row] for row in B]))
        G = flint.acb_mat([[flint.acb(v) for v in row] for row in C]) * X
        parts = [[G[i, j] + flint.acb(D[i, j]) for j in range(B.shape[1])] for i in range(len(C))]
        return np.array([[complex(float(v.real.mid()), float(v.imag.mid())) for v in row] for row in parts])
    finally:
        flint.ctx.prec = before


def beams(count, offset):
    """Undamped oscillators in one turned system, driven and read at one place, and frequencies so near to one mode."""
    modes = np.array([1.0, 2.0, 5.0, 11.0])
    n = 2 * len(modes)
    plain = np.zeros((n, n))
    for k, w in enumerate(modes):
        plain[2 * k : 2 * k + 2, 2 * k : 2 * k + 2] = [[0, 1], [-(w**2), 0]]
    turns = [np.linalg.qr(RNG.normal(size=(n, n)))[0] for _ in range(count)]
    A = np.array([Q @ plain @ np.linalg.inv(Q) for Q in turns])
    b, c = np.zeros((n, 1)), np.zeros((2, n))
    b[1::2], c[0, ::2], c[1, 0] = 1.0, 1.0, 1.0
    return A, np.array([Q @ b for Q in turns]), np.array([c @ np.linalg.inv(Q) for Q in turns]), 2.0 * (1 + offset)


@pytest.mark.parametrize("offset", [1e-2, 1e-6, 1e-10])
def test_answers_beside_an_undamped_pole_lie_within_their_errors(offset):
    *matrices, omega = beams(8, offset)
    D = np.zeros((8, 2, 1))
    answers = row_responses(*matrices, D, [0.5, omega, 300.0])
    assert not answers.flagged_rows.any()
    relative = answers.errors / np.abs(answers.values)
    assert relative.max() < (1e-10 if offset > 1e-8 else 1e-4)  # it grows with the square of 1e-14 / offset
    # python-control's own answer is off by what the rounding of the entries moves
    assert (answers.conditions[:, 1] * 2.2e-16).max() > 1e-16 / offset
    for i in range(8):
        for k, w in enumerate(answers.frequencies):
            wrong = np.abs(answers.values[i, k] - exact(*(M[i] for M in (*matrices, D)), 1j * w))
            assert (wrong <= answers.errors[i, k]).all()


def test_answers_that_cancel_keep_their_digits():
    # a chain of six integrators: at 1e3 rad/s the last state is 1e-18 of the first
    n = 6
    chain, scale = np.diag(np.ones(n - 1), -1), RNG.uniform(0.5, 2, (5, n))
    A = np.array([np.diag(1 / s) @ (chain - 0.1 * np.eye(n)) @ np.diag(s) for s in scale])
    b, c, d = (np.tile(M, (5, 1, 1)) for M in (np.eye(n)[:, :1], np.eye(n)[-1:], np.zeros((1, 1))))
    answers = row_responses(A, b, c, d, [1.0, 1e3])
    for i in range(5):
        for k, w in enumerate(answers.frequencies):
            true = exact(A[i], b[i], c[i], d[i], 1j * w)
            np.testing.assert_allclose(answers.values[i, k], true, rtol=1e-14)
            assert (np.abs(answers.values[i, k] - true) <= answers.errors[i, k]).all()


@pytest.mark.parametrize("period", [None, 0.03])
def test_machine_code_and_arrays_give_the_same_bits(period):
    if response_kernel._function() is None:
        pytest.skip("nothing is compiled here")
    s = 1j * OMEGA if period is None else np.exp(1j * OMEGA * period)
    sparse = A * (RNG.random((NX, NX)) < 0.4)
    for matrix in (A, sparse):
        one, other = (response_kernel.row_answers(matrix, B, C, D, s, compiled) for compiled in (True, False))
        for name in ("values", "errors", "sensitivities"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_points_at_which_the_reduction_breaks_down_are_solved_again():
    # each state moves the next one so little that multiples of the last state leave the range of doubles
    n = 40
    weak = np.diag(np.full(n - 1, 1e-12), -1) - np.diag(np.linspace(1, 2, n))
    b, c, d = (M[np.newaxis] for M in (np.eye(n)[:, :1], np.ones((1, n)), np.zeros((1, 1))))
    answers = row_responses(weak[np.newaxis], b, c, d, [0.3, 3.0])
    for k, w in enumerate(answers.frequencies):
        true = exact(weak, b[0], c[0], d[0], 1j * w)
        assert (np.abs(answers.values[0, k] - true) <= answers.errors[0, k]).all()
        np.testing.assert_allclose(answers.values[0, k], true, rtol=1e-12)


def test_entries_that_change_in_their_last_digits_move_an_answer_by_its_sensitivity_at_most():
    changed = [M * (1 + 1e-9 * RNG.choice([-1, 1], M.shape)) for M in (A, B, C, D)]
    before, after = row_responses(A, B, C, D, OMEGA), row_responses(*changed, OMEGA)
    moved = np.abs(after.values - before.values) / (1e-9 * before.sensitivities)
    assert moved.max() < 1 + 1e-6
    assert moved.max() > 0.05  # and it is no bound that says nothing


def test_a_row_that_is_not_finite_is_flagged_and_the_others_keep_their_bits():
    broken, whole = B.copy(), row_responses(A, B, C, D, OMEGA).values
    broken[5, 0, 0], broken[7, 1, 1] = np.nan, np.inf
    answers = row_responses(A, broken, C, D, OMEGA)
    assert list(np.flatnonzero(answers.flagged_rows)) == [5, 7]
    assert np.isnan(answers.values[5]).all()
    rest = ~answers.flagged_rows
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
    assert list(answers.flagged_rows) == [True, False]
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
