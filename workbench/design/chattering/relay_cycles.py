"""The exact limit cycles of a sampled relay, and the oscillation in the record of a run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array, positive, whole
from workbench.core.validation.signatures import check_arguments
from workbench.design.chattering.linear_part import ROUNDING, LinearPart
from workbench.design.control_system import System
from workbench.design.matrices import DesignError

MOST_INSTANTS = 1_000_000
FEWEST = 5  # periods from which a frequency is taken


@dataclass(frozen=True)
@show
class Cycle:
    """A symmetric limit cycle, s(t + pi / w) = -s(t), of a relay u = -K sign(s), its frequency w in rad/s.

    `amplitude` is the peak of |s|. If W has an integrator, the cycle may have an offset; `highest` is the peak of |s|
    at the largest offset that changes no sign of s. `contraction` is the spectral radius over half a period: below 1
    the cycle attracts, at 1 an offset stays. Half of the period T has `samples` sampling periods; `residual` is |x(T/2)
    + x(0)| over |x(0)|.
    """

    amplitude: float
    highest: float
    frequency: float
    contraction: float
    samples: int
    residual: float

    @property
    def stable(self) -> bool:
        """True if no small deviation from the cycle grows."""
        return self.contraction <= 1 + ROUNDING


@check_arguments
def relay_cycles(system: System, K: float, most: int = 2000) -> tuple[Cycle, ...]:
    """All symmetric limit cycles of u = -K sign(s), s = W u, with two switches a period, slowest first; exact.

    `system` is W, a sampled `LinearPart` or a discrete python-control system from u to s. Half a period of the cycle is
    a whole number of sampling periods; every number up to `most` is tried.

    Raises
    ------
    DesignError
        If there is none.
    ValueError
        If the system cannot be a sampled `LinearPart`, or K or `most` is not positive and finite.

    References
    ----------
    Tsypkin (1984), Relay Control Systems. Astrom (1995), Oscillations in systems with relay feedback, IMA Volumes in
    Mathematics 74.

    Examples
    --------
    >>> from workbench.design.chattering import LinearPart, relay_cycles
    >>> relay_cycles(LinearPart([[1.0]], [0.01], [1.0], 0.01), 5.0, 40)[0]
    Cycle(amplitude=0.025, highest=0.05, frequency=314.159, contraction=1, samples=1, residual=0)
    """
    whole("relay_cycles(most=...)", most, most=MOST_INSTANTS, of=" of instants")
    K, W = positive("relay_cycles(K=...)", K), LinearPart.of(system)
    if not W.period:
        raise ValueError("`relay_cycles(system=...)` must be sampled, as by `c2d(system, period)`; it is not.")
    found, nx = [], len(W.c)
    Phi, Gamma = np.eye(nx), np.zeros(nx)
    free, forced = np.empty((most, nx)), np.empty(most)  # s of the instants, by the start and by u = 1
    for m in range(1, most + 1):
        free[m - 1], forced[m - 1] = W.c @ Phi, W.c @ Gamma
        Phi, Gamma = Phi @ W.A, W.A @ Gamma + W.b
        try:
            start = K * np.linalg.solve(np.eye(nx) + Phi, Gamma)
        except np.linalg.LinAlgError:  # W itself oscillates with this period, and grows in the relay's
            continue
        s = free[:m] @ start - K * forced[:m]
        if s.min() <= 0:
            continue
        contraction = float(np.abs(np.linalg.eigvals(Phi)).max())
        offset = float(s.min()) if contraction > 1 - ROUNDING else 0.0
        residual = float(np.linalg.norm(Phi @ start - K * Gamma + start) / np.linalg.norm(start))
        found.append(Cycle(s.max(), s.max() + offset, np.pi / (m * W.period), contraction, m, residual))
    if not found:
        raise DesignError(
            "`relay_cycles(system, K)` needs a half period after which s comes back with its sign changed, and none of "
            f"up to {most} instants does; the relay slides, or its oscillation is not symmetric. Simulate it."
        )
    return tuple(sorted(found, key=lambda cycle: cycle.frequency))


@dataclass(frozen=True)
@show
class RecordedOscillation:
    """The oscillation in a record of s: its offset, amplitude, frequency in rad/s, and the scatter of its periods.

    `scatter` is the standard deviation of the periods over their mean. `scatter` and `frequency` are None if there are
    fewer than five periods.
    """

    amplitude: float
    offset: float
    frequency: float | None
    scatter: float | None


@check_arguments
def record_oscillation(t: Array, s: Array) -> RecordedOscillation:
    """The oscillation in a record s (N,) at times t (N,) in s; the record must begin after the transient.

    Raises
    ------
    DesignError
        If s is not finite: a run that diverged has no amplitude.
    ValueError
        If t and s are not two vectors of one length, or t does not rise.

    Examples
    --------
    >>> from workbench.design.chattering import record_oscillation
    >>> t = np.linspace(0.0, 9.0, 400)
    >>> record_oscillation(t, np.sin(7.0 * t)).frequency > 6.9
    True
    """
    if t.ndim != 1 or t.shape != s.shape or len(t) < 2 or not (np.isfinite(t).all() and (np.diff(t) > 0).all()):
        raise ValueError(
            f"`record_oscillation(t, s)` must be two vectors of one length, t rising and finite; got shapes "
            f"{t.shape} and {s.shape}."
        )
    if not np.isfinite(s).all():
        raise DesignError("`record_oscillation(t, s)` must be finite, and this record is not; the run was lost.")
    low, high = float(s.min()), float(s.max())
    offset = (low + high) / 2
    d = s - offset
    i = np.flatnonzero((d[:-1] < 0) & (d[1:] >= 0))
    passages = t[i] - d[i] * (t[i + 1] - t[i]) / (d[i + 1] - d[i])
    if len(passages) <= FEWEST:
        return RecordedOscillation((high - low) / 2, offset, None, None)
    periods = np.diff(passages)
    mean = float(periods.mean())
    return RecordedOscillation((high - low) / 2, offset, 2 * np.pi / mean, float(periods.std() / mean))
