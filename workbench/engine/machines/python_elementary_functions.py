"""Elementary functions in Python, as the sine: the formulas of `formula_table`, each in Python's spelling."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial

from workbench.engine.machines.elementary_functions import Angle
from workbench.engine.machines.formula_table import IN_DOUBLE
from workbench.engine.machines.machine import MachineNumber, MachineTruth, MachineWord
from workbench.engine.machines.operations import OPERATIONS
from workbench.engine.machines.python_spelling import HELPERS, OF_TWO, PythonLines

NAMES: Mapping[str, str] = {  # of the functions of Python, by operation
    "exp": "exponential",
    "tanh": "hyperbolic_tangent",
    "log": "logarithm",
    "atan2": "arc_tangent",
    "fmod": "remainder",
    "fmin": "smaller",
    "fmax": "larger",
    "sign": "sign",
    "expm1": "real_expm1",
    "log1p": "real_log1p",
    "sinh": "real_sinh",
    "cosh": "real_cosh",
    "asinh": "real_asinh",
    "acosh": "real_acosh",
    "atanh": "real_atanh",
    "hypot": "real_hypot",
    "copysign": "real_copysign",
}
TURNS = {"sin": "sine", "cos": "cosine"}  # of an angle that `reduced` has reduced


def python_function(operation: str) -> list[str]:
    """An elementary function as Python."""
    machine, names = PythonLines(), list(OPERATIONS[operation].arguments)
    result = IN_DOUBLE.of(operation, *(MachineNumber(machine, argument) for argument in names))
    return _function(NAMES[operation], names, machine.lines, result.value)


def _angle() -> list[str]:
    machine = PythonLines()
    angle = IN_DOUBLE.reduce_angle(MachineNumber(machine, "x"))
    parts = (angle.quadrant.value, angle.odd.value, angle.sine.value, angle.cosine.value)
    return _function("reduced", ["x"], machine.lines, ", ".join(parts))


def _sine_or_cosine(name: str, quarter: int) -> list[str]:
    machine = PythonLines()
    word, odd = MachineWord(machine, "quadrant"), MachineTruth(machine, "odd")
    angle = Angle(word, odd, MachineNumber(machine, "sine_part"), MachineNumber(machine, "cosine_part"))
    result = IN_DOUBLE.sine_or_cosine(angle, quarter)
    return _function(name, ["quadrant", "odd", "sine_part", "cosine_part"], machine.lines, result.value)


def _function(name: str, arguments: Iterable[str], lines: Iterable[str], result: str) -> list[str]:
    return [f"def {name}({', '.join(arguments)}):", *(f"    {line}" for line in lines), f"    return {result}"]


PYTHON_FUNCTIONS: Mapping[str, Callable[[], list[str]]] = {
    "reduced": _angle,
    "sine": lambda: _sine_or_cosine("sine", 0),
    "cosine": lambda: _sine_or_cosine("cosine", 1),
    **{name: partial(python_function, operation) for operation, name in NAMES.items()},
}


def definitions(lines: Iterable[str]) -> list[str]:
    """The functions that some lines call, and those that these call, each before its first use."""
    text = "\n".join(lines)
    functions = ["\n".join(make()) for name, make in PYTHON_FUNCTIONS.items() if f"{name}(" in text]
    text = "\n".join([text, *functions])
    helpers = [
        f"def {name}({'x, y' if name in OF_TWO else 'x'}):{body}"
        for name, body in HELPERS.items()
        if f"{name}(" in text
    ]
    return [line for each in (*helpers, *functions) for line in (*each.splitlines(), "", "")]
