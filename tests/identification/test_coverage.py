"""Intervals of fits over a thousand logs that SciPy makes: each parameter lies inside as often as the interval says.

The logs share no code with the workbench: an integrator with error control for a plant in open loop, and matrix
exponentials for one whose PI law reads the noisy sensor.
"""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.stats import binom

import workbench as wb

LOGS = 1000
BAND = binom.ppf([0.0005, 0.9995], LOGS, 0.95) / LOGS  # 92.6 % to 97.1 %
SIGMA = 0.05


@wb.block
class Pendulum(wb.Plant):
    """A pendulum with viscous and smooth Coulomb friction: J a'' = u - m g l sin(a) - b a' - c tanh(a' / 0.2)."""

    J: float = wb.parameter(default=0.05, unit="kg m^2", low=0, strict=True)
    mgl: float = wb.parameter(default=1.0, unit="N m")
    b: float = wb.parameter(default=0.06, unit="N m s/rad", low=0)
    c: float = wb.parameter(default=0.1, unit="N m", low=0)
    a: float = wb.initial(default=0.0, unit="rad")
    w: float = wb.initial(default=0.0, unit="rad/s")

    inputs = wb.layout(u="N m")
    outputs = wb.layout(a="rad")

    def rate(self, t, x, u):
        friction = self.b * x.w + self.c * np.tanh(x.w / 0.2)
        return {"a": x.w, "w": (u.u - self.mgl * np.sin(x.a) - friction) / self.J}


def share_inside(system, logs, truth):
    """For each parameter how often its 95 % interval holds the truth; the search starts 20 % away from it."""
    start = {name: value * factor for (name, value), factor in zip(truth.items(), (1.2, 0.8, 1.2, 0.8), strict=True)}
    hits = []
    for log in logs:
        intervals = wb.fit(system, log, list(truth), start=start, hold_out=0.0).intervals()
        hits.append([low <= truth[name] <= high for name, (low, high) in intervals.items()])
    return dict(zip(truth, np.mean(hits, axis=0).tolist(), strict=True))


def open_loop_logs():
    """Angles of the pendulum under torques in random steps, each log with noise of its own."""
    t = 0.02 * np.arange(251)
    torque = np.repeat(np.random.default_rng(3).uniform(-1.2, 1.2, 26), 10)[:251]
    x, angles = np.zeros(2), [0.0]
    for (begin, end), u in zip(pairwise(t), torque, strict=False):

        def rate(s, z, u=u):
            return z[1], (u - np.sin(z[0]) - 0.06 * z[1] - 0.1 * np.tanh(z[1] / 0.2)) / 0.05

        x = solve_ivp(rate, (begin, end), x, method="DOP853", rtol=1e-10, atol=1e-12).y[:, -1]
        angles.append(x[0])
    for seed in range(LOGS):
        noise = SIGMA * np.random.default_rng(seed).standard_normal(len(t))
        yield wb.Dataset.of(t, {"u": torque, "a": np.array(angles) + noise}, {"u": "N m", "a": "rad"})


def closed_loop_logs(truth):
    """Speeds and currents of a motor whose PI law acts each 20 ms on the noisy speed that the log has."""
    t, h = 0.02 * np.arange(251), 0.02
    J, b, R, L = (truth[name] for name in ("J", "b", "R", "L"))
    K = 0.01
    whole = expm(h * np.array([[-b / J, K / J, 0.0], [-K / L, -R / L, 1.0 / L], [0.0, 0.0, 0.0]]))
    reference = np.repeat(np.random.default_rng(4).choice([-1.0, 1.0], 26), 10)[:251]
    for seed in range(LOGS):
        noise = SIGMA * np.random.default_rng(seed).standard_normal((len(t), 2))
        x, integral, rows = np.zeros(2), 0.0, []
        for wanted, e in zip(reference, noise, strict=True):
            error = wanted - (x[0] + e[0])
            integral += h * error
            v = 20.0 * error + 40.0 * integral
            rows.append((v, *(x + e)))
            x = (whole @ [*x, v])[:2]
        v, omega, i = np.array(rows).T
        yield wb.Dataset.of(t, {"v": v, "omega": omega, "i": i}, {"v": "V", "omega": "rad/s", "i": "A"})


