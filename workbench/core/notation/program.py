"""Expressions as lists of operations, and as programs without branches in the text of a language.

A program keeps CasADi's order and grouping, so that it rounds alike; a formula, which is tidied for the eye, does not.
"""

from __future__ import annotations

import keyword
import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import count
from typing import TypeVar

import casadi as ca

from workbench.core.notation.formula import Symbol, name_of, symbol
from workbench.core.validation.signatures import check_arguments

T = TypeVar("T")
NAMES = {int(getattr(ca, name)): name.removeprefix("OP_") for name in dir(ca) if name.startswith("OP_")}

# The tightness of a text: a looser one in a tighter place gets parentheses.
SUM, PRODUCT, ATOM = range(3)
# Of a + (b + c) and of a*(b*c) the parentheses stay, for without them other numbers would be rounded.
SIGNS = {
    ca.OP_ADD: ("{} + {}", SUM, (SUM, PRODUCT)),
    ca.OP_SUB: ("{} - {}", SUM, (SUM, PRODUCT)),
    ca.OP_MUL: ("{}*{}", PRODUCT, (PRODUCT, ATOM)),
    ca.OP_DIV: ("{}/{}", PRODUCT, (PRODUCT, ATOM)),
    ca.OP_NEG: ("-{}", PRODUCT, (ATOM,)),
    ca.OP_INV: ("1.0/{}", PRODUCT, (ATOM,)),
    ca.OP_TWICE: ("2.0*{}", PRODUCT, (ATOM,)),
    ca.OP_SQ: ("{0}*{0}", PRODUCT, (ATOM,)),
    # As numbers, for the difference of two truths is refused by NumPy.
    ca.OP_SIGN: ("(1.0*({0} > 0.0) - 1.0*({0} < 0.0))", ATOM, (ATOM,)),
}
WRITTEN_TWICE = {ca.OP_SQ, ca.OP_SIGN}  # so their operand has a variable
# Functions, by the names that they have in C.
FUNCTION_NAMES = (
    "sin cos tan asin acos atan atan2 sinh cosh tanh asinh acosh atanh exp log sqrt fabs fmin fmax fmod floor pow "
)
FUNCTION_NAMES += "ceil log1p expm1 hypot copysign"
FUNCTIONS = {getattr(ca, f"OP_{name.upper()}"): name for name in FUNCTION_NAMES.split()} | {ca.OP_CONSTPOW: "pow"}
# Truths and what is chosen by them, which each language writes in its own way.
CHOICE_NAMES = "lt le eq ne and or not if_else_zero"
CHOICES = {getattr(ca, f"OP_{name.upper()}"): name for name in CHOICE_NAMES.split()}


@dataclass(frozen=True)
class ExpressionNode:
    """One node of an expression: the code of its operation, the places of its operands, and its name or value.

    A call of a function, as of a bounded loop, has a node for each of its results, which depend on all its arguments.
    """

    code: int
    operands: tuple[int, ...]
    value: float = 0.0
    name: str = ""


@dataclass(frozen=True)
class Walk:
    """The nodes of an expression in the order of evaluation, and the place of each entry by row and column."""

    nodes: tuple[ExpressionNode, ...]
    entries: tuple[tuple[int, ...], ...]

    @property
    def names(self) -> list[str]:
        """The names of the symbols."""
        return [node.name for node in self.nodes if node.code == ca.OP_INPUT]


@check_arguments
def walk(expression: ca.SX, *, cse: bool = False) -> Walk:
    """The operations of a matrix (n, m) of expressions, each after its operands; with `cse`, equal ones become one."""
    matrix = ca.densify(ca.SX(expression))
    if matrix.numel() == 0:
        raise ValueError(f"An expression to be read must have entries; this one has shape {matrix.shape}.")
    symbols = ca.symvar(matrix)
    names = [symbol.name() for symbol in symbols]
    if twice := sorted(name for name, times in Counter(names).items() if times > 1):
        raise ValueError(f"Symbols are told apart by name, but two different ones are called {twice[0]!r}.")
    function = ca.Function("walk", [ca.vertcat(*symbols)], [matrix], {"cse": cse, "allow_free": False})
    nodes, places = _nodes(function, names)
    n, m = matrix.shape
    return Walk(tuple(nodes), tuple(tuple(places[i + n * j] for j in range(m)) for i in range(n)))


def _nodes(function: ca.Function, names: list[str]) -> tuple[list[ExpressionNode], dict[int, int]]:
    nodes: list[ExpressionNode] = []
    registers: dict[int, int] = {}
    outputs: dict[int, int] = {}
    for k in range(function.n_instructions()):
        code = function.instruction_id(k)
        reads, writes = function.instruction_input(k), function.instruction_output(k)
        if code == ca.OP_OUTPUT:
            outputs[writes[1]] = registers[reads[0]]
            continue
        if code == ca.OP_INPUT:
            node = ExpressionNode(code, (), name=names[reads[1]])
        elif code == ca.OP_CONST:
            node = ExpressionNode(code, (), value=function.instruction_constant(k))
        else:
            node = ExpressionNode(code, tuple(registers[read] for read in reads if read >= 0))
        for write in (one for one in writes if one >= 0):  # a called function has several results, or leaves some out
            registers[write] = len(nodes)
            nodes.append(node)
    return nodes, outputs


