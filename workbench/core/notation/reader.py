"""From a CasADi expression to the formula that one would write for it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import cache, partial

import casadi as ca

from workbench.core.notation import build
from workbench.core.notation.build import ONE, ZERO, number
from workbench.core.notation.formula import (
    Cases,
    Formula,
    Matrix,
    Number,
    Relation,
    Symbol,
    children,
    symbol,
    symbols_of,
)
from workbench.core.notation.normal_form import NotInClass, to_formula
from workbench.core.notation.program import NAMES, ExpressionNode, Walk, split, walk
from workbench.core.notation.writer import measure
from workbench.core.validation.signatures import check_arguments

MOST_SYMBOLS, DEEPEST = 20_000, 150  # a longer formula tells a reader nothing, and takes too long to typeset
WORTH_A_NAME = 5  # symbols and operations of a shared part
# A textbook form is expanded, so it is tried on small expressions only, and printed if no entry takes more than some
# five lines of a page, in widths of a digit.
MOST_NODES_OF_TEXTBOOKS, LONGEST_ENTRY = 2_000, 400.0

TWO = Number(Fraction(2))
OPERATIONS: dict[int, Callable[..., Formula]] = {
    ca.OP_ASSIGN: lambda x: x,
    ca.OP_ADD: lambda x, y: build.total((x, y)),
    ca.OP_SUB: lambda x, y: build.total((x, build.negative(y))),
    ca.OP_MUL: lambda x, y: build.product((x, y)),
    ca.OP_DIV: build.quotient,
    ca.OP_NEG: build.negative,
    ca.OP_INV: lambda x: build.quotient(ONE, x),
    ca.OP_TWICE: lambda x: build.product((TWO, x)),
    ca.OP_SQ: lambda x: build.power(x, TWO),
    ca.OP_POW: build.power,
    ca.OP_CONSTPOW: build.power,
    ca.OP_LT: lambda x, y: build.condition(x, "<", y),
    ca.OP_LE: lambda x, y: build.condition(x, "<=", y),
    ca.OP_EQ: lambda x, y: build.condition(x, "==", y),
    ca.OP_NE: lambda x, y: build.condition(x, "!=", y),
}
CONDITIONAL: dict[int, Callable[..., Formula]] = {
    ca.OP_AND: lambda x, y: Relation(build.truth(x), "and", build.truth(y)),
    ca.OP_OR: lambda x, y: Relation(build.truth(x), "or", build.truth(y)),
    ca.OP_NOT: build.negation,
    ca.OP_IF_ELSE_ZERO: lambda c, x: Cases(((build.value(x), build.truth(c)),), ZERO),
}
FUNCTIONS = (
    "sin cos tan asin acos atan atan2 sinh cosh tanh asinh acosh atanh exp log sqrt fabs fmin fmax fmod sign floor "
    "ceil erf hypot copysign log1p expm1"
)
SAME = {"fabs": "abs", "fmin": "min", "fmax": "max", "fmod": "mod"}  # names in CasADi, and in mathematics
OPERATIONS |= {
    getattr(ca, f"OP_{name.upper()}"): partial(build.call, SAME.get(name, name)) for name in FUNCTIONS.split()
}


@check_arguments
def read(expression: ca.SX, symbols: Mapping[str, Symbol] | None = None) -> Formula:
    """The formula of an expression or a matrix of them, in the order of the code.

    `symbols` holds the printed symbols by name; others are read by `formula.symbol`. An operation that cannot be
    written, a constant that is not finite, two names printed alike and an endless formula are refused.
    """
    steps = walk(expression)
    _refuse_endless(steps)
    return _matrix(steps, _formulas(steps, symbols, {}))


@check_arguments
def read_shared(expression: ca.SX, symbols: Mapping[str, Symbol] | None = None) -> tuple[tuple[Relation, ...], Formula]:
    """Definitions `w_1 = ...` of the parts that occur more than once, each after those it uses, and the formula.

    The letter is the first of w, z, v, u, a that is not taken.
    """
    steps = walk(expression, cse=True)
    shared = _shared_nodes(steps)
    table = symbols_of(steps.names, symbols)
    taken = {symbol.letter for symbol in table.values()}
    letter = next((letter for letter in "wzvua" if letter not in taken), "shared")
    names = {place: Symbol(letter, str(i)) for i, place in enumerate(shared, start=1)}
    _refuse_endless(steps, frozenset(shared))
    formula = _formulas(steps, symbols, names)
    definitions = tuple(Relation(names[place], "=", formula(place)) for place in shared)
    return definitions, _matrix(steps, lambda place: names[place] if place in names else formula(place))


def loop_free_formula(expression: ca.SX, names: Mapping[str, str]) -> Formula:
    """An expression without loops as a formula, in its textbook form if it has one."""
    symbols = {name: symbol(symbols_of) for name, symbols_of in names.items()}
    try:
        return to_formula(expression, symbols)
    except NotInClass:
        return read(expression, symbols)


def equations_of(
    matrices: Mapping[str, ca.SX], names: Mapping[str, str]
) -> tuple[tuple[Relation, ...], list[Relation]]:
    """Matrices with equal numbers of rows in print: definitions of shared parts, and an equation for each matrix.

    If no entry in its textbook form is longer than `LONGEST_ENTRY`, that form is taken, and nothing is defined.
    """
    symbols = {name: symbol(symbols_of) for name, symbols_of in names.items()}
    together = ca.horzcat(*matrices.values())
    if ca.n_nodes(together) <= MOST_NODES_OF_TEXTBOOKS:
        try:
            formulas = [to_formula(matrix, symbols) for matrix in matrices.values()]
        except NotInClass:
            formulas = []
        entries = (entry for formula in formulas for entry in (children(formula) or (formula,)))
        if formulas and max(map(measure, entries)) <= LONGEST_ENTRY:
            return (), [Relation(symbol(letter), "=", x) for letter, x in zip(matrices, formulas, strict=True)]
    definitions, formula = read_shared(together, symbols)
    parts = split(matrices, formula.rows if isinstance(formula, Matrix) else ((formula,),))
    return definitions, [Relation(symbol(letter), "=", Matrix(rows)) for letter, rows in parts.items()]


def _matrix(steps: Walk, formula: Callable[[int], Formula]) -> Formula:
    rows = tuple(tuple(formula(place) for place in row) for row in steps.entries)
    return rows[0][0] if len(rows) == len(rows[0]) == 1 else Matrix(rows)


def _formulas(
    steps: Walk, symbols: Mapping[str, Symbol] | None, names: Mapping[int, Symbol]
) -> Callable[[int], Formula]:
    """The formula of every node by its place, in which other nodes that have a name are written by it."""
    table = symbols_of(steps.names, symbols)
    formulas: list[Formula] = []

    @cache
    def tidy(place: int) -> Formula:
        return build.collect_terms(formulas[place])

    def operand(node: ExpressionNode, k: int) -> Formula:
        place = node.operands[k]
        if place in names:
            return names[place]
        # A sum that goes on is tidied when it ends: a thousand terms are compared once, not a thousand times.
        return formulas[place] if _flat(steps, node, k) else tidy(place)

    for node in steps.nodes:
        formulas.append(_formula(node, [operand(node, k) for k in range(len(node.operands))], table))
    return tidy


def _formula(node: ExpressionNode, operands: list[Formula], table: Mapping[str, Symbol]) -> Formula:
    if node.code == ca.OP_CONST:
        return number(node.value)
    if node.code == ca.OP_INPUT:
        return table[node.name]
    if node.code in CONDITIONAL:
        return CONDITIONAL[node.code](*operands)
    if node.code not in OPERATIONS:
        raise ValueError(f"`read(expression)` has no way to write the operation {NAMES.get(node.code, node.code)}.")
    return OPERATIONS[node.code](*map(build.value, operands))


def _shared_nodes(steps: Walk) -> list[int]:
    uses = [0] * len(steps.nodes)
    for place in [i for node in steps.nodes for i in node.operands] + list({i for row in steps.entries for i in row}):
        uses[place] += 1  # entries that are equal are one use: they name each other
    sizes: list[int] = []
    shared = []
    for place, node in enumerate(steps.nodes):
        sizes.append(1 + sum(sizes[i] for i in node.operands))
        if uses[place] > 1 and sizes[place] >= WORTH_A_NAME:
            shared.append(place)
            sizes[place] = 1
    return shared


def _refuse_endless(steps: Walk, named_nodes: frozenset[int] = frozenset()) -> None:
    sizes: list[int] = []
    depths: list[int] = []
    largest = deepest = 0
    for place, node in enumerate(steps.nodes):
        size = 1 + sum(sizes[i] for i in node.operands)
        depth = max((depths[i] + (not _flat(steps, node, k)) for k, i in enumerate(node.operands)), default=0)
        largest, deepest = max(largest, size), max(deepest, depth)
        sizes.append(1 if place in named_nodes else size)
        depths.append(0 if place in named_nodes else depth)
    if largest > MOST_SYMBOLS or deepest > DEEPEST:
        raise ValueError(
            f"`read(expression)` writes formulas of at most {MOST_SYMBOLS} symbols, nested {DEEPEST} deep; this one "
            f"has {largest:.3g}, nested {deepest} deep. `read_shared` gives names to the parts that occur often."
        )


def _flat(steps: Walk, node: ExpressionNode, k: int) -> bool:
    """True if operand number k stands on the same level of the page: sums in a sum, products in a product."""
    inner = steps.nodes[node.operands[k]].code
    if node.code == ca.OP_MUL:
        return inner == ca.OP_MUL
    return inner in (ca.OP_ADD, ca.OP_SUB) and (node.code == ca.OP_ADD or (node.code == ca.OP_SUB and k == 0))
