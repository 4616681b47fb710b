"""Elementary functions in C, as the sine: the formulas of `formula_table`, written line by line in C's spelling."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping

from workbench.engine.machines.c_primitives import HARDWARE, NEEDS, PRIMITIVES, primitive
from workbench.engine.machines.c_real import DOUBLE, SINGLE, Real, word_text
from workbench.engine.machines.c_spelling import format_operation
from workbench.engine.machines.formula_table import IN_DOUBLE, IN_SINGLE, QUARTERS, FormulaTable
from workbench.engine.machines.machine import MachineNumber
from workbench.engine.machines.operations import OPERATIONS, Kind

FUNCTIONS: Mapping[Real, FormulaTable] = {DOUBLE: IN_DOUBLE, SINGLE: IN_SINGLE}
ABOUT = {
    "sin": "The sine; not a number beyond 1e12 rad.",
    "cos": "The cosine; not a number beyond 1e12 rad.",
    "turn": "Sine and cosine of one angle; not a number beyond 1e12 rad.",
    "exp": "The exponential; zero below -708, infinite above 709.",
    "log": "The natural logarithm.",
    "tanh": "The hyperbolic tangent.",
    "atan2": "The angle of the point (x, y).",
    "fmod": "The remainder of x / y, with the sign of x.",
    "fmin": "The smaller number; of a number and what is none, the number.",
    "fmax": "The larger number; of a number and what is none, the number.",
    "sign": "1, -1, or x itself where it is zero.",
    "expm1": "The exponential less one, to the last digits also near zero.",
    "log1p": "The natural logarithm of 1 + x, to the last digits also near zero.",
    "sinh": "The hyperbolic sine.",
    "cosh": "The hyperbolic cosine.",
    "asinh": "The inverse hyperbolic sine.",
    "acosh": "The inverse hyperbolic cosine; not a number below 1.",
    "atanh": "The inverse hyperbolic tangent; not a number beyond 1.",
    "hypot": "The length of the vector (x, y).",
}
LETTERS = {Kind.NUMBER: "v", Kind.WORD: "w", Kind.TRUTH: "t"}  # of variables


class Lines:
    """The machine that writes each operation as a line of C, and lists the primitives that it calls."""

    def __init__(self, real: Real, prefix: str, fused_products: bool = False) -> None:
        self.real, self.prefix, self.fused_products = real, prefix, fused_products
        self.calls: set[str] = set()
        self.lines: list[str] = []

    def do(self, operation: str, *operands: str) -> str:
        """One operation; its variable."""
        if operation in PRIMITIVES or operation in HARDWARE:
            self.calls.add(operation)
            text = f"{self.prefix}_{operation}{self.real.mark}({', '.join(operands)})"
        else:
            text = format_operation(operation, operands, self.real)
        kind = OPERATIONS[operation].result
        name = f"{LETTERS[kind]}{len(self.lines)}"
        type_ = {Kind.NUMBER: self.real.type, Kind.WORD: self.real.word, Kind.TRUTH: "bool"}[kind]
        self.lines.append(f"const {type_} {name} = {text};")
        return name

    def constant(self, value: float) -> str:
        """A number."""
        if not math.isfinite(value):
            self.calls.add("number")
            return f"{self.prefix}_number{self.real.mark}({word_text(self.real.pattern(value))})"
        text = self.real.literal(value)
        return f"({text})" if text.startswith("-") else text

    def word(self, value: int) -> str:
        """A whole number of so many bits."""
        return word_text(value % (1 << self.real.bits))


def definitions(prefix: str, real: Real, calls: Iterable[str], hardware: Collection[str] = ()) -> list[str]:
    """Definitions in C of the elementary functions and primitives that are called, with all that they call, in order.

    "turn" is the pair of sine and cosine of one angle; "sin" and "cos" are one of the two. Of `hardware`, "sqrt" and
    "fma", the processor's own are called, and with the second products are rounded together with sums.
    """
    names = dict.fromkeys(calls)
    functions = [name for name in names if name in ABOUT]
    machines = [Lines(real, prefix, "fma" in hardware) for _ in functions]
    texts = [_function(machine, name) for machine, name in zip(machines, functions, strict=True)]
    called = set(names).union(*(machine.calls for machine in machines))
    primitives = [name for name in (*PRIMITIVES, "fma") if name in called]
    order = dict.fromkeys(each for name in primitives for each in _with_needs(name, hardware))
    return [*(primitive(prefix, real, name, hardware) for name in order), *texts]


def _with_needs(name: str, hardware: Collection[str]) -> Iterator[str]:
    """A primitive behind those that it calls."""
    for other in NEEDS.get(name, ()) if name not in hardware else ():
        yield from _with_needs(other, hardware)
    yield name


def _function(machine: Lines, name: str) -> str:
    prefix, real, functions = machine.prefix, machine.real, FUNCTIONS[machine.real]
    names = OPERATIONS["sin" if name == "turn" else name].arguments
    given = [MachineNumber(machine, argument) for argument in names]
    if name == "turn":
        angle = functions.reduce_angle(*given)
        results = [functions.sine_or_cosine(angle, quarter).value for quarter in QUARTERS.values()]
    else:
        results = [functions.of(name, *given).value]
    arguments, pair = ", ".join(f"{real.type} {argument}" for argument in names), f"{prefix}_pair{real.mark}"
    head, returns, begin, end = list[str](), real.type, list[str](), [f"return {results[0]};"]
    if name == "turn":
        head = [f"typedef struct {{ {real.type} sine; {real.type} cosine; }} {pair};", ""]
        returns, begin = pair, [f"{pair} pair;"]
        end = [f"pair.sine = {results[0]};", f"pair.cosine = {results[1]};", "return pair;"]
    head += [f"/* {ABOUT[name]} */", f"static {returns} {prefix}_{name}{real.mark}({arguments})"]
    return "\n".join([*head, "{", *(f"    {line}" for line in (*begin, *machine.lines, *end)), "}"])
