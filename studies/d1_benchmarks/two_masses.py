"""The two masses on a spring of Wie and Bernstein (1992), under controllers that others published for them.

A force on the first mass is the control, the position of the second one is measured, and u = -K y. Under K = N / D the
loop has the characteristic polynomial

    m1 m2 s^4 D + k ((m1 + m2) s^2 D + N),

so the stable range of k / (m1 m2) is the range of the gain of ((m1 + m2) s^2 D + N) / (s^4 D), a loop of one channel.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

import workbench as wb
from studies.d1_benchmarks.linear_systems import (
    System,
    coefficients,
    impulse_response,
    realization,
    state_space,
    transfer_function,
)

Polynomials = tuple[Sequence[float], Sequence[float]]
Pair = tuple[float, float]
SOFT, STIFF = 0.5, 2.0  # N/m, the range of the spring that a loop must bear
# QFT Toolbox, example 5, qftex5.m (Chait 1993 and 2003): 0.032 (10 s + 1) / (4 s^2 + 2 s + 1)
QFT: Polynomials = ((0.32, 0.032), (4.0, 2.0, 1.0))
# Stengel and Marrison (1992), design A, quoted from memory
STENGEL: Polynomials = (
    tuple(40.42 * np.polymul([1.0, 2.388], [1.0, 0.350])),
    tuple(np.polymul([1.0, 163.77], [1.0, 2 * 0.501 * 0.924, 0.924**2])),
)
LEFT, RIGHT = -100.0, -0.35  # 1/s: where the circle of the poles of Chiang and Safonov's design 1 meets the axis
ROBUSTNESS, EFFORT = 0.75, 0.02  # N/m on either side of 1.25, and the weight of u
STEPS, UNTIL = 12001, 60.0  # of an impulse response: every 5 ms
MASSES = (0.5, 1.5)  # kg, both masses of Stengel and Marrison
CELLS, KNOTS = 200, 129  # of each mass, and of the sum of both


def spring_loop(controller: Polynomials, total: float = 2.0, scale: float = 1.0) -> System:
    """The loop whose gain is k / (m1 m2) in units of `scale`, for masses that are `total` together."""
    num, den = controller
    top = np.polyadd(total * np.polymul([1.0, 0.0, 0.0], den), num)
    return realization(transfer_function(tuple(scale * top), tuple(np.polymul([1.0, 0.0, 0.0, 0.0, 0.0], den))))


def spring_range(controller: Polynomials) -> tuple[Pair, Pair]:
    """The softest and the stiffest spring with which masses of 1 kg are stable, each between its bounds."""
    margins = wb.stability_margins(spring_loop(controller))
    if not margins.stable:
        return (np.nan, np.nan), (np.nan, np.nan)
    return (margins.gain_low.low, margins.gain_low.high), (margins.gain_high.low, margins.gain_high.high)


def peak_over_springs(controller: Polynomials) -> Pair:
    """The largest peak of T over the springs: attained at an end of the range, and proved by a real perturbation."""
    ends = (wb.stability_margins(loop_gain(controller, k)).Mt.gain.low for k in (SOFT, STIFF))
    lower = max(ends)
    upper = 1.01 * lower
    real, full = wb.structured_uncertainty.RealScalar(1), wb.structured_uncertainty.FullBlock(1)
    mu = wb.structured_uncertainty.robustness_over_frequency(tracking_loop(controller, upper), [real, full])
    return lower, upper if mu.upper <= 1 else np.inf


def loop_gain(controller: Polynomials, k: float) -> System:
    """L = P K for masses of 1 kg."""
    num, den = controller
    return realization(transfer_function(tuple(k * np.array(num)), tuple(np.polymul([1.0, 0.0, 2 * k, 0.0, 0.0], den))))


def tracking_loop(controller: Polynomials, level: float) -> System:
    """From a change of the spring and a reference to the stretch and x2 / level, for k = 1.25 + 0.75 delta."""
    Ak, Bk, Ck, Dk = matrices(realization(transfer_function(*controller)))
    middle, half = (SOFT + STIFF) / 2, (STIFF - SOFT) / 2
    A, force, stretch, place = masses(middle)
    states = np.block([[A - force @ Dk @ place, force @ Ck], [-Bk @ place, Ak]])
    into = np.block([[-force + np.eye(4)[:, [3]], force @ Dk], [np.zeros((len(Ak), 1)), Bk]])
    rest = np.zeros((1, len(Ak)))
    out = np.block([[half * stretch, rest], [place / level, rest]])
    return state_space(states, into, out, np.zeros((2, 2)))


def masses(k: float) -> tuple[wb.Array, wb.Array, wb.Array, wb.Array]:
    """A, the column of the force, and the rows of the stretch x1 - x2 and of x2, for masses of 1 kg."""
    A = np.zeros((4, 4))
    A[:2, 2:], A[2:, :2] = np.eye(2), [[-k, k], [k, -k]]
    return A, np.eye(4)[:, [2]], np.array([[1.0, -1.0, 0.0, 0.0]]), np.eye(4)[[1]]


def matrices(system: System) -> tuple[wb.Array, wb.Array, wb.Array, wb.Array]:
    """A, B, C and D of a system."""
    return np.asarray(system.A), np.asarray(system.B), np.asarray(system.C), np.asarray(system.D)


def substitute(system: System, a: float, b: float, g: float, d: float) -> System:
    """The system with s = (a z + b) / (g z + d), as a system in z."""
    A, B, C, D = matrices(system)
    M = np.linalg.inv(a * np.eye(len(A)) - g * A)
    return state_space((d * A - b * np.eye(len(A))) @ M, (a * d - b * g) * M @ B, C @ M, D + g * C @ M @ B)


def chiang_safonov() -> Polynomials:
    """Design 1 of Chiang and Safonov: an H-infinity controller of level 1 whose loop has its poles in a circle."""
    A, force, stretch, place = masses((SOFT + STIFF) / 2)
    B = np.hstack([-force + np.eye(4)[:, [3]], force])
    C = np.vstack([ROBUSTNESS * stretch, np.zeros((1, 4)), place])
    D = np.array([[0.0, 0.0], [0.0, EFFORT], [0.0, 0.0]])
    moved = substitute(state_space(A, B, C, D), 1.0, RIGHT, 1 / LEFT, 1.0)
    found = wb.hinf_controller(wb.synthesis.GeneralizedPlant.of(moved, 1, 1), gamma=1.0)
    num, den = coefficients(substitute(found.controller, 1.0, -RIGHT, -1 / LEFT, 1.0))
    return tuple(-np.array(num)), den  # u = K y there, and u = -K y here


def settling_times(controller: Polynomials) -> Pair:
    """When x2 stays within 5 % and 2 % of its peak after an impulse on the second mass, in s, for masses of 1 kg."""
    num, den = controller
    whole = np.polyadd(np.polymul([1.0, 0.0, 2.0, 0.0, 0.0], den), num)
    system = transfer_function(tuple(np.polymul(den, [1.0, 0.0, 1.0])), tuple(whole))
    t, y = impulse_response(system, UNTIL, STEPS)
    size = np.abs(y)
    late = [float(t[np.flatnonzero(size > part * size.max())[-1]]) for part in (0.05, 0.02)]
    return late[0], late[1]


def instability(controller: Polynomials) -> Pair:
    """The probability that a loop is unstable where k, m1 and m2 are uniform in their ranges.

    For each sum of the masses the loop must be stable at the largest k / (m1 m2), and a certified margin is its
    threshold. Its bounds lie on either side by what half as many cells and sums change.
    """
    sums = np.linspace(2 * MASSES[0], 2 * MASSES[1], KNOTS)
    largest = STIFF / MASSES[0] ** 2
    softest = []
    for total in sums:
        margins = wb.stability_margins(spring_loop(controller, total, scale=largest))
        if not margins.stable:
            return np.nan, np.nan
        softest.append(largest * margins.gain_low.value)
    fine = share_below(sums, np.array(softest), CELLS)
    coarse = share_below(sums[::2], np.array(softest)[::2], CELLS // 2)
    return fine - abs(fine - coarse), fine + abs(fine - coarse)


def share_below(sums: wb.Array, softest: wb.Array, cells: int) -> float:
    """The share of the box in which k / (m1 m2) is below what the sum of the masses needs."""
    m = MASSES[0] + (MASSES[1] - MASSES[0]) * (np.arange(cells) + 0.5) / cells
    needed = np.multiply.outer(m, m) * np.interp(np.add.outer(m, m), sums, softest)
    return float(np.clip((needed - SOFT) / (STIFF - SOFT), 0.0, 1.0).mean())


def two_mass_figure(name: str) -> Pair:
    """A figure of the two masses between its bounds, by the last words of its key."""
    match name:
        case "qft peak":
            return peak_over_springs(QFT)
        case "qft softest":
            return spring_range(QFT)[0]
        case "hinf softest":
            return spring_range(chiang_safonov())[0]
        case "hinf stiffest":
            return spring_range(chiang_safonov())[1]
        case "hinf settling":
            return settling_times(chiang_safonov())
        case _:
            return instability(STENGEL)
