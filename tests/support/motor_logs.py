"""Logs of a motor under a voltage in random steps, simulated by SciPy."""

from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp

import workbench as wb

MOTOR = wb.open_loop(wb.DCMotor())
TRUE = dict(zip(MOTOR.parameters.labels, MOTOR.parameters.default.tolist(), strict=True))
UNITS = {"v": "V", "omega": "rad/s", "i": "A"}
FREE = ("J", "b", "R", "L")
START = {"J": 1.5 * TRUE["J"], "b": 0.5 * TRUE["b"], "R": 1.5 * TRUE["R"], "L": 0.7 * TRUE["L"]}


def steps(count, seed, t_end=4.0):
    """Times and a voltage in random steps."""
    t = np.linspace(0.0, t_end, count)
    levels = 12 * np.random.default_rng(seed).choice([-1.0, 1.0], 20)
    return t, levels[np.minimum((t / t_end * 20).astype(int), 19)]


def motion(t, v, x0=(0.0, 0.0), delay=0.0, **values):
    """Speed and current of the motor under a held voltage that acts `delay` later, by SciPy, piece by piece."""
    p = np.array([{**TRUE, **values}[label] for label in MOTOR.parameters.labels])
    edges = np.unique(np.concatenate([t, (t + delay)[t + delay < t[-1]]]))
    x, rows = np.array(x0), [np.array(x0)]
    for a, b in pairwise(edges):
        p[-1] = v[max(int(np.searchsorted(t + delay, (a + b) / 2, side="right")) - 1, 0)]
        # its equation is linear in x, so its matrix exponential would do, but another program is the judge here
        x = solve_ivp(lambda s, x: MOTOR.rate_at(s, x, p), (a, b), x, method="DOP853", rtol=1e-10, atol=1e-12).y[:, -1]
        rows.append(x)
    return np.array(rows)[np.searchsorted(edges, t)]


def log(t, v, x, noise=0.0, seed=1):
    e = noise * np.random.default_rng(seed).standard_normal(x.shape)
    return wb.Dataset.of(t, {"v": v, "omega": x[:, 0] + e[:, 0], "i": x[:, 1] + e[:, 1]}, UNITS)


T, V = steps(161, 0)
X = motion(T, V)
