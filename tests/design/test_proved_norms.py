"""Norms proved in floating point, against exact arithmetic and closed forms, and what must not pass."""

from fractions import Fraction

import control
import numpy as np
import pytest

import workbench as wb
from workbench.design.frequency.gain_levels import prove_level, prove_poles
from workbench.design.frequency.modal_systems import ModalSystem
from workbench.design.frequency.proved_norm import proved_norm, proved_stability, starts_below
from workbench.design.frequency.wide_matrices import Wide, is_contraction, is_positive_definite
from workbench.design.synthesis.closed_loop_norm import closed_loop_norm, enclosed_loop

NARROW = 1.001e-12  # relative width of an enclosure, and the rounding of its ends


def random_matrices(seed, gap, discrete, n=None):
    """A system whose nearest pole is a `gap` inside the limit of stability, or beyond it; some are scaled by 1e8."""
    rng = np.random.default_rng(seed)
    n = n or int(rng.integers(1, 10))
    ny, nu = rng.integers(1, 4, 2)
    A = rng.normal(size=(n, n)) / np.sqrt(n)
    poles = np.linalg.eigvals(A)
    A = A * (1 - gap) / np.abs(poles).max() if discrete else A - (poles.real.max() + gap) * np.eye(n)
    B, C, D = rng.normal(size=(n, nu)), rng.normal(size=(ny, n)), rng.normal(size=(ny, nu)) * (seed % 3 > 0)
    units = 10.0 ** rng.integers(-8, 9, n) if seed % 2 else np.ones(n)
    return A * units / units[:, None], B / units[:, None], C * units, D


def proved(matrices, discrete):
    return proved_norm(*map(Wide.of, matrices), discrete)


def exact(matrices, discrete):
    """By exact arithmetic, as such a system has few states and channels."""
    return wb.hinf_norm(control.ss(*matrices, 1.0 if discrete else 0, remove_useless_states=False)).gain


@pytest.mark.parametrize("discrete", [False, True])
@pytest.mark.parametrize("gap", [0.1, 1e-3])
def test_each_proved_enclosure_meets_the_exact_one(discrete, gap):
    for seed in range(12):
        matrices = random_matrices(seed, gap, discrete)
        ours, theirs = proved(matrices, discrete), exact(matrices, discrete)
        assert ours.low <= theirs.high
        assert theirs.low <= ours.high <= ours.low * (1 + 1e-9)  # the widest that is accepted


@pytest.mark.release
@pytest.mark.parametrize("discrete", [False, True])
@pytest.mark.parametrize("gap", [0.5, 0.01, 1e-6, 1e-9, 1e-12, -1e-12, -1e-6, -0.1])
def test_no_enclosure_contradicts_exact_arithmetic_near_the_limit_of_stability(discrete, gap):
    for seed in range(20):
        matrices = random_matrices(100 + seed, gap, discrete)
        ours, theirs = proved(matrices, discrete), exact(matrices, discrete)
        assert ours is None or (ours.low <= theirs.high and theirs.low <= ours.high)


@pytest.mark.parametrize("discrete", [False, True])
@pytest.mark.parametrize("gap", [-1e-1, -1e-6, -1e-12])
def test_no_unstable_system_has_a_proved_norm(discrete, gap):
    pole = 1 - gap if discrete else -gap
    seen = np.diag([pole, 0.2 if discrete else -1.0])
    for C in ([[1.0, 1.0]], [[0.0, 1.0]]):  # the last hides the mode
        ours = proved((seen, np.ones((2, 1)), np.array(C), np.zeros((1, 1))), discrete)
        assert ours is None or ours.low == np.inf
    assert proved_stability(seen, discrete) is not True


