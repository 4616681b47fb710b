"""A graph as assignments in C: a value that is used twice, has a name or grows too long gets a variable."""

from __future__ import annotations

import enum
import itertools
import math
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from workbench.engine.kernel.graph import Graph
from workbench.engine.machines.c_real import DOUBLE, Real, word_text
from workbench.engine.machines.c_spelling import (
    FUSED_ARGUMENTS,
    SPELLING,
    Text,
    formula,
    fused_arguments,
    number_of_truth,
    truth_of_number,
)
from workbench.engine.machines.operations import OPERATIONS, Kind, Tightness, gives_truth
from workbench.handover.c99.c_branches import Branch, branch_lines, branches_of, evaluation_order
from workbench.handover.c99.c_loop_writer import AbstractLoopWriter
from workbench.handover.c99.c_loops import OF_ARRAYS, LoopNames, LoopText, PartText, item_text
from workbench.handover.c99.c_scope import Scope

WIDTH = 84  # letters of an expression, beyond which its longest part gets a variable
MEMBERS = {"sin": "sine", "cos": "cosine"}  # of the pair that one call gives for one angle


class ValueForm(enum.Enum):
    """The form in which a value is wanted: made, as an expression, or as a variable or a plain number."""

    MADE = "made"
    TEXT = "text"
    VARIABLE = "variable"


class Demand(NamedTuple):
    """Places of a graph, and the form in which each value is wanted."""

    places: tuple[int, ...]
    form: ValueForm = ValueForm.MADE


class DemandCode(NamedTuple):
    """The lines that a demand needs behind those before it, and the texts of its places where they are wanted."""

    lines: tuple[str, ...]
    texts: tuple[str, ...]


class CCall(NamedTuple):
    """A function that is called, and the format of its numbers."""

    name: str
    real: Real


@dataclass(frozen=True)
class Assignments:
    """The answers to some demands, in their order, and what their lines call, in the order of the first calls.

    `room` is the length of the array for the arrays of loops.
    """

    answers: tuple[DemandCode, ...]
    calls: tuple[CCall, ...]
    room: int = 0


def assignments(scope: Scope, demands: Sequence[Demand]) -> Assignments:
    """The assignments that meet one demand after the other, each value made once."""
    writer = _Writer(scope)
    answers = tuple(writer.answer(demand) for demand in demands)
    return Assignments(answers, tuple(writer.calls), writer.loop_names.room)


def uses_of(graph: Graph, numbers: Collection[int]) -> Counter[int]:
    """The number of times that the results need each value, as an operand or as a result."""
    uses = Counter(graph.results)
    for place in graph.before(graph.results):
        if place not in numbers:
            uses.update(graph.nodes[place].operands)
    return uses


def paired_angles(graph: Graph, numbers: Collection[int]) -> frozenset[int]:
    """The angles of which both the sine and the cosine are needed."""
    needed = [graph.nodes[i] for i in graph.before(graph.results) if i not in numbers]
    sines, cosines = ({node.operands[0] for node in needed if node.op == op} for op in ("sin", "cos"))
    return frozenset(sines & cosines)


