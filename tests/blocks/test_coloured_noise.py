"""Coloured noise against its equation in continuous time: covariances, spectra, and its place in a loop."""

import casadi as ca
import numpy as np
import pytest
from scipy.linalg import expm, solve_discrete_lyapunov
from scipy.stats import chi2, norm

import workbench as wb

# The chance that a test refuses numbers that are as they should be. The seeds are fixed, so its answer never changes.
SIGNIFICANCE = 1e-5
MOTOR = wb.DCMotor()


@wb.block
class Still(wb.Controller):
    """v = 0."""

    reads = wb.layout()
    drives = wb.layout(v="V")

    def command(self, t, z, est, ref):
        return {"v": 0.0 * ca.SX(t)}


def loop_with(noise, plant=MOTOR):
    return wb.ClosedLoop(wb.DisturbedPlant(plant, by=noise), controller=Still())


def matrices(noise, period):
    """Phi and L of z+ = Phi z + L w, and the factor of the first covariance."""
    n = len(noise.states)
    z, w = ca.SX.sym("z", n), ca.SX.sym("w", n)
    after = ca.vertcat(*noise.after(ca.vertsplit(z), ca.vertsplit(w), period))
    start = ca.vertcat(*noise.start(ca.vertsplit(w)))
    parts = [ca.jacobian(after, z), ca.jacobian(after, w), ca.jacobian(start, w)]
    return [np.array(ca.evalf(ca.densify(part))) for part in parts]


def van_loan(A, b, period):
    """exp(A h), and the covariance that white noise through b adds in h, by the exponential of a block matrix.

    Van Loan (1978), Computing integrals involving the matrix exponential, IEEE Trans. Automatic Control 23(3).
    """
    n = len(A)
    block = np.zeros((2 * n, 2 * n))
    block[:n, :n], block[:n, n:], block[n:, n:] = -A, np.outer(b, b), A.T
    found = expm(block * period)
    flow = found[n:, n:].T
    return flow, flow @ found[:n, n:]


SHARES = [1e-4, 0.01, 0.3, 2.0, 5.0]


@pytest.mark.parametrize("share", SHARES)
def test_noise_of_first_order_moves_by_its_exact_law(share):
    T, sigma = 0.7, 1.3
    Phi, L, S = matrices(wb.GaussMarkov("v", sigma, T), share * T)
    flow, Q = van_loan(np.array([[-1 / T]]), np.array([sigma * np.sqrt(2 / T)]), share * T)
    np.testing.assert_allclose(Phi, flow, rtol=1e-13)
    np.testing.assert_allclose(L @ L.T, Q, rtol=1e-12)  # the block's exponential rounds at its largest entry, e^5
    np.testing.assert_allclose(Phi @ S @ S.T @ Phi.T + L @ L.T, S @ S.T, rtol=1e-15)


@pytest.mark.parametrize("damping", [0.02, 0.5, 1 / np.sqrt(2), 1 - 1e-9, 1.0, 1 + 1e-9, 1.5, 20.0])
@pytest.mark.parametrize("share", SHARES)
def test_noise_of_second_order_moves_by_its_exact_law(damping, share):
    omega, sigma = 3.0, 0.4
    period = share / omega
    Phi, L, S = matrices(wb.SecondOrderNoise("v", sigma, omega, damping), period)
    A = np.array([[0, 1], [-(omega**2), -2 * damping * omega]])
    scale = np.diag([sigma, sigma * omega])
    np.testing.assert_allclose(S, scale, rtol=1e-15)
    np.testing.assert_allclose(Phi, expm(A * period), rtol=0, atol=1e-12)
    # what is added is 1 less what is left, to a few roundings of 1
    one = np.linalg.solve(scale, Phi @ scale), np.linalg.solve(scale, L)
    np.testing.assert_allclose(one[0] @ one[0].T + one[1] @ one[1].T, np.eye(2), rtol=0, atol=2e-15)
    if damping * share < 4:  # beyond, entries of exp(2 damping share) cancel in the exponential of the block
        _, Q = van_loan(A, np.array([0, 2 * sigma * np.sqrt(damping * omega**3)]), period)
        np.testing.assert_allclose(one[1] @ one[1].T, Q / np.outer(*[np.diag(scale)] * 2), rtol=1e-9, atol=2e-15)


def test_a_damping_beyond_all_reason_leaves_finite_numbers():
    for damping in (1e-8, 1e3):
        for period in (1e-9, 1e4):
            assert all(
                np.isfinite(part).all() for part in matrices(wb.SecondOrderNoise("v", 1.0, 5.0, damping), period)
            )


def paths(noise, period, count, runs, seed=1):
    """The noise on v at the instants of many runs, (runs, count)."""
    step = loop_with(noise).digital(period).step(1)
    run = wb.simulate(step, x0=np.tile(step.states.default, (runs, 1)), until=count * period, seed=seed)
    return run.x[:, 1:, step.states.slice("plant.v.noise")][:, :, 0]  # the state behind an instant has its noise