@pytest.mark.parametrize("gap", [1e-1, 1e-6, 1e-12])
def test_stability_is_proved_down_to_a_distance_of_1e_minus_12(gap):
    turned = np.array([[-gap, 3.0], [-3.0, -gap]])
    assert proved_stability(turned, discrete=False) is True
    assert proved_stability(-turned, discrete=False) is False
    assert proved_stability(np.diag([1 - gap, 0.3]), discrete=True) is True
    assert proved_stability(np.diag([1 + gap, 0.3]), discrete=True) is False


@pytest.mark.parametrize("discrete", [False, True])
def test_no_level_below_the_norm_passes_and_one_just_above_does(discrete):
    for seed in range(4):
        matrices = random_matrices(seed, 0.1, discrete)
        norm = exact(matrices, discrete)
        system = ModalSystem.in_good_units(*map(Wide.of, matrices), discrete).by_modes(3)
        for below in (1e-12, 1e-9, 1e-3):
            level = norm.low * (1 - below)
            assert not (prove_level(system, level).is_proved and starts_below(system, level))
        level = norm.high * (1 + 1e-11)
        assert prove_level(system, level).is_proved
        assert starts_below(system, level)


@pytest.mark.parametrize("discrete", [False, True])
def test_a_level_below_a_gain_that_is_the_same_everywhere_meets_no_singular_value_and_does_not_pass(discrete):
    # (1 - s)/(1 + s), or (1 - z/2)/(z - 1/2): all-pass
    matrices = ([[0.5]], [[1.0]], [[0.75]], [[-0.5]]) if discrete else ([[-1.0]], [[1.0]], [[2.0]], [[-1.0]])
    system = ModalSystem.in_good_units(*(Wide.of(np.array(part)) for part in matrices), discrete)
    assert prove_level(system, 0.5).is_proved
    assert not starts_below(system, 0.5)
    assert starts_below(system, 1 + 1e-9)


def test_forty_resonances_have_their_textbook_peak_in_any_units():
    rng = np.random.default_rng(8)
    rates, damping = np.geomspace(1e-2, 1e2, 40), rng.uniform(0.05, 0.3, 40)
    parts = [
        control.ss([[0, w], [-w, -2 * z * w]], [[0], [w]], [[1, 0]], 0) for w, z in zip(rates, damping, strict=True)
    ]
    whole = control.append(*parts)
    units = 10.0 ** rng.integers(-8, 9, 80)
    scaled = control.ss(
        whole.A * units / units[:, None],
        whole.B / units[:, None],
        whole.C * units,
        whole.D,
        remove_useless_states=False,
    )
    z = damping.min()
    gain = wb.hinf_norm(scaled).gain
    # the entries of A in these units are rounded to 1e-16, and the peak moves by that
    assert gain.value == pytest.approx(1 / (2 * z * np.sqrt(1 - z * z)), rel=1e-11)
    assert gain.high <= gain.low * (1 + NARROW)


def as_fractions(M):
    return [[Fraction(float(x)) for x in row] for row in M]


def times(M, N):
    columns = list(zip(*N, strict=True))
    return [[sum((a * b for a, b in zip(row, column, strict=True)), Fraction(0)) for column in columns] for row in M]


def is_enclosed(exact_matrix, wide):
    parts = zip(exact_matrix, as_fractions(wide.high), as_fractions(wide.low), as_fractions(wide.radius), strict=True)
    return all(abs(x - h - t) <= r for rows in parts for x, h, t, r in zip(*rows, strict=True))


@pytest.mark.parametrize("spread", [0, 12])
def test_a_product_and_a_sum_enclose_the_exact_ones(spread):
    rng = np.random.default_rng(spread)
    A, B, C = (rng.normal(size=(9, 9)) * 10.0 ** rng.integers(-spread, spread + 1, (9, 9)) for _ in range(3))
    wide = Wide.of(A) @ B
    assert is_enclosed(times(as_fractions(A), as_fractions(B)), wide)
    twice = times(times(as_fractions(A), as_fractions(B)), as_fractions(C))
    expected = [[x - Fraction(float(a)) for x, a in zip(*rows, strict=True)] for rows in zip(twice, A, strict=True)]
    assert is_enclosed(expected, wide @ C - A)
    if not spread:
        assert (wide.radius <= 1e-28).all()  # about 2^-106 of its terms


