"""The supremum of mu over frequency: norms, published loops, and jumps of real perturbations."""

import control
import numpy as np
import pytest

import workbench as wb
from workbench.design.structured_uncertainty import (
    ComplexScalar,
    FullBlock,
    RealScalar,
    robustness_over_frequency,
    structured_singular_value,
)

F, C, R = FullBlock, ComplexScalar, RealScalar
TIGHT = 5.1e-4  # what the upper bound adds to the peak, so that bands have a width


def random_system(seed, n, m, discrete=False):
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(n, n))
    poles = np.linalg.eigvals(A)
    A = A / (1.1 * abs(poles).max()) if discrete else A - (poles.real.max() + 0.1) * np.eye(n)
    return control.ss(A, rng.normal(size=(n, m)), rng.normal(size=(m, n)), 0.2 * rng.normal(size=(m, m)), discrete / 2)


def check_bands(system, answer):
    """The bands join, and the scalings of each hold at its ends and between."""
    ends = 0.0
    for band in answer.bands:
        assert band.low <= ends
        ends = max(ends, band.high)
    assert ends == np.inf
    for band in answer.bands:
        high = min(band.high, 1e6)
        for omega in np.linspace(band.low, high, 7)[1:-1]:
            M = np.asarray(system(1j * omega, squeeze=False))
            cross = 1j * band.G @ M
            W = answer.upper**2 * band.D - M.conj().T @ band.D @ M - cross - cross.conj().T
            assert np.linalg.eigvalsh(W)[0] >= -1e-9 * np.linalg.norm(band.D)


@pytest.mark.parametrize("discrete", [False, True])
def test_one_full_block_has_the_h_infinity_norm(discrete):
    system = random_system(1, 6, 3, discrete)
    norm = wb.hinf_norm(system)
    answer = robustness_over_frequency(system, [F(3)])
    assert answer.lower <= norm.gain.high
    assert norm.gain.low <= answer.upper <= norm.gain.high * (1 + TIGHT)
    assert answer.lower == pytest.approx(norm.gain.value, rel=1e-7)
    assert answer.frequency == pytest.approx(norm.frequency, rel=1e-4)


def test_a_narrow_resonance_between_channels_is_found():
    A = np.zeros((6, 6))
    for k, omega in enumerate((1.0, 2.3, 5.0)):
        A[2 * k : 2 * k + 2, 2 * k : 2 * k + 2] = [[0, 1], [-(omega**2), -4e-4 * omega]]
    B = np.zeros((6, 2))
    B[1::2] = [[0.3, 0.1], [1.0, -0.7], [0.2, 2.0]]
    C_ = np.zeros((2, 6))
    C_[:, 0::2] = B[1::2].T
    system = control.ss(A, B, C_, 0)
    answer = robustness_over_frequency(system, [F(1), F(1)])
    check_bands(system, answer)
    assert answer.upper == pytest.approx(answer.lower, rel=TIGHT)
    assert answer.lower <= wb.hinf_norm(system).gain.high
    for omega in 2.3 * (1 + 1e-4 * np.linspace(-5, 5, 11)):
        assert structured_singular_value(system(1j * omega), [F(1), F(1)]).lower <= answer.upper


HEAVY = pytest.mark.heavy


@pytest.mark.parametrize(
    "blocks", [[F(1)] * 3, *(pytest.param(b, marks=HEAVY) for b in ([R(1), F(2)], [R(2), C(1)]))], ids=str
)
def test_no_frequency_of_a_grid_is_above_and_the_perturbation_makes_the_loop_singular(blocks):
    system = random_system(2, 6, 3)
    answer = robustness_over_frequency(system, blocks)
    check_bands(system, answer)
    assert answer.upper <= answer.lower * (1 + TIGHT)
    for omega in np.geomspace(1e-2, 1e2, 13):
        assert structured_singular_value(system(1j * omega), blocks).lower <= answer.upper
    M = system(1j * answer.frequency)
    values = np.linalg.svd(np.eye(3) - M @ answer.perturbation, compute_uv=False)
    assert values[-1] < 1e-7 * values[0]
    assert np.linalg.norm(answer.perturbation, 2) == pytest.approx(answer.margin[1], rel=1e-3)


def test_one_real_parameter_counts_where_the_gain_is_real_alone():
    """1 / (s + 1)^2 is real at zero, where it is one, and then at none; s / (s + 1)^2 is a half at 1 rad/s."""
    lags = control.ss([[-2, -1], [1, 0]], [[1], [0]], [[0, 1]], 0)
    answer = robustness_over_frequency(lags, [R(1)])
    assert (answer.lower, answer.frequency) == (1.0, 0.0)
    assert answer.upper == pytest.approx(1.0, rel=TIGHT)
    band_pass = control.ss([[-2, -1], [1, 0]], [[1], [0]], [[1, 0]], 0)
    answer = robustness_over_frequency(band_pass, [R(1)])
    assert answer.lower == pytest.approx(0.5, rel=1e-6)
    assert answer.upper == pytest.approx(0.5, rel=TIGHT)
    assert answer.frequency == pytest.approx(1.0, rel=1e-6)


def test_the_real_margin_of_a_polynomial_is_that_of_its_roots():
    """s^3 + (2 + d) s^2 + 3 s + 1 loses stability at d = -5 / 3, by Routh: (2 + d) 3 = 1."""
    A = np.array([[-2.0, -3.0, -1.0], [1, 0, 0], [0, 1, 0]])
    answer = robustness_over_frequency(control.ss(A, [[1.0], [0], [0]], [[-1.0, 0, 0]], 0), [R(1)])
    low, high = answer.margin
    assert low <= 5 / 3 <= high * (1 + 1e-12)
    assert low == pytest.approx(5 / 3, rel=TIGHT)
    assert answer.frequency == pytest.approx(np.sqrt(3), rel=1e-6)


