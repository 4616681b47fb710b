"""Smoothers: the states by samples that come later, over the same moves as those of the filter."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from workbench.core import Layout
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.identification.datasets import Dataset, Experiment
from workbench.identification.filters.array_steps import BackwardSteps, backward_steps, definiteness, triangle
from workbench.identification.filters.forward_pass import Moves

DEVIATION = "_deviation"  # behind the name of a state


@dataclass(frozen=True, eq=False, repr=False)
@check_arguments
class SmoothedEstimate:
    """The states that a smoother has estimated, at the N samples of a filter.

    Parameters
    ----------
    t
        (N,), the times of the samples.
    states
        Names, shapes and units of the states.
    x, S
        (N, n) and (N, n, n), the state and the square root of its covariance, P = S S'.
    lag
        The number of later samples that each state knows; None if it knows all.

    Examples
    --------
    >>> level = wb.filters.kalman_filter([1.0, 1.2, 0.9], [[1]], [[1]], [[0.01]], [[0.04]], x0=[0], P0=[[1]])
    >>> smooth = level.smooth()
    >>> smooth
    <SmoothedEstimate of x: 3 samples, by all samples>
    """

    t: Array
    states: Layout
    x: Array
    S: Array
    lag: int | None = None

    def __post_init__(self) -> None:
        N, n = self.t.size, self.states.size
        for name, shape in {"t": (N,), "x": (N, n), "S": (N, n, n)}.items():
            refuse_shape("SmoothedEstimate", name, getattr(self, name), shape)

    @property
    def P(self) -> Array:
        """(N, n, n), the covariance of each state."""
        return self.S @ np.swapaxes(self.S, 1, 2)

    @property
    def deviations(self) -> Array:
        """(N, n), the standard deviation of each state."""
        return np.asarray(np.linalg.norm(self.S, axis=2))

    @property
    def least_correlation(self) -> float:
        """The least eigenvalue of all covariances, each with variances scaled to 1; it is never negative."""
        return definiteness(self.S)

    @check_arguments
    def to_dataset(self, name: str = "smoothed") -> Dataset:
        """A `Dataset` of the states, and of their standard deviations as `NAME_deviation`."""
        return dataset_of(name, self.t, self.states, self.x, self.deviations)

    def __repr__(self) -> str:
        by = "all samples" if self.lag is None else f"samples up to {self.lag} later"
        return f"<SmoothedEstimate of {', '.join(self.states.names)}: {len(self.t)} samples, by {by}>"


def refuse_shape(call: str, name: str, value: Array, shape: tuple[int, ...]) -> None:
    """Refuse an array of another shape."""
    if value.shape != shape:
        raise ValueError(f"`{call}({name}=...)` must have shape {shape}; got {value.shape}.")


def dataset_of(name: str, t: Array, states: Layout, x: Array, deviations: Array) -> Dataset:
    """States and standard deviations as a dataset of one experiment."""
    entries = tuple(replace(entry, name=f"{entry.name}{DEVIATION}") for entry in states.entries)
    experiment = Experiment(name, t, states + Layout(entries), np.hstack([x, deviations]))
    return Dataset((experiment,), "a Kalman filter")


def steps_back(S: Array, moves: Moves) -> BackwardSteps:
    """The steps backward from each sample to the one before, for roots S (N, n, n) after the samples."""
    spreads, roots = moves.of_roots(S[:-1])
    return backward_steps(spreads, moves.noises, roots)


def smooth_over_all(t: Array, states: Layout, x: Array, S: Array, x_predicted: Array, moves: Moves) -> SmoothedEstimate:
    """The Rauch-Tung-Striebel smoother, P_k = S_k S_k' + G P_(k+1) G', a sum of squares."""
    back, n = steps_back(S, moves), states.size
    x_smooth, roots = x.copy(), S.copy()
    rows = np.empty((2 * n, n), order="F")
    state, root = x[-1], S[-1]
    for k in range(len(x) - 2, -1, -1):
        G = back.G[k]
        state = x[k] + G.dot(state - x_predicted[k + 1])
        rows[:n], rows[n:] = root.T.dot(G.T), back.S[k].T
        root = triangle(rows).T
        x_smooth[k], roots[k] = state, root
    return SmoothedEstimate(t, states, x_smooth, roots)


def smooth_by_lag(
    t: Array, states: Layout, x: Array, S: Array, x_predicted: Array, moves: Moves, lag: int
) -> SmoothedEstimate:
    """The fixed-lag smoother: of each sample by those up to `lag` later, all samples in one sweep for each lag."""
    back, N = steps_back(S, moves), len(x)
    ends = np.minimum(np.arange(N) + lag, N - 1)
    state, root = x[ends].copy(), S[ends].copy()
    for step in range(lag):
        places = np.flatnonzero(ends - np.arange(N) > step)
        k = ends[places] - step - 1  # from sample k + 1 back to sample k
        G = back.G[k]
        state[places] = x[k] + np.einsum("kij,kj->ki", G, state[places] - x_predicted[k + 1])
        rows = np.concatenate([np.swapaxes(G @ root[places], 1, 2), np.swapaxes(back.S[k], 1, 2)], axis=1)
        root[places] = np.swapaxes(np.linalg.qr(rows, mode="r"), 1, 2)
    return SmoothedEstimate(t, states, state, root, lag)