def assert_moment(products, want, deviation):
    """The mean of independent products against its expectation, with their standard deviation."""
    bound = norm.isf(SIGNIFICANCE / 2) * deviation / np.sqrt(len(products))
    assert abs(products.mean() - want) < bound


@pytest.mark.parametrize("period", [0.01, 0.2, 3.0])
def test_the_variance_and_the_correlation_are_those_declared_at_every_period_from_the_first_instant_on(period):
    sigma, T, runs = 0.5, 0.4, 4000
    x = paths(wb.GaussMarkov("v", sigma, T), period, 12, runs)
    for k in (0, 1, 11):
        low, high = chi2.ppf([SIGNIFICANCE / 2, 1 - SIGNIFICANCE / 2], runs)
        assert low < (x[:, k] ** 2).sum() / sigma**2 < high
    for i, j in ((0, 1), (0, 5), (4, 11)):
        r = np.exp(-(j - i) * period / T)
        assert_moment(x[:, i] * x[:, j], sigma**2 * r, sigma**2 * np.sqrt(1 + r**2))


@pytest.mark.parametrize("period", [0.05, 0.5])
def test_the_correlation_of_second_order_is_a_damped_wave(period):
    sigma, omega, zeta, runs = 2.0, 3.0, 0.2, 4000
    x = paths(wb.SecondOrderNoise("v", sigma, omega, zeta), period, 12, runs)
    damped = omega * np.sqrt(1 - zeta**2)
    for i, j in ((0, 0), (7, 7), (0, 1), (0, 4), (3, 11)):
        s = (j - i) * period
        r = np.exp(-zeta * omega * s) * (np.cos(damped * s) + zeta * omega / damped * np.sin(damped * s))
        assert_moment(x[:, i] * x[:, j], sigma**2 * r, sigma**2 * np.sqrt(1 + r**2))


def test_a_random_walk_has_the_variance_and_the_correlation_of_a_drift():
    N, first, period, runs = 0.3, 0.2, 0.25, 4000
    x = paths(wb.RandomWalk("v", N, first), period, 20, runs)
    for i, j in ((0, 0), (8, 8), (19, 19), (3, 15)):
        early, late = (first**2 + N**2 * k * period for k in (i, j))
        assert_moment(x[:, i] * x[:, j], early, np.sqrt(early * late + early**2))


SPECTRA = {
    "first order": (wb.GaussMarkov("v", 0.5, 0.4), lambda w: 2 * 0.5**2 * 0.4 / (1 + (0.4 * w) ** 2)),
    "second order": (
        wb.SecondOrderNoise("v", 0.5, 4.0, 0.3),
        lambda w: 4 * 0.5**2 * 0.3 * 4.0**3 / ((4.0**2 - w**2) ** 2 + (2 * 0.3 * 4.0 * w) ** 2),
    ),
}


