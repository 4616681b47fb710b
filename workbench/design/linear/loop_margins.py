"""Margins of a feedback loop: gain, phase and delay, loop by loop, and the disk margin of all loops at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.design.frequency.margin_records import Crossover, StableMargins
from workbench.design.frequency.stability_margins import stability_margins
from workbench.design.linear.feedback_loops import (
    largest_gain,
    one_loop,
    pole_frequencies,
    response_at,
    sensitivity,
    square_loop,
)
from workbench.design.matrices import DesignError

if TYPE_CHECKING:
    import control

PHASES, LOOKED_AT = 16, 100  # phases of a channel and frequencies from which searches begin
MOST_ON_A_GRID = 3  # channels whose phases are searched together
DECAY = 1e-12  # of the size of A: a pole that decays no faster is on the axis, as far as rounding can tell


@dataclass(frozen=True)
@show
class DiskMargin:
    """The largest complex change of all loop gains at once, each by its own factor, with which the loop stays stable.

    The closed loop stays stable while each loop gain is multiplied by a factor (2 + d) / (2 - d) with |d| < `alpha`,
    where d may differ from loop to loop. This holds as far as eigenvalues of a Hamiltonian matrix can be trusted. A
    change of the size `alpha_above` makes the closed loop unstable, at `frequency` in rad/s.
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


@check_arguments
def disk_margin(loop: control.StateSpace) -> DiskMargin:
    """The disk margin of a loop L: 1 / mu of (S - T) / 2, over complex changes of each channel by itself.

    mu is bounded from above by the H-infinity norm of D (S - T) D^-1 / 2 with the best constant diagonal D, and from
    below by spectral radii at frequencies.

    Raises
    ------
    ValueError
        If `loop` is not a square, continuous `StateSpace`, or I + D is singular.
    DesignError
        If the closed loop is not asymptotically stable: its slowest pole is named.

    References
    ----------
    Seiler, Packard and Gahinet (2020), IEEE Control Systems Magazine 40(5), "An introduction to disk margins".
    """
    square_loop("disk_margin", loop)
    if loop.ninputs == 1:  # mu is the gain itself
        return _disk(_one_channel(loop)[0])
    M = _balanced_sensitivity(loop)
    above = _scaled_peak(M)
    below, frequency = _spectral_peak(M)
    return DiskMargin(1 / above, 1 / below, frequency)


@dataclass(frozen=True)
@show
class LoopMargins:
    """The margins of the loop that is broken at input `name` while all others are closed.

    `gain` has the factors (below 1, above 1) at which the closed loop is no longer stable; 0 and infinity if none.
    `crossover` is the frequency in rad/s with |L| = 1 and the least phase margin. The loop may lose or gain `phase`
    degrees, and stands a `delay` in s. Without a crossover, `crossover` is NaN, and phase and delay are infinite.
    """

    name: str
    gain: tuple[float, float]
    phase: float
    delay: float
    crossover: float
    disk: DiskMargin


@check_arguments
def loop_margins(loop: control.StateSpace) -> tuple[LoopMargins, ...]:
    """The classical margins of each channel of a loop L, one broken at a time; refusals are those of `disk_margin`.

    All numbers come from `stability_margins`.
    """
    square_loop("loop_margins", loop)
    return tuple(_margins(one_loop(loop, i), loop.input_labels[i]) for i in range(loop.ninputs))


def _margins(L: control.StateSpace, name: str) -> LoopMargins:
    margins, crossovers = _one_channel(L)
    nearest = min(crossovers, key=lambda crossover: abs(crossover.margin.value), default=None)
    return LoopMargins(
        name,
        (margins.gain_low.value, margins.gain_high.value),
        margins.phase_margin.value,
        margins.delay_margin.value,
        float("nan") if nearest is None else nearest.frequency.value,
        _disk(margins),
    )


def _one_channel(L: control.StateSpace) -> tuple[StableMargins, tuple[Crossover, ...]]:
    """The margins of a loop with one channel, and its gain crossovers."""
    _balanced_sensitivity(L)
    found = stability_margins(L)
    if found.margins is None:
        raise DesignError(
            "A loop has a margin only where it is asymptotically stable once closed; here a pole is on the axis, but "
            "for rounding. Hold states that no command depends on by `freeze`."
        )
    return found.margins, found.gain_crossovers


def _disk(margins: StableMargins) -> DiskMargin:
    return DiskMargin(margins.disk_margin.low, margins.disk_margin.high, margins.disk_frequency)


def _balanced_sensitivity(L: control.StateSpace) -> control.StateSpace:
    """(S - T) / 2 = S - I / 2; refused where the closed loop does not decay."""
    import control

    S = sensitivity(L)
    slowest = max(np.linalg.eigvals(S.A), key=lambda pole: pole.real, default=-1.0)
    if slowest.real >= -DECAY * (1 + np.linalg.norm(S.A)):
        raise DesignError(
            f"A loop has a margin only where it is asymptotically stable once closed; here a pole is "
            f"{slowest:.4g} 1/s. Hold states that no command depends on by `freeze`."
        )
    return control.ss(S.A, S.B, S.C, S.D - np.eye(len(S.D)) / 2)


def _scaled_peak(G: control.StateSpace) -> float:
    """The least H-infinity norm of diag(d) G diag(d)^-1 over constant d > 0 that is found: an upper bound of mu."""
    from scipy.optimize import minimize  # here, as it takes long to import

    n = len(G.D)
    response = response_at(G, np.concatenate([[0.0], pole_frequencies(G, LOOKED_AT)]))

    def size(logarithms: Array) -> float:
        d = np.exp(np.concatenate([[0.0], logarithms]))
        return float(np.linalg.norm(d[:, np.newaxis] * response / d, 2, axis=(-2, -1)).max())

    best = minimize(size, np.zeros(n - 1), method="Nelder-Mead", options={"xatol": 1e-3, "fatol": 1e-7})
    plain, scaled = (largest_gain(_scale(G, np.exp(np.concatenate([[0.0], at])))).above for at in (0 * best.x, best.x))
    return min(plain, scaled)


def _scale(G: control.StateSpace, d: Array) -> control.StateSpace:
    """diag(d) G diag(d)^-1."""
    import control

    return control.ss(G.A, G.B / d, d[:, np.newaxis] * G.C, d[:, np.newaxis] * G.D / d)


def _spectral_peak(G: control.StateSpace) -> tuple[float, float]:
    """The largest spectral radius of G(i omega) U over diagonal unitary U, a lower bound of mu, and its frequency."""
    from scipy.optimize import minimize  # here, as it takes long to import

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
