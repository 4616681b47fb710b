"""Models of lower order: Hankel values to their last digits, and errors between what theorems allow."""

import control
import mpmath
import numpy as np
import pytest

import workbench as wb
from workbench.design.reduction import (
    balanced_truncation,
    hankel_norm_reduction,
    hankel_values,
    singular_perturbation,
)

METHODS = [balanced_truncation, singular_perturbation, hankel_norm_reduction]
ROUNDING = 1e-12  # of the largest Hankel value: what doubles leave of a reduced model


def random_system(seed, n, ny, nu, discrete):
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(n, n))
    poles = np.linalg.eigvals(A)
    A = A / (1.05 * abs(poles).max()) if discrete else A - (poles.real.max() + 0.2) * np.eye(n)
    B, C, D = rng.normal(size=(n, nu)), rng.normal(size=(ny, n)), rng.normal(size=(ny, nu))
    return control.ss(A, B, C, D, 0.1 if discrete else 0)


def difference(one, other):
    n, k = one.nstates, other.nstates
    A = np.block([[one.A, np.zeros((n, k))], [np.zeros((k, n)), other.A]])
    B, C = np.vstack([one.B, other.B]), np.hstack([one.C, -other.C])
    return control.StateSpace(A, B, C, one.D - other.D, one.dt, remove_useless_states=False)


def lags(n):
    return control.ss(control.tf([1.0], np.poly([-1.0] * n)))


def test_the_hankel_values_of_a_symmetric_system_are_the_eigenvalues_of_its_cauchy_matrix_down_to_the_least():
    rates, n = np.arange(1.0, 15.0), 14
    system = control.ss(-np.diag(rates), np.ones((n, 1)), np.ones((1, n)), 0)
    with mpmath.workdps(60):
        gramian = mpmath.matrix(n, n)
        for i in range(n):
            for j in range(n):
                gramian[i, j] = 1 / (mpmath.mpf(rates[i]) + mpmath.mpf(rates[j]))
        expected = sorted((float(x) for x in mpmath.eigsy(gramian, eigvals_only=True)), reverse=True)
    answer = hankel_values(system)
    assert expected[-1] < 1e-13 * expected[0]  # below the rounding of the largest
    np.testing.assert_allclose(answer.values, expected, rtol=4e-15)
    assert answer.error < 1e-15


def test_stiff_and_lightly_damped_modes_have_their_hankel_values():
    """Far apart, each mode keeps its own: 1 / (2 a) of a lag, and twice 1 / (4 damping) of a resonance."""
    modes = [([[-1e6]], 1.0), ([[-1e-6]], 1.0), ([[-1e-7, 1.0], [-1.0, -1e-7]], 1.0)]
    parts = [control.ss(A, np.eye(len(A)), np.eye(len(A)), 0) for A, _ in modes]
    values = hankel_values(control.append(*parts)).values
    np.testing.assert_allclose(values, [5e6, 5e6, 5e5, 5e-7], rtol=1e-14)


@pytest.mark.parametrize("discrete", [False, True])
def test_a_change_of_states_keeps_the_hankel_values(discrete):
    system = random_system(3, 6, 2, 2, discrete)
    T = np.diag([1.0, 1e-3, 2.0, 1e3, 0.5, 1.0]) @ (np.eye(6) + np.triu(np.ones((6, 6)), 1))
    other = control.ss(np.linalg.solve(T, system.A @ T), np.linalg.solve(T, system.B), system.C @ T, 0, system.dt)
    # the matrices of the other system are rounded, which moves its values by the condition of T
    np.testing.assert_allclose(hankel_values(system).values, hankel_values(other).values, rtol=1e-8)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("discrete", [False, True])
@pytest.mark.parametrize(("ny", "nu"), [(1, 1), (2, 3), (3, 1)])
def test_no_error_is_above_its_bound_or_below_the_first_hankel_value_left_out(method, discrete, ny, nu):
    system = random_system(ny, 5, ny, nu, discrete)
    values = hankel_values(system).values
    share = 1 if method is hankel_norm_reduction else 2
    for order in (0, 2, 4):
        answer = method(system, order)
        assert answer.order == order
        assert answer.bound == pytest.approx(share * values[order:].sum(), rel=1e-14)
        assert answer.within_bound
        assert answer.error.gain.high <= answer.bound * (1 + 1e-9) + ROUNDING * values[0]
        assert answer.error.gain.high >= values[order] * (1 - 1e-9)
        assert answer.error.gain.value == wb.hinf_norm(difference(system, answer.system)).gain.value


@pytest.mark.parametrize("discrete", [False, True])
@pytest.mark.parametrize(("ny", "nu"), [(1, 1), (2, 3)])
def test_the_hankel_norm_of_the_optimal_error_is_the_first_value_left_out(discrete, ny, nu):
    system = random_system(5, 5, ny, nu, discrete)
    values = hankel_values(system).values
    for order in (0, 2, 4):
        model = hankel_norm_reduction(system, order).system
        assert hankel_values(difference(system, model)).values[0] == pytest.approx(values[order], abs=1e-11 * values[0])


def test_four_equal_lags_have_errors_below_half_the_bound_by_the_optimal_constant():
    system = lags(4)
    truncated, optimal = balanced_truncation(system, 2), hankel_norm_reduction(system, 2)
    assert optimal.error.gain.value < truncated.error.gain.value
    assert optimal.bound == pytest.approx(truncated.bound / 2)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("discrete", [False, True])
