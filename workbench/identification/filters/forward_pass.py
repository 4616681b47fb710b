"""The pass of a filter forward over the samples, for any model that gives its readings and its moves."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from workbench.core import Layout
from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array
from workbench.identification.filters.array_steps import correction, predict, square_root

Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
@show
class Moves:
    """The moves from each of the N samples to the next, as a smoother needs them.

    `transitions` (N - 1, n, n) are the Jacobians F, and `noises` (N - 1, n, l) the square roots of the added noise. Of
    an unscented filter `spreads` (N - 1, n, m) are the moved sigma points, each over its mean and by the root of its
    weight, and `points` (n, m) those before the move, in units of S. Of a linear filter `readings` (N, q, n) are C.
    """

    transitions: Array
    noises: Array
    spreads: Array | None = None
    points: Array | None = None
    readings: Array | None = None

    def of_roots(self, S: Array) -> tuple[Array, Array]:
        """The spreads (N - 1, n, m) after the moves and before them, of roots S (N - 1, n, n) before them."""
        if self.spreads is None or self.points is None:
            return self.transitions @ S, S
        return self.spreads, S @ self.points


class AbstractPass(ABC):
    """The model of a filter along N samples; a sample k is read at the predicted state, and then the state moves on."""

    states: Layout
    outputs: Layout
    t: Array  # (N,), in s, or the numbers of the samples
    y: Array  # (N, q), NaN where a sensor has no sample

    @abstractmethod
    def read(self, k: int, x: Array, S: Array) -> tuple[Array, Array, Array]:
        """The readings (q,) expected at x, their spread (q, m), and the spread (n, m) of x to which it belongs."""

    @abstractmethod
    def move(self, k: int, x: Array, S: Array) -> tuple[Array, Array, Array]:
        """The next state (n,), the spread (n, m) that S becomes, and the square root (n, l) of the added noise."""

    @abstractmethod
    def moves(self) -> Moves:
        """All moves since the pass began."""

    def run(self, x: Array, S: Array, R: Array) -> PassRecord:
        """The pass from the state x (n,) and root S (n, n) before the first sample, with sensors of covariance R."""
        return forward_pass(self, x, S, R)


@dataclass(frozen=True, eq=False)
class PassRecord:
    """All that a pass computes, sample by sample; NaN from the sample on at which the state left the numbers."""

    x_predicted: Array  # (N, n)
    S_predicted: Array  # (N, n, n)
    x: Array
    S: Array
    innovations: Array  # (N, q)
    normalised_innovations: Array  # (N, q), of the sensors with a sample, one after another
    roots: Array  # (N, q, q), upper triangular, of the covariances of these innovations

    @staticmethod
    def empty(N: int, n: int, q: int) -> PassRecord:
        """A record of which nothing is known."""
        shapes = ((N, n), (N, n, n), (N, n), (N, n, n), (N, q), (N, q), (N, q, q))
        return PassRecord(*(np.full(shape, np.nan) for shape in shapes))


@dataclass(frozen=True, eq=False)
class SensorNoise:
    """Square roots of the covariances of the sensors that have a sample, each computed once."""

    R: Array
    _roots: dict[bytes, Array] = field(default_factory=dict)

    def root(self, mask: Mask) -> Array:
        """The root (s, s) of the rows and columns of the s sensors of a mask (q,)."""
        key = mask.tobytes()
        if key not in self._roots:
            self._roots[key] = square_root(self.R[np.ix_(mask, mask)])
        return self._roots[key]


def forward_pass(model: AbstractPass, x: Array, S: Array, R: Array) -> PassRecord:
    """Correct and move from sample to sample, beginning with the state x (n,) and root S (n, n) before the first."""
    N, q, n = len(model.y), model.outputs.size, model.states.size
    record = PassRecord.empty(N, n, q)
    seen, noise = np.isfinite(model.y), SensorNoise(R)
    counts = seen.sum(axis=1).tolist()
    for k in range(N):
        record.x_predicted[k], record.S_predicted[k] = x, S
        if counts[k]:
            x, S = _correct_at(record, model, k, x, S, None if counts[k] == q else seen[k], noise.root(seen[k]))
        record.x[k], record.S[k] = x, S
        if k + 1 < N:
            x, spread, added = model.move(k, x, S)
            S = predict(spread, added)
            if not np.isfinite(S[0, 0]):  # R of a matrix with a number that is none has none but such
                break
    return record


def _correct_at(
    record: PassRecord, model: AbstractPass, k: int, x: Array, S: Array, mask: Mask | None, noise: Array
) -> tuple[Array, Array]:
    expected, readings, roots = model.read(k, x, S)
    innovation = model.y[k] - expected
    record.innovations[k] = innovation
    if mask is not None:
        innovation, readings = innovation[mask], readings[mask]
    answer, s = correction(roots, readings, noise), len(innovation)
    whitened = answer.whiten(innovation)
    record.normalised_innovations[k, :s], record.roots[k, :s, :s] = whitened, answer.root
    return x + whitened.dot(answer.gains), answer.S
