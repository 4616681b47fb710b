"""Subspace identification: states from the past that predict the future, then matrices by regression."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from workbench.core.validation.refusals import Array, one_of, whole
from workbench.core.validation.signatures import check_arguments
from workbench.design.matrices import DesignError
from workbench.design.riccati import dare
from workbench.identification.datasets import Dataset
from workbench.identification.linear_models.polynomial_estimates import Names
from workbench.identification.linear_models.signal_records import LinearSignals, checked_offsets, signals_of
from workbench.identification.linear_models.subspace_model import Matrices, SubspaceModel, fits_of_states

WEIGHTINGS = ("SSARX", "CVA", "MOESP", "N4SID")
RANK = 1e-10  # relative: a smaller eigenvalue of a covariance counts as zero
EXACT = 1e-9  # relative: smaller prediction errors are rounding, and tell no K
SMALLEST = 1e-9  # of the largest singular value: a smaller one is of no state
INTEGRATES = 1e8  # a condition number of I - A beyond it: there is no rest to which a constant would lead
FLOOR = 1e-12  # of the variance of an output: prediction errors below it count as equal
MOST = 12  # the highest order that is tried, if none is named
USUAL = 15  # rows of past and future


@check_arguments
def subspace_model(
    data: Dataset,
    inputs: Names,
    outputs: Names,
    order: int | None = None,
    *,
    weighting: str = "SSARX",
    horizon: int | None = None,
    feedthrough: bool = False,
    holdout: Dataset | None = None,
    offsets: str = "estimate",
) -> SubspaceModel:
    """A state space of several inputs and outputs, without a search: states are what the past tells of the future.

    "N4SID", "MOESP" and "CVA" are the weights W1 O W2 of the matrix O, whose row space holds the states. They project
    future inputs out, which must not depend on the noise, as those of a closed loop do. "SSARX" takes their effect out
    by a long ARX model, and holds there too. A, B, Cy, D and K follow from the states by least squares.

    Parameters
    ----------
    data, holdout
        Datasets at one constant period, without missing or marked samples; the summary says if there is no hold-out.
    inputs, outputs
        The names of the inputs and of the outputs.
    order
        The number of states, by default that with the least BIC of the prediction errors.
    weighting, horizon
        One of the above, and the rows of past and future, by default 15, or less for a short log.
    feedthrough
        True to estimate D, which else is zero.
    offsets
        As of `polynomial_model`.

    Raises
    ------
    ValueError
        If samples are missing, there are too few for this horizon, or the order exceeds it.
    LookupError
        If there is no such signal.

    References
    ----------
    Van Overschee and De Moor (1996), Subspace Identification for Linear Systems, theorem 12; Jansson (2003), IFAC
    Proceedings 36.

    Examples
    --------
    >>> u, x = np.random.default_rng(1).standard_normal(600), np.zeros(601)
    >>> for k in range(600):
    ...     x[k + 1] = 0.8 * x[k] + 0.5 * u[k]
    >>> log = wb.Dataset.of(0.1 * np.arange(600), {"u": u, "y": x[:600]}, {"u": "V", "y": "rad"})
    >>> model = wb.linear_models.subspace_model(log, "u", "y", order=1)
    >>> np.round(model.A, 6)
    array([[0.8]])
    """
    rule = one_of("subspace_model(weighting=...)", weighting, WEIGHTINGS)
    signals = signals_of("subspace_model(data)", data, inputs, outputs)
    model = _estimate(signals, rule, checked_offsets("subspace_model", offsets), feedthrough, horizon, order)
    return _with_remarks(model if holdout is None else replace(model, holdout=model.compare(holdout)), order)


def _estimate(
    signals: LinearSignals, rule: str, offsets: str, feedthrough: bool, horizon: int | None, order: int | None
) -> SubspaceModel:
    """The model of the order with the least criterion, or of a named one, as far as the data have the rank."""
    rows, highest = _sizes(signals, horizon, order)
    u0, y0 = signals.offsets(offsets)
    past = _Past.of(signals, u0, y0, rows, offsets == "estimate")
    J, values = past.states(rule)
    usable = int(min(highest, max(1, np.sum(values > SMALLEST * values[0]))))
    candidates = [past.regress(J[:n], feedthrough) for n in range(1, usable + 1)]
    spreads = [covariance for _, covariance in candidates]
    criteria = np.array([past.criterion(spread, n, feedthrough) for n, spread in enumerate(spreads, 1)])
    chosen = int(np.argmin(criteria)) if order is None else min(order, usable) - 1
    (model, rest), covariance = candidates[chosen]
    model, covariance = _with_stable_predictor(model, covariance)
    point = u0, y0 + rest
    fits = fits_of_states(model, signals, *point)
    ports = signals.period, signals.inputs, signals.outputs
    return SubspaceModel(rule, *model, covariance, *ports, *point, signals.samples, values, criteria, fits)


def _with_stable_predictor(model: Matrices, covariance: Array) -> tuple[Matrices, Array]:
    """The model with the K of the stable predictor of the same noise spectrum, by a Riccati equation if K is not it."""
    A, B, Cy, D, K = model
    if np.abs(np.linalg.eigvals(A - K @ Cy)).max(initial=0.0) < 1:
        return model, covariance
    try:
        answer = dare(A.T, Cy.T, K @ covariance @ K.T, covariance, K @ covariance)
    except DesignError:  # there is none; the summary says that the predictor is not stable
        return model, covariance
    return (A, B, Cy, D, np.asarray(answer.K, dtype=float).T), covariance + Cy @ np.asarray(answer.X) @ Cy.T


def _sizes(signals: LinearSignals, horizon: int | None, order: int | None) -> tuple[int, int]:
    """The rows of past and future, and the highest order that is tried."""
    ny = signals.outputs.size
    ports = signals.inputs.size + ny
    room = min(map(len, signals.y)) // (2 * ports + 2)
    rows = min(USUAL, room // 2) if horizon is None else whole("subspace_model(horizon=...)", horizon, 2)
    if rows < 2 or 2 * rows * (ports + 1) > signals.samples - 2 * rows * len(signals.y):
        raise ValueError(
            f"`subspace_model(data)` has {signals.samples} samples, too few for past and future of {max(rows, 2)} of "
            f"{ports} signals: log for longer, or take a smaller horizon."
        )
    highest = min(MOST, rows * ny - 1) if order is None else whole("subspace_model(order=...)", order)
    if highest > rows * ny:
        raise ValueError(
            f"`subspace_model(order=...)` must be at most {rows * ny}, the horizon times the outputs; got {highest}."
        )
    return rows, highest


def _with_remarks(model: SubspaceModel, order: int | None) -> SubspaceModel:
    remarks = []
    if order is not None and model.order < order:
        remarks.append(f"The data have rank {model.order}; the order {order} that was asked for is more.")
    largest = float(np.abs(np.linalg.eigvals(model.A)).max(initial=0.0))
    if largest > 1:
        remarks.append(f"The model is unstable, with a pole of size {largest:.4g}.")
    if model.predictor_radius >= 1:
        remarks.append("The predictor is not stable: log for longer, or take another horizon.")
    return replace(model, remarks=tuple(remarks))


@dataclass(frozen=True, eq=False)
class _Past:
    """Samples with their past: y and u, the past (N, p (nu + ny)), the past one later, and the future of each."""

    y: Array
    u: Array
    past: Array
    later: Array
    Y: Array
    U: Array
    Z: Array
    rows: int
    constant: bool

    @staticmethod
    def of(signals: LinearSignals, u0: Array, y0: Array, rows: int, constant: bool) -> _Past:
        """The columns of all experiments in a row."""
        parts = []
        for u, y in zip(signals.u, signals.y, strict=True):
            z = np.hstack([y - y0, u - u0])
            at = np.arange(rows, len(z) - rows)
            past = z[at[:, np.newaxis] - np.arange(1, rows + 1)].reshape(len(at), -1)
            later = z[at[:, np.newaxis] - np.arange(rows)].reshape(len(at), -1)
            ahead = z[at[:, np.newaxis] + np.arange(rows)]
            ny = y.shape[1]
            parts.append((z[at, :ny], z[at, ny:], past, later, ahead[..., :ny], ahead[..., ny:], ahead))
        y, u, past, later, Y, U, Z = (np.concatenate(column) for column in zip(*parts, strict=True))
        return _Past(y, u, past, later, Y, U, Z, rows, constant)

    def states(self, weighting: str) -> tuple[Array, Array]:
        """The rows J of x = J past in the order of their weight, and the singular values."""
        N = len(self.y)
        P = self._moved(self.past)
        if weighting == "SSARX":
            F = self._moved(self._future_of_past())
            left, right = _inverse_root(F.T @ F / N), _inverse_root(P.T @ P / N)
            _, s, V = np.linalg.svd(left @ (F.T @ P / N) @ right)
            return V @ right, s
        Y, U = self._moved(self.Y.reshape(N, -1)), self._moved(self.U.reshape(N, -1))
        Q = np.linalg.qr(U)[0]
        Yp, Pp = Y - Q @ (Q.T @ Y), P - Q @ (Q.T @ P)  # both less what the future inputs explain
        whole_past = np.linalg.lstsq(Pp, Yp, rcond=RANK)[0].T  # O = whole_past P, oblique along the future inputs
        left = _inverse_root(Yp.T @ Yp / N) if weighting == "CVA" else np.eye(Y.shape[1])
        base = Pp if weighting != "N4SID" else P
        R = np.linalg.qr(base)[1] / np.sqrt(N)
        W, s, _ = np.linalg.svd(left @ whole_past @ R.T, full_matrices=False)
        seen = s > RANK * s[0]
        return (W[:, seen].T @ left @ whole_past) / np.sqrt(s[seen])[:, np.newaxis], s

    def _future_of_past(self) -> Array:
        """The future outputs less what the future's own inputs and outputs add, by a long ARX model (N, rows ny)."""
        ny = self.y.shape[1]
        regressor = np.hstack([self._moved(self.past), self._moved(self.u)])
        solution = np.linalg.lstsq(regressor, self._moved(self.y), rcond=RANK)[0].T
        size = ny + self.u.shape[1]
        Phi = solution[:, : self.past.shape[1]].reshape(ny, self.rows, size)
        future = self.Y - np.einsum("nfu,yu->nfy", self.U, solution[:, self.past.shape[1] :])
        for i in range(1, self.rows):
            for j in range(1, i + 1):
                future[:, i] -= self.Z[:, i - j] @ Phi[:, j - 1].T
        return np.asarray(future.reshape(len(self.y), -1))

    def _moved(self, columns: Array) -> Array:
        """The columns (N, n) less their means, if constants are estimated."""
        return columns - columns.mean(axis=0) if self.constant else columns

    def regress(self, J: Array, feedthrough: bool) -> tuple[tuple[Matrices, Array], Array]:
        """A, B, Cy, D and K for the states J past, the output at rest, and the covariance of the prediction errors."""
        n, nu, ny = len(J), self.u.shape[1], self.y.shape[1]
        x, later = self.past @ J.T, self.later @ J.T
        columns = np.hstack([x, self.u]) if feedthrough else x
        solution = np.linalg.lstsq(self._moved(columns), self._moved(self.y), rcond=RANK)[0].T
        Cy, D = solution[:, :n], solution[:, n:] if feedthrough else np.zeros((ny, nu))
        e = self._moved(self.y - columns @ solution.T)
        noise = e if np.linalg.norm(e) > EXACT * np.linalg.norm(self.y) else e[:, :0]
        steps = np.hstack([x, self.u, noise])
        flow = np.linalg.lstsq(self._moved(steps), self._moved(later), rcond=RANK)[0].T
        A, B, K = flow[:, :n], flow[:, n : n + nu], flow[:, n + nu :] if noise.size else np.zeros((n, ny))
        rest = np.zeros(ny)
        if self.constant and np.linalg.cond(np.eye(n) - A) < INTEGRATES:
            drift = np.linalg.solve(np.eye(n) - A, (later - steps @ flow.T).mean(axis=0))
            rest = Cy @ drift + (self.y - columns @ solution.T).mean(axis=0)
        A, B, Cy, D, K = (part.astype(np.float64) for part in (A, B, Cy, D, K))
        return ((A, B, Cy, D, K), rest), np.atleast_2d(e.T @ e) / len(e)

    def criterion(self, covariance: Array, n: int, feedthrough: bool) -> float:
        """BIC: N ln det of the covariance and ln N for each number of a model of n states."""
        N, ny, nu = len(self.y), self.y.shape[1], self.u.shape[1]
        floor = np.diag(np.maximum(self.y.var(axis=0), 1e-300)) * FLOOR
        count = n * (2 * ny + nu) + ny * nu * feedthrough
        return float(N * np.linalg.slogdet(covariance + floor)[1] + count * np.log(N))


def _inverse_root(covariance: Array) -> Array:
    """The inverse of the square root of a covariance, on its range."""
    values, vectors = np.linalg.eigh(covariance)
    seen = values > RANK * values[-1]
    return np.asarray((vectors[:, seen] / np.sqrt(values[seen])) @ vectors[:, seen].T)
