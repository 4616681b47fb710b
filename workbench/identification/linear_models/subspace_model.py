"""A state space estimated from subspaces: x+ = A x + B u + K e, y = Cy x + D u + e, with its misfits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.core import Layout
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.design.control_system import System
from workbench.identification.datasets import Dataset
from workbench.identification.linear_models.polynomial_model import ModelFit
from workbench.identification.linear_models.signal_records import LinearSignals, signals_of

Matrices = tuple[Array, Array, Array, Array, Array]


@dataclass(frozen=True, eq=False)
class SubspaceModel:
    """An estimate of x+ = A x + B (u - u0) + K e, y = y0 + Cy x + D (u - u0) + e, cov e = `covariance` (ny, ny).

    `singular_values` are those from which the order was read, `criteria` has BIC of the orders from 1 on. `fits` has a
    `ModelFit` for each output, and `holdout` those of other data, empty if there are none. It has no standard errors;
    estimate the polynomials of this order by prediction errors for them.
    """

    weighting: str
    A: Array
    B: Array
    Cy: Array
    D: Array
    K: Array
    covariance: Array
    period: float
    inputs: Layout
    outputs: Layout
    u0: Array
    y0: Array
    samples: int
    singular_values: Array
    criteria: Array
    fits: tuple[ModelFit, ...]
    holdout: tuple[ModelFit, ...] = ()
    remarks: tuple[str, ...] = ()

    @property
    def order(self) -> int:
        """The number of states."""
        return len(self.A)

    @property
    def predictor_radius(self) -> float:
        """The largest absolute pole of the predictor, of A - K Cy, which is stable below 1."""
        return float(np.abs(np.linalg.eigvals(self.A - self.K @ self.Cy)).max(initial=0.0))

    def to_ss(self) -> System:
        """The system from the inputs to the outputs as a `StateSpace` in discrete time, about u0 and y0."""
        from workbench.design.linear import sampled_model

        name = f"{self.weighting} model of order {self.order}"
        matrices = self.A, self.B, self.Cy, self.D
        return sampled_model(*matrices, self.period, self.inputs, self.outputs, self.u0, self.y0, name)

    def to_continuous(self) -> System:
        """The system in continuous time behind a zero-order hold.

        Raises
        ------
        DesignError
            If there is none, as `d2c` says.
        """
        from workbench.design.frequency import d2c

        return d2c(self.to_ss())

    @check_arguments
    def compare(self, data: Dataset) -> tuple[ModelFit, ...]:
        """The misfit of predictions and simulations of each output of a dataset.

        Raises
        ------
        ValueError, LookupError
            As of the estimate, or if the period of the data is another one.
        """
        signals = signals_of("compare(data)", data, self.inputs.labels, self.outputs.labels)
        if abs(signals.period / self.period - 1) > 1e-6:
            raise ValueError(
                f"`compare(data)` needs data at the period of the model, {self.period:g} s; got {signals.period:g} s: "
                "resample them."
            )
        return fits_of_states((self.A, self.B, self.Cy, self.D, self.K), signals, self.u0, self.y0)

    @property
    def summary(self) -> str:
        """A summary in words, the doubts first."""
        quality = ", ".join(f"{fit.simulation:.1f} %" for fit in self.holdout)
        held = f"hold-out {quality} simulated" if self.holdout else "no hold-out"
        return " ".join([*self.remarks, f"{self.weighting} of order {self.order} from {self.samples} samples, {held}."])

    def __repr__(self) -> str:
        ways = f"{', '.join(self.inputs.labels)} to {', '.join(self.outputs.labels)}"
        return f"<{self.weighting} model of order {self.order} from {ways} at {self.period:g} s>"


def fits_of_states(model: Matrices, signals: LinearSignals, u0: Array, y0: Array) -> tuple[ModelFit, ...]:
    """Prediction and simulation of each output, from the initial states that fit best."""
    A, B, Cy, D, K = model
    predictor = A - K @ Cy, np.hstack([B - K @ D, K]), Cy
    errors: tuple[list[Array], list[Array]] = ([], [])
    moved = []
    for u, y in zip(signals.u, signals.y, strict=True):
        du, dy = u - u0, y - y0
        errors[0].append(_misfit(*predictor, np.hstack([du, dy]), dy - du @ D.T))
        errors[1].append(_misfit(A, B, Cy, du, dy - du @ D.T))
        moved.append(dy)
    sizes = np.linalg.norm(np.vstack(moved) - np.vstack(moved).mean(axis=0), axis=0)
    with np.errstate(over="ignore"):
        lengths = [np.linalg.norm(np.vstack(part), axis=0) for part in errors]
    count = np.sqrt(signals.samples)
    return tuple(
        ModelFit(float(p / count), float(100 * (1 - p / size)), float(s / count), float(100 * (1 - s / size)))
        for p, s, size in zip(*lengths, sizes, strict=True)
    )


def _misfit(A: Array, B: Array, Cy: Array, inputs: Array, wanted: Array) -> Array:
    """wanted (N, ny) less the outputs of x+ = A x + B u from the best initial state; infinite if these grow too far."""
    n, N = len(A), len(wanted)
    x, powers = np.zeros(n), np.eye(n)
    forced, free = np.empty((N, len(Cy))), np.empty((N, len(Cy), n))
    with np.errstate(all="ignore"):
        driven = inputs @ B.T
        for k in range(N):
            forced[k], free[k] = Cy @ x, Cy @ powers
            x, powers = A @ x + driven[k], A @ powers
    columns, target = free.reshape(-1, n), (wanted - forced).ravel()
    if not np.isfinite(columns).all() or not np.isfinite(target).all():
        return np.full(wanted.shape, np.inf)
    x0 = np.linalg.lstsq(columns, target, rcond=1e-12)[0]
    return np.asarray((target - columns @ x0).reshape(wanted.shape))
