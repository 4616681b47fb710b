"""Margins of a feedback loop: gain, phase and delay, loop by loop, and the disk margin of all loops at once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import block_diag, eigvals
from scipy.optimize import brentq, minimize

from workbench.design.linear.feedback_loops import (
    crossings_of,
    largest_gain,
    one_loop,
    pole_frequencies,
    response_at,
    sensitivity,
    square_loop,
)
from workbench.design.matrices import Complex, Refused
from workbench.validation.notebook_display import show
from workbench.validation.refusals import Array
from workbench.validation.signatures import door

if TYPE_CHECKING:
    import control

TURN = 2 * np.pi
PHASES, LOOKED_AT = 16, 100  # phases of a channel and frequencies from which searches begin
MOST_ON_A_GRID = 3  # channels whose phases are searched together
FREQUENCIES = 2000
DECAY = 1e-12  # of the size of A: a pole that decays no faster is on the axis, as far as rounding can tell


@dataclass(frozen=True)
@show
class DiskMargin:
    """The largest complex change of all loop gains at once, each by its own factor, with which the loop stays stable.

    The loop stays stable while each loop is multiplied by its own (2 + d) / (2 - d) with |d| < `alpha`, as far as
    eigenvalues of a Hamiltonian matrix can be trusted. A change of the size `alpha_above` makes it unstable, at
    `frequency` in rad/s.
    """

    alpha: float
    alpha_above: float
    frequency: float

    @property
    def gain(self) -> tuple[float, float]:
        """The factors between which all loop gains may change, each by itself, while phases stay."""
        a = self.alpha
        return ((2 - a) / (2 + a), (2 + a) / (2 - a)) if a < 2 else (0.0, float("inf"))

    @property
    def phase(self) -> float:
        """The degrees by which all phases may change, each by itself, while gains stay."""
        return float(np.degrees(2 * np.arctan(min(self.alpha, 2.0) / 2)))


@door
def disk_margin(loop: control.StateSpace) -> DiskMargin:
    """The disk margin of a loop L: 1 / mu of (S - T) / 2, over complex changes of each channel by itself.

    mu is bounded from above by the H-infinity norm of D (S - T) D^-1 / 2 with the best constant diagonal D, and from
    below by spectral radii at frequencies.

    Raises
    ------
    ValueError
        If `loop` is no square, continuous `StateSpace`, or I + D is singular.
    Refused
        If the closed loop is not asymptotically stable: its slowest pole is named.

    References
    ----------
    Seiler, Packard and Gahinet (2020), IEEE Control Systems Magazine 40(5), "An introduction to disk margins".
    """
    square_loop("disk_margin", loop)
    M = _balanced(loop)
    if loop.ninputs == 1:  # mu is the gain itself
        peak = largest_gain(M)
        return DiskMargin(1 / peak.above, 1 / peak.below, peak.frequency)
    above = _scaled_peak(M)
    below, frequency = _spectral_peak(M)
    return DiskMargin(1 / above, 1 / below, frequency)


@dataclass(frozen=True)
@show
class LoopMargins:
    """The margins of the loop that is broken at input `name` while all others are closed.

    `gain` has the factors (below 1, above 1) at which the closed loop is no longer stable; 0 and infinity if none. The
    phase in degrees that it may lose or gain, and the delay in s that it stands, are infinite without a crossover, the
    frequency of |L| = 1 in rad/s with the least phase margin, which is then NaN.
    """

    name: str
    gain: tuple[float, float]
    phase: float
    delay: float
    crossover: float
    disk: DiskMargin


@door
def loop_margins(loop: control.StateSpace) -> tuple[LoopMargins, ...]:
    """The classical margins of each channel of a loop L, one broken at a time; refusals are those of `disk_margin`.

    Crossings are found by eigenvalues and not on a grid, and located to rounding: |L(i omega)| = 1 by those of a
    Hamiltonian matrix, and a real L(i omega) by the zeros of L(s) - L(-s).
    """
    square_loop("loop_margins", loop)
    return tuple(_margins(one_loop(loop, i), loop.input_labels[i]) for i in range(loop.ninputs))


def _margins(L: control.StateSpace, name: str) -> LoopMargins:
    def values(frequencies: Array) -> Complex:
        return np.asarray(response_at(L, frequencies)[:, 0, 0])

    def excess(frequencies: Array) -> Array:  # of |L| over 1, between -1 and 1
        size = np.abs(values(frequencies))
        return np.asarray((size - 1) / (size + 1))

    disk, feedthrough = disk_margin(L), float(L.D[0, 0])
    crossings = _zeros(excess, _between(L, crossings_of(L, 1.0) if abs(feedthrough) != 1 else np.zeros(0)))
    turned = np.angle(-values(crossings))  # the phase above -180 degrees
    real = _zeros(lambda frequencies: values(frequencies).imag, _between(L, _real_at(L)))
    # a loop that integrates has no finite gain at 0
    still = np.zeros(1 if not len(L.A) or np.linalg.cond(L.A) < 1e12 else 0)
    reals = [feedthrough, *values(np.concatenate([still, real])).real]
    factors = [-1 / float(gain) for gain in reals if gain < 0]
    least = int(np.argmin(np.abs(turned))) if len(turned) else None
    return LoopMargins(
        name,
        (max((f for f in factors if f < 1), default=0.0), min((f for f in factors if f > 1), default=float("inf"))),
        float("inf") if least is None else float(np.degrees(abs(turned[least]))),
        float("inf") if least is None else float(np.min(turned % TURN / crossings)),
        float("nan") if least is None else float(crossings[least]),
        disk,
    )


def _real_at(L: control.StateSpace) -> Array:
    """The frequencies at which L may be real, (N,): the zeros of L(s) - L(-s), perhaps with some others."""
    nx = len(L.A)
    pencil = np.block([[block_diag(L.A, -L.A), np.vstack([L.B, L.B])], [L.C, L.C, np.zeros((1, 1))]])
    with np.errstate(divide="ignore", invalid="ignore"):  # the zeros at infinity
        zeros = eigvals(pencil, block_diag(np.eye(2 * nx), np.zeros((1, 1))))
    return np.unique(np.abs(zeros[np.isfinite(zeros)].imag))


def _between(L: control.StateSpace, candidates: Array) -> Array:
    """Frequencies in rad/s, from far below all poles to far above, with one between any two candidates of a zero."""
    S = sensitivity(L)
    spread = np.concatenate([pole_frequencies(system, FREQUENCIES) for system in (L, S)])
    candidates = np.sort(candidates[(candidates > 0) & (candidates < 1e6 * spread.max())])
    # not just halfway, where an undamped pole may lie
    gaps = 0.47 * candidates[:-1] + 0.53 * candidates[1:]
    ends = np.concatenate([candidates[:1] / 3, 3 * candidates[-1:]])
    return np.unique(np.concatenate([spread, gaps, ends]))


def _zeros(function: Callable[[Array], Array], frequencies: Array) -> Array:
    """The zeros of a function of frequencies, at those given and between those where it changes its sign."""

    def at(omega: float) -> float:
        return float(function(np.array([omega]))[0])

    signs = np.sign(function(frequencies))
    places = np.flatnonzero(signs[:-1] * signs[1:] < 0)
    ends = [(float(frequencies[k]), float(frequencies[k + 1])) for k in places]
    found = [brentq(at, low, high, xtol=1e-13 * low, rtol=1e-13) for low, high in ends]
    return np.sort([*found, *frequencies[signs == 0]])


def _balanced(L: control.StateSpace) -> control.StateSpace:
    """(S - T) / 2 = S - I / 2; refused where the closed loop does not decay."""
    import control

    S = sensitivity(L)
    slowest = max(np.linalg.eigvals(S.A), key=lambda pole: pole.real, default=-1.0)
    if slowest.real >= -DECAY * (1 + np.linalg.norm(S.A)):
        raise Refused(
            f"A loop has a margin only where it is asymptotically stable once closed; here a pole is "
            f"{slowest:.4g} 1/s. Hold states that no command depends on by `freeze`."
        )
    return control.ss(S.A, S.B, S.C, S.D - np.eye(len(S.D)) / 2)


def _scaled_peak(G: control.StateSpace) -> float:
    """The least H-infinity norm of diag(d) G diag(d)^-1 over constant d > 0 that is found: an upper bound of mu."""
    n = len(G.D)
    response = response_at(G, np.concatenate([[0.0], pole_frequencies(G, LOOKED_AT)]))

    def size(logarithms: Array) -> float:
        d = np.exp(np.concatenate([[0.0], logarithms]))
        return float(np.linalg.norm(d[:, np.newaxis] * response / d, 2, axis=(-2, -1)).max())

    best = minimize(size, np.zeros(n - 1), method="Nelder-Mead", options={"xatol": 1e-3, "fatol": 1e-7})
    plain, scaled = (largest_gain(_scaled(G, np.exp(np.concatenate([[0.0], at])))).above for at in (0 * best.x, best.x))
    return min(plain, scaled)


def _scaled(G: control.StateSpace, d: Array) -> control.StateSpace:
    """diag(d) G diag(d)^-1."""
    import control

    return control.ss(G.A, G.B / d, d[:, np.newaxis] * G.C, d[:, np.newaxis] * G.D / d)


def _spectral_peak(G: control.StateSpace) -> tuple[float, float]:
    """The largest spectral radius of G(i omega) U over diagonal unitary U, a lower bound of mu, and its frequency."""
    n = len(G.D)
    frequencies = np.concatenate([[0.0], pole_frequencies(G, LOOKED_AT)])
    response = response_at(G, frequencies)
    steps = np.arange(PHASES if n <= MOST_ON_A_GRID else 1) / PHASES
    turns = np.exp(2j * np.pi * np.stack(np.meshgrid(*[steps] * (n - 1)), -1).reshape(-1, n - 1))
    best = (0.0, 0, np.zeros(n - 1))
    for turn in turns:
        radii = np.abs(np.linalg.eigvals(response * np.concatenate([[1.0], turn]))).max(axis=-1)
        k = int(np.argmax(radii))
        if radii[k] > best[0]:
            best = (float(radii[k]), k, np.angle(turn))

    def small(at: Array) -> float:
        unitary = np.exp(1j * np.concatenate([[0.0], at[1:]]))
        return -float(np.abs(np.linalg.eigvals(response_at(G, np.exp(at[:1]))[0] * unitary)).max())

    start = np.concatenate([[np.log(max(frequencies[best[1]], frequencies[1]))], best[2]])
    end = minimize(small, start, method="Nelder-Mead", options={"xatol": 1e-5, "fatol": 1e-9})
    return max((-float(end.fun), float(np.exp(end.x[0]))), (best[0], float(frequencies[best[1]])))
