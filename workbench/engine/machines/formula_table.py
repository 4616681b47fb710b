"""Functions: the formula of each operation of a graph over a machine's numbers, in double and in single precision."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

from workbench.engine.machines import elementary_functions as double
from workbench.engine.machines import single_elementary_functions as single
from workbench.engine.machines.further_elementary_functions import DOUBLE
from workbench.engine.machines.machine import MachineNumber, MachineTruth, Value, fma, select
from workbench.engine.machines.operations import OPERATIONS, Kind, Role

QUARTERS = {"sin": 0, "cos": 1}  # of a turn, by which a function leads the sine
Formula = Callable[..., object]  # of Number and Truth of any machine, to one of them


class ToAngle(Protocol):
    """A function from a number of any machine to its reduced angle."""

    def __call__(self, x: MachineNumber[Value], /) -> double.Angle[Value]: ...  # noqa: D102


class OfAngle(Protocol):
    """A function from a reduced angle and a quarter to a number."""

    def __call__(self, angle: double.Angle[Value], quarter: int, /) -> MachineNumber[Value]: ...  # noqa: D102


@dataclass(frozen=True)
class FormulaTable:
    """The formulas in one format of numbers.

    Attributes
    ----------
    reduce_angle, sine_or_cosine
        The two halves of a sine and of a cosine, the first of which serves both.
    formulas
        That of each other operation of a graph, by name.
    """

    reduce_angle: ToAngle
    sine_or_cosine: OfAngle
    formulas: Mapping[str, Formula]

    def of(
        self, operation: str, *operands: MachineNumber[Value] | MachineTruth[Value]
    ) -> MachineNumber[Value] | MachineTruth[Value]:
        """The result of an operation of a graph on numbers and truths of a machine."""
        if operation in QUARTERS:
            (x,) = operands
            assert isinstance(x, MachineNumber)
            return self.sine_or_cosine(self.reduce_angle(x), QUARTERS[operation])
        made = self.formulas[operation](*operands)
        assert isinstance(made, MachineNumber | MachineTruth)
        return made


def _of_the_machine(name: str) -> Formula:
    """The formula of an operation that the machine has itself."""
    if OPERATIONS[name].result is Kind.TRUTH:
        return lambda a, b: a.compare(name, b)
    return lambda a, *others: a.do(name, *others)


def _both(a: MachineTruth[Value], b: MachineTruth[Value]) -> MachineTruth[Value]:
    return a & b


def _either(a: MachineTruth[Value], b: MachineTruth[Value]) -> MachineTruth[Value]:
    return a | b


def _inverse(a: MachineTruth[Value]) -> MachineTruth[Value]:
    return ~a


# What every format has in common: what the machine has itself, and what is short for it.
COMMON: Mapping[str, Formula] = {
    **{name: _of_the_machine(name) for name, row in OPERATIONS.items() if Role.MACHINE | Role.NODE in row.role},
    "and": _both,
    "or": _either,
    "not": _inverse,
    "if_else": select,
    "fma": fma,
    "fnma": lambda a, b, c: fma(-a, b, c) if a.machine.fused_products else c - a * b,
    "fms": lambda a, b, c: fma(a, b, -c) if a.machine.fused_products else a * b - c,
    "inv": lambda a: 1.0 / a,
    "barrier": lambda a: a,
}
IN_DOUBLE = FormulaTable(
    double.reduce_angle,
    double.sine_or_cosine,
    {
        **COMMON,
        "exp": double.exponential,
        "tanh": double.hyperbolic_tangent,
        "log": double.logarithm,
        "atan2": double.arc_tangent,
        "fmod": double.remainder,
        "fmin": double.smaller,
        "fmax": double.larger,
        "sign": double.sign,
        **DOUBLE.functions,
    },
)
IN_SINGLE = FormulaTable(
    single.reduce_angle,
    single.sine_or_cosine,
    {
        **COMMON,
        "exp": single.exponential,
        "tanh": single.hyperbolic_tangent,
        "log": single.logarithm,
        "atan2": single.arc_tangent,
        "fmod": single.remainder,
        "fmin": double.smaller,
        "fmax": double.larger,
        "sign": double.sign,
        **single.SINGLE.functions,
    },
)
