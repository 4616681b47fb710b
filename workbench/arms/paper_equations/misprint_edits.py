"""The likely slip: the smallest change of a printed entry that makes it right.

For every part of a formula the value is found that it would need for the whole to be right, at some states and
parameters; an edit of the part (another sign, symbol, power, factor or function) that has it at all of them is likely.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import casadi as ca
import numpy as np

from workbench.arms.dynamics import Dynamics
from workbench.arms.identity_proofs import Witness
from workbench.arms.paper_equations.arm_letters import symbols_of
from workbench.arms.paper_equations.formula_values import NUMPY, evaluate
from workbench.arms.paper_equations.printed_equations import Place
from workbench.core.notation import build, text
from workbench.core.notation.build import parts, substitute
from workbench.core.notation.formula import Call, Formula, Number, Power, Product, Quotient, Sum, Symbol, letters
from workbench.core.validation.refusals import Array

CLOSE = 1e-9  # of the larger value: far above rounding, far below what any edit changes
LONGEST = 600  # parts of a formula; in a longer one the search would take seconds
TWO = Number(Fraction(2))
LARGEST_FACTOR = 24  # factors p/q that a slip is looked for have p and q up to this

# The kinds of edits, the likeliest first.
RANKS = (
    *("sign", "velocity", "function", "angle", "symbol", "throughout", "power", "factor", "extra", "missing"),
    *("scale", "term", "rounded"),
)


@dataclass(frozen=True)
class Slip:
    """An edit that makes a printed entry right: its kind, one of `RANKS`, and its description."""

    kind: str
    description: str


@dataclass(frozen=True)
class _Part:
    """A part of the printed formula, its value and the value it needs; perhaps a term of a sum, or the whole entry."""

    formula: Formula
    value: Array
    needed_values: Array
    is_term: bool
    is_whole: bool

    @property
    def text(self) -> str:
        return "the whole entry" if self.is_whole else text.emit(self.formula, width=60)


@dataclass(frozen=True, eq=False)
class Editor:
    """The values of an arm's symbols, and of its entries of M, C and G, each (K,); its velocities, (n, K)."""

    values: Mapping[Symbol, Array]
    entries: Mapping[Place, Array]
    velocities: Array

    @staticmethod
    def near(states: Sequence[Witness], derived_dynamics: Dynamics) -> Editor:
        """The values near some states, by which formulas are told apart without algebra."""
        q, qd, p = (np.stack([getattr(state, name) for state in states], axis=1) for name in ("q", "qd", "p"))
        off = 0.01 * np.sqrt(np.arange(2.0, 2.0 + q.size)).reshape(q.shape)  # sums of round numbers vanish
        q, qd = q + off, qd + off
        inputs = [derived_dynamics.q, derived_dynamics.qd, derived_dynamics.symbols]
        rows = dict(zip([s.name() for s in ca.vertsplit(ca.vertcat(*inputs))], np.vstack([q, qd, p]), strict=True))
        entries: dict[Place, Array] = {}
        for name, matrix in (("M", derived_dynamics.M), ("C", derived_dynamics.C), ("G", derived_dynamics.G)):
            numbers = np.array(ca.Function("entries", inputs, [ca.vec(matrix)])(q, qd, p))
            for k, row in enumerate(numbers):
                entries[name, k % matrix.shape[0] + 1, k // matrix.shape[0] + 1] = row
        return Editor({letter: rows[name] for letter, name in symbols_of(derived_dynamics).items()}, entries, qd)

    def slip(self, formula: Formula, right: Array) -> Slip | None:
        """The likeliest single edit of a printed entry that gives it the right values (K,); None if it is too long."""
        if sum(1 for _ in parts(formula)) > LONGEST:
            return None
        with np.errstate(all="ignore"):
            found = []
            for letter in dict.fromkeys(letters(formula)):
                for other, value in self.candidate_symbols.items():
                    turned: dict[Symbol, Array | np.float64] = {**self.values, letter: value}
                    if other != letter and _near(evaluate(formula, turned, NUMPY), right):
                        said = f"{text.emit(letter)} stands throughout where {text.emit(other)} is right"
                        found.append(Slip("throughout", said))
            for part in self._parts(formula, right, is_term=True, is_whole=True):
                found.extend(self._edits(part))
        return min(found, key=lambda slip: RANKS.index(slip.kind), default=None)

    def value(self, formula: Formula) -> Array:
        """The values of a formula, (K,)."""
        size = len(next(iter(self.values.values())))
        with np.errstate(all="ignore"):  # what is no number at a state is near to nothing there
            return np.asarray(evaluate(formula, self.values, NUMPY) + np.zeros(size))

    @cached_property
    def candidate_symbols(self) -> dict[Symbol, Array]:
        """The symbols that may be meant instead of another one, or left out: only those that are not given as zero."""
        return {letter: value for letter, value in self.values.items() if np.any(value != 0)}

    @cached_property
    def joints(self) -> list[Symbol]:
        """The joint angles in order."""
        angles = (s for s in self.values if s.letter == "q" and s.dots == 0 and s.index.isdecimal())
        return sorted(angles, key=lambda angle: int(angle.index))

    @cached_property
    def angles(self) -> list[Formula]:
        """The angles that are sums of neighbouring joints' ones, and differences of two."""
        q = self.joints
        sums = [build.total(q[i:j]) for i in range(len(q)) for j in range(i + 1, len(q) + 1)]
        differences = [build.total([a, build.negative(b)]) for a in q for b in q if a != b]
        return [*sums, *differences]

    def _parts(
        self, formula: Formula, needed_values: Array, *, is_term: bool, is_whole: bool = False
    ) -> Iterator[_Part]:
        """Every part, with the value that it needs when all others stay as they are."""
        part = _Part(formula, self.value(formula), needed_values, is_term, is_whole)
        yield part
        match formula:
            case Sum(terms):
                for term in terms:
                    yield from self._parts(term, needed_values - part.value + self.value(term), is_term=True)
            case Product(factors):
                if factors[0] == TWO and is_term:  # 2 x may have been x + y before y was misread as x
                    yield from self._parts(build.product(factors[1:]), needed_values - part.value / 2, is_term=False)
                for i, factor in enumerate(factors):
                    others = build.product([*factors[:i], *factors[i + 1 :]])
                    yield from self._parts(factor, needed_values / self.value(others), is_term=False)
            case Quotient(above, below):
                yield from self._parts(above, needed_values * self.value(below), is_term=False)
                yield from self._parts(below, self.value(above) / needed_values, is_term=False)
            case Power(base, Number(exponent)) if exponent > 0:
                root = np.sign(self.value(base)) * np.abs(needed_values) ** (1 / float(exponent))
                root = np.where(np.sign(needed_values) == np.sign(part.value), root, np.nan)
                yield from self._parts(base, root, is_term=False)
                if isinstance(base, Symbol):  # x x where x y is right
                    yield from self._parts(base, needed_values * self.value(base) / part.value, is_term=False)

    def _edits(self, part: _Part) -> Iterator[Slip]:
        match part.formula:
            case Symbol() as printed:
                for other, value in self.candidate_symbols.items():
                    if other != printed and _near(value, part.needed_values):
                        same = (other.letter, other.index) == (printed.letter, printed.index)
                        yield _instead("velocity" if same else "symbol", printed, other)
            case Call("sin" | "cos") as printed:
                yield from self._other_function(part, printed)
        yield from self._other_power(part)
        if part.is_term:
            yield from self._other_scale(part)
        elif isinstance(part.formula, Number) and (ratio := _ratio(part.needed_values, np.ones(1))) is not None:
            yield Slip("factor", f"the number {text.emit(part.formula)} stands where {ratio} is right")

    def _other_function(self, part: _Part, formula: Call) -> Iterator[Slip]:
        (argument,) = formula.arguments
        angles = [argument, *self.angles]
        for letter in letters(argument):
            angles += [substitute(argument, {letter: other}) for other in self.values if other.letter == "q"]
        for angle in angles:
            for other in (Call("sin", (angle,)), Call("cos", (angle,))):
                if other != formula and _near(self.value(other), part.needed_values):
                    kind = "angle" if other.function == formula.function else "term"
                    yield _instead("function" if angle == argument else kind, formula, other)

    def _other_power(self, part: _Part) -> Iterator[Slip]:
        match part.formula:
            case Power(Symbol() | Call() as base, Number(Fraction() as printed)):
                pass
            case Symbol() | Call() as base:
                printed = Fraction(1)
            case _:
                return
        for exponent in range(1, 4):
            if exponent != printed and _near(self.value(base) ** exponent, part.needed_values):
                yield _instead("power", part.formula, build.power(base, Number(Fraction(exponent))))

    def _other_scale(self, part: _Part) -> Iterator[Slip]:
        """Another sign, a number, or a symbol too many or too few; or a term that does not belong here."""
        if _near(-part.value, part.needed_values):
            yield Slip("sign", f"{part.text} has the wrong sign")
        elif (ratio := _ratio(part.needed_values, part.value)) is not None:
            scaled = f"lacks the factor {ratio}" if abs(ratio) > 1 else f"has a factor {1 / ratio} too many"
            yield Slip("factor", f"{part.text} {scaled}")
        elif (scale := float(np.median(part.value / part.needed_values))) and _near(
            part.value / part.needed_values, scale
        ):
            yield Slip("scale", f"{part.text} is {scale:.10g} times what is right")
        if not part.is_whole and _near(1 + part.needed_values, np.ones(1)):
            yield Slip("extra", f"the term {part.text} does not belong here")
        for letter, value in self.candidate_symbols.items():
            for sign, word in ((1, ""), (-1, "-")):
                if _near(part.needed_values * value, sign * part.value):
                    yield Slip("extra", f"{part.text} has a factor {word}{text.emit(letter)} too many")
                if _near(part.needed_values, sign * part.value * value):
                    yield Slip("missing", f"{part.text} lacks the factor {word}{text.emit(letter)}")
        for angle in self.angles:
            for function in ("sin", "cos"):
                if _near(part.needed_values, part.value * NUMPY.functions[function](self.value(angle))):
                    yield Slip("missing", f"{part.text} lacks the factor {function}({text.emit(angle)})")


def _instead(kind: str, formula: Formula, right: Formula) -> Slip:
    return Slip(kind, f"{text.emit(formula)} stands where {text.emit(right)} is right")


def _near(value: Array | np.float64, target: Array | float) -> bool:
    scale = np.maximum(np.abs(value), np.abs(target))
    return bool(np.all(np.isfinite(value) & np.isfinite(target) & (np.abs(value - target) <= CLOSE * scale)))


def _ratio(needed_values: Array, value: Array) -> Fraction | None:
    """The simple fraction by which the one is the other, if it is the same at all states."""
    ratios = needed_values / value
    if not np.isfinite(ratios).all():
        return None
    simple = Fraction(float(np.median(ratios))).limit_denominator(LARGEST_FACTOR)
    if simple in (0, 1) or abs(simple) > LARGEST_FACTOR or not _near(ratios, float(simple)):
        return None
    return simple
