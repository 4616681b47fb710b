r"""A sheet: the equations of a paper as one types them, read as entries of M, C and G of an arm.

Each statement has the form `name = formula`, in text (`M[1,1] = m_1*l_1^2 + I_1`) or LaTeX
(`M(q) = \begin{bmatrix} ... \end{bmatrix}`). It prints

    a matrix       M = [[a, b], [c, d]],  C(q, qd) = ...,  G = [a, b]
    an entry       M[1,2] = ...,  M_12 = ...,  G_1 = ...
    a declaration  l_c1 = links[0].com,  theta_1 = q_1,  c_2 = cos(q_2),  h = m_2*l_1*l_c2*sin(q_2)
    a number       links[0].offset = 0,  m_1 = 2.5

The robot's own letters (those that `workbench derive` prints) and paths need no declaration, and one
comes before a letter of the robot; q_i may also be written theta_i, and qd_i as q_i', dq_i, qdot_i. A declared
angle takes its rate with it: with theta_2 = q_1 + q_2, theta_2' is qd_1 + qd_2.
A number holds for the robot too, as the fraction that it is printed as; so does 0 for what is 0 in the robot and
never printed on the sheet. A formula of constants for a letter of the robot would hold on one side, and is refused.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from graphlib import CycleError, TopologicalSorter

from workbench.arms.dynamics import Dynamics
from workbench.arms.paper_equations.arm_letters import names_of, numbers_given, parameter_of, rate_of, unnamed_zeros
from workbench.arms.paper_equations.formula_values import check_depth, expanded_size
from workbench.arms.paper_equations.grammar import parse
from workbench.arms.paper_equations.statements import Language, Statement, statements
from workbench.arms.paper_equations.tokens import FormulaError, Key, Names, Token, key_of, refusal, spelled_symbol
from workbench.core.notation.build import parts, substitute
from workbench.core.notation.formula import Formula, Matrix, Number, Symbol, letters, name_of
from workbench.core.validation.signatures import check_arguments

# Beyond these an entry is no equation that a paper prints, and would take minutes to judge.
MOST_SYMBOLS, MOST_TERMS, MOST_TERMS_IN_ALL = 5_000, 1_000, 4_000
SMALLEST, LARGEST = 1e-99, 1e99
MOST_NAMES = 8  # of a circle of declarations

Place = tuple[str, int, int]


@dataclass(frozen=True)
class Sheet:
    """The printed entries by their place (matrix, row, column; counted from 1), declarations written out.

    Their symbols are those by which the derived arm is printed, and pi. `numbers` holds the numbers that the
    sheet gives to parameters, and zeros for those that are zero in the arm and not on the sheet: `zeros`.
    """

    entries: Mapping[Place, Formula]
    numbers: Mapping[str, Fraction]
    zeros: frozenset[str] = frozenset()

    @property
    def fixed_values(self) -> dict[str, float]:
        """The numbers that the sheet gives, as doubles."""
        return {label: float(value) for label, value in self.numbers.items()}


@check_arguments
def read_sheet(text: str, dynamics: Dynamics, language: Language) -> Sheet:
    """The entries of M, C and G that a text prints.

    A `FormulaError` tells the place of what is no statement, an unknown name, a matrix of another size, an entry
    printed twice, declared by itself or too long, and a formula of constants for a letter of the robot.
    """
    declared, printed, rest = _sort_statements(statements(text, language), dynamics.dof)
    given = numbers_given(declared, dynamics)
    declared = {name: statement for name, statement in declared.items() if name not in given}
    names = names_of(dynamics, printed, declared)
    entries = _entries(rest, names, dynamics.dof, printed)
    if not entries:
        raise FormulaError(
            "no entry of M, C or G is printed here: write `M[1,1] = ...`, or `M = [[..., ...], [..., ...]]`, with the "
            "letters M, C and G of M(q) qdd + C(q, qd) qd + G(q) = tau."
        )
    joints = {Symbol("q", str(i)): Symbol("q", str(i), 1) for i in range(1, dynamics.dof + 1)}
    meanings = {name: (parse(statement.right, names), statement.name) for name, statement in declared.items()}
    in_order = sorted(entries, key=lambda place: ("MCG".index(place[0]), place))
    places = {_entry_symbol(place): place for place in in_order}
    reading = _Declarations(joints, meanings | {letter: entries[place] for letter, place in places.items()})
    bound: dict[Symbol, str] = {}
    for name, statement in declared.items():
        is_path = len(statement.right) == 1 and statement.right[0].text in dynamics.p.labels
        if not is_path and (path := parameter_of(name, statement, dynamics)):
            bound[name] = path
    resolved = reading.resolve([*places, *bound])
    for name, path in bound.items():
        if not any(letter in joints or letter.dots for letter in letters(resolved[name])):
            why = "to which a sheet gives a number or nothing, as a formula would not hold for the robot too"
            said = f"'{declared[name].name.quotation}' is this robot's letter for {path}, {why}; choose another letter."
            raise refusal(declared[name].name, said)
    written = {place: resolved[letter] for letter, place in places.items()}
    for place, formula in written.items():
        _refuse_length(formula, entries[place][1])
    if sum(map(expanded_size, written.values())) > MOST_TERMS_IN_ALL:
        raise FormulaError(
            f"multiplied out, these entries have more than {MOST_TERMS_IN_ALL} terms; put them into several files."
        )
    numbers = dict(given.values())
    zeros = unnamed_zeros(written.values(), dynamics).difference(numbers)
    return Sheet(written, dict.fromkeys(sorted(zeros), Fraction(0)) | numbers, zeros)


def _sort_statements(
    all_statements: Iterable[Statement], n: int
) -> tuple[dict[Symbol, Statement], dict[Symbol, Place], list[tuple[Place | str, Statement]]]:
    """The declarations and the single entries, each by its name, and all printed entries."""
    declared: dict[Symbol, Statement] = {}
    keys: set[Key] = set()
    printed: dict[Symbol, Place] = {}
    rest: list[tuple[Place | str, Statement]] = []
    for statement in all_statements:
        name = spelled_symbol(statement.name.text, statement.name.index, statement.name.dots)
        place = _place(name, statement, n)
        if place is None:
            own = replace(name, bold=True)
            if key_of(own) in keys:
                raise refusal(statement.name, f"'{statement.name.quotation}' is declared twice; keep one of the two.")
            keys.add(key_of(own))
            declared[own] = statement
        else:
            rest.append((place, statement))
            if not isinstance(place, str):
                printed[_entry_symbol(place)] = place
    return declared, printed, rest


def _entry_symbol(place: Place) -> Symbol:
    matrix, row, column = place
    return Symbol(matrix, f"{row}" if matrix == "G" else f"{row},{column}", bold=True)


def _place(name: Symbol, statement: Statement, n: int) -> Place | str | None:
    if name.letter not in "MCG" or name.dots or name.accent or name.mark:
        return None
    numbers = statement.place
    if name.index and not numbers:
        parts = name.index.split(",") if "," in name.index else list(name.index)
        if not all(part.isdecimal() for part in parts):
            return None
        numbers = tuple(map(int, parts))
        if n == 1 and len(numbers) == 1:  # M_1 of a single joint
            numbers = (numbers[0], 1)
        if len(numbers) != 2 and (name.letter != "G" or len(numbers) > 1):
            return None
    if not numbers:
        return name.letter
    if name.letter == "G" and len(numbers) == 2 and numbers[1] != 1:
        raise refusal(statement.name, "G is a vector: its entries are G[1], G[2], ....")
    if name.letter != "G" and len(numbers) == 1:
        raise refusal(statement.name, f"an entry of {name.letter} has a row and a column, as in {name.letter}[1,2].")
    return name.letter, numbers[0], 1 if name.letter == "G" else numbers[1]


def _entries(
    rest: Iterable[tuple[Place | str, Statement]], names: Names, n: int, printed_symbols: Mapping[Symbol, Place]
) -> dict[Place, tuple[Formula, Token]]:
    entries: dict[Place, tuple[Formula, Token]] = {}
    for place, statement in rest:
        formula = parse(statement.right, names)
        for one, entry in _single_entries(place, formula, n, statement.name):
            if isinstance(entry, Symbol) and entry.bold and printed_symbols.get(entry) == one:
                continue  # M = [[M_11, M_12], ...] says nothing that M_11 = ... does not
            if one in entries:
                raise refusal(statement.name, f"{one[0]}[{one[1]},{one[2]}] is printed twice; keep one of the two.")
            entries[one] = entry, statement.name
    return entries


def _single_entries(place: Place | str, formula: Formula, n: int, name: Token) -> Iterator[tuple[Place, Formula]]:
    if not isinstance(place, str):
        matrix, i, j = place
        if not is_place(place, n):
            raise refusal(name, f"this robot has {n} joint{'s' if n > 1 else ''}: there is no {matrix}[{i},{j}].")
        if isinstance(formula, Matrix):
            raise refusal(name, f"{matrix}[{i},{j}] is one number; got a matrix.")
        yield place, formula
        return
    rows = formula.rows if isinstance(formula, Matrix) else ((formula,),)
    if place == "G" and len(rows) == 1:
        rows = tuple((entry,) for entry in rows[0])
    shape, wanted = (len(rows), len(rows[0])), (n, 1 if place == "G" else n)
    if shape != wanted:
        raise refusal(name, f"{place} of this robot is {wanted[0]} by {wanted[1]}; got {shape[0]} by {shape[1]}.")
    for i, row in enumerate(rows, start=1):
        for j, entry in enumerate(row, start=1):
            yield (place, i, j), entry


def is_place(place: Place, n: int) -> bool:
    """True if M, C or G of so many joints has such an entry."""
    matrix, row, column = place
    return matrix in ("M", "C", "G") and 1 <= row <= n and 1 <= column <= (1 if matrix == "G" else n)


def _refuse_length(formula: Formula, name: Token) -> None:
    if expanded_size(formula) > MOST_TERMS:
        raise refusal(name, f"multiplied out, this entry has more than {MOST_TERMS} terms; print it in a simpler form.")
    for part in parts(formula):
        if isinstance(part, Number) and part.value != 0 and not SMALLEST < abs(Fraction(part.value)) < LARGEST:
            raise refusal(name, f"an entry holds numbers between {SMALLEST:g} and {LARGEST:g}, and zero.")


@dataclass(frozen=True)
class _Declarations:
    """The meanings of the names of a sheet, each with its place, and the joints' velocities by their angles."""

    joints: Mapping[Symbol, Symbol]
    meanings: Mapping[Symbol, tuple[Formula, Token]]

    def resolve(self, targets: Iterable[Symbol]) -> dict[Symbol, Formula]:
        """The wanted names, and all that they need, with all declarations in place of their names."""
        needs: dict[Symbol, list[Symbol]] = {}
        waiting = list(targets)
        while waiting:
            letter = waiting.pop()
            if letter not in needs:
                needs[letter] = self.needs(letter)
                waiting += needs[letter]
        resolved: dict[Symbol, Formula] = {}
        try:
            for letter in TopologicalSorter(needs).static_order():
                resolved[letter] = self.written_out(letter, resolved)
        except CycleError as error:
            raise self.circle(error.args[1]) from None
        return resolved

    def needs(self, letter: Symbol) -> list[Symbol]:
        """The names of the sheet in a name's meaning; the rate of an angle needs that angle."""
        if letter not in self.meanings:
            return [replace(letter, dots=0)]
        return [part for part in letters(self.meanings[letter][0]) if part.bold]

    def circle(self, ring: Sequence[Symbol]) -> FormulaError:
        shown = [name_of(letter) for letter in reversed(ring)]
        if len(shown) > MOST_NAMES:
            shown[MOST_NAMES // 2 : -MOST_NAMES // 2] = ["..."]
        place = next(self.meanings[letter][1] for letter in ring if letter in self.meanings)
        return refusal(place, f"'{place.quotation}' is declared by itself: {' needs '.join(shown)}.")

    def written_out(self, letter: Symbol, resolved_formulas: Mapping[Symbol, Formula]) -> Formula:
        if letter not in self.meanings:
            return self.rate(letter, resolved_formulas)
        formula, name = self.meanings[letter]
        used = self.needs(letter)
        if any(isinstance(resolved_formulas[part], Matrix) for part in used):
            raise refusal(name, "a matrix under another name is not read; print it as M, C or G itself.")
        if sum(1 for one in (formula, *(resolved_formulas[part] for part in used)) for _ in parts(one)) > MOST_SYMBOLS:
            raise refusal(name, f"with its declarations written out, this has more than {MOST_SYMBOLS} symbols.")
        return check_depth(substitute(formula, resolved_formulas), name) if used else formula

    def rate(self, letter: Symbol, resolved_formulas: Mapping[Symbol, Formula]) -> Formula:
        angle = replace(letter, dots=0)
        if (rate := rate_of(resolved_formulas[angle], self.joints)) is None:
            name = next(name for formula, name in self.meanings.values() if letter in letters(formula))
            why = "which is found only where that is a sum of joint angles times constants"
            wrong = f"'{name.quotation}' takes the rate of '{name_of(angle)}'"
            raise refusal(name, f"{wrong}, {why}; declare it: `{name_of(letter)} = ...`.")
        return rate
