"""The Kalman filter of a linear model in discrete time, in square-root form."""

from __future__ import annotations

import numpy as np

from workbench.core import Entry, Layout
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array, as_array, describe
from workbench.core.validation.signatures import check_arguments
from workbench.identification.filters.array_steps import square_root
from workbench.identification.filters.constant_pass import ConstantModel, constant_pass
from workbench.identification.filters.filter_estimate import FilterEstimate, estimate_by
from workbench.identification.filters.filter_input import covariance, initial_mean, matrices, samples, times
from workbench.identification.filters.forward_pass import AbstractPass, Moves, PassRecord, forward_pass


class _LinearPass(AbstractPass):
    """x+ = A x + b_k + w, y = C x + d_k + v, with A and the root of Q (N, n, n), of stride 0 if they are constant."""

    def __init__(self, ports: tuple[Layout, Layout], t: Array, y: Array, parts: tuple[Array, ...]) -> None:
        self.states, self.outputs = ports
        self.t, self.y = t, y
        self._A, self._C, self._noise, self._b, self._d = parts

    def read(self, k: int, x: Array, S: Array) -> tuple[Array, Array, Array]:
        C = self._C[k]
        return C.dot(x) + self._d[k], C.dot(S), S

    def move(self, k: int, x: Array, S: Array) -> tuple[Array, Array, Array]:
        A = self._A[k]
        return A.dot(x) + self._b[k], A.dot(S), self._noise[k]

    def moves(self) -> Moves:
        return Moves(self._A[: len(self.y) - 1], self._noise[: len(self.y) - 1])

    def run(self, x: Array, S: Array, R: Array) -> PassRecord:
        if self._A.strides[0] or self._C.strides[0] or self._noise.strides[0]:
            return forward_pass(self, x, S, R)
        return constant_pass(self, ConstantModel(self._A[0], self._C[0], self._noise[0], self._b, self._d), x, S, R)


@check_arguments
def kalman_filter(
    y: Numbers,
    A: Numbers,
    C: Numbers,
    Q: Numbers,
    R: Numbers,
    *,
    x0: Numbers | None = None,
    P0: Numbers | None = None,
    B: Numbers | None = None,
    D: Numbers | None = None,
    u: Numbers | None = None,
    t: Numbers | None = None,
    states: Layout | None = None,
    outputs: Layout | None = None,
) -> FilterEstimate:
    """The Kalman filter of x+ = A x + B u + w, y = C x + D u + v, with cov w = Q and cov v = R.

    It works on square roots of the covariances, by orthogonal transformations alone. So P stays positive definite over
    any number of samples, and sensors that are very sharp beside P0 cost few digits.

    Parameters
    ----------
    y
        (N, q) or (N,), the samples of the sensors; NaN where a sensor has none.
    A, C, Q
        (n, n), (q, n) and (n, n), or (N, n, n), (N, q, n) and (N, n, n) where they change: A and Q of sample k lead to
        sample k + 1. Q is positive semidefinite.
    R
        (q, q), positive definite.
    x0, P0
        (n,) and (n, n), mean and covariance of the state before the first sample. They must be given.
    B, D, u
        (n, m), (q, m) and (N, m): the input u of sample k enters y of sample k and the state of sample k + 1.
    t
        (N,), the times of the samples in s, for tables and pictures; by default their numbers.
    states, outputs
        Names and units of x and y, as of `wb.layout`; by default x and y.

    Raises
    ------
    ValueError
        If a shape does not fit, Q or P0 is not positive semidefinite, R is not positive definite, x0 or P0 is not
        given, or a number other than one of y is not finite.

    References
    ----------
    Kailath, Sayed and Hassibi (2000), Linear Estimation, section 12.3: array algorithms.

    Examples
    --------
    >>> y = [1.0, 1.2, float("nan"), 0.9]
    >>> level = wb.filters.kalman_filter(y, A=[[1.0]], C=[[1.0]], Q=[[0.01]], R=[[0.04]], x0=[0.0], P0=[[1.0]])
    >>> level.x[:, 0].round(3)
    array([0.962, 1.087, 1.087, 1.007])
    >>> level
    <FilterEstimate of x: 4 samples, log-likelihood -1.3614>
    """
    call = "kalman_filter"
    rows = samples(call, y)
    N, q = rows.shape
    a = matrices(call, "A", A, N)
    n = a.shape[-1]
    a, c = matrices(call, "A", A, N, (n, n)), matrices(call, "C", C, N, (q, n))
    noise = roots_of(call, Q, N, n)
    b, d = _driven(call, (B, D, u), (N, n, q))
    mean, P = initial_mean(call, x0, n), covariance(call, "P0", P0, n)
    ports = (_port(call, "states", states, "x", n), _port(call, "outputs", outputs, "y", q))
    model = _LinearPass(ports, times(call, t, N), rows, (a, c, noise, b, d))
    return estimate_by(model, mean, P, covariance(call, "R", R, q, definite=True))


def roots_of(call: str, Q: Numbers, N: int, n: int) -> Array:
    """The square roots (N, n, n) of covariances, once where they are constant."""
    array = as_array(Q)
    if array is None or array.ndim != 3:
        return np.broadcast_to(square_root(covariance(call, "Q", Q, n)), (N, n, n))
    checked = matrices(call, "Q", Q, N, (n, n))
    return np.array([square_root(covariance(call, f"Q[{k}]", one, n)) for k, one in enumerate(checked)])


def _driven(
    call: str, driven: tuple[Numbers | None, Numbers | None, Numbers | None], sizes: tuple[int, ...]
) -> tuple[Array, Array]:
    """B u (N, n) and D u (N, q), zero where there is no such matrix."""
    B, D, u = driven
    N, n, q = sizes
    if u is None or (B is None and D is None):
        if not (u is None and B is None and D is None):
            raise ValueError(
                f"`{call}(B=..., D=..., u=...)` must have u together with B, D or both; got "
                f"{'u alone' if B is None and D is None else 'no u: give its samples, or leave B and D out'}."
            )
        return np.zeros((N, n)), np.zeros((N, q))
    inputs = as_array(u)
    inputs = inputs if inputs is None or inputs.ndim != 1 else inputs[:, None]
    if inputs is None or inputs.ndim != 2 or len(inputs) != N or not np.isfinite(inputs).all():
        raise ValueError(
            f"`{call}(u=...)` must be {N} rows of finite numbers, as y has; got {describe(u)}: an input without a "
            "sample must be filled in first, as no filter can guess it."
        )
    m = inputs.shape[1]
    parts = [(B, n, "B"), (D, q, "D")]
    b, d = (
        np.zeros((N, rows))
        if value is None
        else np.einsum("kij,kj->ki", matrices(call, name, value, N, (rows, m)), inputs)
        for value, rows, name in parts
    )
    return b, d


def _port(call: str, name: str, layout: Layout | None, letter: str, size: int) -> Layout:
    if layout is None:
        return Layout((Entry(letter, np.zeros(() if size == 1 else size), "?"),))
    if layout.size != size:
        raise ValueError(f"`{call}({name}=...)` must have {size} numbers; got {layout}, which has {layout.size}.")
    return layout
