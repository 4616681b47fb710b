"""Poles, zeros, orders and ranks: exact against the minors of the pencil, and cases of the literature."""

import itertools

import control
import numpy as np
import pytest

from workbench.design.frequency import pole_zero_structure

EXACT = 1e-14  # a root is proved to the last digits of a double


def plain(A, B, C, D):
    return control.ss(A, B, C, D, remove_useless_states=False)


def nearest_distance(values, wanted):
    """The largest distance after greedy matching, relative to roots larger than one."""
    left, worst = list(values), 0.0
    assert len(left) == len(wanted)
    for root in wanted:
        near = min(left, key=lambda z: abs(z - root))
        left.remove(near)
        worst = max(worst, abs(near - root) / max(1, abs(root)))
    return worst


def random_degenerate(rng):
    """Small whole numbers with many zeros, often with equal inputs or outputs, so that ranks are lost."""
    n, nu, ny = rng.integers(1, 5), rng.integers(1, 4), rng.integers(1, 4)
    share = rng.choice([0.3, 0.5, 0.8])
    A, B, C, D = (
        (rng.integers(-2, 3, size=shape) * (rng.random(shape) < share)).astype(float)
        for shape in ((n, n), (n, nu), (ny, n), (ny, nu))
    )
    D *= rng.random() < 0.5
    if rng.random() < 0.3:
        B[:, -1], D[:, -1] = B[:, 0], D[:, 0]
    if rng.random() < 0.3:
        C[-1], D[-1] = C[0], D[0]
    return A, B, C, D


def smith(A, B, C, D):
    """The rank of the system pencil and the greatest common divisor of its minors of that order."""
    flint = pytest.importorskip("flint")
    n, M = len(A), np.block([[A, B], [C, D]]).astype(int)
    x = flint.fmpz_poly([0, 1])
    P = [[int(v) - x * (i == j < n) for j, v in enumerate(row)] for i, row in enumerate(M.tolist())]
    for r in range(min(M.shape), 0, -1):
        divisor = flint.fmpz_poly([0])
        for rows in itertools.combinations(range(M.shape[0]), r):
            for columns in itertools.combinations(range(M.shape[1]), r):
                divisor = divisor.gcd(determinant([[P[i][j] for j in columns] for i in rows]))
        if divisor != 0:
            return r, divisor
    return 0, flint.fmpz_poly([1])


def determinant(P):
    """The determinant of a matrix of polynomials of flint, by its first row."""
    flint = pytest.importorskip("flint")
    if not P:
        return flint.fmpz_poly([1])
    rests = ([row[:j] + row[j + 1 :] for row in P[1:]] for j in range(len(P)))
    terms = ((-1) ** j * P[0][j] * determinant(rest) for j, rest in enumerate(rests) if P[0][j] != 0)
    return sum(terms, flint.fmpz_poly([0]))


@pytest.mark.parametrize("seed", range(40))
def test_zeros_rank_and_order_are_those_of_all_minors_and_of_the_hankel_matrix(seed):
    A, B, C, D = random_degenerate(np.random.default_rng(seed))
    found = pole_zero_structure(plain(A, B, C, D))
    flint = pytest.importorskip("flint")
    rank, divisor = smith(A, B, C, D)
    wanted = [complex(z) for factor, times in divisor.factor()[1] for z, _ in factor.complex_roots() * times]
    assert nearest_distance(found.invariant_zeros.values, wanted) < EXACT
    n = len(A)
    assert found.normal_rank == rank - n
    hankel = np.block([[C @ np.linalg.matrix_power(A, i + j) @ B for j in range(n)] for i in range(n)])
    assert found.minimal_order == flint.fmpz_mat(hankel.astype(int).tolist()).rank()


@pytest.mark.parametrize("seed", range(20))
def test_transmission_zeros_do_not_change_when_hidden_modes_are_joined(seed):
    rng = np.random.default_rng(seed)
    A, B, C, D = random_degenerate(rng)
    before = pole_zero_structure(plain(A, B, C, D))
    n, T = len(A) + 2, np.triu(rng.integers(-1, 2, size=(len(A) + 2, len(A) + 2)), 1) + np.eye(len(A) + 2)
    wide = np.zeros((n, n))
    wide[:-2, :-2], wide[:-2, -2], wide[-1, :-2] = A, 1.0, 1.0  # a mode that nobody moves, one that nobody sees
    wide[-2, -2], wide[-1, -1] = 5.0, -7.0
    inverse = np.round(np.linalg.inv(T))
    inputs = np.vstack([B, np.zeros((1, B.shape[1])), np.ones((1, B.shape[1]))])
    outputs = np.hstack([C, np.ones((len(C), 1)), np.zeros((len(C), 1))])
    after = pole_zero_structure(plain(T @ wide @ inverse, T @ inputs, outputs @ inverse, D))
    assert after.minimal_order == before.minimal_order
    assert after.normal_rank == before.normal_rank
    assert nearest_distance(after.transmission_zeros.values, before.transmission_zeros.values) < EXACT
    assert len(after.poles) == len(before.poles) + 2


