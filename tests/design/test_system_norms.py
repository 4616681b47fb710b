"""H-infinity and H2 norms: closed forms, traps, and other roads to the same figures."""

import control
import numpy as np
import pytest
from scipy.linalg import solve_continuous_lyapunov, solve_discrete_lyapunov

from workbench.design.frequency import condition_number, h2_norm, hinf_norm, relative_gains

NARROW = 1.001e-12  # the width of an enclosure, and the rounding of its ends to doubles
ROUNDING = 1e-12  # of a dense Lyapunov equation, or of a singular value on a grid


def resonance(omega, damping, gain=1.0):
    """gain / (s^2 + 2 damping omega s + omega^2)."""
    return control.ss([[0, 1], [-(omega**2), -2 * damping * omega]], [[0], [1]], [[gain, 0]], 0)


def random_system(rng, n, ny, nu, discrete=False):
    A = rng.normal(size=(n, n))
    poles = np.linalg.eigvals(A)
    A = A / (1.05 * abs(poles).max()) if discrete else A - (poles.real.max() + 0.05) * np.eye(n)
    D = rng.normal(size=(ny, nu)) if discrete else np.zeros((ny, nu))
    return control.ss(A, rng.normal(size=(n, nu)), rng.normal(size=(ny, n)), D, 0.1 if discrete else 0)


def encloses(norm, value):
    low, high = norm.gain.low, norm.gain.high
    return low <= value * (1 + 1e-15) and value * (1 - 1e-15) <= high and high <= low * (1 + NARROW)


@pytest.mark.parametrize("damping", [0.5, 1e-2, 1e-4, 1e-7, 1e-10])
@pytest.mark.parametrize("omega", [1e-6, 1.0, 1e6])
def test_a_resonance_has_its_textbook_peak_at_any_damping_and_rate(damping, omega):
    norm = hinf_norm(resonance(omega, damping, omega**2))
    # the rounding of 2 damping omega and of omega^2 moves the peak by some units in the last place
    value = 1 / (2 * damping * np.sqrt(1 - damping**2))
    assert abs(norm.gain.value / value - 1) < 2e-12
    assert norm.frequency == pytest.approx(omega * np.sqrt(1 - 2 * damping**2), rel=1e-6)


@pytest.mark.parametrize(
    ("system", "value", "peak"),
    [
        (control.ss(-1, 1, 1, 0), 1.0, 0.0),
        (control.ss(-1, 1, -1, 2), 2.0, np.inf),
        (control.ss(-0.5, 1, 1, 0, 0.1), 2 / 3 + 4 / 3, np.pi / 0.1),
        (control.ss(0.5, 1, 1, 0, 0.1), 2.0, 0.0),
        (control.ss([[0, 0], [1, 0]], [[1], [0]], [[-1, 1]], 1, 1.0), 3.0, np.pi),
    ],
)
def test_a_peak_at_either_end_of_the_axis_is_found(system, value, peak):
    norm = hinf_norm(system)
    assert encloses(norm, value)
    assert norm.frequency == pytest.approx(peak)


def test_an_all_pass_system_has_the_norm_one_though_every_frequency_attains_it():
    slow, fast = control.ss(-1e-6, 1e-6, -2, 1), control.ss(-1e6, 1e6, -2, 1)
    turn = control.ss([], [], [], [[0.6, -0.8], [0.8, 0.6]])
    assert encloses(hinf_norm(slow * fast), 1.0)
    assert encloses(hinf_norm(turn * control.append(slow, fast)), 1.0)
    assert encloses(hinf_norm(control.ss([[0, 1], [-1, -2e-7]], [[0], [1]], [[0, -4e-7]], 1)), 1.0)
    assert encloses(hinf_norm(control.ss(0.75, 1, -0.4375, 0.75, 1.0)), 1.0)


def test_of_nearly_equal_narrow_peaks_the_highest_is_found():
    rates, excess = (1.0, 1.5, 7.0, 100.0, 1e4), (0.0, 1e-10, 2e-10, -1e-10, 1e-11)
    parts = [resonance(w, 1e-4, w**2 * 2e-4 * (1 + e)) for w, e in zip(rates, excess, strict=True)]
    norm = hinf_norm(control.append(*parts))
    assert encloses(norm, (1 + 2e-10) / np.sqrt(1 - 1e-8))
    assert norm.frequency == pytest.approx(7.0, rel=1e-6)


