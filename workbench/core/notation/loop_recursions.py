"""Expressions with bounded loops on paper: each loop is a recursion with its index and its number of passes.

A loop carries c from pass to pass. In print a letter stands for it, with the index of the entry and of the pass: the
letter with a bar is what each pass makes, with a tilde what it gets, with a hat what all passes get.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import count

import casadi as ca

from workbench.core.bounded_loop import LoopBody, called_loop
from workbench.core.expressions import evaluate_sx
from workbench.core.notation.build import substitute
from workbench.core.notation.formula import Call, Formula, Matrix, Relation, Symbol, System, symbol
from workbench.core.notation.reader import loop_free_formula, read_shared
from workbench.core.validation.signatures import check_arguments

LETTERS = (*"csvzwbdhklmnpq", "alpha", "beta", "gamma", "delta", "kappa", "lambda", "mu", "nu", "xi", "rho")
PARTS = ("a", "u", "g", "r", "t")
INDICES = ("i", "j", "m", "n")  # of a loop, of those inside it, and so on
DOTS = Symbol("...")
MOST_OPERATIONS = 400  # of what is written out: more are a function of the values that a pass has
LISTED = 8  # entries with a line each
SHOWN = 4  # entries of a longer list, the last one among them
UNARY = 1


@dataclass(frozen=True)
class _Sheet:
    """The relations that are written so far, and the symbols of names."""

    symbols: dict[str, Symbol]
    letters: list[str]
    part: str  # the letter of parts that occur more than once
    relations: list[Relation] = field(default_factory=list)
    made: dict[str, tuple[str, int, int]] = field(default_factory=dict)  # by the name: letter, entry and pass
    places: Iterator[int] = field(default_factory=lambda: count(1))  # of shared parts


@check_arguments
def formula_of(expression: ca.SX, names: Mapping[str, str]) -> Formula:
    """An expression as a formula, in its textbook form if it has one.

    Where it calls bounded loops, the answer is a `System`: the recursion of each loop with its index and number of
    passes, and last the value `f`.

    Examples
    --------
    >>> import casadi as ca
    >>> q = ca.SX.sym("q")
    >>> [type(part).__name__ for part in wb.notation.formula_of(2 * q**2, {"q": "q_1"}).factors]
    ['Number', 'Power']
    >>> (end,) = wb.bounded_loop(3, lambda c: (c / 2 + q / c,), q)
    >>> len(wb.notation.formula_of(end, {}).relations)
    4
    """
    if not _has_loops(expression):
        return loop_free_formula(expression, names)
    symbols = {one.name(): symbol(names.get(one.name(), one.name())) for one in ca.symvar(expression)}
    taken = {one.letter for one in symbols.values()}
    part = next((letter for letter in PARTS if letter not in taken), "part")
    sheet = _Sheet(symbols, [letter for letter in LETTERS if letter not in taken], part)
    matrix = ca.densify(expression)
    flat = _cut(sheet, matrix, 0)
    formula = DOTS if _is_long(flat) else _written(sheet, ca.reshape(ca.vertcat(*flat), *matrix.shape))
    return System((*sheet.relations, Relation(Symbol("f" if "f" not in taken else "value"), "=", formula)))


def _has_loops(expression: ca.SX) -> bool:
    symbols = ca.vertcat(ca.SX(0, 1), *ca.symvar(expression))
    function = ca.Function("paper", [symbols], [expression])
    return any(function.instruction_id(k) == ca.OP_CALL for k in range(function.n_instructions()))


def _cut(sheet: _Sheet, expression: ca.SX, depth: int) -> list[ca.SX]:
    """The entries of an expression in which symbols stand for the results of loops, whose recursions are written."""
    symbols = ca.symvar(expression)
    function = ca.Function("paper", [ca.vertcat(ca.SX(0, 1), *symbols)], [ca.densify(expression)])

    def call(function: ca.Function, operands: Sequence[ca.SX]) -> list[ca.SX]:
        loop = called_loop(function)
        if loop is None:
            raise ValueError(
                f"`formula_of(expression)` has no way to write a call of the function {function.name()!r}."
            )
        return _write_loop(sheet, loop, list(operands), depth)

    (entries,) = evaluate_sx(function, lambda _, k: symbols[k], ca.SX, _operation, call)
    return [entries[k] for k in range(expression.numel())]


def _operation(code: int, *operands: ca.SX) -> ca.SX:
    return ca.SX.unary(code, *operands) if len(operands) == UNARY else ca.SX.binary(code, *operands)


def _write_loop(sheet: _Sheet, loop: LoopBody, operands: list[ca.SX], depth: int) -> list[ca.SX]:
    """The symbols of the results of a loop, whose recursion is written."""
    nc, N, place = loop.carry_size, loop.count, INDICES[min(depth, len(INDICES) - 1)]
    letter = sheet.letters.pop(0) if sheet.letters else f"c{len(sheet.made)}"
    carry, rest = operands[:nc], operands[nc:]
    rows: list[list[ca.SX]] = []
    for size in loop.row_sizes:
        block, rest = rest[: size * N], rest[size * N :]
        rows += [block[k::size] for k in range(size)]
    first, last = (N, 0) if loop.backward else (0, N)
    before, after = (f"{place}+1", place) if loop.backward else (place, f"{place}+1")
    start = [Relation(_entry(letter, k, nc, str(first)), "=", f) for k, f in enumerate(_formulas(sheet, carry))]
    sheet.relations.extend(_in_short(start))
    given = [_given(sheet, letter, k, rows, row, place) for k, row in enumerate(rows)]
    shared = _constants(sheet, letter, rest)
    c = [_fresh(sheet, _entry(letter, k, nc, before)) for k in range(nc)]
    columns = [ca.vertcat(ca.SX(0, 1), *part) for part in _split(given, loop.row_sizes)]
    arguments = [ca.vertcat(ca.SX(0, 1), *c), *columns, ca.vertcat(ca.SX(0, 1), *shared)]
    bodies = loop.function.call(arguments, True, False)
    values = ca.vertcat(*(ca.vec(ca.densify(part)) for part in bodies))
    made = sum(loop.result_sizes)
    targets = [_entry(letter, k, nc, after) for k in range(nc)]
    targets += [_entry(letter, k, made, place, "bar") for k in range(made)]
    _write_pass(sheet, targets, values, letter, (before, after, place), depth)
    order = f"{N - 1}, ..., 0" if loop.backward else f"0, ..., {N - 1}"
    sheet.relations.append(Relation(Symbol(place), "=", Symbol(order if N > 1 else "0")))
    ends = [_fresh(sheet, _entry(letter, k, nc, str(last))) for k in range(nc)]
    return [*ends, *_results(sheet, loop, letter, made)]


def _write_pass(
    sheet: _Sheet, targets: list[Symbol], values: ca.SX, letter: str, at: tuple[str, str, str], depth: int
) -> None:
    """The relations of a pass; a long one as a function of the values that it has."""
    before, after, place = at
    left = list(sheet.letters)
    flat = _cut(sheet, values, depth + 1)
    if not _is_long(flat):
        lines = [Relation(t, "=", f) for t, f in zip(targets, _formulas(sheet, flat), strict=True)]
        sheet.relations.extend(_in_short(lines, 2 * LISTED))
        return
    inner = (Symbol(one) for one in left if one not in sheet.letters)
    own = Symbol(letter, before), Symbol(letter, place, accent="tilde"), Symbol(letter, accent="hat")
    pair = Matrix(((Symbol(letter, after),), (Symbol(letter, place, accent="bar"),)))
    sheet.relations.append(Relation(pair, "=", Call(f"F_{letter}", (*own, *inner))))


def _results(sheet: _Sheet, loop: LoopBody, letter: str, made: int) -> list[ca.SX]:
    """Symbols of what the passes make, in the order of the results of the loop."""
    symbols, begin = [], 0
    for size in loop.result_sizes:
        for i in range(loop.count):
            for k in range(begin, begin + size):
                symbols.append(_fresh(sheet, _entry(letter, k, made, str(i), "bar")))
                sheet.made[symbols[-1].name()] = letter, k, i
        begin += size
    return symbols


def _given(sheet: _Sheet, letter: str, k: int, rows: list[list[ca.SX]], row: list[ca.SX], place: str) -> ca.SX:
    """The entry of a column that a pass gets: one that another loop makes in the same pass, or a list of its own."""
    if all(ca.is_equal(one, row[0], 3) for one in row):
        return row[0]
    sources = [sheet.made.get(one.name()) if one.is_symbolic() else None for one in row]
    if sources[0] is not None and all(one == (*sources[0][:2], i) for i, one in enumerate(sources)):
        known = sheet.symbols[row[0].name()]
        return _fresh(sheet, Symbol(known.letter, known.index.removesuffix("0") + place, accent="bar"))
    N, size = len(row), len(rows)
    shown = list(range(N)) if N <= SHOWN else [*range(SHOWN - 1), N - 1]
    left: list[Formula] = [_entry(letter, k, size, str(i), "tilde") for i in shown]
    right = _formulas(sheet, [row[i] for i in shown])
    if N > SHOWN:
        left.insert(-1, DOTS)
        right.insert(-1, DOTS)
    sheet.relations.append(Relation(Matrix((tuple(left),)), "=", Matrix((tuple(right),))))
    return _fresh(sheet, _entry(letter, k, size, place, "tilde"))


def _constants(sheet: _Sheet, letter: str, shared: list[ca.SX]) -> list[ca.SX]:
    """The values that all passes get: symbols and numbers as they are, all else by a name."""
    long = [one for one in shared if not (one.is_symbolic() or one.is_constant())]
    names = {id(one): _entry(letter, k, len(long), "", "hat") for k, one in enumerate(long)}
    relations = [Relation(names[id(x)], "=", f) for x, f in zip(long, _formulas(sheet, long), strict=True)]
    sheet.relations.extend(_in_short(relations))
    return [_fresh(sheet, names[id(one)]) if id(one) in names else one for one in shared]


def _in_short(relations: list[Relation], most: int = LISTED) -> list[Relation]:
    """The first and the last of many relations."""
    return relations if len(relations) <= most else [relations[0], Relation(DOTS, "=", DOTS), relations[-1]]


def _entry(letter: str, k: int, count: int, place: str, accent: str = "") -> Symbol:
    """The symbol of entry k, of several, at a pass."""
    return Symbol(letter, ",".join(filter(None, (str(k + 1) if count > 1 else "", place))), accent=accent)


def _fresh(sheet: _Sheet, printed_as: Symbol) -> ca.SX:
    """A new symbol, and how it is printed."""
    name = f"{printed_as.letter} {printed_as.accent} {printed_as.index}"
    sheet.symbols[name] = printed_as
    return ca.SX.sym(name)


def _is_long(entries: Sequence[ca.SX]) -> bool:
    """True if entries take more operations than a reader follows."""
    expression = ca.vertcat(ca.SX(0, 1), *entries)
    function = ca.Function("paper", [ca.vertcat(ca.SX(0, 1), *ca.symvar(expression))], [expression])
    return int(function.n_instructions()) > MOST_OPERATIONS


def _formulas(sheet: _Sheet, entries: Sequence[ca.SX]) -> list[Formula]:
    """The formulas of entries, or dots for long ones."""
    if not entries or _is_long(entries):
        return [DOTS] * len(entries)
    formula = _written(sheet, ca.vertcat(*entries))
    return [row[0] for row in formula.rows] if isinstance(formula, Matrix) else [formula]


def _written(sheet: _Sheet, expression: ca.SX) -> Formula:
    """The formula of an expression without loops, behind the parts of it that occur more than once."""
    table = {one.name(): sheet.symbols[one.name()] for one in ca.symvar(expression)}
    definitions, formula = read_shared(expression, table)
    meanings: dict[Symbol, Formula] = {}
    for one in definitions:
        name = Symbol(sheet.part, str(next(sheet.places)))
        sheet.relations.append(Relation(name, "=", substitute(one.right, meanings)))
        if isinstance(one.left, Symbol):
            meanings[one.left] = name
    return substitute(formula, meanings)


def _split(entries: list[ca.SX], sizes: Sequence[int]) -> list[list[ca.SX]]:
    """Entries in parts of some sizes."""
    ends = [sum(sizes[: i + 1]) for i in range(len(sizes))]
    return [entries[end - size : end] for end, size in zip(ends, sizes, strict=True)]
