"""The tanks of b3: what a zero to the right forces, and what a placed design settles."""

import control
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import place_poles

from studies.b3_any_plant import tanks
from studies.b3_any_plant.loops import LQG, OBSERVER, PID, PLACED, REGULATOR, cut, placed_gains
from studies.b3_any_plant.settings import EASY, HARD
from tests.support.settings_of_b3 import BY_NAME, compensator, rows
from workbench.design.linear import sensitivity


def test_under_two_pi_the_slowest_mode_is_thirteen_times_as_slow_at_p_plus_and_the_level_four_to_five_times():
    slow = {name: -sensitivity(cut(BY_NAME[name], PID)).poles().real.max() for name in (EASY, HARD)}
    assert slow[EASY] / slow[HARD] == pytest.approx(13.4, abs=0.1)
    runs = {name: tanks.levels((name, PID, 1.0)) for name in (EASY, HARD)}
    (easy, _), (hard, both) = runs[EASY].settling, runs[HARD].settling
    assert hard / easy == pytest.approx(4.6, abs=0.1)  # times on a grid of 0.25 s
    assert both / max(runs[EASY].settling) > 15


def placed_by_scipy():
    """The tanks at P+ under the placed design, with equations, gains and solver of other hands: t, levels, voltages."""
    setting = BY_NAME[HARD]
    A, B, C = (np.asarray(part) for part in (setting.model.A, setting.model.B, setting.model.C))
    K = place_poles(A, B, REGULATOR).gain_matrix
    L = place_poles(A.T, C.T, OBSERVER).gain_matrix.T
    x0, u0, start = setting.point.x, setting.point.u, np.array([10.4, 13.0, 4.8, 4.9])

    def rate(t, z):
        x, hat = z[:4], z[4:]
        v, out = u0 - K @ hat, np.sqrt(2 * 981.0 * x)
        levels = [
            (-0.071 * out[0] + 0.071 * out[2] + 0.43 * 3.14 * v[0]) / 28.0,
            (-0.057 * out[1] + 0.057 * out[3] + 0.34 * 3.29 * v[1]) / 32.0,
            (-0.071 * out[2] + 0.66 * 3.29 * v[1]) / 28.0,
            (-0.057 * out[3] + 0.57 * 3.14 * v[0]) / 32.0,
        ]
        return np.concatenate([levels, A @ hat + B @ (v - u0) + L @ ((x - x0)[:2] - hat[:2])])

    z0 = np.concatenate([start, (start - x0)[:2], [0.0, 0.0]])
    t = np.arange(0.0, 400.0, 0.25)
    out = solve_ivp(rate, (0.0, 400.0), z0, "LSODA", t, rtol=1e-9, atol=1e-11)
    return t, out.y[:2].T - [setting.operating_outputs["h_1"], setting.operating_outputs["h_2"]], u0 - out.y[4:].T @ K.T


def test_a_placed_design_settles_both_tanks_beyond_the_decay_of_the_mirrored_zero():
    t, off, volts = placed_by_scipy()
    band = 0.05 * np.abs(off[0]).max()
    late = t[np.flatnonzero((np.abs(off) > band).any(axis=1)).max() + 1]
    assert late < 73.0
    assert 1.5 < volts.min() < volts.max() < 6.0
    ours = tanks.levels((HARD, PLACED, 1.0))
    # both on the grid of 0.25 s; the two solvers differ by less than a step of it
    assert max(ours.settling) == pytest.approx(late, abs=0.26)
    assert ours.voltages == pytest.approx((volts.min(), volts.max()), rel=1e-3)
    # what the zero does force, to the 5 % that are left then
    _, psi = tanks.zero_of(BY_NAME[HARD])
    assert np.abs(off @ psi).max() > 0.95 * tanks.least_swing(BY_NAME[HARD], late)
    # eight poles, the nearest where it was placed: no mode as slow as the mirror image of the zero
    assert ours.decay == pytest.approx(0.05, rel=1e-6)
    assert ours.decay > 3 * tanks.zero_of(BY_NAME[HARD])[0]


def test_the_zero_fixes_a_weighted_integral_of_the_levels_under_every_law():
    setting = BY_NAME[HARD]
    (z, psi), n = tanks.zero_of(setting), 4
    A, B, C = (np.asarray(part) for part in (setting.model.A, setting.model.B, setting.model.C))
    off = setting.open.states.default - setting.point.x
    K, L = placed_gains(setting)
    laws = [compensator(setting, PID), compensator(setting, LQG), control.ss(A - B @ K - L @ C, L, K, 0)]
    for law in laws:
        whole = np.block([[A - B @ law.D @ C, -B @ law.C], [law.B @ C, law.A]])
        start = np.concatenate([off, np.zeros(len(law.A))])
        # the Laplace transform of the levels at z, which is the integral where the loop decays
        transform = np.linalg.solve(z * np.eye(len(whole)) - whole, start)[:n]
        assert psi @ C @ transform == pytest.approx(tanks.predicted_integral(setting), rel=1e-9)
    # the nonlinear run is 2 cm from rest of 12 cm
    assert tanks.levels((HARD, LQG, 1.0)).fixed_integral == pytest.approx(tanks.predicted_integral(setting), rel=0.03)


def test_cheap_control_puts_a_mode_of_the_regulator_on_the_mirror_image_of_the_zero():
    setting = BY_NAME[HARD]
    z, _ = tanks.zero_of(setting)
    far = []
    for price in (1.0, 1e-2, 1e-4):
        _, _, poles = control.lqr(setting.model.A, setting.model.B, rows(setting)[0], price * np.eye(2), method="scipy")
        far.append(np.abs(poles + z).min() / z)
    assert far[0] < 2e-3
    assert far[0] > far[1] > far[2]
