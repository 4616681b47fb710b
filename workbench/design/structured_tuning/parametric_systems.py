"""A linear system whose matrices are CasADi expressions of the numbers that are tuned."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from workbench.core.validation.refusals import Array, refusal
from workbench.core.validation.signatures import check_arguments
from workbench.design.structured_tuning.controller_structure import free_numbers
from workbench.design.structured_tuning.system_jets import SystemJet


@dataclass(frozen=True, eq=False)
class ParametricSystem:
    """The closed loop x' = A x + B w, z = C x + D w, whose matrices are CasADi expressions of `numbers` (d, 1).

    Attributes
    ----------
    numbers
        The symbols (d, 1) that are tuned.
    A, B, C, D
        (n, n), (n, nw), (nz, n) and (nz, nw).
    period
        The period of a sampled system in s; None in continuous time.

    Raises
    ------
    ValueError
        If a matrix is no CasADi expression, is of another shape, or has symbols that are not among the numbers.

    Examples
    --------
    >>> import casadi as ca
    >>> k = ca.SX.sym("k", 1)
    >>> wb.structured_tuning.ParametricSystem(k, -k, ca.SX(1), ca.SX(1), ca.SX(0)).jet(np.array([2.0])).A
    array([[-2.]])
    """

    numbers: ca.SX
    A: ca.SX
    B: ca.SX
    C: ca.SX
    D: ca.SX
    period: float | None = None

    @check_arguments
    def __post_init__(self) -> None:
        for name in ("numbers", *"ABCD"):
            if not isinstance(getattr(self, name), ca.SX):
                raise refusal(f"ParametricSystem({name}=...)", "a CasADi `SX`", getattr(self, name))
        n, nw, nz = self.A.shape[0], self.B.shape[1], self.C.shape[0]
        for name, shape in {"A": (n, n), "B": (n, nw), "C": (nz, n), "D": (nz, nw)}.items():
            if getattr(self, name).shape != shape:
                raise refusal(f"ParametricSystem({name}=...)", f"of shape {shape}", getattr(self, name).shape)
        both = ca.vertcat(ca.horzcat(self.A, self.B), ca.horzcat(self.C, self.D))
        own = {one.name() for one in ca.symvar(self.numbers)}
        foreign = [one.name() for one in ca.symvar(both) if one.name() not in own]
        if foreign:
            raise ValueError(
                f"`ParametricSystem(numbers=...)` must have all symbols of the matrices; it lacks '{foreign[0]}'."
            )

    @property
    def size(self) -> int:
        """The number of tuned numbers."""
        return int(self.numbers.numel())

    @check_arguments
    def jet(self, numbers: Array) -> SystemJet:
        """The matrices at a point (d,), and their exact derivatives."""
        own = free_numbers("ParametricSystem.jet(numbers=...)", numbers, self.size)
        M, slopes = (np.array(part) for part in self._function(own))
        made = slopes.reshape(M.shape[1], M.shape[0], self.size).transpose(2, 1, 0)
        return SystemJet(M, made, self.A.shape[0], self.period)

    @cached_property
    def _function(self) -> ca.Function:
        both = ca.densify(ca.vertcat(ca.horzcat(self.A, self.B), ca.horzcat(self.C, self.D)))
        return ca.Function("system", [self.numbers], [both, ca.densify(ca.jacobian(ca.vec(both), self.numbers))])
