"""A generalized plant: disturbances w and controls u come in, errors z and measurements y go out."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from workbench.core.point import OperatingPoint
from workbench.core.validation.notebook_display import show
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.design.control_system import System
from workbench.design.linear.operating_point import state_space
from workbench.design.matrices import DesignError, matrix, square

if TYPE_CHECKING:
    import control

CALL = "GeneralizedPlant"
NEAR_SINGULAR = 1e-12  # relative: I + D D22, or I + A, with a smaller singular value has no inverse to trust


@dataclass(frozen=True, eq=False)
@show
@check_arguments
class GeneralizedPlant:
    """x' = A x + B1 w + B2 u, z = C1 x + D11 w + D12 u, y = C2 x + D21 w + D22 u, or x+ = ... with a period `dt` in s.

    A controller u = K y is designed that stabilises the plant and makes the errors z small for disturbances w. The sign
    of the feedback is inside K. `measurements` and `controls` name the entries of y and u. `point` is the operating
    point of y and u; a controller that is designed for this plant carries it.

    Parameters
    ----------
    A, B1, B2
        (n, n), (n, nw) and (n, nu), n at least 1.
    C1, D11, D12
        (nz, n), (nz, nw) and (nz, nu).
    C2, D21, D22
        (ny, n), (ny, nw) and (ny, nu).

    Raises
    ------
    ValueError
        If a matrix is not real, finite or of its shape.

    Examples
    --------
    >>> one, none = [[1.0]], [[0.0, 0.0]]
    >>> plant = wb.synthesis.GeneralizedPlant(
    ...     A=[[0.0]], B1=[[1.0, 0.0]], B2=one, C1=[[1.0], [0.0]], C2=one,
    ...     D11=[[0.0, 0.0], [0.0, 0.0]], D12=[[0.0], [1.0]], D21=[[0.0, 1.0]], D22=[[0.0]],
    ... )
    >>> plant.sizes
    (1, 2, 1, 2, 1)
    """

    A: Numbers
    B1: Numbers
    B2: Numbers
    C1: Numbers
    C2: Numbers
    D11: Numbers
    D12: Numbers
    D21: Numbers
    D22: Numbers
    dt: float | None = None
    measurements: tuple[str, ...] = ()
    controls: tuple[str, ...] = ()
    point: OperatingPoint | None = None

    def __post_init__(self) -> None:
        A = square(CALL, "A", self.A)
        n = len(A)
        B1, B2 = (matrix(CALL, name, getattr(self, name), n) for name in ("B1", "B2"))
        C1, C2 = (matrix(CALL, name, getattr(self, name), None, n) for name in ("C1", "C2"))
        held = {"A": A, "B1": B1, "B2": B2, "C1": C1, "C2": C2}
        for i, C in (("1", C1), ("2", C2)):
            for j, B in (("1", B1), ("2", B2)):
                name = f"D{i}{j}"
                held[name] = matrix(CALL, name, getattr(self, name), len(C), B.shape[1])
        for name, value in held.items():
            object.__setattr__(self, name, value)
        if self.dt is not None and not 0 < self.dt < np.inf:
            raise ValueError(f"`{CALL}`: dt must be a positive period in seconds, or None; got {self.dt!r}.")
        for port, letter, size in (("measurements", "y", len(C2)), ("controls", "u", B2.shape[1])):
            names = getattr(self, port) or tuple(f"{letter}[{k}]" for k in range(size))
            if len(names) != size:
                raise ValueError(f"`{CALL}`: {port} must name each of the {size} numbers of {letter}; got {names!r}.")
            object.__setattr__(self, port, names)

    @staticmethod
    @check_arguments
    def of(system: control.StateSpace, measurements: int, controls: int) -> GeneralizedPlant:
        """The plant of a system whose last `measurements` outputs are y and whose last `controls` inputs are u.

        Raises
        ------
        ValueError
            If the system is no `StateSpace`, or has no further outputs or inputs.
        """
        call = "GeneralizedPlant.of(system, measurements, controls)"
        A, B, C, D = state_space(call, system)
        if system.dt is True:
            raise ValueError(f"`{call}`: the system must have a period in seconds; its dt is True.")
        for what, count, most in (("measurements", measurements, len(C)), ("controls", controls, B.shape[1])):
            if not 0 < count < most:
                kind = "outputs" if what == "measurements" else "inputs"
                raise ValueError(
                    f"`{call}`: {what} must count some of the {most} {kind}, at least 1 and not all; got {count}."
                )
        nz, nw = len(C) - measurements, B.shape[1] - controls
        return GeneralizedPlant(
            A, B[:, :nw], B[:, nw:], C[:nz], C[nz:], D[:nz, :nw], D[:nz, nw:], D[nz:, :nw], D[nz:, nw:],
            dt=float(system.dt) if system.dt else None,
            measurements=tuple(system.output_labels[nz:]),
            controls=tuple(system.input_labels[nw:]),
            point=_last_of_point(system, nz, nw),
        )  # fmt: skip

    @property
    def sizes(self) -> tuple[int, int, int, int, int]:
        """The numbers of states, disturbances, controls, errors and measurements: n, nw, nu, nz, ny."""
        p = self.parts
        return len(p.A), p.B1.shape[1], p.B2.shape[1], len(p.C1), len(p.C2)

    @property
    def parts(self) -> PlantParts:
        """The nine matrices as arrays."""
        names = ("A", "B1", "B2", "C1", "C2", "D11", "D12", "D21", "D22")
        return PlantParts(*(np.asarray(getattr(self, name), dtype=float) for name in names))

    @check_arguments
    def close(self, controller: control.StateSpace) -> System:
        """The closed loop from w to z with u = K y, a python-control `StateSpace` with hidden modes kept.

        Raises
        ------
        ValueError, DesignError
            If the controller is no `StateSpace` of these sizes and this period, or the loop has no unique solution.
        """
        import control as ct  # takes seconds

        call = "GeneralizedPlant.close(controller)"
        K = state_space(call, controller)
        period = float(controller.dt) if controller.dt else None
        _, _, nu, _, ny = self.sizes
        if K[3].shape != (nu, ny) or period != self.dt:
            raise ValueError(
                f"`{call}`: the controller must have {ny} inputs, {nu} outputs and the period {self.dt}; it has "
                f"{K[3].shape[1]}, {K[3].shape[0]} and {period}."
            )
        matrices = self.parts.close(*K)
        return ct.ss(*matrices, self.dt or 0, remove_useless_states=False)


@dataclass(frozen=True)
class PlantParts:
    """The nine matrices of a generalized plant as arrays, for computations."""

    A: Array
    B1: Array
    B2: Array
    C1: Array
    C2: Array
    D11: Array
    D12: Array
    D21: Array
    D22: Array

    def dual(self) -> PlantParts:
        """The plant of the transposed transfer matrix: disturbances and errors change places, and so do u and y."""
        return PlantParts(
            self.A.T, self.C1.T, self.C2.T, self.B1.T, self.B2.T, self.D11.T, self.D21.T, self.D12.T, self.D22.T
        )

    def close(self, Ak: Array, Bk: Array, Ck: Array, Dk: Array) -> tuple[Array, Array, Array, Array]:
        """The matrices of the loop from w to z that u = K y closes."""
        W = np.eye(len(Dk)) - Dk @ self.D22
        if np.linalg.cond(W) * NEAR_SINGULAR > 1:
            raise DesignError(
                "`GeneralizedPlant.close(controller)`: I - D D22, with the controller's D, has no inverse, so the loop "
                "has no unique solution. Give the controller no direct term, or the plant none."
            )
        gain = np.linalg.solve(W, np.hstack([Dk @ self.C2, Ck, Dk @ self.D21]))  # u by x, the controller's x, and w
        Fx, Fk, Fw = np.split(gain, [len(self.A), len(self.A) + len(Ak)], axis=1)
        A = np.block([[self.A + self.B2 @ Fx, self.B2 @ Fk], [Bk @ (self.C2 + self.D22 @ Fx), Ak + Bk @ self.D22 @ Fk]])
        B = np.vstack([self.B1 + self.B2 @ Fw, Bk @ (self.D21 + self.D22 @ Fw)])
        C = np.hstack([self.C1 + self.D12 @ Fx, self.D12 @ Fk])
        return A, B, C, self.D11 + self.D12 @ Fw

    def bilinear(self, call: str) -> PlantParts:
        """The continuous plant at s = (z - 1) / (z + 1) of a sampled one, with the same H-infinity norms."""
        one = np.eye(len(self.A))
        if np.linalg.cond(one + self.A) * NEAR_SINGULAR > 1:
            raise DesignError(
                f"`{call}`: the sampled plant has a mode at z = -1, which its bilinear transform sends to infinity. "
                "Choose another period, or take this mode out."
            )
        nw, nz = self.B1.shape[1], len(self.C1)
        A, B, C, D = bilinear_matrices(
            self.A,
            np.hstack([self.B1, self.B2]),
            np.vstack([self.C1, self.C2]),
            np.block([[self.D11, self.D12], [self.D21, self.D22]]),
        )
        return PlantParts(A, B[:, :nw], B[:, nw:], C[:nz], C[nz:], D[:nz, :nw], D[:nz, nw:], D[nz:, :nw], D[nz:, nw:])

    def without_d22(self) -> PlantParts:
        """The same plant with D22 = 0."""
        return replace(self, D22=np.zeros_like(self.D22))


def bilinear_matrices(A: Array, B: Array, C: Array, D: Array) -> tuple[Array, Array, Array, Array]:
    """The system at z = (1 + s) / (1 - s) of a sampled one; I + A must have an inverse."""
    inverse = np.linalg.inv(np.eye(len(A)) + A)
    root = np.sqrt(2.0)
    return inverse @ (A - np.eye(len(A))), root * inverse @ B, root * C @ inverse, D - C @ inverse @ B


def sampled_matrices(A: Array, B: Array, C: Array, D: Array) -> tuple[Array, Array, Array, Array]:
    """The sampled system at s = (z - 1) / (z + 1) of a continuous one; I - A must have an inverse."""
    inverse = np.linalg.inv(np.eye(len(A)) - A)
    root = np.sqrt(2.0)
    return inverse @ (np.eye(len(A)) + A), root * inverse @ B, root * C @ inverse, D + C @ inverse @ B


def _last_of_point(system: System, nz: int, nw: int) -> OperatingPoint | None:
    from workbench.design.linear.pointed_systems import point_of

    point = point_of(system)
    if point is None:
        return None
    return point.part(range(nz, system.noutputs), range(nw, system.ninputs))
