"""A Riccati equation's solution in time, with what it says of itself."""

from __future__ import annotations

from dataclasses import dataclass

from workbench.validation.refusals import Array
from workbench.validation.views import show


@dataclass(frozen=True, eq=False)
@show
class RiccatiFlow:
    """P(t) at the times asked for, symmetric to the last bit, with the gains K = R^-1 B' P of u = -K x.

    Parameters
    ----------
    times
        (N,), in s.
    P
        (N, n, n).
    K
        (N, m, n).
    error
        (N,), an estimate of the relative error of P in the Frobenius norm.
    least
        (N,), the least eigenvalue of P.
    rest
        (N,), the norm of P' over the sum of those of its four terms: zero where P is at rest.
    distance
        (N,), of P from the stabilising solution X of the algebraic equation, over the norm of X; None where the
        coefficients vary or there is no such X.
    """

    times: Array
    P: Array
    K: Array
    error: Array
    least: Array
    rest: Array
    distance: Array | None

    def __str__(self) -> str:
        away = "" if self.distance is None else f", from the algebraic solution {self.distance[-1]:.1e}"
        return (
            f"{len(self.times)} times in [{self.times[0]:g}, {self.times[-1]:g}] s: error {self.error.max():.1e}, "
            f"least eigenvalue {self.least.min():.3g}; at the last time P' {self.rest[-1]:.1e} of its terms{away}"
        )