class _Writer(AbstractLoopWriter):
    """The state of `assignments`: the text of each value so far, and the variables that are taken.

    The body of a loop has a writer of its own, which shares the names of the one around it.
    """

    scope: Scope

    def __init__(self, scope: Scope, around: _Writer | None = None) -> None:
        self.scope, self.nodes = scope, scope.graph.nodes
        self.uses = uses_of(scope.graph, scope.numbers)
        self.paired = paired_angles(scope.graph, scope.numbers)
        self.texts: dict[int, Text] = {}
        self.narrow: dict[int, Text] = {}  # of values in doubles, rounded to the format
        self.turns: dict[int, str] = {}  # the pairs of sine and cosine, by their angles
        self.lines: list[str] = []
        self.calls: dict[CCall, None] = around.calls if around else {}
        self.fresh: Iterator[int] = around.fresh if around else itertools.count(1)
        self.fresh_turns: Iterator[int] = around.fresh_turns if around else itertools.count(1)
        self.loop_names: LoopNames = around.loop_names if around else LoopNames()
        self.loops: dict[int, LoopText] = {}
        self.branches: dict[int, Branch] = {}

    def answer(self, demand: Demand) -> DemandCode:
        self.lines = []
        if demand.form is ValueForm.MADE:
            for place in self._lacking(demand.places):
                self._make(place)
            return DemandCode(tuple(self.lines), ())
        texts = [self._number(place, self.scope.real) for place in demand.places]
        if demand.form is ValueForm.VARIABLE:
            type_ = self.scope.real.type
            texts = [text if text.plain else self._variable(type_, self._new(), text) for text in texts]
        return DemandCode(tuple(self.lines), tuple(text.text for text in texts))

    def _lacking(self, places: Iterable[int]) -> list[int]:
        """The places among some, and all that they need, that have no text yet, in the order of evaluation."""
        found, stack = set[int](), list(places)
        while stack:
            place = stack.pop()
            if place not in found and place not in self.texts and place not in self.scope.numbers:
                found.add(place)
                stack.extend(self.nodes[place].operands)
        return sorted(found)

    def _make(self, place: int) -> None:
        node = self.nodes[place]
        if place in self.branches:
            self._make_branch(self.branches[place])
            return
        if not node.operands:
            self.texts[place] = self.scope.sources[place]
            return
        if node.op in OF_ARRAYS:
            array = self.scope.arrays.get(place) or self.array(place, node)
            self.texts[place] = Text(array, Tightness.ATOM, plain=True)
            return
        text = self._composed(place)
        while len(text.text) > WIDTH and (longest := self._longest_operand(place)) is not None:
            self._assign(longest)
            text = self._composed(place)
        self.texts[place] = text
        if place in self.scope.names or self.uses[place] > 1:
            self._assign(place)

    def _make_branch(self, branch: Branch) -> None:
        """The lines of a branch, and its choices as variables or as carried numbers."""
        array = next((self.scope.sources[i].text for i, node in enumerate(self.nodes) if node.op == "carried"), "")
        names = {place: f"{array}[{entry}]" for place, entry in branch.kept_numbers.items()}
        own = {place: self._new() for place in branch.choices if place not in names}
        lines, sides = self.lines, list[list[str]]()
        for side, places in enumerate(branch.sides):
            self.lines = []
            for place in places:
                self._make(place)
            values = {i: self.number(self.nodes[i].operands[1 + side]) for i in (*own, *(names if side == 0 else ()))}
            self.lines += [f"{name} = {values[place].text};" for place, name in own.items()]
            if side == 0 and not branch.is_direct(self.scope.graph):
                values |= {i: self.variable(values[i]) for i in names if not values[i].plain}
            self.lines += [f"{name} = {values[place].text};" for place, name in names.items() if side == 0]
            sides.append(self.lines)
        self.lines, names = lines, names | own
        condition = self._truth(branch.condition, self.scope.real).text
        self.lines += branch_lines(self.scope.real.type, own.values(), condition, sides)
        self.texts |= {place: Text(name, Tightness.ATOM, plain=True) for place, name in names.items()}

    def _longest_operand(self, place: int) -> int | None:
        """The operand with the longest text that has no variable yet."""
        operands = [i for i in self.nodes[place].operands if i in self.texts]
        longest = max(operands, key=lambda i: len(self.texts[i].text), default=None)
        return longest if longest is not None and self.texts[longest].tightness < Tightness.ATOM else None

    def _assign(self, place: int) -> None:
        """Give a value a variable."""
        real, text, name = self.scope.format_of(place), self.texts[place], self.scope.names.get(place)
        if self.scope.is_truth(place):
            self.texts[place] = self._variable("bool", self._new(), text)
            return
        number = number_of_truth(text, real) if gives_truth(self.nodes[place].op) else text
        self.texts[place] = self._variable(real.type, name or self._new(), number)

    def _variable(self, type_: str, name: str, text: Text) -> Text:
        self.lines.append(f"const {type_} {name} = {text.text};")
        return Text(name, Tightness.ATOM, plain=True)

    def _new(self) -> str:
        return f"w_{next(self.fresh)}"

    def _composed(self, place: int) -> Text:
        """The expression of a value from those of its operands."""
        op, operands, *_ = self.nodes[place]
        real = self.scope.format_of(place)
        if op == "item":
            return Text(item_text(self.texts[operands[0]].text, self.nodes[place].entry), Tightness.ATOM)
        if op in MEMBERS and operands[0] in self.paired:
            return Text(f"{self._turn(operands[0], real)}.{MEMBERS[op]}", Tightness.ATOM)
        if op in FUSED_ARGUMENTS and self.scope.fused_products:
            return self._call("fma", real, fused_arguments(op, [self._number(i, real) for i in operands]))
        if op not in SPELLING:
            return self._call(op, real, ", ".join(self._number(i, real).text for i in operands))
        kinds = OPERATIONS[op].operands
        given = [
            self._truth(i, real) if kind is Kind.TRUTH else self._number(i, real)
            for i, kind in zip(operands, kinds, strict=True)
        ]
        return formula(op, given, real)

    def _call(self, name: str, real: Real, arguments: str) -> Text:
        self.calls[CCall(name, real)] = None
        return Text(f"{self.scope.prefix}_{name}{real.mark}({arguments})", Tightness.ATOM)

    def _turn(self, angle: int, real: Real) -> str:
        """The variable with sine and cosine of an angle."""
        if angle not in self.turns:
            name = f"turn_{next(self.fresh_turns)}"
            text = self._call("turn", real, self._number(angle, real).text)
            self.turns[angle] = self._variable(f"{self.scope.prefix}_pair{real.mark}", name, text).text
        return self.turns[angle]

    def number(self, place: int) -> Text:
        """A value as a number of the scope's format."""
        return self._number(place, self.scope.real)

    def variable(self, text: Text) -> Text:
        """A new variable with a value."""
        return self._variable(self.scope.real.type, self._new(), text)

    def inside(self, body: Graph, carry_size: int, sources: Mapping[int, Text]) -> tuple[list[str], list[PartText]]:
        """The lines of a pass of a body, and its results, of which the first are the next carried values."""
        numbers = {i: one.value for i, one in enumerate(body.nodes) if one.op == "const"}
        scope = replace(self.scope, graph=body, numbers=numbers, sources=sources, names={}, doubles=(), arrays={})
        inner = _Writer(scope, self)
        turned = {i for i, node in enumerate(body.nodes) if node.op in MEMBERS and node.operands[0] in inner.paired}
        inner.branches = branches_of(body, body.results[:carry_size], turned)
        for place in (
            evaluation_order(body, inner.branches, numbers) if inner.branches else inner._lacking(body.results)
        ):
            inner._make(place)
        return inner.lines, [inner.part(place) for place in body.results]

    def _truth(self, place: int, real: Real) -> Text:
        if self.scope.is_truth(place):
            return self.texts[place]
        return truth_of_number(self._number(place, real), real)

    def _number(self, place: int, real: Real) -> Text:
        """A value as a number of a format."""
        if place in self.scope.numbers:
            return self._constant(self.scope.numbers[place], real)
        if self.scope.is_truth(place):
            return number_of_truth(self.texts[place], real)
        if place in self.scope.doubles and real is not DOUBLE:
            if place not in self.narrow:
                rounded = f"({real.type}){self.texts[place].within(Tightness.UNARY)}"
                self.narrow[place] = self._variable(real.type, self._new(), Text(rounded, Tightness.UNARY))
            return self.narrow[place]
        return self.texts[place]

    def _constant(self, value: float, real: Real) -> Text:
        if not math.isfinite(value):
            return self._call("number", real, word_text(real.pattern(value)))
        text = real.literal(value)
        return Text(text, Tightness.UNARY if text.startswith("-") else Tightness.ATOM, plain=True)
