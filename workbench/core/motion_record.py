"""A motion on record, states with their rates and inputs at both ends of each interval, and gains over time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.core.layout import Layout
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments


@dataclass(frozen=True, eq=False)
@check_arguments
class MotionRecord:
    """States and inputs over time, piece by piece: between N + 1 instants cubic states and linear inputs.

    `wb.plan(...).motion` is one; `wb.PlannedReference` and `wb.TrajectoryFeedback` take it.

    Parameters
    ----------
    t
        (N + 1,), the instants in s, in increasing order from 0 on.
    states, inputs
        The layouts of x and u.
    x_begins, x_ends, rate_begins, rate_ends
        (N, nx), the states and their rates at the begin and at the end of each interval.
    u_begins, u_ends
        (N, nu), the inputs there, which may jump from one interval to the next.

    Raises
    ------
    ValueError
        If the instants do not increase from 0, or a shape does not fit.
    """

    t: Array
    states: Layout
    inputs: Layout
    x_begins: Array
    x_ends: Array
    rate_begins: Array
    rate_ends: Array
    u_begins: Array
    u_ends: Array

    def __post_init__(self) -> None:
        if self.t.ndim != 1 or self.t.size < 2 or self.t[0] != 0 or not (np.diff(self.t) > 0).all():
            raise ValueError(
                "`MotionRecord(t=...)` must be two or more instants in increasing order, the first at 0 s."
            )
        sizes = {"x_begins": self.states, "x_ends": self.states, "rate_begins": self.states, "rate_ends": self.states}
        for name, layout in {**sizes, "u_begins": self.inputs, "u_ends": self.inputs}.items():
            shape, want = getattr(self, name).shape, (self.t.size - 1, layout.size)
            if shape != want:
                raise ValueError(f"`MotionRecord({name}=...)` must have shape {want}; got {shape}.")

    @property
    def pieces(self) -> Array:
        """(N, 1 + 4 (nx + nu)): of each interval its begin and the coefficients of 1, s, s^2 and s^3 after it.

        The states are cubic Hermite polynomials, the inputs straight lines.
        """
        h = np.diff(self.t)[:, np.newaxis]
        rise = (self.x_ends - self.x_begins) / h
        square = (3 * rise - 2 * self.rate_begins - self.rate_ends) / h
        cube = (self.rate_begins + self.rate_ends - 2 * rise) / h**2
        none = np.zeros_like(self.u_begins)
        constant = np.hstack([self.x_begins, self.u_begins])
        linear = np.hstack([self.rate_begins, (self.u_ends - self.u_begins) / h])
        parts = [constant, linear, np.hstack([square, none]), np.hstack([cube, none])]
        return np.hstack([self.t[:-1, np.newaxis], *parts])


@dataclass(frozen=True, eq=False)
@check_arguments
class GainRecord:
    """Gains of a state feedback over time, linear between their times and constant behind the last one.

    Parameters
    ----------
    t
        (m,), two or more times in s, in increasing order from 0 on.
    K
        (m, nu, nx), the gains.

    Raises
    ------
    ValueError
        If the times do not increase from 0, or a number is not finite.

    Examples
    --------
    >>> wb.core.GainRecord(t=[0.0, 1.0], K=[[[0.2, 0.1]], [[0.0, 0.0]]]).K.shape
    (2, 1, 2)
    """

    t: Array
    K: Array

    def __post_init__(self) -> None:
        if self.t.ndim != 1 or self.t.size < 2 or self.t[0] != 0 or not (np.diff(self.t) > 0).all():
            raise ValueError("`GainRecord(t=...)` must be two or more times in increasing order, the first at 0 s.")
        if self.K.ndim != 3 or len(self.K) != self.t.size or not np.isfinite(self.K).all():
            raise ValueError(
                f"`GainRecord(K=...)` must be finite gains ({self.t.size}, nu, nx), a matrix for each time; got shape "
                f"{self.K.shape}."
            )

    @property
    def pieces(self) -> Array:
        """(m, 1 + 4 nu nx): the time of each row and the coefficients of 1, s, s^2 and s^3 after it, row by row."""
        rows = self.K.reshape(len(self.t), -1)
        slopes = np.vstack([np.diff(rows, axis=0) / np.diff(self.t)[:, np.newaxis], np.zeros((1, rows.shape[1]))])
        none = np.zeros_like(rows)
        return np.hstack([self.t[:, np.newaxis], rows, slopes, none, none])
