"""The Kalman filter of a linear model in discrete time, in square-root form."""

from __future__ import annotations

import numpy as np

from workbench.core import Entry, Layout
from workbench.core.validation.refusals import Array, as_array, describe
from workbench.core.validation.signatures import check_arguments
from workbench.identification.filters.array_steps import square_root
from workbench.identification.filters.constant_pass import ConstantModel, constant_pass
from workbench.identification.filters.filter_estimate import FilterEstimate, estimate_by
from workbench.identification.filters.filter_input import covariance, initial_mean, matrices, samples, times
from workbench.identification.filters.forward_pass import AbstractPass, Moves, PassRecord, forward_pass


class _MatrixPass(AbstractPass):
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
        return Moves(self._A[: len(self.y) - 1], self._noise[: len(self.y) - 1], readings=self._C)

    def run(self, x: Array, S: Array, R: Array) -> PassRecord:
        if self._A.strides[0] or self._C.strides[0] or self._noise.strides[0]:
            return forward_pass(self, x, S, R)
        return constant_pass(self, ConstantModel(self._A[0], self._C[0], self._noise[0], self._b, self._d), x, S, R)


@check_arguments
def kalman_filter(
    y: Array,
    A: Array,
    C: Array,
    Q: Array,
    R: Array,
    *,
    x0: Array | None = None,
    P0: Array | None = None,
    B: Array | None = None,
    D: Array | None = None,
    u: Array | None = None,
    t: Array | None = None,
    states: Layout | None = None,
    outputs: Layout | None = None,
) -> FilterEstimate:
    """The Kalman filter of x+ = A x + B u + w, y = C x + D u + v, with cov w = Q and cov v = R, by array algorithms.

    Parameters
    ----------
    y
        (N, q) or (N,), the samples of the sensors; NaN where a sensor has none.
    A, C, Q, R
        (n, n), (q, n), (n, n) and (q, q). A, C and Q are (N, ...) where they change: A and Q of sample k lead to the
        next sample. Q is positive semidefinite, and R definite.
    x0, P0
        (n,) and (n, n), mean and covariance of the state before the first sample. They must be given.
    B, D, u
        (n, m), (q, m) and (N, m): u of sample k enters y of sample k and the state of the next one.
    t, states, outputs
        The times (N,) in s, by default the numbers of the samples; names and units, as of `wb.layout`.

    Raises
    ------
    ValueError
        If a shape does not fit, a covariance is none, x0 or P0 is not given, or a number but of y is not finite.

    Examples
    --------
    >>> level = wb.filters.kalman_filter([1.0, float("nan"), 0.9], [[1]], [[1]], [[0.01]], [[0.04]], x0=[0], P0=[[1]])
    >>> level
    <FilterEstimate of x: 3 samples, log-likelihood -1.1984>
    """
    rows = samples("kalman_filter", y)
    ports = (states, outputs)
    return _estimate("kalman_filter", rows, (A, C, Q, R), (x0, P0), (B, D, u), t, ports)


def _estimate(
    call: str,
    rows: Array,
    matrices_: tuple[Array, Array, Array, Array],
    start: tuple[Array | None, Array | None],
    driven: tuple[Array | None, Array | None, Array | None],
    t: Array | None,
    ports: tuple[Layout | None, Layout | None],
) -> FilterEstimate:
    (N, q), (A, C, Q, R) = rows.shape, matrices_
    n = matrices(call, "A", A, N).shape[-1]
    a, c = matrices(call, "A", A, N, (n, n)), matrices(call, "C", C, N, (q, n))
    noise = roots_of(call, Q, N, n)
    b, d = _driven(call, driven, (N, n, q))
    mean, P = initial_mean(call, start[0], n), covariance(call, "P0", start[1], n)
    layouts = (_port(call, "states", ports[0], "x", n), _port(call, "outputs", ports[1], "y", q))
    model = _MatrixPass(layouts, times(call, t, N), rows, (a, c, noise, b, d))
    return estimate_by(model, mean, P, covariance(call, "R", R, q, definite=True))


def roots_of(call: str, Q: Array, N: int, n: int) -> Array:
    """The square roots (N, n, n) of covariances, once where they are constant."""
    array = as_array(Q)
    if array is None or array.ndim != 3:
        return np.broadcast_to(square_root(covariance(call, "Q", Q, n)), (N, n, n))
    checked = matrices(call, "Q", Q, N, (n, n))
    return np.array([square_root(covariance(call, f"Q[{k}]", one, n)) for k, one in enumerate(checked)])


def _driven(
    call: str, driven: tuple[Array | None, Array | None, Array | None], sizes: tuple[int, ...]
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
