"""Truncation and residualisation of a balanced realisation: what is left out adds at most twice its Hankel values."""

from __future__ import annotations

import numpy as np

from workbench.core.validation.signatures import check_arguments
from workbench.design.control_system import System
from workbench.design.reduction.balanced_realization import BalancedRealization
from workbench.design.reduction.reduced_model import Matrices, ReducedModel, reduced_model


@check_arguments
def balanced_truncation(system: System, order: int | None = None, tolerance: float | None = None) -> ReducedModel:
    """The model of the first states of the balanced realisation; it has the same D, the gain at high frequencies.

    Modes that no input drives or no output shows are always left out. The bound of the error is twice the sum of the
    Hankel values that are left out.

    Parameters
    ----------
    system
        A stable `StateSpace`, continuous or discrete, with at most 60 states.
    order
        The number of states of the model, from 0 to that of the system.
    tolerance
        In place of the order, the largest H-infinity norm of the error, absolute, in the unit of the outputs over that
        of the inputs. The least order whose proved error is not larger is taken.

    Raises
    ------
    ValueError
        If the system is not a `StateSpace`, or not exactly one of order and tolerance is given, in its range.
    DesignError
        If the system is not stable or too large, or the order separates equal Hankel values.

    References
    ----------
    Pernebo and Silverman (1982), Model reduction via balanced state space representations, IEEE Trans. Autom. Control
    27. Enns (1984), Proc. 23rd CDC, and Glover (1984), International Journal of Control 39 (bound). Hinrichsen and
    Pritchard (1990), An improved error estimate for reduced-order models of discrete-time systems, IEEE Trans. Autom.
    Control 35 (bound in discrete time).

    Examples
    --------
    >>> import control
    >>> lags = control.ss(control.tf([1.0], [1.0, 4.0, 6.0, 4.0, 1.0]))
    >>> answer = wb.reduction.balanced_truncation(lags, 2)
    >>> round(answer.error.gain.value, 4), round(answer.bound, 4)
    (0.0718, 0.0804)
    """
    return reduced_model("balanced_truncation", "balanced truncation", system, order, tolerance, _truncate)


@check_arguments
def singular_perturbation(system: System, order: int | None = None, tolerance: float | None = None) -> ReducedModel:
    """The model of the balanced realisation with its last states at rest; it has the same static gain.

    Arguments, bound and refusals are those of `balanced_truncation`.

    References
    ----------
    Liu and Anderson (1989), Singular perturbation approximation of balanced systems, International Journal of Control
    50.

    Examples
    --------
    >>> import control
    >>> lags = control.ss(control.tf([1.0], [1.0, 4.0, 6.0, 4.0, 1.0]))
    >>> answer = wb.reduction.singular_perturbation(lags, tolerance=0.1)
    >>> answer.order, f"{answer.system(0).real:.9f}"
    (2, '1.000000000')
    """
    return reduced_model("singular_perturbation", "singular perturbation", system, order, tolerance, _residualise)


def _truncate(realization: BalancedRealization, order: int) -> tuple[Matrices, float]:
    k, b = order, realization
    return (b.A[:k, :k], b.B[:k], b.C[:, :k], b.D), twice_sum(realization, order)


def _residualise(realization: BalancedRealization, order: int) -> tuple[Matrices, float]:
    k, b = order, realization
    # the last states where they rest: 0 = A21 x1 + A22 x2 + B2 u, or x2 = ... in discrete time
    at_rest = b.A[k:, k:] - (np.eye(len(b.A) - k) if b.discrete else 0)
    solved = np.linalg.solve(at_rest, np.hstack([b.A[k:, :k], b.B[k:]]))
    states, inputs = solved[:, :k], solved[:, k:]
    A, B = b.A[:k, :k] - b.A[:k, k:] @ states, b.B[:k] - b.A[:k, k:] @ inputs
    C, D = b.C[:, :k] - b.C[:, k:] @ states, b.D - b.C[:, k:] @ inputs
    return (A, B, C, D), twice_sum(realization, order)


def twice_sum(realization: BalancedRealization, order: int) -> float:
    """Twice the sum of the Hankel values after the first ones."""
    return 2 * float(np.sum(realization.values[order:][::-1]))
