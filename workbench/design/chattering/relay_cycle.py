"""Exact limit cycles of a relay, in continuous time and sampled: what harmonic balance only estimates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import brentq

from workbench.design.certificates import Refused
from workbench.design.chattering.linear_part import ROUNDING, LinearPart, flow
from workbench.validation.refusals import Array, positive, whole
from workbench.validation.signatures import door
from workbench.validation.views import show

HALF_PERIODS, DECADES = 1200, 3  # tried, and how far beyond the slowest and the fastest pole
DENSE = 2001  # instants of a half period at which the sign of s is looked at
MOST_INSTANTS = 1_000_000


@dataclass(frozen=True)
@show
class Cycle:
    """A symmetric limit cycle, s(t + pi / w) = -s(t), of a relay u = -K sign(s).

    Attributes
    ----------
    amplitude, highest
        The peak of |s|, and the highest that it can be: sampled, a linear part with an integrator
        keeps any offset of s that changes none of its signs, and `highest` is that of the farthest one.
    frequency
        w in rad/s.
    contraction
        The spectral radius over half a period: below 1 the cycle attracts, at 1 it keeps an offset.
    samples
        How many instants of the computer make up half a period; None in continuous time.
    residual
        |s| at the switch, over the amplitude; sampled, |x(T/2) + x(0)| over |x(0)|.
    """

    amplitude: float
    highest: float
    frequency: float
    contraction: float
    samples: int | None
    residual: float

    @property
    def stable(self) -> bool:
        """Whether no small departure grows."""
        return self.contraction <= 1 + ROUNDING


@door
def relay_cycles(system: Any, K: float, most: int = 2000) -> tuple[Cycle, ...]:
    """All symmetric limit cycles of u = -K sign(s), s = W u, with two switches a period, slowest first; exact.

    In continuous time half the period T solves the condition of Tsypkin in its form for states,
    c x(T) = 0 with x(0) = K (I + exp(A T))^-1 times the integral of exp(A t) b from 0 to T. Beneath a computer
    T is a whole number of periods, and each number is tried whether the signs of s agree with it.

    Parameters
    ----------
    system
        W: a `LinearPart`, or a python-control system from u to s.
    most
        How many instants half a period may have in a sampled-data loop.

    Raises
    ------
    Refused
        If there is none: in continuous time the relay then slides, or switches ever faster.
    ValueError
        If the system cannot be a `LinearPart`, K is not positive and finite, or `most` no positive whole number.

    References
    ----------
    Tsypkin (1984), Relay Control Systems.
    Astrom (1995), Oscillations in systems with relay feedback, Adaptive Control, Filtering, and Signal
    Processing, IMA Volumes in Mathematics 74.
    """
    whole("relay_cycles(most=...)", most, most=MOST_INSTANTS, of=" of instants")
    K, W = positive("relay_cycles(K=...)", K), LinearPart.of(system)
    found = _sampled(W, K, most) if W.period else _continuous(W, K)
    if not found:
        raise Refused(
            "`relay_cycles(system, K)` needs a half period after which s comes back with its sign changed, and none "
            + (f"of up to {most} instants does" if W.period else "crosses the locus of Tsypkin")
            + "; the relay slides, or its oscillation is not symmetric. Simulate it."
        )
    return tuple(sorted(found, key=lambda cycle: cycle.frequency))


def _continuous(W: LinearPart, K: float) -> list[Cycle]:
    poles = np.abs(W.poles)
    sizes = poles[poles > 1e-9 * poles.max()] if poles.max() > 0 else poles[:0]
    scale = 1 / W.delay if W.delay else 1.0
    low, high = (f([*sizes, scale]) * 10.0**d for f, d in ((min, -DECADES), (max, DECADES)))
    T = np.geomspace(max(1 / high, W.delay * (1 + 1e-9)), 10 / low, HALF_PERIODS)

    def switch(half: float) -> float:
        return float(W.c @ _start(W, K, half)[1])

    s = np.array([switch(half) for half in T])
    roots = [brentq(switch, T[i], T[i + 1], xtol=1e-15 * T[i], rtol=1e-14) for i in np.flatnonzero(s[:-1] * s[1:] < 0)]
    roots += T[s == 0].tolist()
    return [cycle for half in roots if (cycle := _cycle(W, K, float(half))) is not None]


def _start(W: LinearPart, K: float, half: float) -> tuple[Array, Array]:
    """The state at which u becomes -K, and the one at which s is next zero: a dead time before half a period."""
    Phi, Gamma = flow(W.A, W.b, half)
    start = np.asarray(K * np.linalg.solve(np.eye(len(Phi)) + Phi, Gamma), dtype=float)
    Phi, Gamma = flow(W.A, W.b, half - W.delay)
    return start, Phi @ start - K * Gamma


def _cycle(W: LinearPart, K: float, half: float) -> Cycle | None:
    """The cycle of that half period, or None if s has another sign somewhere than the relay has."""
    start, at_zero = _start(W, K, half)
    Phi, Gamma = flow(W.A, W.b, half / (DENSE - 1))
    x, s = start, np.empty(DENSE)
    for i in range(DENSE):
        s[i] = W.c @ x
        x = Phi @ x - K * Gamma
    t, peak = np.linspace(0, half, DENSE), float(np.abs(s).max())
    edge = 2 * half / (DENSE - 1)
    before, after = (t > edge) & (t < half - W.delay - edge), (t > half - W.delay + edge) & (t < half - edge)
    if (s[before] <= 0).any() or (s[after] >= 0).any():
        return None
    residual = abs(float(W.c @ at_zero)) / peak
    whole, _ = flow(W.A, W.b, half)
    until, _ = flow(W.A, W.b, half - W.delay)
    crossing = float(W.c @ (W.A @ at_zero - K * W.b))
    leaving = W.A @ -start - K * W.b  # the rate just before the relay switches, at x = -x(0)
    contraction = float(np.abs(np.linalg.eigvals(whole - np.outer(leaving, W.c @ until) / crossing)).max())
    peak = _peak(s)
    return Cycle(peak, peak, np.pi / half, contraction, None, residual)


def _peak(s: Array) -> float:
    """The largest |s|, by the parabola through it and its neighbours."""
    size = np.abs(s)
    i = int(np.argmax(size[1:-1])) + 1
    left, top, right = size[i - 1 : i + 2]
    bend = left - 2 * top + right
    return float(top - (right - left) ** 2 / (8 * bend)) if bend < 0 else float(size.max())


def _sampled(W: LinearPart, K: float, most: int) -> list[Cycle]:
    found, nx = [], len(W.c)
    Phi, Gamma = np.eye(nx), np.zeros(nx)
    free, forced = np.empty((most, nx)), np.empty(most)  # s of the instants, by the start and by u = 1
    for m in range(1, most + 1):
        free[m - 1], forced[m - 1] = W.c @ Phi, W.c @ Gamma
        Phi, Gamma = Phi @ W.A, W.A @ Gamma + W.b
        try:
            start = K * np.linalg.solve(np.eye(nx) + Phi, Gamma)
        except (
            np.linalg.LinAlgError
        ):  # the linear part keeps up an oscillation of this period, and grows in the relay's
            continue
        s = free[:m] @ start - K * forced[:m]
        if s.min() <= 0:
            continue
        contraction = float(np.abs(np.linalg.eigvals(Phi)).max())
        offset = float(s.min()) if contraction > 1 - ROUNDING else 0.0
        residual = float(np.linalg.norm(Phi @ start - K * Gamma + start) / np.linalg.norm(start))
        found.append(Cycle(s.max(), s.max() + offset, np.pi / (m * W.period), contraction, m, residual))
    return found