@pytest.mark.parametrize("least", [1e-13, 0.0, -1e-16, -1e-13])
def test_only_definite_matrices_pass_the_factorisation(least):
    # [[1, x], [x, 1]] has the least eigenvalue 1 - x, without rounding
    x = 1 - least
    passes = is_positive_definite(Wide.of(np.array([[1.0, x], [x, 1.0]])))
    assert passes == (least == 1e-13)


def test_only_matrices_with_a_spectral_radius_below_one_are_contractions():
    # the eigenvalues of [[0, 4], [x, 0]] are +- 2 sqrt(x)
    assert is_contraction(np.array([[0.0, 4.0], [0.2499999, 0.0]]))
    for x in (0.25, 0.2500001, 9.0, np.nan, np.inf):
        assert not is_contraction(np.array([[0.0, 4.0], [x, 0.0]]))


def sensitive_plant():
    """A plant whose nearly optimal loop has gains so large that rounding its matrices moves the norm by 1e-6."""
    rng = np.random.default_rng(2)
    nu, ny = (int(k) for k in rng.integers(1, 3, 2))
    nw, nz, draw = ny + int(rng.integers(0, 3)), nu + int(rng.integers(0, 3)), rng.standard_normal
    A = draw((4, 4)) / 2 - rng.uniform(0.2, 1.3) * np.eye(4)
    return wb.synthesis.GeneralizedPlant(
        A, draw((4, nw)), draw((4, nu)), draw((nz, 4)), draw((ny, 4)), 0.3 * draw((nz, nw)), draw((nz, nu)),
        draw((ny, nw)), 0.3 * draw((ny, nu)),
    )  # fmt: skip


def solve(M, N):
    """The solution of a regular system of fractions."""
    rows, n = [[*a, *b] for a, b in zip(M, N, strict=True)], len(M)
    for k in range(n):
        pivot = next(i for i in range(k, n) if rows[i][k])
        rows[k], rows[pivot] = rows[pivot], rows[k]
        rows[k] = [x / rows[k][k] for x in rows[k]]
        for i in range(n):
            if i != k and rows[i][k]:
                rows[i] = [x - rows[i][k] * y for x, y in zip(rows[i], rows[k], strict=True)]
    return [row[n:] for row in rows]


def exact_gain(plant, controller, omega):
    """The largest singular value of the loop of plant and controller at a frequency: only the last step is rounded."""
    p = plant.parts
    # x, the controller's state, u and y at j omega, each by real and imaginary part
    n, k, nu, ny = len(p.A), controller.nstates, *p.D22.T.shape
    none = np.zeros
    real = np.block([
        [-p.A, none((n, k)), -p.B2, none((n, ny))],
        [none((k, n)), -controller.A, none((k, nu)), -controller.B],
        [none((nu, n)), -controller.C, np.eye(nu), -controller.D],
        [-p.C2, none((ny, k)), -p.D22, np.eye(ny)],
    ])  # fmt: skip
    turn = none(real.shape)
    turn[: n + k, : n + k] = omega * np.eye(n + k)
    entering = np.vstack([p.B1, none((k + nu, p.B1.shape[1])), p.D21])
    leaving = np.hstack([p.C1, none((len(p.C1), k)), p.D12, none((len(p.C1), ny))])
    both = as_fractions(np.block([[real, -turn], [turn, real]]))
    inner = solve(both, as_fractions(np.vstack([entering, none(entering.shape)])))
    seen = times(as_fractions(np.block([[leaving, 0 * leaving], [0 * leaving, leaving]])), inner)
    direct = as_fractions(np.vstack([p.D11, 0 * p.D11]))
    G = np.array([[float(a + b) for a, b in zip(*rows, strict=True)] for rows in zip(seen, direct, strict=True)])
    return np.linalg.norm(G[: len(p.C1)] + 1j * G[len(p.C1) :], 2)


