"""NumPy's arrays and linear algebra as a function of numbers writes them, for symbols."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np


def array(plain: Callable[..., Any]) -> Callable[..., Any]:
    """`numpy.array` whose entries may be symbols, or become some; of whole numbers it is an index, and stays one."""

    def of(values: Any, *rest: Any, **options: Any) -> Any:
        if isinstance(values, ca.SX):
            return values
        if isinstance(values, list | tuple):
            if any(isinstance(value, ca.SX) for value in values):
                result = np.empty(len(values), dtype=object)
                result[:] = values
                return result
            rows = [of(value) if isinstance(value, list | tuple) else value for value in values]
            if any(isinstance(row, np.ndarray) and row.dtype == object for row in rows):
                return np.stack(rows)
        if isinstance(values, np.ndarray) and values.dtype == object:
            return values.copy()
        result = plain(values, *rest, **options)
        return result.astype(object) if result.dtype == float else result

    return of


def blank(plain: Callable[..., Any]) -> Callable[..., Any]:
    """`numpy.zeros` and its like, into which symbols may be put."""

    def of(*values: Any, **options: Any) -> Any:
        result = plain(*values, **options)
        return result.astype(object) if result.dtype == float else result

    return of


def matrix(values: Any) -> ca.SX:
    """An array of symbols and numbers as CasADi's."""
    rows = np.asarray(values, dtype=object)
    return ca.SX(ca.vertcat(*[ca.horzcat(*row) for row in (rows if rows.ndim > 1 else rows[:, np.newaxis])]))


def entries(values: ca.SX, shape: tuple[int, ...]) -> Any:
    """CasADi's matrix as an array of symbols."""
    result = np.empty(values.shape, dtype=object)
    for i, j in np.ndindex(values.shape):
        result[i, j] = values[i, j]
    return result.reshape(shape)


def _solve(A: Any, b: Any) -> Any:
    return entries(ca.solve(matrix(A), matrix(b)), np.shape(b))


def _inv(A: Any) -> Any:
    return entries(ca.inv(matrix(A)), np.shape(A))


def _norm(x: Any) -> Any:
    return ca.sqrt(ca.sumsqr(matrix(x)))


def _det(A: Any) -> Any:
    return ca.det(matrix(A))


ALGEBRA: dict[str, Callable[..., Any]] = {"solve": _solve, "inv": _inv, "norm": _norm, "det": _det}


class Algebra:
    """The module `numpy.linalg`, where solve, inv, norm and det take symbols; the others take numbers only."""

    def __getattr__(self, name: str) -> Any:
        plain = getattr(np.linalg, name)
        if not callable(plain) or isinstance(plain, type):
            return plain

        def of(*values: Any, **options: Any) -> Any:
            if any(_symbolic(value) for value in values):
                return ALGEBRA[name](*values, **options)
            numbers = (np.array(v, dtype=float) if isinstance(v, np.ndarray) else v for v in values)
            return plain(*numbers, **options)

        return of


def _symbolic(values: Any) -> bool:
    return any(isinstance(value, ca.SX) for value in np.asarray(values, dtype=object).ravel())
