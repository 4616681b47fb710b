"""A controller of a given order whose matrices have free and fixed numbers, and the closed loop by the free ones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array, as_array, refusal, whole
from workbench.core.validation.signatures import check_arguments
from workbench.design.structured_tuning.system_jets import SystemJet

MOST_SIGNALS = 1000  # measurements or controls of one controller

MOST_STATES = 40


@dataclass(frozen=True, eq=False)
@check_arguments
class ControllerStructure:
    """A controller u = K y with `order` states. Its numbers are free where a matrix is NaN, and fixed elsewhere.

    Attributes
    ----------
    order
        The number of states; 0 for a static gain.
    A, B, C, D
        (order, order), (order, ny), (nu, order) and (nu, ny); all numbers are free by default.

    Raises
    ------
    ValueError
        If a matrix has an infinity, or a state is given to a static gain.

    Examples
    --------
    >>> wb.structured_tuning.ControllerStructure(D=[[np.nan, 0.0], [0.0, np.nan]]).pattern(2, 2)[0]
    array([[nan,  0.],
           [ 0., nan]])
    """

    order: int = 0
    A: Numbers | None = None
    B: Numbers | None = None
    C: Numbers | None = None
    D: Numbers | None = None

    def __post_init__(self) -> None:
        whole("ControllerStructure(order=...)", self.order, 0, MOST_STATES, " of states")
        for name in "ABCD":
            value = getattr(self, name)
            array = None if value is None else as_array(value)
            if value is not None and (array is None or array.ndim != 2 or np.isinf(array).any()):
                must = "a matrix of numbers, NaN where one is free"
                raise refusal(f"ControllerStructure({name}=...)", must, value)
            if value is not None and name != "D" and not self.order:
                raise ValueError(
                    f"`ControllerStructure({name}=...)` needs an order above 0, as a static gain has D alone."
                )

    @check_arguments
    def pattern(self, ny: int, nu: int) -> tuple[Array, int]:
        """The matrix [D C; B A] (nu + order, ny + order) with NaN at its free numbers, and how many these are.

        Raises
        ------
        ValueError
            If a matrix has another shape, or no number is free.
        """
        for name, count in (("ny", ny), ("nu", nu)):
            whole(f"ControllerStructure.pattern({name}=...)", count, most=MOST_SIGNALS)
        k = self.order
        shapes = {"D": (nu, ny), "C": (nu, k), "B": (k, ny), "A": (k, k)}
        parts = {}
        for name, shape in shapes.items():
            given = getattr(self, name)
            parts[name] = np.full(shape, np.nan) if given is None else np.array(as_array(given), dtype=float)
            if parts[name].shape != shape:
                raise ValueError(
                    f"`ControllerStructure({name}=...)` must have shape {shape} for {ny} measurements and {nu} "
                    f"controls; got {parts[name].shape}."
                )
        whole_pattern = np.block([[parts["D"], parts["C"]], [parts["B"], parts["A"]]])
        free = int(np.isnan(whole_pattern).sum())
        if not free:
            raise ValueError("`ControllerStructure(...)` must have at least one free number, NaN; all are fixed.")
        return whole_pattern, free

    @check_arguments
    def first(self, pattern: Array, ny: int, nu: int, initial: Numbers | None = None) -> Array:
        """The free numbers of the first start: those given, or no gain and slow stable states, weakly coupled."""
        if initial is not None:
            return free_numbers("structured_controller(initial=...)", initial, int(np.isnan(pattern).sum()))
        start = np.zeros(pattern.shape)
        k = self.order
        if k:
            start[nu:, ny:] = -np.diag(np.arange(1.0, k + 1))
            start[nu:, :ny] = 0.1
            start[:nu, ny:] = 0.1 * (-1.0) ** np.arange(k)
        return np.asarray(start[np.isnan(pattern)])


def free_numbers(call: str, value: object, count: int) -> Array:
    """So many finite numbers, as a vector."""
    array = as_array(value)
    if array is None or array.size != count or not np.isfinite(array).all():
        raise refusal(call, f"{count} finite numbers, one for each free one", value)
    return np.ravel(array)


@dataclass(frozen=True, eq=False)
class LoopByController:
    """The closed loop of a plant and a controller, by the free numbers of its matrices."""

    M: Array  # of the plant with the states of the controller, from (x, w) to (x', z)
    left: Array  # by which the controller acts
    right: Array  # what it reads
    direct: Array  # from its outputs to what it reads
    pattern: Array
    n: int
    period: float | None

    @staticmethod
    def of(
        matrices: tuple[Array, Array, Array, Array], ny: int, nu: int, pattern: Array, period: float | None
    ) -> LoopByController:
        """The loop of a plant [A B; C D] whose last outputs are measured, and whose last inputs are controls."""
        A, B, C, D = matrices
        k, n = len(pattern) - nu, len(A)
        nz, nw = len(C) - ny, B.shape[1] - nu
        M = np.zeros((n + k + nz, n + k + nw))
        M[:n, :n], M[:n, n + k :], M[n + k :, :n], M[n + k :, n + k :] = A, B[:, :nw], C[:nz], D[:nz, :nw]
        left, right = np.zeros((len(M), nu + k)), np.zeros((ny + k, M.shape[1]))
        left[:n, :nu], left[n + k :, :nu], left[n : n + k, nu:] = B[:, nw:], D[:nz, nw:], np.eye(k)
        right[:ny, :n], right[:ny, n + k :], right[ny:, n : n + k] = C[nz:], D[nz:, :nw], np.eye(k)
        direct = np.zeros((ny + k, nu + k))
        direct[:ny, :nu] = D[nz:, nw:]
        return LoopByController(M, left, right, direct, pattern, n + k, period)

    def controller(self, numbers: Array) -> Array:
        """The matrix [D C; B A] of the controller."""
        made = self.pattern.copy()
        made[np.isnan(made)] = numbers
        return made

    def __call__(self, numbers: Array) -> SystemJet:
        """The closed loop, with its derivatives."""
        K = self.controller(numbers)
        right = np.linalg.solve(np.eye(len(self.direct)) - self.direct @ K, self.right)
        left = self.left @ np.linalg.inv(np.eye(len(K)) - K @ self.direct)
        rows, columns = np.nonzero(np.isnan(self.pattern))
        slopes = left.T[rows][:, :, np.newaxis] * right[columns][:, np.newaxis, :]
        return SystemJet(self.M + self.left @ K @ right, slopes, self.n, self.period)
