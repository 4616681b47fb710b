"""Structured singular values: closed forms, published values, and what proves each bound."""

from itertools import product

import numpy as np
import pytest

import workbench as wb
from workbench.design.structured_uncertainty import (
    ComplexScalar,
    FullBlock,
    RealScalar,
    structured_singular_value,
)

F, C, R = FullBlock, ComplexScalar, RealScalar
TRUE = 1e-12  # the rounding that a comparison of doubles leaves
TIGHT = 2e-6  # of bounds that meet: G is limited to 1e6 times the size of M


def random_matrix(seed, rows, columns=None, real=False):
    rng = np.random.default_rng(seed)
    shape = rows, columns or rows
    return rng.normal(size=shape) + (0 if real else 1j) * rng.normal(size=shape)


def is_structured(Delta, blocks):
    """True if a perturbation is block diagonal, with equal numbers where a block repeats one, real ones where due."""
    row = column = 0
    rest = Delta.copy()
    for block in blocks:
        rows, columns = block.shape
        part = Delta[row : row + rows, column : column + columns]
        rest[row : row + rows, column : column + columns] = 0
        if not isinstance(block, FullBlock) and not np.array_equal(part, part[0, 0] * np.eye(rows)):
            return False
        if isinstance(block, RealScalar) and part.imag.any():
            return False
        row, column = row + rows, column + columns
    return not rest.any()


def check(M, blocks):
    """The bounds, after a look at what proves both."""
    M, answer = np.asarray(M, dtype=complex), structured_singular_value(M, blocks)
    assert 0 <= answer.lower <= answer.upper
    if answer.perturbation is not None:
        assert is_structured(answer.perturbation, blocks)
        assert np.linalg.norm(answer.perturbation, 2) <= (1 + 1e-3) / answer.lower
        assert answer.residual < 1e-8
        left_over = np.linalg.svd(np.eye(len(M)) - M @ answer.perturbation, compute_uv=False)[-1]
        assert left_over == pytest.approx(answer.residual, abs=1e-12)
    if M.shape == answer.D.shape and (M != 0).all():
        cross = 1j * answer.G @ M
        W = answer.upper**2 * answer.D - M.conj().T @ answer.D @ M - cross - cross.conj().T
        assert np.linalg.eigvalsh(W)[0] >= -1e-9 * np.linalg.norm(answer.D)
    return answer


@pytest.mark.parametrize("seed", range(3))
def test_one_block_has_the_norm_the_spectral_radius_or_the_largest_real_eigenvalue(seed):
    M, N = random_matrix(seed, 4), random_matrix(seed, 4, real=True)
    real = [abs(z) for z in np.linalg.eigvals(N) if abs(z.imag) < 1e-9]
    for matrix, block, value in (
        (M, F(4), np.linalg.norm(M, 2)),
        (M, C(4), abs(np.linalg.eigvals(M)).max()),
        (N, R(4), max(real, default=0.0)),
    ):
        answer = check(matrix, [block])
        assert answer.lower <= value * (1 + TRUE)
        assert value * (1 - TRUE) <= answer.upper
        assert answer.upper - answer.lower <= TIGHT * max(value, 1.0)


def test_a_block_that_is_not_square_has_the_norm():
    M = random_matrix(5, 2, 3)
    answer = check(M, [F(3, 2)])
    assert answer.perturbation.shape == (3, 2)
    assert answer.lower == pytest.approx(np.linalg.norm(M, 2), rel=1e-9)
    assert answer.upper == pytest.approx(np.linalg.norm(M, 2), rel=1e-9)


def test_two_scalars_of_a_product_of_vectors_have_the_sum_of_moduli():
    u, v = random_matrix(1, 4, 1), random_matrix(2, 1, 4)
    for blocks in ([F(1)] * 4, [C(1)] * 4):
        answer = check(u @ v, blocks)
        assert answer.lower == pytest.approx(np.abs(u.ravel() * v.ravel()).sum(), rel=1e-9)
        assert answer.upper == pytest.approx(answer.lower, rel=1e-8)


def test_real_scalars_of_a_product_of_vectors_solve_a_linear_program():
    """Of 1 = sum of m_i delta_i, with m = 1 + j, 2 - j, -0.5 + 0.25 j: the smallest has delta_3 at its end."""
    m = np.array([1 + 1j, 2 - 1j, -0.5 + 0.25j])
    answer = check(np.outer(m, np.ones(3)), [R(1)] * 3)
    assert answer.lower == pytest.approx(3.0, rel=1e-8)
    assert answer.upper == pytest.approx(3.0, rel=TIGHT)
    assert answer.lower <= 3.0 <= answer.upper


@pytest.mark.parametrize("seed", range(4))
def test_a_real_matrix_with_real_scalars_has_its_value_at_a_vertex(seed):
    """The determinant is linear in each of them, so its sign changes at a vertex of the box first."""
    M = random_matrix(seed, 4, real=True)
    vertices = (np.linalg.eigvals(M * signs) for signs in product((1.0, -1.0), repeat=4))
    value = max(z.real for values in vertices for z in values if abs(z.imag) < 1e-9)
    answer = check(M, [R(1)] * 4)
    assert answer.lower == pytest.approx(value, rel=1e-9)
    assert answer.upper >= value * (1 - TRUE)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("blocks", [[F(1), F(1), F(2)], [C(2), F(2)], [F(1), F(3)], [F(2), F(2)]], ids=str)