@pytest.mark.parametrize("blocks", [[F(1), F(1)], [F(2)], pytest.param([R(1), R(1)], marks=HEAVY)], ids=str)
def test_the_satellite_whose_every_loop_looks_perfect_is_unstable_by_a_tenth_in_both_channels(blocks):
    """Skogestad and Postlethwaite (2005), Multivariable Feedback Control, section 3.7.1, after Doyle (1986).

    G = 1 / (s^2 + a^2) [s - a^2, a (s + 1); -a (s + 1), s - a^2] with a = 10 and K = I: each loop alone is 1 / s, and
    T = 1 / (s + 1) [1, a; -a, 1]. Both gains changed by delta and -delta: unstable from 1 / sqrt(1 + a^2).
    """
    a = 10.0
    A, B = np.array([[0.0, a], [-a, 0.0]]), np.eye(2)
    C_ = np.array([[1.0, a], [-a, 1.0]])
    T = control.ss(A - B @ C_, B, C_, 0)
    for channel in range(2):  # the other one closed
        other = 1 - channel
        part = control.ss(A - np.outer(B[:, other], C_[other]), B[:, [channel]], C_[[channel]], 0)
        assert wb.stability_margins(part).margins.Ms.gain.value == pytest.approx(1.0, abs=1e-12)
    assert wb.hinf_norm(T).gain.value == pytest.approx(np.sqrt(1 + a**2), rel=1e-9)
    answer = robustness_over_frequency(T, blocks)
    assert answer.lower == pytest.approx(np.sqrt(1 + a**2), rel=1e-9)
    assert answer.upper == pytest.approx(answer.lower, rel=TIGHT)


def distillation_column():
    """N of Skogestad and Postlethwaite (2005), section 8.11.3, with what cancels left out; rates per minute.

    Plant G0 / (75 s + 1), inverse-based controller 0.7 / s (75 s + 1) G0^-1, w_I = (s + 0.2) / (0.5 s + 1) for each
    input, w_P = (s / 2 + 0.05) / s.
    """
    G0 = np.array([[87.8, -86.4], [108.2, -109.6]])
    G1, one = np.linalg.inv(G0), np.eye(2)

    def lag(rate, gain, direct=0.0):
        return control.append(*[control.ss(-rate, 1.0, gain, direct)] * 2)

    w_I = lag(2.0, 0.4 - 4.0, 2.0)
    T = lag(0.7, 0.7)  # 0.7 / (s + 0.7)
    KS = lag(0.7, 0.7 * (1 - 52.5), 52.5)  # 0.7 (75 s + 1) / (s + 0.7)
    w_PS = lag(0.7, 0.05 - 0.35, 0.5)
    slow = lag(1 / 75, 1 / 75)
    static = [control.ss([], [], [], M) for M in (G0, G1, np.hstack([one, one]))]
    add = static[2]
    rows = [
        w_I * add * control.append(T, KS * static[1]),
        w_PS * add * control.append(static[0] * slow, control.ss([], [], [], one)),
    ]
    both = control.append(*rows)
    return control.ss(
        both.A, both.B @ np.vstack([np.eye(4), np.eye(4)]), both.C, both.D @ np.vstack([np.eye(4), np.eye(4)])
    )


def test_the_distillation_column_has_its_published_values():
    """Figure 8.11 of Skogestad and Postlethwaite (2005), after Skogestad, Morari and Doyle (1988)."""
    N = distillation_column()
    performance = wb.hinf_norm(N[2:, 2:]).gain.value
    stability = robustness_over_frequency(N[:2, :2], [F(1), F(1)])
    assert round(performance, 2) == 0.5
    assert round(stability.lower, 2) == round(stability.upper, 2) == 0.53


@HEAVY
def test_the_robust_performance_of_the_distillation_column_is_as_poor_as_published():
    """Figure 8.11 of Skogestad and Postlethwaite (2005), after Skogestad, Morari and Doyle (1988): a peak of 5.8."""
    robust = robustness_over_frequency(distillation_column(), [F(1), F(1), F(2)])
    assert 5.7 < robust.lower < robust.upper < 5.8
    assert robust.upper == pytest.approx(robust.lower, rel=TIGHT)


def test_systems_without_states_and_blocks_that_are_not_square_have_answers():
    answer = robustness_over_frequency(control.ss([], [], [], [[1.0, 2.0], [3.0, 4.0]]), [F(1), F(1)])
    assert answer.lower <= structured_singular_value([[1.0, 2.0], [3.0, 4.0]], [F(1), F(1)]).upper <= answer.upper
    tall = control.ss(-1, 1, [[3.0], [4.0]], [[0.0], [0.0]])
    answer = robustness_over_frequency(tall, [F(1, 2)])
    assert answer.lower == pytest.approx(5.0, rel=1e-9)
    assert answer.perturbation.shape == (1, 2)


def test_odd_systems_are_refused_by_name():
    with pytest.raises(ValueError, match="not stable"):
        robustness_over_frequency(control.ss(1, 1, 1, 0), [F(1)])
    with pytest.raises(ValueError, match="StateSpace"):
        robustness_over_frequency(control.tf([1], [1, 1]), [F(1)])
    with pytest.raises(ValueError, match="shape"):
        robustness_over_frequency(control.ss(-1, 1, 1, 0), [F(2)])
    with pytest.raises(ValueError, match="60 states"):
        robustness_over_frequency(control.ss(-np.eye(61), np.ones((61, 1)), np.ones((1, 61)), 0), [F(1)])
