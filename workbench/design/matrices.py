"""Matrices that a design may use, the certificate of its answer, and one thread for the linear algebra of a solver."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from typing import TypeVar

import numpy as np
import scipy.linalg  # noqa: F401  brings a BLAS of its own, which must be here before it is looked for
from numpy.typing import NDArray
from threadpoolctl import ThreadpoolController

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array, as_array, describe

Complex = NDArray[np.complex128]
EPS = float(np.finfo(float).eps)
# Squares and cubes of the entries occur in every equation of this room, and must neither overflow nor vanish.
LARGEST, SMALLEST = 1e100, 1e-100
T = TypeVar("T")


class DesignError(ValueError):
    """The error of a design without a trustworthy answer; the message has the reason and a remedy.

    Examples
    --------
    >>> try:
    ...     wb.riccati.care(np.eye(1), np.zeros((1, 1)), np.eye(1), np.eye(1))
    ... except wb.linear.DesignError as refused:
    ...     print("no gain")
    no gain
    """


@dataclass(frozen=True)
@show
class Certificate:
    """The accuracy of a solution, and the decay rate of the loop that it gives.

    `residual` is that of the equation over the size of its terms, `error` an estimate of the relative error of the
    solution for the data exactly as given, and `condition` a bound of its relative change over that of the data.
    `decay_rate` is the distance of the slowest pole from instability: -max Re in 1/s, or 1 - max |z|. `newton_steps` is
    the number of Newton steps that refined the solution.
    """

    residual: float
    error: float
    condition: float
    decay_rate: float
    newton_steps: int = 0
    warnings: tuple[str, ...] = ()

    def __str__(self) -> str:
        figures = (
            f"residual {self.residual:.1e}, error {self.error:.1e}, condition {self.condition:.1e}, "
            f"decay rate {self.decay_rate:.3g}, Newton steps {self.newton_steps}"
        )
        return "; ".join([figures, *self.warnings])


def matrix(call: str, name: str, value: object, rows: int | None = None, columns: int | None = None) -> Array:
    """The value as a new real matrix of finite numbers, of the asked shape; a single number is (1, 1)."""
    array = as_array(value)
    if array is None:
        raise ValueError(f"`{call}`: {name} must be a matrix of real numbers; got {describe(value)}.")
    array = array.reshape(1, 1) if array.ndim == 0 else array
    want = f"({rows or 'any'}, {columns or 'any'})"
    if array.ndim != 2 or array.size == 0 or rows not in (None, len(array)) or columns not in (None, array.shape[1]):
        raise ValueError(f"`{call}`: {name} must be a matrix of shape {want}, not empty; got shape {array.shape}.")
    if not np.isfinite(array).all():
        i, j = np.argwhere(~np.isfinite(array))[0]
        raise ValueError(f"`{call}`: {name} must hold finite numbers; {name}[{i}, {j}] is {array[i, j]}.")
    size = float(np.abs(array).max())
    if size > LARGEST or 0 < size < SMALLEST:
        i, j = np.unravel_index(np.abs(array).argmax(), array.shape)
        raise ValueError(
            f"`{call}`: the largest entry of {name} must lie between {SMALLEST:g} and {LARGEST:g}, or its powers leave "
            f"the range of floating-point numbers; {name}[{i}, {j}] is {array[i, j]:g}. Choose other units."
        )
    return array


def answer(call: str, name: str, function: Callable[..., T], *arguments: object) -> T:
    """The answer of a function of the caller, or a refusal with the error that it raised."""
    try:
        return function(*arguments)
    except Exception as error:
        text = describe(f"{type(error).__name__}: {error}")
        raise ValueError(f"`{call}`: {name} could not be asked for its answer; it raised {text}.") from error


def square(call: str, name: str, value: object, n: int | None = None) -> Array:
    """A real matrix (n, n)."""
    array = matrix(call, name, value, n, n)
    if array.shape[0] != array.shape[1]:
        raise ValueError(f"`{call}`: {name} must be square; got shape {array.shape}.")
    return array


def invertible(call: str, name: str, value: object, n: int | None = None) -> Array:
    """A real matrix (n, n) whose inverse can be trusted."""
    array = square(call, name, value, n)
    condition = float(np.linalg.cond(_level(array)))
    if not condition * len(array) * EPS < 1:
        raise ValueError(
            f"`{call}`: {name} must have an inverse; its condition number is {condition:.1e}, so it is singular within "
            "rounding. A descriptor system with algebraic equations must be reduced to its states first."
        )
    return array


def symmetric(call: str, name: str, value: object, n: int | None = None) -> Array:
    """A real symmetric matrix (n, n); asymmetry within rounding is averaged away."""
    array = square(call, name, value, n)
    gap = np.abs(array - array.T)
    # a product such as T Q T' of n terms is symmetric to about n roundings of its largest term
    if gap.max() > 32 * len(array) * EPS * np.abs(array).max():
        i, j = sorted(np.unravel_index(gap.argmax(), gap.shape))
        raise ValueError(
            f"`{call}`: {name} must be symmetric; {name}[{i}, {j}] is {array[i, j]:g} but {name}[{j}, {i}] is "
            f"{array[j, i]:g}. A quadratic form sees only ({name} + {name}') / 2: pass that if it is meant."
        )
    return (array + array.T) / 2


def definite(call: str, name: str, value: object, n: int | None = None) -> Array:
    """A real symmetric positive definite matrix (n, n) whose inverse can be trusted."""
    array = symmetric(call, name, value, n)
    root = np.sqrt(np.maximum(np.diag(array), SMALLEST))
    if np.linalg.eigvalsh(array / root[:, None] / root)[0] <= len(array) * EPS:
        values = np.linalg.eigvalsh(array)
        raise ValueError(
            f"`{call}`: {name} must be positive definite beyond rounding, as its inverse is needed; its eigenvalues "
            f"run from {values[0]:.3g} to {values[-1]:.3g}. Give every direction a weight above zero."
        )
    return array


def semidefinite(call: str, name: str, value: object, n: int | None = None) -> Array:
    """A real symmetric matrix (n, n) without a negative eigenvalue, but for rounding."""
    array = symmetric(call, name, value, n)
    if indefinite(array):
        values = np.linalg.eigvalsh(array)
        raise ValueError(
            f"`{call}`: {name} must be positive semidefinite; its least eigenvalue is {values[0]:.3g}, its largest "
            f"{values[-1]:.3g}."
        )
    return array


def indefinite(array: Array) -> bool:
    """True if a symmetric matrix has a negative eigenvalue beyond rounding."""
    values = np.linalg.eigvalsh(array)
    return bool(values[0] < -8 * len(array) * EPS * np.abs(values).max())


def _level(array: Array) -> Array:
    for _ in range(3):
        rows, columns = np.abs(array).max(axis=1, keepdims=True), np.abs(array).max(axis=0, keepdims=True)
        array = array / np.sqrt(np.where(rows > 0, rows, 1.0)) / np.sqrt(np.where(columns > 0, columns, 1.0))
    return array


def pole_text(pole: complex) -> str:
    """A pole in four digits, as a real number if it is one."""
    if abs(pole.imag) < 1e-12 * (1 + abs(pole)):
        return f"{pole.real + 0.0:.4g}"
    return f"{pole.real + 0.0:.4g}{pole.imag:+.4g}j"  # a zero without a sign


@contextmanager
def one_thread() -> Iterator[None]:
    """A context in which the BLAS of NumPy and SciPy runs one thread, as threads would wait for each other."""
    with libraries().limit(limits=1, user_api="blas"):
        yield


@cache
def libraries() -> ThreadpoolController:
    """The libraries of this process that have a number of threads."""
    return ThreadpoolController()