def test_equal_blocks_whose_levels_meet_the_axis_in_double_roots_are_enclosed():
    block = resonance(2.0, 1e-3)
    assert encloses(hinf_norm(control.append(block, block, block)), hinf_norm(block).gain.value)


def test_the_rates_1e6_and_1e_minus_6_stand_in_one_system():
    parts = resonance(1e6, 1e-7, 1e12), resonance(1e-6, 1e-7, 1e-12)
    norm = hinf_norm(control.append(*parts))
    assert abs(norm.gain.value / 5e6 - 1) < 1e-12


@pytest.mark.parametrize("discrete", [False, True])
@pytest.mark.parametrize("seed", range(6))
def test_no_frequency_has_a_gain_above_the_enclosure(seed, discrete):
    system = random_system(np.random.default_rng(seed), 7, 2, 3, discrete)
    norm = hinf_norm(system)
    w = np.append(np.linspace(0, np.pi / 0.1, 500) if discrete else np.logspace(-3, 3, 500), norm.frequency)
    answers = system(np.exp(0.1j * w) if discrete else 1j * w)
    gains = np.linalg.svd(np.moveaxis(answers, 2, 0), compute_uv=False)[:, 0]
    assert gains.max() <= norm.gain.high * (1 + ROUNDING)
    assert gains[-1] >= norm.gain.low * (1 - ROUNDING)


@pytest.mark.parametrize("seed", range(4))
def test_the_hamiltonian_loses_its_imaginary_eigenvalues_inside_the_enclosure(seed):
    system = random_system(np.random.default_rng(100 + seed), 4, 2, 2)
    norm = hinf_norm(system)
    assert _imaginary_eigenvalues(system, norm.gain.low * (1 - 1e-12)) > 0
    assert _imaginary_eigenvalues(system, norm.gain.high) == 0


def _imaginary_eigenvalues(system, gamma):
    """The number of imaginary eigenvalues of the Hamiltonian without D, by flint's exact polynomial and its roots."""

    flint = pytest.importorskip("flint")

    def exact(M):
        ratios = [[float(x).as_integer_ratio() for x in row] for row in M]
        return flint.fmpq_mat([[flint.fmpq(*ratio) for ratio in row] for row in ratios])

    A, B, C = exact(system.A), exact(system.B), exact(system.C)
    weight = 1 / flint.fmpq(*gamma.as_integer_ratio()) ** 2
    over, under = (B * B.transpose()).tolist(), (C.transpose() * C).tolist()
    n = system.nstates
    H = [A.tolist()[i] + [weight * x for x in over[i]] for i in range(n)]
    H += [[-x for x in under[i]] + [-A[j, i] for j in range(n)] for i in range(n)]
    p = flint.fmpq_mat(H).charpoly()
    even = flint.fmpq_poly([(-1) ** k * p[2 * k] for k in range(n + 1)]).numer()  # of omega^2
    return sum(root.imag == 0 and root.real > 0 for root, _ in even.complex_roots())


def test_slycot_agrees_where_it_is_installed():
    pytest.importorskip("slycot")
    system = random_system(np.random.default_rng(7), 8, 2, 2)
    assert control.linfnorm(system)[0] == pytest.approx(hinf_norm(system).gain.value, rel=1e-8)


@pytest.mark.parametrize("system", [control.ss(1, 1, 1, 0), control.ss([[0, 1], [-1, 0]], [[0], [1]], [[1, 0]], 0)])
def test_a_system_that_is_not_stable_has_infinite_norms_and_the_reason_is_given(system):
    assert hinf_norm(system).gain.value == h2_norm(system).gain.value == np.inf
    assert "not stable" in hinf_norm(system).reason
    assert "not stable" in h2_norm(system).reason


def test_an_unstable_mode_that_nobody_sees_counts():
    hidden = control.ss([[-1, 0], [0, 1]], [[1], [0]], [[1, 1]], 0)
    assert hinf_norm(hidden).gain.value == np.inf


