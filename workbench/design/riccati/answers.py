"""What comes back: a solution, the gain and poles that it gives, and how far all of it can be trusted."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from workbench.design.certificates import Certificate
from workbench.validation.refusals import Array
from workbench.validation.views import show

Poles = np.ndarray[Any, np.dtype[np.complex128]]


@dataclass(frozen=True)
@show
class Riccati:
    """The stabilising solution X of an algebraic Riccati equation, and its gain.

    Parameters
    ----------
    X
        The solution (n, n), symmetric.
    K
        The gain: (m, n) of a regulator u = -K x, (n, ny) of an estimator x_hat' = A x_hat + K (y - C x_hat).
    poles
        The eigenvalues (n,) of A - B K, or A - K C.
    certificate
        How far X can be trusted.
    """

    X: Array
    K: Array
    poles: Poles
    certificate: Certificate


@dataclass(frozen=True)
@show
class Lyapunov:
    """The solution X (n, n) of a Lyapunov equation, the eigenvalues (n,) of A, and how far X can be trusted."""

    X: Array
    poles: Poles
    certificate: Certificate


@dataclass(frozen=True)
@show
class Lqg:
    """A linear-quadratic-Gaussian controller from y to u.

    Parameters
    ----------
    controller
        The python-control `StateSpace` with the inputs y and the outputs u; its feedback sign is already inside,
        so the loop is closed by u = controller(y) without another minus.
    regulator, estimator
        The two Riccati solutions of which it is made.
    poles
        The eigenvalues (2 n,) of the closed loop, computed from the loop and not from its two halves.
    certificate
        Of the loop: the worse figure of both halves, and how far its poles lie from theirs (`residual`).
    """

    controller: Any
    regulator: Riccati
    estimator: Riccati
    poles: Poles
    certificate: Certificate