def test_the_model_without_one_value_has_the_error_of_an_all_pass_system(method, discrete):
    """Twice the last value, of the one or other end of the axis, or just the value in the Hankel norm (Glover 1984)."""
    system = random_system(8, 4, 1, 1, discrete)
    answer = method(system, 3)
    if not discrete or method is not balanced_truncation:
        assert answer.error.gain.value == pytest.approx(answer.bound, rel=1e-7)


@pytest.mark.parametrize("discrete", [False, True])
def test_truncation_keeps_the_direct_term_and_a_singular_perturbation_the_static_gain(discrete):
    system = random_system(2, 6, 2, 2, discrete)
    assert (balanced_truncation(system, 3).system.D == system.D).all()
    at = 1.0 if discrete else 0.0
    np.testing.assert_allclose(singular_perturbation(system, 3).system(at), system(at), rtol=1e-11)


@pytest.mark.parametrize("method", METHODS)
def test_a_tolerance_gives_the_least_order_that_meets_it(method):
    answer = method(lags(8), tolerance=1e-2)
    assert answer.error.gain.high <= 1e-2
    assert method(lags(8), answer.order - 1).error.gain.low > 1e-2


def test_equal_hankel_values_of_an_all_pass_system_are_not_separated():
    all_pass = control.ss([[-3, -2], [1, 0]], [[1], [0]], [[-6, 0]], 1)
    np.testing.assert_allclose(hankel_values(all_pass).values, [1, 1], rtol=1e-15)
    with pytest.raises(ValueError, match="order 0 or 2"):
        balanced_truncation(all_pass, 1)
    assert hankel_norm_reduction(all_pass, 0).error.gain.value == pytest.approx(1.0, rel=1e-9)


def test_modes_that_nobody_drives_or_sees_have_the_value_zero_and_are_left_out():
    A = np.array([[-1.0, 1.0, 0.0], [0.0, -0.3, 0.0], [0.2, 0.0, -2.0]])
    hidden = control.ss(A, [[1], [0], [0]], [[1, 1, 0]], 0)
    answer = hankel_values(hidden)
    assert answer.minimal_order == 1
    np.testing.assert_allclose(answer.values, [0.5, 0, 0], rtol=1e-15)
    model = balanced_truncation(hidden, 3)
    assert model.order == 1
    assert model.error.gain.high < 1e-15


def test_a_system_of_many_states_has_an_error_between_a_gain_that_it_attains_and_the_bound():
    n = 30
    A = np.diag(np.full(n, -2.0)) + np.diag(np.ones(n - 1), -1) + np.diag(np.ones(n - 1), 1)  # a rod that is heated
    system = control.ss(A, np.eye(n)[:, :1], np.eye(n)[-1:], 0)
    answer = balanced_truncation(system, 12)
    assert 0 < answer.error.gain.low < answer.error.gain.high
    assert answer.error.gain.high == pytest.approx(answer.bound, rel=1e-6)
    gain = abs(difference(system, answer.system)(1j * answer.error.frequency))
    assert gain >= answer.error.gain.low


def test_a_reduced_controller_runs_in_the_loop_about_the_same_point():
    motor = wb.linearize(wb.open_loop(wb.DCMotor()), 0.0, [0.0, 0.0])
    design = wb.lqg(motor, Q=np.diag([100.0, 0.0]), R=[[1.0]], Qn=np.eye(2), Rn=[[1e-3]])
    controller = balanced_truncation(design.controller, 1).system
    loop = wb.ClosedLoop(wb.DCMotor(), controller=controller)
    assert max(pole.value.real for pole in wb.linear_loop(loop).poles) < 0
    assert controller.point.x0.tolist() == [0.0]


@pytest.mark.parametrize("method", [hankel_values, *[lambda G, m=m: m(G, 1) for m in METHODS]])
def test_a_system_that_is_not_stable_is_refused_by_its_pole(method):
    for A in ([[1.0, 0.0], [0.0, -1.0]], [[0.0, 1.0], [0.0, -1.0]]):
        with pytest.raises(ValueError, match="not stable: its pole near"):
            method(control.ss(A, [[1], [1]], [[1, 1]], 0))


def test_odd_arguments_are_refused_by_name():
    with pytest.raises(ValueError, match="either an order or a tolerance"):
        balanced_truncation(lags(3))
    with pytest.raises(ValueError, match="between 0 and the 3 states"):
        balanced_truncation(lags(3), 4)
    with pytest.raises(ValueError, match="above zero"):
        balanced_truncation(lags(3), tolerance=-1.0)
    with pytest.raises(ValueError, match="larger tolerance"):
        balanced_truncation(lags(3), tolerance=1e-30)
    with pytest.raises(ValueError, match="finite"):
        hankel_values(control.ss([[np.nan]], 1, 1, 0))
    with pytest.raises(ValueError, match="StateSpace"):
        balanced_truncation(control.tf([1], [1, 1]), 1)
    with pytest.raises(ValueError, match="60 states"):
        hankel_values(control.ss(-np.eye(70), np.ones((70, 1)), np.ones((1, 70)), 0))