def test_systems_without_states_or_without_gain_have_norms():
    assert encloses(hinf_norm(control.ss([], [], [], [[1, 2], [3, 4]])), np.linalg.norm([[1, 2], [3, 4]], 2))
    assert hinf_norm(control.ss([[-1, 2], [0, -3]], [[1], [1]], [[0, 0]], 0)).gain.high == 0
    assert h2_norm(control.ss([], [], [], 3.0, 1.0)).gain.value == 3


@pytest.mark.parametrize("discrete", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_the_h2_norm_is_that_of_the_gramian(seed, discrete):
    system = random_system(np.random.default_rng(seed), 8, 2, 3, discrete)
    A, B, C, D = system.A, system.B, system.C, system.D
    P = (solve_discrete_lyapunov if discrete else lambda A, Q: solve_continuous_lyapunov(A, -Q))(A, B @ B.T)
    expected = np.sqrt(np.trace(C @ P @ C.T + D @ D.T))
    assert h2_norm(system).gain.value == pytest.approx(expected, rel=ROUNDING)


@pytest.mark.parametrize("damping", [0.3, 1e-6, 1e-12])
def test_the_h2_norm_of_a_resonance_is_its_closed_form(damping):
    norm = h2_norm(resonance(10.0, damping))
    assert norm.gain.value == pytest.approx(1 / np.sqrt(4 * damping * 10.0**3), rel=1e-14)
    assert norm.gain.error <= 4e-16 * norm.gain.value


def test_a_direct_term_in_continuous_time_has_no_h2_norm():
    norm = h2_norm(control.ss(-1, 1, 1, 1))
    assert norm.gain.value == np.inf
    assert "direct term" in norm.reason


def test_the_distillation_column_has_its_published_gain_condition_number_and_relative_gains():
    """Skogestad and Postlethwaite (2005), Multivariable Feedback Control, example 3.6 and section 3.4."""
    G = np.array([[87.8, -86.4], [108.2, -109.6]])
    column = control.ss(-np.eye(2) / 75, np.eye(2) / 75, G, np.zeros((2, 2)))
    norm = hinf_norm(column)
    assert round(norm.gain.value, 1) == 197.2
    assert norm.frequency == 0
    assert round(condition_number(G), 1) == 141.7
    gains = relative_gains(G)
    assert round(gains[0, 0].real, 1) == 35.1
    np.testing.assert_allclose(gains.sum(axis=0), 1, atol=1e-12)


@pytest.mark.parametrize("G", [[[1.0, np.nan]], "gain", [1.0, 2.0], [[]], None])
def test_what_is_no_matrix_of_gains_is_refused(G):
    for function in (condition_number, relative_gains):
        with pytest.raises(ValueError, match=r"matrix of finite numbers"):
            function(G)


def test_a_singular_matrix_has_no_relative_gains():
    assert condition_number([[1, 2], [2, 4]]) == np.inf
    with pytest.raises(ValueError, match="singular"):
        relative_gains([[1, 2], [2, 4]])
    with pytest.raises(ValueError, match="square"):
        relative_gains([[1, 2]])


@pytest.mark.parametrize("function", [hinf_norm, h2_norm])
def test_odd_systems_are_refused_by_name(function):
    with pytest.raises(ValueError, match="finite"):
        function(control.ss([[np.nan]], 1, 1, 0))
    with pytest.raises(ValueError, match="StateSpace"):
        function(control.tf([1], [1, 1]))
    with pytest.raises(ValueError, match="200"):
        function(control.ss(-np.eye(200), np.ones((200, 1)), np.ones((1, 200)), 0))
    with pytest.raises(ValueError, match="1e307"):
        function(control.ss(-1, 1e200, 1e200, 0))


def test_many_channels_have_a_norm():
    gain = np.random.default_rng(3).normal(size=(9, 12))
    assert encloses(hinf_norm(control.ss([], [], [], gain)), np.linalg.norm(gain, 2))


def test_too_many_channels_for_exact_arithmetic_are_refused_where_nothing_else_proves_the_norm():
    delays = np.eye(4, k=-1)  # one chain, so that no eigenvectors are a basis
    with pytest.raises(ValueError, match="channels"):
        hinf_norm(control.ss(delays, np.ones((4, 8)), np.ones((8, 4)), np.eye(8), 0.1))
