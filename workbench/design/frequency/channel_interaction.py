"""The interaction of the channels of a transfer matrix at one frequency: its condition number and relative gains."""

from __future__ import annotations

import numpy as np

from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import as_array, refusal
from workbench.core.validation.signatures import check_arguments
from workbench.design.control_system import System
from workbench.design.matrices import EPS, Complex, DesignError


@check_arguments
def condition_number(G: Numbers | System) -> float:
    """The ratio of the largest to the smallest singular value of a matrix (ny, nu) of gains; inf if it lacks rank.

    For a system, give its gain at one frequency, as `system(0)` or `system(1j * omega)`.

    Raises
    ------
    ValueError
        If G is not a matrix of finite numbers.

    Examples
    --------
    >>> column = [[87.8, -86.4], [108.2, -109.6]]
    >>> round(wb.condition_number(column), 1)
    141.7
    """
    values = np.linalg.svd(_gains("condition_number", G), compute_uv=False)
    return float(values[0] / values[-1]) if values[-1] > EPS * max(values.shape) * values[0] else np.inf


@check_arguments
def relative_gains(G: Numbers | System) -> Complex:
    """The relative gain array of a square matrix of gains: each entry of G times that of (G^-1)^T.

    The transpose is the plain one. Rows and columns each add up to one.

    For a system, give its gain at one frequency, as `system(0)` or `system(1j * omega)`.

    Raises
    ------
    ValueError
        If G is not a square matrix of finite numbers.
    DesignError
        If G is singular within rounding.

    References
    ----------
    Bristol (1966), On a new measure of interaction for multivariable process control, IEEE Trans. Autom. Control 11.

    Examples
    --------
    >>> float(wb.relative_gains([[87.8, -86.4], [108.2, -109.6]])[0, 0].real.round(1))
    35.1
    """
    gains = _gains("relative_gains", G)
    if gains.shape[0] != gains.shape[1]:
        raise ValueError(f"`relative_gains(G=...)` must be square, as it takes the inverse; got shape {gains.shape}.")
    if not np.isfinite(condition_number(gains)):
        raise DesignError(
            "`relative_gains(G)` takes the inverse of G, which is singular within rounding; leave out a channel."
        )
    return np.asarray(gains * np.linalg.inv(gains).T)


def _gains(call: str, G: Numbers | System) -> Complex:
    """A matrix of finite numbers, real or complex."""
    must = "a matrix of finite numbers, real or complex"
    try:
        parts = as_array(np.real(G)), as_array(np.imag(G))
    except Exception:  # an object of the user's may raise anything when it is asked for its parts
        raise refusal(f"{call}(G=...)", must, G) from None
    real, imaginary = parts
    if real is None or imaginary is None or real.ndim != 2 or real.size == 0:
        raise refusal(f"{call}(G=...)", must, G)
    gains = real + 1j * imaginary
    if not np.isfinite(gains).all():
        raise refusal(f"{call}(G=...)", must, G)
    return np.asarray(gains)
