"""The body of a function in C: the nodes of a graph as expressions, each value that is used twice in a variable."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from workbench.engine.kernel.graph import Graph
from workbench.engine.kernel.plan import COMPARISONS, PLAIN
from workbench.handover.c99.c_primitives import DOUBLE, Real, word_text

WIDTH = 84  # letters of an expression, beyond which its longest part gets a variable
CHOICE, LOGIC, ORDER, SUM, PRODUCT, SIGNED, ATOM = range(7)  # how tightly a text holds together
FORMS = {
    "add": ("{} + {}", SUM, (SUM, SIGNED)),
    "sub": ("{} - {}", SUM, (SUM, SIGNED)),
    "mul": ("{} * {}", PRODUCT, (PRODUCT, SIGNED)),
    "div": ("{} / {}", PRODUCT, (PRODUCT, SIGNED)),
    "fma": ("({} * {}) + {}", SUM, (PRODUCT, SIGNED, SIGNED)),
    "fms": ("({} * {}) - {}", SUM, (PRODUCT, SIGNED, SIGNED)),
    "fnma": ("{2} - ({0} * {1})", SUM, (PRODUCT, SIGNED, SUM)),
    "neg": ("-{}", SIGNED, (ATOM,)),
    "lt": ("{} < {}", ORDER, (SUM, SUM)),
    "le": ("{} <= {}", ORDER, (SUM, SUM)),
    "eq": ("{} == {}", ORDER, (SUM, SUM)),
    "ne": ("{} != {}", ORDER, (SUM, SUM)),
    "and": ("{} && {}", LOGIC, (ATOM, ATOM)),
    "or": ("{} || {}", LOGIC, (ATOM, ATOM)),
    "not": ("!{}", SIGNED, (ATOM,)),
    "if_else": ("{} ? {} : {}", CHOICE, (ATOM, ATOM, ATOM)),
    "barrier": ("{}", ATOM, (ATOM,)),
}
FUSED = {"fma": "{0}, {1}, {2}", "fms": "{0}, {1}, -{2}", "fnma": "-{0}, {1}, {2}"}  # of a processor's fma
TRUTHS = {*COMPARISONS, "and", "or", "not"}
OF_TRUTHS = {"and": (0, 1), "or": (0, 1), "not": (0,), "if_else": (0,)}  # the operands that are truths
PRIMITIVES = ("fabs", "sqrt", "floor", "copysign")


class Text(NamedTuple):
    """An expression in C, and how tightly it holds together."""

    text: str
    tightness: int

    def within(self, least: int) -> str:
        """The text where it must hold together so tightly; a product in a sum has parentheses of its own."""
        plain = self.tightness >= least and not (least == SUM and self.tightness == PRODUCT)
        return self.text if plain else f"({self.text})"


@dataclass(frozen=True, eq=False)
class Body:
    """The lines of a function in C, which grow as values are asked for.

    Attributes
    ----------
    numbers
        The values of nodes that are numbers.
    load
        The text of a node that has no operands, as an entry of a state.
    names
        Names for some nodes.
    reals
        The format of each node that is made; that of the body unless told.
    functions, primitives
        Those that are called, each with its format.
    """

    graph: Graph
    prefix: str
    real: Real
    numbers: Mapping[int, float]
    load: Callable[[int], Text]
    names: Mapping[int, str] = field(default_factory=dict)
    fused: bool = False  # products are rounded together with sums
    doubles: Collection[int] = ()  # nodes that are made in doubles whatever the format of the body
    lines: list[str] = field(default_factory=list)
    functions: dict[tuple[str, Real], None] = field(default_factory=dict)
    primitives: dict[tuple[str, Real], None] = field(default_factory=dict)
    texts: dict[int, Text] = field(default_factory=dict)
    narrow: dict[int, Text] = field(default_factory=dict)  # the same as reals of the body
    turns: dict[int, str] = field(default_factory=dict)
    uses: Counter[int] = field(default_factory=Counter)
    counted: list[int] = field(default_factory=lambda: [0])

    def prepare(self, results: Iterable[int]) -> None:
        """Count the uses of each node that the results need."""
        results = list(results)
        for place in self.graph.before(results):
            if place not in self.numbers:
                self.uses.update(self.graph.nodes[place].operands)
        self.uses.update(results)
        angles: dict[int, set[str]] = {}
        for place in self.graph.before(results):
            op, operands, *_ = self.graph.nodes[place]
            if op in ("sin", "cos") and place not in self.numbers:
                angles.setdefault(operands[0], set()).add(op)
        self.turns.update({angle: "" for angle, both in angles.items() if len(both) == 2})

    def make(self, results: Iterable[int]) -> None:
        """The lines that make some values, and what they need."""
        for place in self.graph.before(results):
            if place not in self.texts and place not in self.numbers:
                self._make(place)

    def value(self, place: int, least: int = CHOICE) -> str:
        """The text of a value as a number of the body's format."""
        return self._number(place, self.real).within(least)

    def _make(self, place: int) -> None:
        node = self.graph.nodes[place]
        if not node.operands:
            self.texts[place] = self.load(place)
            return
        text = self._composed(place)
        while len(text.text) > WIDTH and (longest := self._longest(place)) is not None:
            self._assign(longest)
            text = self._composed(place)
        self.texts[place] = text
        if place in self.names or self.uses[place] > 1:
            self._assign(place)

    def _longest(self, place: int) -> int | None:
        """The operand with the longest text that has no variable yet."""
        operands = [i for i in self.graph.nodes[place].operands if i in self.texts and i not in self.numbers]
        longest = max(operands, key=lambda i: len(self.texts[i].text), default=None)
        return longest if longest is not None and self.texts[longest].tightness < ATOM else None

    def _assign(self, place: int) -> None:
        """A variable for a value."""
        real = self._real(place)
        truth = self.graph.nodes[place].op in TRUTHS
        name = self.names.get(place) or self._free()
        if truth and place in self.names:
            self.texts[place] = Text(
                f"{self.texts[place].within(ATOM)} ? {real.literal(1)} : {real.literal(0)}", CHOICE
            )
        type_ = "bool" if truth and place not in self.names else real.type
        self.lines.append(f"const {type_} {name} = {self.texts[place].text};")
        self.texts[place] = Text(name, ATOM)

    def _free(self) -> str:
        self.counted[0] += 1
        return f"w_{self.counted[0]}"

    def _real(self, place: int) -> Real:
        return DOUBLE if place in self.doubles else self.real

    def _composed(self, place: int) -> Text:
        op, operands, *_ = self.graph.nodes[place]
        real = self._real(place)
        if op in ("sin", "cos"):
            return self._turned(op, operands[0], real)
        if op == "inv":
            return Text(f"{real.literal(1)} / {self._number(operands[0], real).within(SIGNED)}", PRODUCT)
        if op in FUSED and self.fused:
            self.primitives["fma", real] = None
            parts = [self._number(i, real).within(SIGNED) for i in operands]
            signed = [part if part[0] != "-" else f"({part})" for part in parts]
            return Text(f"{self.prefix}_fma{real.mark}({FUSED[op].format(*signed)})", ATOM)
        if op in FORMS:
            form, tightness, least = FORMS[op]
            truths = OF_TRUTHS.get(op, ())
            parts = [
                (self._truth(i, real) if n in truths else self._number(i, real)).within(t)
                for n, (i, t) in enumerate(zip(operands, least, strict=True))
            ]
            return Text(form.format(*parts), tightness)
        return Text(f"{self._called(op, real)}({', '.join(self._number(i, real).text for i in operands)})", ATOM)

    def _called(self, op: str, real: Real) -> str:
        (self.primitives if op in PRIMITIVES else self.functions)[op, real] = None
        return f"{self.prefix}_{op}{real.mark}"

    def _turned(self, op: str, angle: int, real: Real) -> Text:
        """The sine or the cosine of an angle, both of them from one call where both are needed."""
        given = self._number(angle, real).text
        if angle not in self.turns:
            return Text(f"{self._called(op, real)}({given})", ATOM)
        if not self.turns[angle]:
            self.turns[angle] = f"turn_{sum(map(bool, self.turns.values())) + 1}"
            pair = f"{self.prefix}_pair{real.mark}"
            self.lines.append(f"const {pair} {self.turns[angle]} = {self._called('turn', real)}({given});")
        return Text(f"{self.turns[angle]}.{'sine' if op == 'sin' else 'cosine'}", ATOM)

    def _truth(self, place: int, real: Real) -> Text:
        """A value as a truth: nonzero is true."""
        if place in self.texts and self.graph.nodes[place].op in TRUTHS and place not in self.names:
            return self.texts[place]
        return Text(f"{self._number(place, real).within(SUM)} != {real.literal(0)}", ORDER)

    def _number(self, place: int, real: Real) -> Text:
        """A value as a number of a format: 1 or 0 for a truth."""
        if place in self.numbers and place not in self.texts:
            return self.constant(place, real)
        if self.graph.nodes[place].op in TRUTHS and place not in self.names and place not in self.numbers:
            return Text(f"{self.texts[place].within(ATOM)} ? {real.literal(1)} : {real.literal(0)}", CHOICE)
        if place in self.doubles and real is not DOUBLE:
            if place not in self.narrow:
                name = self._free()
                self.lines.append(f"const {real.type} {name} = ({real.type}){self.texts[place].within(SIGNED)};")
                self.narrow[place] = Text(name, ATOM)
            return self.narrow[place]
        return self.texts[place]

    def constant(self, place: int, real: Real) -> Text:
        """A number by the name that it has, or as it is."""
        value = self.numbers[place]
        if place in self.names and value not in PLAIN:
            return Text(self.names[place], ATOM)
        if not math.isfinite(value):
            self.primitives["number", real] = None
            return Text(f"{self.prefix}_number{real.mark}({word_text(real.pattern(value))})", ATOM)
        text = real.literal(value)
        return Text(text, SIGNED if text.startswith("-") else ATOM)
