"""Units of equations by experiment: where a metre, a second or a volt is made larger, each value must follow its unit.

An equation whose terms have one unit gives, in other units of measurement, the same quantity. A number in the code that
has a unit of its own, a factor that is missing, and a sum of two units do not follow, whatever the equation looks like.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from workbench.blocks.loop.contracts import is_recursion
from workbench.core import Layout
from workbench.core.units import ANY, BASE, DERIVED_UNITS, UnitError, read
from workbench.core.validation.refusals import Array
from workbench.testing.block_equations import BlockEquations

ANGLE = "rad"  # a pure number, as sines need it
TOLERANCE = 1e-6  # relative: rounding is some 1e-13, a term that does not follow its unit differs by a fifth
WAYS = re.compile(r" or |, ")  # between the units that a text leaves open, or that nobody can tell apart
WORD = re.compile(r"[A-Za-z%_]\w*")
POINTS = 3


@dataclass(frozen=True)
class Misfit:
    """A value that does not follow its unit when a unit of measurement is made larger."""

    value: str
    unit: str
    base: str
    factor: float  # by which the unit of measurement is larger
    grew: float
    must_grow: float


def find_misfit(equations: BlockEquations, rng: np.random.Generator) -> Misfit | None:
    """The first value that does not follow its unit, or None if there is none."""
    bases = sorted(scalable_bases(equations))
    factors = dict(zip(bases, 1.2 + 0.37 * np.arange(len(bases)) / max(1, len(bases)), strict=True))
    points = [equations.random_arguments(rng) for _ in range(POINTS)]
    if _misfit(equations, points, factors) is None:
        return None
    alone = (_misfit(equations, points, {base: factor}) for base, factor in factors.items())
    return next((found for found in alone if found is not None), _misfit(equations, points, factors))


def scalable_bases(equations: BlockEquations) -> set[str]:
    """The base units in which each argument and each result has a known power."""
    texts = {unit for layout in (equations.arguments, equations.results) for unit in _units(layout)}
    if any(ANY in text for text in texts):
        return set()
    moves_at_instants = is_recursion(equations.block) or equations.block.period is not None
    known, open_ones = {"s"}, {ANGLE, *(["s"] if moves_at_instants else [])}  # its period is a bare number
    for text in texts:
        ways = [_powers(way, open_ones) for way in WAYS.split(text)]
        known |= {base for powers in ways for base in powers}
        open_ones |= {base for powers in ways for base in powers if len({way.get(base, 0.0) for way in ways}) > 1}
    return known - open_ones


def _misfit(equations: BlockEquations, points: list[Array], factors: dict[str, float]) -> Misfit | None:
    given = growth_of(equations.arguments, factors)
    must = growth_of(equations.results, factors)
    for numbers in points:
        before, after = equations.at(numbers), equations.at(numbers * given)
        size = np.maximum(np.abs(before), 1e-9 * np.abs(before).max(initial=0.0))
        with np.errstate(invalid="ignore"):
            off = np.abs(after / must - before) > TOLERANCE * size
        if off.any():
            i = int(np.argmax(off))
            base, factor = next(iter(factors.items()))
            grew = float(after[i] / before[i]) if before[i] else np.inf
            unit = _units(equations.results)[i]
            return Misfit(equations.results.labels[i], unit, base, factor, grew, float(must[i]))
    return None


def growth_of(layout: Layout, factors: dict[str, float]) -> Array:
    """The factor of each number of a layout, (n,), where base units of measurement grow by `factors`."""
    growth = []
    for text in _units(layout):
        powers = _powers(WAYS.split(text)[0], set())
        growth.append(np.prod([factor ** powers.get(base, 0.0) for base, factor in factors.items()]))
    return np.array(growth)


def _units(layout: Layout) -> list[str]:
    return [unit for entry in layout.entries for unit in entry.units]


def _powers(text: str, open_ones: set[str]) -> dict[str, float]:
    """The powers of base units; those of a word to a power in letters join the open ones, as nobody knows them."""
    powers: dict[str, float] = {}
    try:
        words = read(text).powers
    except UnitError:
        words, open_ones = (), open_ones | set(WORD.findall(text))
    for word, n in words:
        if "^" in word:
            open_ones |= {base for part in WORD.findall(word) for base, _ in _in_base(part)}
            continue
        for base, own in _in_base(word):
            powers[base] = powers.get(base, 0.0) + float(n) * own
    return powers


def _in_base(word: str) -> list[tuple[str, float]]:
    """A word as base units with their powers; a word that nobody knows is a base unit."""
    if word in BASE or word not in DERIVED_UNITS:
        return [(word, 1.0)]
    return [(base, float(n)) for base, n in read(DERIVED_UNITS[word][1]).powers]
