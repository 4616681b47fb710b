"""Elementary functions in C: the operations of every other machine, and the few for which C has a library."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from workbench.engine.kernel import elementary_functions as double_functions
from workbench.engine.kernel.further_functions import ARGUMENTS, DOUBLE
from workbench.engine.kernel.target_operations import Number
from workbench.handover.c99.c_primitives import HARDWARE, NEEDS, PRIMITIVES, SINGLE, Real, primitive, word_text
from workbench.handover.single import single_functions

NUMBER, WORD, TRUTH = "number", "word", "truth"


TEXTS = {
    **dict.fromkeys(("add", "word_add"), "{} + {}"),
    **dict.fromkeys(("mul", "word_mul"), "{} * {}"),
    "sub": "{} - {}",
    "div": "{} / {}",
    "neg": "-{}",
    "lt": "{} < {}",
    "le": "{} <= {}",
    "gt": "{} > {}",
    "ge": "{} >= {}",
    "eq": "{} == {}",
    "ne": "{} != {}",
    "and": "{} && {}",
    "or": "{} || {}",
    "not": "!{}",
    "nonzero": "{} != 0u",
    "select": "{} ? {} : {}",
    "word_and": "{} & {}",
    "word_or": "{} | {}",
    "word_xor": "{} ^ {}",
    "shl": "{} << {}",
    "lshr": "{} >> {}",
    "signed": "(REAL)(INTEGER){}",
}
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
KINDS = dict.fromkeys(("lt", "le", "gt", "ge", "eq", "ne", "and", "or", "not", "nonzero"), TRUTH)
KINDS |= dict.fromkeys(("bits", "word_add", "word_mul", "word_and", "word_or", "word_xor", "shl", "lshr"), WORD)


@dataclass(frozen=True, eq=False)
class Lines:
    """The machine that writes each operation as a line of C."""

    real: Real
    prefix: str
    calls: set[str]  # primitives
    lines: list[str] = field(default_factory=list)
    fused: bool = False

    def do(self, operation: str, *operands: str) -> str:
        """One operation; its variable."""
        if operation in PRIMITIVES or operation in HARDWARE:
            self.calls.add(operation)
            text = f"{self.prefix}_{operation}{self.real.mark}({', '.join(operands)})"
        else:
            text = TEXTS[operation].format(*operands).replace("REAL", self.real.type)
            text = text.replace("INTEGER", self.real.signed)
        kind = KINDS.get(operation, NUMBER)
        name = f"{'vwt'[(NUMBER, WORD, TRUTH).index(kind)]}{len(self.lines)}"
        type_ = {NUMBER: self.real.type, WORD: self.real.word, TRUTH: "bool"}[kind]
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


def arguments_of(name: str) -> tuple[str, ...]:
    """The arguments of an elementary function."""
    own = {"atan2": ("y", "x"), "fmod": ("x", "y"), "fmin": ("a", "b"), "fmax": ("a", "b")}
    return {**own, **ARGUMENTS}.get(name, ("x",))


def definitions(
    prefix: str, real: Real, functions: Sequence[str], primitives: Sequence[str] = (), hardware: Collection[str] = ()
) -> list[str]:
    """The definitions in C of elementary functions and primitives of a format, with all that they call, in order.

    "turn" is the pair of sine and cosine of one angle; "sin" and "cos" are one of the two. Of `hardware`, "sqrt" and
    "fma", the processor's own are called, and with the second products are rounded together with sums.
    """
    calls = set(primitives)
    written = [_function(Lines(real, prefix, calls, fused="fma" in hardware), name) for name in functions]
    order: list[str] = []

    def need(name: str) -> None:
        for other in NEEDS.get(name, ()) if name not in hardware else ():
            need(other)
        if name not in order:
            order.append(name)

    for name in [*PRIMITIVES, "fma"]:
        if name in calls:
            need(name)
    return [*(primitive(prefix, real, name, hardware) for name in order), *written]


def functions_of(real: Real) -> Mapping[str, Callable[..., Any]]:
    """The elementary functions of a format over the operations of a machine."""
    if real is SINGLE:
        return single_functions.FUNCTIONS
    f = double_functions
    return {
        "exp": f.exponential,
        "tanh": f.hyperbolic_tangent,
        "log": f.logarithm,
        "atan2": f.arc_tangent,
        "fmod": f.remainder,
        "fmin": f.smaller,
        "fmax": f.larger,
        "sign": f.sign,
        "angle": f.reduce_angle,
        "sine_or_cosine": f.sine_or_cosine,
        **DOUBLE.functions,
    }


def _function(machine: Lines, name: str) -> str:
    prefix, real, functions = machine.prefix, machine.real, functions_of(machine.real)
    names = arguments_of(name)
    given = [Number(machine, argument) for argument in names]
    returns = real.type
    if name in ("sin", "cos", "turn"):
        angle = functions["angle"](*given)
        quarters = {"sin": (0,), "cos": (1,), "turn": (0, 1)}[name]
        results = [functions["sine_or_cosine"](angle, quarter).value for quarter in quarters]
    else:
        results = [functions[name](*given).value]
    ends = [f"return {results[0]};"]
    if name == "turn":
        returns = f"{prefix}_pair{real.mark}"
        ends = [f"pair.sine = {results[0]};", f"pair.cosine = {results[1]};", "return pair;"]
        machine.lines.insert(0, f"{returns} pair;")
    lines = [f"    {line}" for line in [*machine.lines, *ends]]
    arguments = ", ".join(f"{real.type} {argument}" for argument in names)
    head = [f"typedef struct {{ {real.type} sine; {real.type} cosine; }} {returns};", ""] if name == "turn" else []
    head += [f"/* {ABOUT[name]} */"]
    return "\n".join([*head, f"static {returns} {prefix}_{name}{real.mark}({arguments})", "{", *lines, "}"])
