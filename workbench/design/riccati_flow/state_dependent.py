"""The state-dependent Riccati equation: the algebraic one at each state of x' = A(x) x + B(x) u."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from workbench.design.matrices import Certificate, answer
from workbench.validation.refusals import Array
from workbench.validation.signatures import door
from workbench.validation.views import show

Factors = Callable[[Array], tuple[Any, Any]]


@dataclass(frozen=True, eq=False)
@show
class StateDependent:
    """P (N, n, n) at states (N, n), with the gains K = R^-1 B' P (N, m, n) of u = -K x and N certificates."""

    states: Array
    P: Array
    K: Array
    certificates: tuple[Certificate, ...]

    @property
    def margin(self) -> float:
        """The least stability margin with the state frozen, in 1/s, which proves nothing for the moving state."""
        return min(certificate.margin for certificate in self.certificates)


@door
def sdre(factors: Factors, states: Array, Q: Any, R: Any) -> StateDependent:
    """The solution of the state-dependent Riccati equation at states x of x' = A(x) x + B(x) u:

        A(x)'P + P A(x) - P B(x) R^-1 B(x)' P + Q = 0.

    u = -R^-1 B(x)' P(x) x stabilises a neighbourhood of x = 0 and is optimal in the limit there. The
    factorisation A(x) is not unique, and another one gives another P.

    Parameters
    ----------
    factors
        From a state (n,) to A (n, n) and B (n, m).
    states
        (N, n), or one state (n,).
    Q, R
        (n, n) and (m, m), as `care` takes them.

    Raises
    ------
    ValueError
        If the states are no such array, or a matrix does not fit.
    Refused
        If there is no stabilising solution at one of the states, which the message names.

    References
    ----------
    Cimen (2008), State-dependent Riccati equation (SDRE) control: a survey, IFAC World Congress.
    """
    from workbench.design.riccati import Riccati, care  # which opens python-control, and that takes seconds

    call = "sdre(factors, states, Q, R)"
    x = np.atleast_2d(states)
    if x.ndim != 2 or x.size == 0 or not np.isfinite(x).all():
        raise ValueError(f"`{call}`: states must be finite numbers (N, n); got shape {x.shape}.")
    answers: list[Riccati] = []
    for i, state in enumerate(x):
        where = f"`{call}`, at state {i}, {state.tolist()}"
        try:
            found = answer(call, "factors", factors, state)
            if not isinstance(found, tuple | list) or len(found) != 2:
                raise ValueError(f"factors must give A and B; got {type(found).__name__}.")
            A, B = found
            answers.append(care(A, B, Q, R))
        except ValueError as error:  # a `Refused` is one, and stays one
            raise type(error)(f"{where}: {error}") from error
        if answers[-1].K.shape != answers[0].K.shape:
            shapes = f"{answers[-1].K.shape} after {answers[0].K.shape}"
            raise ValueError(f"{where}: A and B must have the same shapes at all states; K is {shapes}.")
    P, K = (np.array([getattr(answer, name) for answer in answers]) for name in ("X", "K"))
    return StateDependent(x, P, K, tuple(answer.certificate for answer in answers))
