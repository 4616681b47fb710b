"""The table of operations: one row for each that a graph or an elementary function asks of a machine.

To add one, write a row here and a line in each spelling, or its formula in `functions`; a test says what is missing.
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from typing import NamedTuple


class Kind(enum.Enum):
    """The kind of an operand or a result: a real number, a truth, or a word with as many bits as a number."""

    NUMBER = "number"
    TRUTH = "truth"
    WORD = "word"


class Tightness(enum.IntEnum):
    """The tightness with which a formula holds together, from that of a choice to that of a name or a call."""

    CHOICE = 0
    LOGIC = 1
    ORDER = 2
    SUM = 3
    PRODUCT = 4
    UNARY = 5
    ATOM = 6


class Role(enum.Flag):
    """The users of an operation.

    MACHINE
        Every machine: elementary functions are made of these alone.
    NODE
        A graph, in the nodes of which it stands.
    SHORT
        A graph, for what a machine does in one or two operations: its formula is in `functions`.
    FUNCTION
        A graph, for an elementary function of `functions`.
    PROGRAM
        The program of a metric's value, which NumPy and a page evaluate.
    """

    MACHINE = enum.auto()
    NODE = enum.auto()
    SHORT = enum.auto()
    FUNCTION = enum.auto()
    PROGRAM = enum.auto()


class Operation(NamedTuple):
    """One row: the kinds of operands and result, the users, and how it is written and counted.

    Attributes
    ----------
    tightness
        The tightness of its formula, in a language that writes one.
    symmetric
        True if its two operands can change places.
    count_words
        The words for it in a count of operations; its name if empty.
    arguments
        The letters of its operands, where it is a function.
    """

    name: str
    operands: tuple[Kind, ...]
    result: Kind
    role: Role
    tightness: Tightness = Tightness.ATOM
    symmetric: bool = False
    count_words: tuple[str, ...] = ()
    arguments: str = ""


_N, _T, _W = Kind.NUMBER, Kind.TRUTH, Kind.WORD
_LOGIC, _ORDER, _SUM, _PRODUCT, _UNARY = list(Tightness)[1:6]
_MACHINE, _PROGRAM, _BOTH = Role.MACHINE, Role.PROGRAM, Role.MACHINE | Role.NODE
_ALL = Role.MACHINE | Role.NODE | Role.PROGRAM
_SHORT, _FUNCTION = Role.NODE | Role.SHORT, Role.NODE | Role.FUNCTION
_DECISION, _MIRROR, _FUSED_WORDS = ("comparison or choice",), ("change of sign",), ("product", "sum")

_ROWS = (
    # of numbers
    Operation("add", (_N, _N), _N, _ALL, _SUM, True, ("sum",)),
    Operation("sub", (_N, _N), _N, _ALL, _SUM, False, ("sum",)),
    Operation("mul", (_N, _N), _N, _ALL, _PRODUCT, True, ("product",)),
    Operation(
        "fma", (_N, _N, _N), _N, _BOTH, _SUM, False, _FUSED_WORDS
    ),  # a b + c; on a machine that fuses products alone
    Operation("fms", (_N, _N, _N), _N, _SHORT, _SUM, False, _FUSED_WORDS),  # a b - c
    Operation("fnma", (_N, _N, _N), _N, _SHORT, _SUM, False, _FUSED_WORDS),  # c - a b
    Operation("div", (_N, _N), _N, _ALL, _PRODUCT, False, ("quotient",)),
    Operation("inv", (_N,), _N, _SHORT, _PRODUCT, False, ("quotient",)),
    Operation("neg", (_N,), _N, _ALL, _UNARY, False, _MIRROR),
    Operation("fabs", (_N,), _N, _ALL, count_words=_MIRROR),
    Operation("copysign", (_N, _N), _N, _BOTH, count_words=_MIRROR, arguments="xy"),
    Operation("sqrt", (_N,), _N, _ALL),
    Operation("floor", (_N,), _N, _ALL),
    Operation("trunc", (_N,), _N, _MACHINE),
    Operation("max", (_N, _N), _N, _PROGRAM),  # NaN passes on, unlike by fmax; -0 is below 0
    Operation("min", (_N, _N), _N, _PROGRAM),
    Operation("isnan", (_N,), _T, _PROGRAM),
    # comparisons, truths and choices
    Operation("lt", (_N, _N), _T, _ALL, _ORDER, False, _DECISION),
    Operation("le", (_N, _N), _T, _ALL, _ORDER, False, _DECISION),
    Operation("gt", (_N, _N), _T, _MACHINE | _PROGRAM, _ORDER),
    Operation("ge", (_N, _N), _T, _MACHINE | _PROGRAM, _ORDER),
    Operation("eq", (_N, _N), _T, _ALL, _ORDER, True, _DECISION),
    Operation("ne", (_N, _N), _T, _ALL, _ORDER, True, _DECISION),
    Operation("and", (_T, _T), _T, _ALL, _LOGIC, True, _DECISION),
    Operation("or", (_T, _T), _T, _ALL, _LOGIC, True, _DECISION),
    Operation("not", (_T,), _T, _ALL, _UNARY, False, _DECISION),
    Operation("select", (_T, _N, _N), _N, _MACHINE | _PROGRAM, Tightness.CHOICE),
    Operation("if_else", (_T, _N, _N), _N, _SHORT, Tightness.CHOICE, False, _DECISION),
    Operation("barrier", (_N,), _N, _SHORT),  # gives its operand; nothing is simplified across it
    # of words, which wrap around, and between words and numbers
    Operation("word_add", (_W, _W), _W, _MACHINE, _SUM),
    Operation("word_mul", (_W, _W), _W, _MACHINE, _PRODUCT),
    Operation("word_and", (_W, _W), _W, _MACHINE, _LOGIC),
    Operation("word_or", (_W, _W), _W, _MACHINE, _LOGIC),
    Operation("word_xor", (_W, _W), _W, _MACHINE, _LOGIC),
    Operation("shl", (_W, _W), _W, _MACHINE, _LOGIC),
    Operation("lshr", (_W, _W), _W, _MACHINE, _LOGIC),
    Operation("nonzero", (_W,), _T, _MACHINE, _ORDER),
    Operation("bits", (_N,), _W, _MACHINE),  # of a number
    Operation("number", (_W,), _N, _MACHINE),  # that has these bits
    Operation("signed", (_W,), _N, _MACHINE, _UNARY),  # the whole number that a signed word is
    # elementary functions
    *(Operation(name, (_N,), _N, _FUNCTION, arguments="x") for name in ("sin", "cos", "exp", "tanh", "log")),
    Operation("atan2", (_N, _N), _N, _FUNCTION, arguments="yx"),
    Operation("fmod", (_N, _N), _N, _FUNCTION, arguments="xy"),
    Operation("fmin", (_N, _N), _N, _FUNCTION, arguments="ab"),
    Operation("fmax", (_N, _N), _N, _FUNCTION, arguments="ab"),
    *(Operation(name, (_N,), _N, _FUNCTION, arguments="x") for name in ("sign", "expm1", "log1p", "sinh", "cosh")),
    *(Operation(name, (_N,), _N, _FUNCTION, arguments="x") for name in ("asinh", "acosh", "atanh")),
    Operation("hypot", (_N, _N), _N, _FUNCTION, arguments="xy"),
)
OPERATIONS: Mapping[str, Operation] = {row.name: row for row in _ROWS}
OF_NUMBERS = frozenset(name for name, row in OPERATIONS.items() if {*row.operands, row.result} == {Kind.NUMBER})


def with_role(role: Role) -> tuple[str, ...]:
    """The names of the operations that have a role."""
    return tuple(name for name, operation in OPERATIONS.items() if role in operation.role)


def gives_truth(name: str) -> bool:
    """True if the result of an operation, or of a source of a graph, is a truth."""
    return name in OPERATIONS and OPERATIONS[name].result is Kind.TRUTH