def test_the_norm_is_that_of_plant_and_controller_without_rounding_between_them():
    plant = sensitive_plant()
    answer = wb.hinf_controller(plant)
    gain = answer.norm.gain
    reached = exact_gain(plant, answer.controller, answer.norm.frequency)
    assert gain.low * (1 - 1e-14) <= reached <= gain.high * (1 + 1e-14)  # of the last singular value
    rounded = wb.hinf_norm(plant.close(answer.controller)).gain
    assert not rounded.low <= gain.high <= rounded.high


def test_an_enclosed_loop_holds_the_exact_one_with_direct_terms_on_both_sides():
    plant = sensitive_plant()
    p, (_, _, nu, _, ny) = plant.parts, plant.sizes
    rng = np.random.default_rng(1)
    K = rng.normal(size=(2, 2)), rng.normal(size=(2, ny)), rng.normal(size=(nu, 2)), rng.normal(size=(nu, ny))
    A, _, _, D = enclosed_loop(p, K)
    W = np.array(times(as_fractions(K[3]), as_fractions(p.D22)))
    W = [[(i == j) - W[i, j] for j in range(nu)] for i in range(nu)]
    by_w = solve(W, times(as_fractions(K[3]), as_fractions(p.D21)))
    by_k = solve(W, as_fractions(K[2]))
    direct = times(as_fractions(p.D12), by_w)
    direct = [[a + Fraction(float(b)) for a, b in zip(*rows, strict=True)] for rows in zip(direct, p.D11, strict=True)]
    assert is_enclosed(direct, D)
    assert is_enclosed(times(as_fractions(p.B2), by_k), A[: len(p.A), len(p.A) :])
    assert A.radius.max() <= 1e-25  # of entries up to some hundred


def test_a_sampled_loop_has_its_norm_between_the_same_bounds():
    plant = sensitive_plant()
    p = plant.parts
    sampled = wb.synthesis.GeneralizedPlant(
        0.3 * p.A, p.B1, p.B2, p.C1, p.C2, p.D11, p.D12, p.D21, p.D22, dt=0.5
    )  # fmt: skip
    answer = wb.hinf_controller(sampled)
    gain, loop = answer.norm.gain, sampled.close(answer.controller)
    assert gain.high <= gain.low * (1 + NARROW)
    # of loops with large gains the sixth digit is lost to rounding
    assert wb.hinf_norm(loop).gain.value == pytest.approx(gain.value, rel=1e-5)
    assert closed_loop_norm(sampled, answer.controller).gain == gain


@pytest.mark.release
def test_the_poles_of_a_loop_of_forty_states_are_proved_stable_and_its_norm_narrow():
    rng = np.random.default_rng(4)
    n, draw = 20, rng.standard_normal
    plant = wb.synthesis.GeneralizedPlant(
        draw((n, n)) / np.sqrt(n) - 0.5 * np.eye(n), draw((n, 3)), draw((n, 2)), draw((3, n)), draw((2, n)),
        0.3 * draw((3, 3)), draw((3, 2)), draw((2, 3)), np.zeros((2, 2)),
    )  # fmt: skip
    answer = wb.hinf_controller(plant)
    loop = enclosed_loop(
        plant.parts, (answer.controller.A, answer.controller.B, answer.controller.C, answer.controller.D)
    )
    assert prove_poles(ModalSystem.in_good_units(*loop, discrete=False).by_modes(3)).is_proved
    assert answer.norm.gain.high <= answer.norm.gain.low * (1 + 1e-10)
    assert answer.gamma.low <= answer.norm.gain.high <= answer.gamma.value * (1 + 2e-6)