def test_both_bounds_meet_where_repeated_blocks_twice_and_full_ones_count_three_at_most(seed, blocks):
    answer = check(random_matrix(seed, 4), blocks)
    assert answer.upper == pytest.approx(answer.lower, rel=1e-7)


def test_four_scalars_of_morton_and_doyle_have_a_gap():
    """Packard and Doyle (1993), The complex structured singular value, section 9: mu 0.872, bound 1."""
    gamma, beta = 3 + np.sqrt(3), np.sqrt(3) - 1
    a, b, d, f = np.sqrt(2 / gamma), np.sqrt(1 / gamma), -np.sqrt(beta / gamma), (1 + 1j) / np.sqrt(gamma * beta)
    U = np.array([[a, 0], [b, b], [b, 1j * b], [d, f]])
    V = np.array([[0, a], [b, -b], [b, -1j * b], [-1j * f, -d]])
    answer = check(U @ V.conj().T, [F(1)] * 4)
    assert round(answer.lower, 3) == 0.872
    assert answer.upper == pytest.approx(1.0, abs=1e-8)


@pytest.mark.parametrize("blocks", [[R(1), R(1), F(2)], [R(2), C(1), F(1)], [R(1)] * 4], ids=str)
def test_no_smaller_perturbation_of_many_is_singular(blocks):
    M, rng = random_matrix(7, 4), np.random.default_rng(0)
    answer = check(M, blocks)
    least = np.inf
    for _ in range(300):
        parts = []
        for block in blocks:
            if isinstance(block, FullBlock):
                Q, _ = np.linalg.qr(rng.normal(size=block.shape) + 1j * rng.normal(size=block.shape))
                parts.append(Q)
            else:
                number = rng.uniform(-1, 1) if isinstance(block, RealScalar) else np.exp(1j * rng.uniform(0, 6.3))
                parts.append(number * np.eye(block.count))
        Delta, start = np.zeros((4, 4), dtype=complex), 0
        for part in parts:
            Delta[start : start + len(part), start : start + len(part)] = part
            start += len(part)
        values = np.linalg.eigvals(M @ Delta)
        real = values[np.abs(values.imag) < 1e-3]
        least = min(least, *(1 / real.real[real.real > 0]), np.inf)
    # eigenvalues off the real axis by 1e-3 are counted, too, for which the bound is off by some of it
    assert least >= 1 / answer.upper * (1 - 1e-2)


def test_values_that_are_zero_are_zero():
    for M, blocks in (
        (np.zeros((2, 2)), [F(1), F(1)]),
        ([[0, 1], [0, 0]], [F(1), F(1)]),
        ([[1 + 1e-12j]], [R(1)]),
        ([[0.0, 1.0], [-1.0, 0.0]], [R(2)]),
    ):
        answer = structured_singular_value(M, blocks)
        assert (answer.lower, answer.upper, answer.perturbation) == (0.0, 0.0, None)


def test_defective_matrices_keep_true_bounds():
    jordan = np.array([[2.0, 1.0], [-1.0, 0.0]])  # a double eigenvalue of one, with one eigenvector
    for block in (C(2), R(2)):
        answer = structured_singular_value(jordan, [block])
        assert answer.lower <= 1 + TRUE
        assert answer.upper >= 1
        assert answer.upper - answer.lower < 1e-3


def test_units_and_order_of_size_do_not_matter():
    M = np.array([[1.0, 2.0], [3.0, 4.0]])
    plain = structured_singular_value(M, [F(1), F(1)])
    for factor in (2.0**-600, 2.0**400):
        scaled = structured_singular_value(factor * M, [F(1), F(1)])
        assert scaled.lower == factor * plain.lower
        assert scaled.upper == factor * plain.upper
    units = np.array([1.0, 2.0**30])
    other = structured_singular_value(M * units[:, None] / units, [F(1), F(1)])
    assert other.upper == pytest.approx(plain.upper, rel=1e-8)


def test_triangular_matrices_have_the_largest_value_of_their_diagonal():
    answer = structured_singular_value([[1, 1e9, 5], [0, 0.5, 1], [0, 0, 0.3]], [F(1), F(1), R(1)])
    assert (answer.lower, answer.upper) == (1.0, 1.0)
    np.testing.assert_allclose(answer.perturbation, np.diag([1.0, 0, 0]))


def test_odd_arguments_are_refused_by_name():
    with pytest.raises(ValueError, match="finite numbers"):
        structured_singular_value([[np.nan, 0], [0, 1]], [F(1), F(1)])
    with pytest.raises(ValueError, match=r"shape \(3, 3\)"):
        structured_singular_value(np.eye(2), [F(1), F(2)])
    with pytest.raises(ValueError, match="whole number from 1"):
        R(0)
    with pytest.raises(ValueError, match="40 rows"):
        structured_singular_value(np.eye(41), [C(41)])
    with pytest.raises(ValueError, match="blocks"):
        structured_singular_value(np.eye(2), [])
    assert wb.structured_uncertainty.FullBlock is FullBlock