@pytest.mark.parametrize("name", SPECTRA)
def test_the_spectrum_is_the_one_of_the_equation_folded_at_the_period(name):
    noise, S = SPECTRA[name]
    period, count, runs = 0.1, 256, 2000
    x = paths(noise, period, count, runs, seed=5)
    power = (np.abs(np.fft.rfft(x, axis=1)) ** 2).mean(axis=0)[1:-1] / count * period
    # the expectation of a periodogram, by the covariances whose transform the folded spectrum is
    grid = 2 * np.pi * np.fft.fftfreq(2**14, period)
    folded = sum(S(grid + 2 * np.pi * m / period) for m in range(-500, 501)) / period
    covariance = np.fft.ifft(folded).real[:count]
    assert covariance[0] == pytest.approx(0.5**2, rel=1e-3)  # what 500 folds leave out of a spectrum of first order
    lags = np.arange(count)
    weights = covariance * (1 - lags / count) * np.where(lags, 2, 1)
    frequencies = np.arange(1, count // 2)
    want = period * (weights * np.cos(2 * np.pi * np.outer(frequencies, lags) / count)).sum(axis=1)
    # a line of a periodogram is nearly exponential, the mean of many nearly chi-squared; by Bonferroni over all lines
    share = SIGNIFICANCE / 2 / len(want)
    low, high = chi2.ppf([share, 1 - share], 2 * runs) / (2 * runs)
    assert np.all((power / want > low * (1 - 2e-3)) & (power / want < high * (1 + 2e-3)))


def test_a_plant_under_noise_has_the_variance_that_lyapunov_s_equation_says():
    @wb.block
    class Lag(wb.Plant):
        """T x' = v - x."""

        T: float = wb.parameter(default=0.3, unit="s")
        x: float = wb.initial(default=0.0, unit="V")
        inputs, outputs = wb.layout(v="V"), wb.layout(x="V")

        def rate(self, t, x, u):
            return {"x": (u.v - x.x) / self.T}

    period, runs, sigma, T = 0.1, 4000, 0.8, 0.5
    step = loop_with(wb.GaussMarkov("v", sigma, T), Lag()).digital(period).step(4)
    run = wb.simulate(step, x0=np.tile(step.states.default, (runs, 1)), until=10.0, seed=2)
    a, b = np.exp(-period / 0.3), np.exp(-period / T)
    F = np.array([[a, 1 - a], [0, b]])  # of the lag, and of the noise that is held over a period
    P = solve_discrete_lyapunov(F, np.diag([0, sigma**2 * (1 - b**2)]))
    x = run.x[:, -1, step.states.slice("plant.x")].ravel()
    assert_moment(x**2, P[0, 0], np.sqrt(2) * P[0, 0])


@pytest.mark.parametrize(
    "noise", [wb.GaussMarkov("v", [0.5, 2.0], 0.4), wb.SecondOrderNoise("v", [0.5, 2.0], 3.0, 0.2)]
)
def test_a_path_has_the_law_of_the_noise_and_a_table_holds_it_in_continuous_time(noise):
    period, count = 0.1, 60_000
    x = noise.path(period, count, np.random.default_rng(3))
    assert x.shape == (count, 2)
    if len(noise.states) == 1:
        r = np.exp(-period / 0.4)
    else:
        damped = 3.0 * np.sqrt(1 - 0.2**2)
        wave = np.cos(damped * period) + 0.2 * 3.0 / damped * np.sin(damped * period)
        r = np.exp(-0.2 * 3.0 * period) * wave
    # some 6000 correlation times: a variance within 5 % is five standard deviations
    np.testing.assert_allclose(x.var(axis=0), [0.25, 4.0], rtol=0.1)
    np.testing.assert_allclose((x[1:] * x[:-1]).mean(axis=0) / x.var(axis=0), r, atol=0.02)
    assert abs(np.corrcoef(x.T)[0, 1]) < 0.1
    one = wb.GaussMarkov("v", 0.5, 0.4).path(period, 50, np.random.default_rng(3))
    gust = wb.Table("v", "V", period * np.arange(50), one, "hold")
    run = wb.simulate(
        wb.rk4(wb.ClosedLoop(wb.DisturbedPlant(MOTOR, by=gust), controller=Still()).ode(), period), until=4.9
    )
    np.testing.assert_array_equal(run["d_v"][0, :-1], one[:-1])


def test_each_number_of_a_signal_has_noise_of_its_own():
    plant = wb.QuadrupleTank()
    name, entry = plant.outputs.names[0], plant.outputs.entries[0]
    gauges = wb.Instruments.of(plant, coloured_noises=(wb.GaussMarkov(name, 0.1, 2.0),))
    assert gauges.memory[f"{name}.noise"].unit == entry.unit

    arm = wb.Manipulator(wb.paper_arm(), q=[0.0, 0.0])
    both = wb.Instruments.of(arm, coloured_noises=(wb.GaussMarkov("q", 0.1, 2.0),))
    assert both.memory["q.noise"].shape == (2,)
    np.testing.assert_array_equal(both.coloured_noises[0].sigma, [0.1, 0.1])


@pytest.mark.parametrize(
    ("make", "kind", "says"),
    [
        (
            lambda: loop_with(wb.GaussMarkov("v", 1.0, 1.0)).ode(),
            ValueError,
            r"no.*take `ClosedLoop.digital\(period\)`",
        ),
        (
            lambda: wb.open_loop(loop_with(wb.GaussMarkov("v", 1.0, 1.0)).plant),
            ValueError,
            "coloured noise, which moves",
        ),
        (lambda: loop_with(wb.GaussMarkov("w", 1.0, 1.0)), LookupError, "no 'w' among the 2 inputs and outputs"),
        (
            lambda: wb.Instruments.of(MOTOR, coloured_noises=(wb.RandomWalk("v", 1.0),)),
            LookupError,
            "outputs of the plant",
        ),
        (lambda: loop_with(wb.GaussMarkov("v", [1.0, 2.0], 1.0)), ValueError, "must be one number, as 'v' is"),
        (
            lambda: wb.DisturbedPlant(
                wb.DisturbedPlant(MOTOR, by=wb.Step("v", "V", 1.0)), by=wb.GaussMarkov("v", 1.0, 1.0)
            ),
            ValueError,
            "must leave the name 'd_v'",
        ),
        (
            lambda: wb.GaussMarkov("v", -1.0, 1.0),
            ValueError,
            r"`GaussMarkov\(sigma=...\)` must be finite, with 0 <= value",
        ),
        (lambda: wb.GaussMarkov("v", 1.0, 0.0), ValueError, r"`GaussMarkov\(time_constant=...\)` must be finite"),
        (
            lambda: wb.SecondOrderNoise("v", 1.0, 1.0, 0.0),
            ValueError,
            r"`SecondOrderNoise\(damping=...\)` must be finite",
        ),
        (lambda: wb.RandomWalk("v", np.inf), ValueError, r"`RandomWalk\(intensity=...\)` must be finite"),
    ],
)
def test_noise_that_cannot_be_is_refused_by_name(make, kind, says):
    with pytest.raises(kind, match=says):
        make()
