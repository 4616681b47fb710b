"""How long a step may be: the stability limit from the exact Jacobian along a run."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from workbench.core.layout import Array
from workbench.simulate.trajectories import Trajectories


@dataclass(frozen=True)
class StepLimit:
    """The longest step that keeps every decaying mode of a run decaying.

    Attributes
    ----------
    h, limit
        The step that was taken and the longest that is stable, in s.
    at, eigenvalue
        When the limit is reached, in s, and the mode that sets it, in 1/s.
    checked
        At how many states of the run the eigenvalues were taken; with none there is no limit but NaN.
    """

    h: float
    limit: float
    at: float
    eigenvalue: complex
    checked: int

    @property
    def holds(self) -> bool:
        """Whether the step is within the limit."""
        return self.h <= self.limit


def step_limit(trajectories: Trajectories, run: int = 0, points: int = 400) -> StepLimit:
    """The stability limit of the step along one run, from frozen-time eigenvalues at up to `points` states.

    A mode lambda with Re lambda < 0 is kept decaying while |R(h lambda)| <= 1, where R is the
    method's amplification. Modes that grow by themselves set no limit. The states are those that
    were kept, so a stiff instant between two of them can be missed: `checked` says how many there were.

    A state whose Jacobian is not finite, as the last ones of a run that diverges, is not counted. If
    none is left the limit, its time and its mode are NaN, and it does not hold.
    """
    step, flow = trajectories.step, trajectories.step.flow
    good = np.flatnonzero(np.isfinite(trajectories.x[run]).all(axis=1))
    picked = good[np.unique(np.linspace(0, len(good) - 1, min(points, len(good))).astype(int))]
    nx = flow.states.size
    A = np.array(
        flow.A.map(len(picked))(
            trajectories.t[picked][np.newaxis],
            trajectories.x[run, picked, :nx].T,
            np.repeat(trajectories.p[run][:, np.newaxis], len(picked), axis=1),
        )
    )
    A = A.reshape(nx, len(picked), nx).transpose(1, 0, 2)
    finite = np.isfinite(A).all(axis=(1, 2))
    picked, modes = picked[finite], np.linalg.eigvals(A[finite])
    finite = np.isfinite(modes).all(axis=1)  # an eigenvalue of a huge matrix may overflow by itself
    picked, modes = picked[finite], modes[finite]
    if modes.size == 0:
        return StepLimit(step.h, np.nan, np.nan, complex(np.nan, np.nan), 0)
    limits = longest_steps(modes, step.amplification)
    where = np.unravel_index(np.argmin(limits), limits.shape)
    return StepLimit(
        step.h,
        float(limits[where]),
        float(trajectories.t[picked[where[0]]]),
        complex(modes[where]),
        len(picked),
    )


def longest_steps(modes: Array, amplification: tuple[float, ...]) -> Array:
    """For each mode the longest step h with |R(h lambda)| <= 1; infinite where the mode does not decay."""
    size = np.abs(modes)
    decays = (modes.real < 0) & (size > 0)
    angles, reach = _region(amplification)
    radius = np.interp(np.abs(np.where(decays, np.angle(modes), np.pi)), angles, reach)
    return np.where(decays, radius / np.where(decays, size, 1.0), np.inf)


@lru_cache
def _region(amplification: tuple[float, ...]) -> tuple[Array, Array]:
    """How far the stability region reaches along rays: the first r > 0 with |R(r e^(i angle))| > 1."""
    angles, r = np.linspace(np.pi / 2, np.pi, 721), np.linspace(1e-3, 5.0, 5000)
    z = r * np.exp(1j * angles[:, np.newaxis])
    grows = np.abs(np.polyval(amplification, z)) > 1 + 1e-9
    return angles, np.where(grows.any(axis=1), r[np.argmax(grows, axis=1)], r[-1])
