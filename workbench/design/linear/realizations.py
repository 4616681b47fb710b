"""`realize`: a state space of given order from Markov parameters, by the eigensystem realisation algorithm."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from workbench.core.validation.refusals import Array, numbers, seconds, whole
from workbench.core.validation.signatures import check_arguments

if TYPE_CHECKING:
    import control


@check_arguments
def realize(markov: Array, order: int, period: float) -> tuple[control.StateSpace, Array]:
    """A system with the Markov parameters D, CB, CAB, ..., and the singular values of their Hankel matrix.

    It is python-control's `era`. With Markov parameters of a system of this order it is exact; a gap in the singular
    values shows the order.

    Parameters
    ----------
    markov
        (m, ny, nu), the responses to unit impulses, of one channel (m,), with m > 2 order.
    order
        The number of states.
    period
        The period in s.

    Raises
    ------
    ValueError
        If there are too few Markov parameters for the order, or one is not finite.

    References
    ----------
    Juang and Pappa (1985), Journal of Guidance, Control, and Dynamics 8, pages 620 to 627.

    Examples
    --------
    >>> system, singular_values = wb.linear.realize(np.r_[0.0, 0.5 * 0.8 ** np.arange(20)], 1, 0.1)
    >>> np.round(system.A, 6), system.dt
    (array([[0.8]]), 0.1)
    """
    import control

    responses = numbers("realize(markov=...)", markov)
    responses = responses[:, np.newaxis, np.newaxis] if responses.ndim == 1 else responses
    n, h = whole("realize(order=...)", order), seconds("realize(period=...)", period)
    if responses.ndim != 3 or not np.isfinite(responses).all():
        raise ValueError("`realize(markov=...)` must be finite numbers of shape (m,) or (m, ny, nu).")
    count = len(responses)
    rows = (count - 1) // 2
    if rows * min(responses.shape[1:]) < n:
        raise ValueError(
            f"`realize(order=...)` must be at most {rows * min(responses.shape[1:])} for {count} Markov parameters; "
            f"got {n}: give more of them."
        )
    system, values = control.era(np.moveaxis(responses, 0, -1), n, m=rows, n=rows)
    return control.ss(system.A, system.B, system.C, system.D, h), np.asarray(values)
