"""Records with missing outputs: innovations of a Kalman filter for tests, and the information that the outputs hold."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from workbench.core.validation.refusals import Array
from workbench.identification.datasets.experiment import Marks
from workbench.identification.linear_models.prediction_errors import Errors, Predictor


def innovations(predictor: Predictor, theta: Array, errors: Errors) -> list[Array]:
    """The innovations (N,) of each record over the standard deviations that white noise of variance 1 gives them.

    NaN where an output is missing. The noise of the outputs, C/(A D) e, starts at rest: initial values are taken off.
    """
    model = predictor.structure.polynomials(theta)
    below = np.convolve(model.A, model.D)
    e = np.split(errors.e / errors.scale, np.cumsum([len(record.y) for record in predictor.records])[:-1])
    found = []
    for record, part in zip(predictor.records, e, strict=True):
        noise = np.asarray(lfilter(model.C, below, part))
        counts: Marks = np.ones(len(part), dtype=bool) if record.counts is None else record.counts
        found.append(_filtered(noise, counts, model.C, below))
    return found


def _filtered(noise: Array, counts: Marks, above: Array, below: Array) -> Array:
    """The normalised innovations of a filter for above / below e in companion form, e with variance 1."""
    n = max(len(above), len(below)) - 1
    c, a = (np.concatenate([part, np.zeros(n + 1 - len(part))]) for part in (above, below))
    F = np.eye(n, k=1)
    F[:, 0] -= a[1:]
    gain = c[1:] - a[1:]  # of e on the next state; the output is the first state plus e
    x, P, found = np.zeros(n), np.zeros((n, n)), np.full(len(noise), np.nan)
    for k, (y, there) in enumerate(zip(noise, counts, strict=True)):
        if there:
            S = P[0, 0] + 1.0
            found[k] = (y - x[0]) / np.sqrt(S)
            K = (F @ P[:, 0] + gain) / S
            x = F @ x + K * (y - x[0])
            P = F @ P @ F.T + np.outer(gain, gain) - np.outer(K, K) * S
        else:
            x, P = F @ x, F @ P @ F.T + np.outer(gain, gain)
    return found


def information(predictor: Predictor, theta: Array, steps: Array, free: Array) -> Array:
    """The second derivative (k, k) of minus the log-likelihood along `free` (size, k), by differences of its gradient.

    `steps` (k,) are those along the directions.
    """

    def gradient(at: Array) -> Array:
        errors = predictor.errors(at)
        return np.asarray(predictor.samples * (free.T @ (errors.J.T @ errors.e)) / float(errors.e @ errors.e))

    columns = [
        (gradient(theta + step * way) - gradient(theta - step * way)) / (2 * step)
        for step, way in zip(steps, free.T, strict=True)
    ]
    whole = np.column_stack(columns)
    return np.asarray((whole + whole.T) / 2)