@pytest.mark.release
def test_intervals_from_an_open_loop_hold_the_truth_as_often_as_they_say():
    truth = {"J": 0.05, "mgl": 1.0, "b": 0.06, "c": 0.1}
    shares = share_inside(wb.open_loop(Pendulum()), open_loop_logs(), truth)
    assert {name: share for name, share in shares.items() if not BAND[0] <= share <= BAND[1]} == {}


@pytest.mark.release
def test_intervals_from_a_closed_loop_hold_the_truth_as_often_as_they_say():
    truth = {"J": 0.01, "b": 0.1, "R": 1.0, "L": 0.5}
    shares = share_inside(wb.open_loop(wb.DCMotor()), closed_loop_logs(truth), truth)
    assert {name: share for name, share in shares.items() if not BAND[0] <= share <= BAND[1]} == {}


def computer_logs(truth, is_fed_back):
    """References, speeds and voltages of a motor under a PI law each 20 ms, whose command waits a period."""
    t, h, K = 0.02 * np.arange(501), 0.02, 0.5
    J, b, L, Kp = truth.values()
    whole = expm(h * np.array([[-b / J, K / J, 0.0], [-K / L, -1.2 / L, 1.0 / L], [0.0, 0.0, 0.0]]))
    reference = np.repeat(np.random.default_rng(4).choice([0.0, 2.0, 5.0], 26), 20)[:501]
    for seed in range(COMPUTER_LOGS):
        noise = np.random.default_rng(seed).standard_normal((len(t), 2)) * [0.1, 0.0 if is_fed_back else 0.02]
        x, integral, waits, rows = np.zeros(2), 0.0, 0.0, []
        for wanted, e in zip(reference, noise, strict=True):
            error = wanted - x[0] - (e[0] if is_fed_back else 0.0)
            v, waits = waits, Kp * error + integral
            integral += h * 2.0 * error
            rows.append((x[0] + e[0], v + e[1]))
            x = (whole @ [*x, v])[:2]
        omega, v = np.array(rows).T
        signals = {"omega_ref": reference, "omega": omega, "v": v}
        yield wb.Dataset.of(t, signals, {"omega_ref": "rad/s", "omega": "rad/s", "v": "V"})


def computer_loop():
    motor = wb.DCMotor(J=0.012, b=0.1, K=0.5, R=1.2, L=0.4)
    law = wb.PID(motor.outputs, motor.inputs, Kp=0.35, Ki=2.0)
    closed = wb.ClosedLoop(motor, controller=law, reference=wb.Constant("omega", "rad/s", 0.0))
    return closed.digital(0.02, delay=True, inputs=True)


COMPUTER_LOGS = 300
COMPUTER_BAND = binom.ppf([0.0005, 0.9995], COMPUTER_LOGS, 0.95) / COMPUTER_LOGS  # 90.3 % to 98.7 %
COMPUTER_TRUTH = {"plant.J": 0.014, "plant.b": 0.08, "plant.L": 0.5, "controller.Kp[0]": 0.4}


@pytest.mark.release
@pytest.mark.parametrize("kind", ["noise of the log", "noise fed back", "noise fed back, command too"])
def test_intervals_from_a_loop_in_a_computer_hold_the_truth_or_the_fit_says_why_not(kind):
    logs, inside, told = computer_logs(COMPUTER_TRUTH, kind != "noise of the log"), [], []
    system = computer_loop()
    for log in logs:
        seen = log.select(["omega_ref", "omega"]) if kind == "noise fed back" else log
        found = wb.fit(system, seen, list(COMPUTER_TRUTH), hold_out=0.0)
        intervals = found.intervals()
        inside.append([intervals[name][0] <= value <= intervals[name][1] for name, value in COMPUTER_TRUTH.items()])
        told.append(any("residuals of omega" in one.about and not one.is_passed for one in found.residual_tests))
    shares = np.mean(inside, axis=0)
    if kind == "noise of the log":
        assert ((COMPUTER_BAND[0] <= shares) & (shares <= COMPUTER_BAND[1])).all()
    elif kind == "noise fed back":  # whose power the law takes away at the frequencies of the parameters
        assert (shares >= COMPUTER_BAND[0]).all()
    else:
        assert (shares < COMPUTER_BAND[0]).any()
        assert np.mean(told) > 0.99