def test_multiplicities_are_exact_however_many():
    chain = np.diag([-1.0] * 8) + np.diag([1.0] * 7, 1)
    poles = pole_zero_structure(plain(chain, np.eye(8)[:, -1:], np.eye(8)[:1], [[0]])).poles
    assert (poles.values == -1).all()
    assert set(poles.multiplicities) == {8}


def test_roots_one_unit_in_the_last_place_apart_are_two():
    near = np.nextafter(1.0, 2.0)
    poles = pole_zero_structure(plain(np.diag([-1.0, -near]), [[1], [1]], [[1, 1]], [[0]])).poles
    assert poles.multiplicities == (1, 1)
    assert sorted(poles.values.real) == [-near, -1.0]


@pytest.mark.parametrize("gamma", [(0.7, 0.6), (0.43, 0.34)])
def test_the_quadruple_tank_has_the_zeros_of_its_publication(gamma):
    """Johansson (2000), The quadruple-tank process, IEEE Trans. Control Systems Technology 8."""
    (g1, g2), minimum_phase = gamma, sum(gamma) > 1
    T = (62.0, 90.0, 23.0, 30.0) if minimum_phase else (63.0, 91.0, 39.0, 56.0)
    area, k = (28.0, 32.0, 28.0, 32.0), (3.33, 3.35) if minimum_phase else (3.14, 3.29)
    A = -np.diag(1 / np.array(T))
    A[0, 2], A[1, 3] = area[2] / (area[0] * T[2]), area[3] / (area[1] * T[3])
    B = np.zeros((4, 2))
    B[0, 0], B[1, 1] = g1 * k[0] / area[0], g2 * k[1] / area[1]
    B[2, 1], B[3, 0] = (1 - g2) * k[1] / area[2], (1 - g1) * k[0] / area[3]
    found = pole_zero_structure(plain(A, B, 0.5 * np.eye(2, 4), np.zeros((2, 2))))
    equation = [T[2] * T[3], T[2] + T[3], 1 - (1 - g1) * (1 - g2) / (g1 * g2)]
    wanted = np.sort(np.roots(equation))
    np.testing.assert_allclose(np.sort(found.transmission_zeros.values.real), wanted, rtol=1e-12)
    published = (-0.060, -0.018) if minimum_phase else (-0.057, 0.013)
    np.testing.assert_allclose(wanted, published, atol=1e-3)  # from times in whole seconds
    assert found.minimal_order == 4


def test_two_masses_have_zeros_where_force_and_place_are_on_one_and_none_where_they_are_not():
    """Wie and Bernstein (1992), Benchmark problems for robust control design, J. Guidance, Control and Dynamics 15."""
    A = np.zeros((4, 4))
    A[:2, 2:], A[2:, :2] = np.eye(2), [[-1, 1], [1, -1]]
    collocated = pole_zero_structure(plain(A, [[0], [0], [1], [0]], [[1, 0, 0, 0]], [[0]]))
    apart = pole_zero_structure(plain(A, [[0], [0], [1], [0]], [[0, 1, 0, 0]], [[0]]))
    np.testing.assert_allclose(collocated.transmission_zeros.values, [-1j, 1j], atol=EXACT)
    assert collocated.relative_degree == 2
    assert len(apart.transmission_zeros) == 0
    assert apart.relative_degree == 4


def test_poles_of_wilkinson_are_found_to_the_last_digit():
    companion = np.diag(np.ones(14), -1)
    companion[0] = -np.poly(np.arange(1, 16))[1:]
    poles = pole_zero_structure(plain(companion, np.eye(15)[:, :1], np.eye(15)[-1:], [[0]])).poles
    np.testing.assert_array_equal(poles.values, np.arange(1, 16))


def test_a_transfer_function_that_is_zero_has_rank_zero_and_no_relative_degree():
    found = pole_zero_structure(plain([[-1, 1], [0, -2]], [[0], [1]], [[0, 0]], [[0]]))
    assert (found.normal_rank, found.minimal_order, found.relative_degree) == (0, 0, np.inf)


def test_a_system_without_states_has_neither_poles_nor_zeros():
    found = pole_zero_structure(control.ss([], [], [], [[1, 2], [2, 4]]))
    assert (len(found.poles), len(found.invariant_zeros), found.normal_rank, found.relative_degree) == (0, 0, 1, None)


def test_odd_systems_are_refused_by_name():
    with pytest.raises(ValueError, match="finite"):
        pole_zero_structure(plain([[-1]], [[1]], [[np.nan]], [[0]]))
    with pytest.raises(ValueError, match="StateSpace"):
        pole_zero_structure(control.tf([1], [1, 1]))
    with pytest.raises(ValueError, match="200"):
        pole_zero_structure(plain(-np.eye(200), np.ones((200, 1)), np.ones((1, 200)), [[0]]))