@dataclass(frozen=True)
@check_arguments
class Dialect:
    """A language: its spelling of functions that C calls otherwise, its reserved words, and the length of a line.

    `choices` are the forms of the operations of `CHOICES`, by their names there, of a language that is to have them.
    """

    spellings: Mapping[str, str]
    reserved_words: frozenset[str]
    width: int
    choices: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Program:
    """Assignments in order, and the entries of matrices in their terms."""

    inputs: tuple[tuple[str, str], ...]  # variables with the names of their symbols
    lines: tuple[tuple[str, str], ...]  # variables with the text that they are assigned
    entries: Mapping[str, tuple[tuple[str, ...], ...]]  # the rows of each matrix
    functions: tuple[str, ...]  # the spelling of those that are called


@dataclass(frozen=True)
class _Text:
    text: str
    tightness: int

    def within(self, least: int) -> str:
        return self.text if self.tightness >= least else f"({self.text})"


@check_arguments
def straight_line(matrices: Mapping[str, ca.SX], letters: Mapping[str, str], dialect: Dialect) -> Program:
    """The program that computes matrices with equal numbers of rows, without branches, in letters by symbols' names.

    A part that is used more than once has a variable, and so have the parts of too long a line.
    """
    steps = walk(ca.horzcat(*matrices.values()), cse=True)
    taken = set(dialect.reserved_words)
    inputs = {x.name: _free(letters.get(x.name, x.name), taken) for x in steps.nodes if x.code == ca.OP_INPUT}
    names = _entry_names(steps, matrices, taken)
    parts = (name for k in count(1) if (name := f"w_{k}") not in taken)
    texts: list[_Text] = []
    lines: list[tuple[str, str]] = []

    def assign(place: int) -> None:
        name = names[place] if place in names else next(parts)
        lines.append((name, texts[place].text))
        texts[place] = _Text(name, ATOM)

    uses = Counter(i for node in steps.nodes for i in node.operands)
    for place, node in enumerate(steps.nodes):
        if node.code in WRITTEN_TWICE and not texts[node.operands[0]].text.isidentifier():
            assign(node.operands[0])
        while len((text := _compose(node, inputs, texts, dialect)).text) > dialect.width:
            longest = max(node.operands, key=lambda i: len(texts[i].text))
            if texts[longest].tightness == ATOM and texts[longest].text.isidentifier():
                break
            assign(longest)
        texts.append(text)
        if node.operands and (uses[place] > 1 or place in names):
            assign(place)
    called = {_spelling(node, dialect) for node in steps.nodes if node.code in FUNCTIONS}
    entries = split(matrices, [[texts[place].text for place in row] for row in steps.entries])
    return Program(tuple((v, name) for name, v in inputs.items()), tuple(lines), entries, tuple(sorted(called)))


@check_arguments
def identifier(symbol: Symbol) -> str:
    """The variable for a symbol: its name, with characters that no variable may have in hexadecimal."""
    name = re.sub(r"[^A-Za-z0-9_]", lambda match: f"_x{ord(match[0]):x}_", name_of(symbol))
    if not name or name[0].isdigit():
        name = f"_{name}"
    return f"{name}_" if keyword.iskeyword(name) else name


def _free(name: str, names_taken: set[str]) -> str:
    variable = identifier(symbol(name))
    while variable in names_taken:
        variable += "_"
    names_taken.add(variable)
    return variable


def _entry_names(steps: Walk, matrices: Mapping[str, ca.SX], names_taken: set[str]) -> dict[int, str]:
    """The name of each computed entry, after the first place at which it stands."""
    named: dict[int, str] = {}
    for letter, rows in split(matrices, steps.entries).items():
        between = "_" if max(matrices[letter].shape) > 9 else ""
        for i, row in enumerate(rows, start=1):
            for j, place in enumerate(row, start=1):
                if steps.nodes[place].operands and place not in named:
                    named[place] = _free(f"{letter}_{i}{between}{j}" if len(row) > 1 else f"{letter}_{i}", names_taken)
    return named


def split(matrices: Mapping[str, ca.SX], rows: Sequence[Sequence[T]]) -> dict[str, tuple[tuple[T, ...], ...]]:
    """Rows across matrices side by side, as rows of each."""
    entries, start = {}, 0
    for letter, matrix in matrices.items():
        entries[letter] = tuple(tuple(row[start : start + matrix.shape[1]]) for row in rows)
        start += matrix.shape[1]
    return entries


def _compose(node: ExpressionNode, inputs: Mapping[str, str], texts: list[_Text], dialect: Dialect) -> _Text:
    if node.code == ca.OP_INPUT:
        return _Text(inputs[node.name], ATOM)
    if node.code == ca.OP_CONST:
        if not math.isfinite(node.value):
            raise ValueError(f"A program holds finite constants; the expression holds {node.value}.")
        return _Text(repr(node.value), ATOM if node.value >= 0 else PRODUCT)
    operands = [texts[i] for i in node.operands]
    if node.code in SIGNS:
        form, tightness, least = SIGNS[node.code]
        return _Text(form.format(*(x.within(t) for x, t in zip(operands, least, strict=True))), tightness)
    if (choice := CHOICES.get(node.code, "")) in dialect.choices:
        return _Text(f"({dialect.choices[choice].format(*(x.within(ATOM) for x in operands))})", ATOM)
    return _Text(f"{_spelling(node, dialect)}({', '.join(x.text for x in operands)})", ATOM)


def _spelling(node: ExpressionNode, dialect: Dialect) -> str:
    if node.code not in FUNCTIONS:
        raise ValueError(
            "A program is written without branches, of arithmetic and elementary functions; "
            f"this expression holds the operation {NAMES.get(node.code, node.code)}."
        )
    name = FUNCTIONS[node.code]
    return dialect.spellings.get(name, name)
