"""Logs of linear systems in open and in closed loop, and their prediction errors by code that shares none of ours."""

from __future__ import annotations

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import lfilter

import workbench as wb

PERIOD = 0.1
ARMAX = {"a": [-1.5, 0.7], "b": [1.0, 0.5], "c": [-0.9, 0.3]}
BOX_JENKINS = {"f": [-0.85], "b": [0.5], "c": [0.6], "d": [-0.9]}
LOOPS = {"ARMAX": (ARMAX, 0.25, 1.0, 0.6), "Box-Jenkins": (BOX_JENKINS, 0.8, 0.4, 0.7)}


def log_of(u, y, name="log"):
    """A dataset of an input u and an output y."""
    return wb.Dataset.of(PERIOD * np.arange(len(y)), {"u": u, "y": y}, {"u": "V", "y": "rad"}, name=name)


def closed_loop(system, count, seed, gain, noise, amplitude):
    """u, y of u_k = r_k - gain y_k, r random binary, at rest before the first sample; polynomials as in `system`."""
    rng = np.random.default_rng(seed)
    e, r = noise * rng.standard_normal(count), amplitude * rng.choice([-1.0, 1.0], count)
    a, b, c, d, f = (np.concatenate([[1.0] * (name != "b"), system.get(name, [])]) for name in "abcdf")
    den, v = np.convolve(a, f), lfilter(np.convolve(c, f), np.convolve(d, [1.0]), e)
    u, y = np.zeros(count), np.zeros(count)
    # A F y = B u + F C/D e
    for k in range(count):
        past = sum(den[i] * y[k - i] for i in range(1, min(k, len(den) - 1) + 1))
        y[k] = -past + sum(b[i - 1] * u[k - i] for i in range(1, min(k, len(b)) + 1)) + v[k]
        u[k] = r[k] - gain * y[k]
    return u, y


def structure_of(system):
    """The structure with the orders of a system."""
    orders = {name: len(system.get(name, [])) for name in "abcdf"}
    return wb.linear_models.PolynomialStructure(
        orders["a"], (orders["b"],), orders["c"], orders["d"], (orders["f"],), (1,)
    )


def reference_errors(structure, theta, u, y):
    """The prediction errors at rest, also of complex parameters."""
    n = np.cumsum([structure.na, structure.nb[0], structure.nc, structure.nd])
    a, b, c, d, f = np.split(np.asarray(theta), n)
    one = np.ones(1)
    monic = [np.concatenate([one, part]) for part in (a, c, d, f)]
    w = lfilter(np.concatenate([[0.0], b]), monic[3], u.astype(complex))
    return lfilter(monic[2], monic[1], lfilter(monic[0], [1.0], y.astype(complex)) - w)


def reference_minimum(structure, starts, u, y):
    """The deepest stable minimum from some starts, by complex steps and MINPACK: parameters, squares and spread."""

    def errors(theta):
        with np.errstate(all="ignore"):
            e = reference_errors(structure, theta, u, y).real
        return np.clip(np.nan_to_num(e, nan=1e6, posinf=1e6, neginf=-1e6), -1e6, 1e6)

    def slopes(theta):
        with np.errstate(all="ignore"):
            turned = [reference_errors(structure, theta + 1e-30j * step, u, y).imag for step in np.eye(len(theta))]
        return np.nan_to_num(np.array(turned).T / 1e-30, nan=0.0, posinf=0.0, neginf=0.0)

    best = None
    for start in starts:
        end = least_squares(errors, start, slopes, method="lm", xtol=1e-13, ftol=1e-13, max_nfev=300)
        stable = structure.polynomials(end.x).radius() < 1
        if stable and (best is None or end.cost < best.cost):
            best = end
    if best is None:
        return None
    squares, J = 2 * best.cost, slopes(best.x)
    spread = squares / (len(y) - len(best.x)) * np.linalg.inv(J.T @ J)
    return best.x, squares, np.sqrt(np.diag(spread))


def random_polynomial(order, rng, low, high):
    """The numbers of a monic polynomial behind its first, with roots at random sizes from `low` to `high`."""
    polynomial, left = np.ones(1), order
    while left:
        size = rng.uniform(low, high)
        if left >= 2 and rng.random() < 0.6:
            polynomial = np.convolve(polynomial, [1.0, -2 * size * np.cos(rng.uniform(0.05, 2.5)), size**2])
            left -= 2
        else:
            polynomial = np.convolve(polynomial, [1.0, -size * rng.choice([1.0, 1.0, -1.0])])
            left -= 1
    return polynomial[1:]


def random_loop(rng):
    """A stable loop about a random ARMAX or Box-Jenkins system of orders 1 to 3, and its gain."""
    while True:
        arma, n = rng.random() < 0.5, int(rng.integers(1, 4))
        numerator = rng.normal(size=rng.integers(1, n + 1))
        numerator /= np.abs(numerator).max()
        den = random_polynomial(n, rng, 0.4, 1.02 if arma else 0.95)
        gain = rng.uniform(0.1, 1) * rng.choice([-1, 1]) / (1 + np.abs(numerator).sum())
        closed = np.concatenate([[1.0], den + gain * np.pad(numerator, (0, n - len(numerator)))])
        if np.abs(np.roots(closed)).max() > 0.97:
            continue
        c = random_polynomial(int(rng.integers(1, 4)), rng, 0.3, 0.95)
        if arma:
            return {"a": den, "b": numerator, "c": c}, gain
        return {"f": den, "b": numerator, "c": c, "d": random_polynomial(int(rng.integers(1, 4)), rng, 0.3, 0.95)}, gain


def loop(kind, count, seed):
    """A system of `LOOPS` with the input and the output of its loop."""
    system, gain, noise, amplitude = LOOPS[kind]
    return system, *closed_loop(system, count, seed, gain, noise, amplitude)


def theta_of(system):
    """The parameters of a system in the order of its structure."""
    return np.concatenate([np.asarray(system.get(name, []), dtype=float) for name in "abcdf"])
