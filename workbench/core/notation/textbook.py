r"""A normal form in the order and with the parentheses that a textbook gives it.

Where every term holds a sine or cosine, terms are collected by it, as in a gravity vector,

    (m_1 + m_2) g l_1 sin q_1 + m_2 g l_2 sin(q_1 + q_2);

elsewhere by the symbols that occur only to the first power, as in a mass matrix,

    m_1 l_1^2 + m_2 (l_1^2 + l_2^2 + 2 l_1 l_2 cos q_2).
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

from workbench.core.notation.build import ONE, call, negative, number, power, product, total
from workbench.core.notation.formula import GREEK, Formula, Symbol
from workbench.core.notation.trigonometric_sums import PLAIN, Key, Monomial, Wave

Polynomial: TypeAlias = dict[Monomial, Fraction]
SortKey: TypeAlias = tuple[object, ...]
# Factors that come first in mechanics: m g l, m l^2. Greek letters go before Latin ones: omega t.
FIRST = ("m", "g", "l")


def textbook_form(terms: Mapping[Key, Fraction], symbols: Mapping[str, Symbol]) -> Formula:
    """The formula of a normal form, over the given symbol of each name."""
    page = _Page({name: _rank(symbol) for name, symbol in symbols.items()}, symbols)
    if all(wave != PLAIN for _, wave in terms):
        return page.by_wave(terms)
    return page.by_symbol(terms)


def _rank(symbol: Symbol) -> SortKey:
    """The sort key of a symbol: parameters before velocities, then by letter and index."""
    first = FIRST.index(symbol.letter) if symbol.letter in FIRST else len(FIRST)
    greek = symbol.letter not in GREEK
    index = tuple((0, int(run), "") if run.isdecimal() else (1, 0, run) for run in re.findall(r"\d+|\D+", symbol.index))
    rest = symbol.accent, symbol.mark, index, symbol.index, symbol.bold
    return symbol.dots, first, greek, symbol.letter.lower(), symbol.letter, *rest


@dataclass(frozen=True)
class _Page:
    rank: Mapping[str, SortKey]
    symbols: Mapping[str, Symbol]

    def by_wave(self, terms: Mapping[Key, Fraction]) -> Formula:
        groups: dict[Wave, Polynomial] = {}
        for (powers, wave), coefficient in terms.items():
            groups.setdefault(wave, {})[powers] = coefficient
        waves = sorted(groups, key=self.wave_order)
        return total(product([*self.factors(groups[wave]), self.wave(wave)]) for wave in waves)

    def by_symbol(self, terms: Mapping[Key, Fraction]) -> Formula:
        """Terms collected by the symbols that occur only to the first power, the most frequent first."""
        powers = {power for monomial, _ in terms for power in monomial}
        nonlinear = {name for name, exponent in powers if exponent != 1}
        linear = sorted({name for name, _ in powers} - nonlinear, key=self.rank.__getitem__)
        rest = set(terms)
        groups: list[set[Key]] = []
        while True:
            shares = {name: {key for key in rest if (name, 1) in key[0]} for name in linear}
            name = max(linear, key=lambda name: len(shares[name]), default="")
            if not name or len(shares[name]) < 2:
                break
            groups.append(shares[name])
            rest -= shares[name]
        groups += [{key} for key in rest]
        groups.sort(key=lambda group: min(map(self.term_order, group)))
        return total(self.group({key: terms[key] for key in group}, linear) for group in groups)

    def group(self, terms: dict[Key, Fraction], linear: list[str]) -> Formula:
        keys = sorted(terms, key=self.term_order)
        if len(keys) == 1:
            return self.term(keys[0], terms[keys[0]])
        common = [name for name in linear if all((name, 1) in powers for powers, _ in keys)]
        content = _content([terms[key] for key in keys])
        rests = [(tuple(power for power in powers if power[0] not in common), wave) for powers, wave in keys]
        inside = total(self.term(rest, terms[key] / content) for rest, key in zip(rests, keys, strict=True))
        factors: list[tuple[SortKey, Formula]] = [(self.rank[name], self.symbols[name]) for name in common]
        factors = sorted([*factors, (self.lead(rests[0][0]), inside)], key=lambda pair: pair[0])
        return product([number(content), *(formula for _, formula in factors)])

    def term(self, key: Key, coefficient: Fraction) -> Formula:
        return product([number(coefficient), self.monomial(key[0]), self.wave(key[1])])

    def factors(self, polynomial: Polynomial) -> list[Formula]:
        """A polynomial as number, symbols and sums, velocities apart from parameters where that is possible."""
        powers = sorted(polynomial, key=self.monomial_order)
        content = _content([polynomial[p] for p in powers])
        exponents = [dict(p) for p in powers]
        shared = {name: min(e.get(name, 0) for e in exponents) for name in sorted({n for e in exponents for n in e})}
        inside = {
            tuple((n, e - shared[n]) for n, e in p if e != shared[n])
            + tuple((n, -shared[n]) for n in shared if shared[n] < 0 and n not in dict(p)): polynomial[p] / content
            for p in powers
        }
        factors = [(self.rank[name], self.monomial(((name, e),))) for name, e in shared.items() if e]
        if len(inside) > 1:
            factors += [
                (self.lead(min(part, key=self.monomial_order)), self.sum(part)) for part in self.separate(inside)
            ]
        factors.sort(key=lambda pair: pair[0])
        return [number(content), *(formula for _, formula in factors)]

    def separate(self, polynomial: Polynomial) -> list[Polynomial]:
        """A polynomial as one in parameters times one in velocities, if it is such a product."""
        rows: dict[Monomial, Polynomial] = {}
        for powers, coefficient in polynomial.items():
            moving = tuple(p for p in powers if self.symbols[p[0]].dots)
            rows.setdefault(moving, {})[tuple(p for p in powers if not self.symbols[p[0]].dots)] = coefficient
        velocities = sorted(rows, key=self.monomial_order)
        first = rows[velocities[0]]
        pivot = min(first, key=self.monomial_order)
        scale = {v: rows[v].get(pivot, Fraction(0)) / first[pivot] for v in velocities}
        alike = all(rows[v] == {p: scale[v] * c for p, c in first.items()} for v in velocities)
        if not alike or len(first) == 1 or len(rows) == 1:
            return [polynomial]
        return [first, scale]

    def lead(self, first: Monomial) -> SortKey:
        """The sort key of a sum among factors: that of the first symbol of its first term, else last."""
        return min((self.rank[name] for name, _ in first), default=(math.inf,))

    def sum(self, polynomial: Polynomial) -> Formula:
        powers = sorted(polynomial, key=self.monomial_order)
        return total(product([number(polynomial[p]), self.monomial(p)]) for p in powers)

    def monomial(self, powers: Monomial) -> Formula:
        ordered = sorted(powers, key=lambda power: self.rank[power[0]])
        return product(power(self.symbols[name], number(exponent)) for name, exponent in ordered)

    def wave(self, wave: Wave) -> Formula:
        """A sine or cosine, its angle beginning with a plus sign."""
        kind, angle = wave
        if not angle:
            return ONE
        powers = sorted(dict(angle), key=self.monomial_order)
        minus = dict(angle)[powers[0]] < 0
        coefficients = {p: -c if minus else c for p, c in angle}
        formula = call(kind, self.sum(coefficients))
        return negative(formula) if minus and kind == "sin" else formula

    def monomial_order(self, powers: Monomial) -> SortKey:
        """The sort key of a monomial: higher degree first, then alphabetically: x^2, x y, y^2, x, y, 1."""
        letters = sorted((self.rank[name], -exponent) for name, exponent in powers)
        return -sum(exponent for _, exponent in powers), tuple(letters)

    def wave_order(self, wave: Wave) -> SortKey:
        """The sort key of a wave: 1, then angles of few symbols before angles of many, cosine before sine."""
        kind, angle = wave
        terms = sorted((self.monomial_order(powers), coefficient) for powers, coefficient in angle)
        return len(angle), tuple(terms), kind

    def term_order(self, key: Key) -> SortKey:
        return self.wave_order(key[1]), self.monomial_order(key[0])


def _content(coefficients: list[Fraction]) -> Fraction:
    """The common factor of the coefficients of a sum, with the sign of the first; 1 if any is no short fraction."""
    sign = -1 if coefficients[0] < 0 else 1
    if len(coefficients) == 1:
        return coefficients[0]
    if any(c.denominator > 64 for c in coefficients):
        return Fraction(sign)
    above = math.gcd(*(c.numerator for c in coefficients))
    below = math.lcm(*(c.denominator for c in coefficients))
    return sign * Fraction(above, below)
