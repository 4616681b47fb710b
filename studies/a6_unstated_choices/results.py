"""What was found for each law: the nearest fits, how many choices come near, and what these have in common."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from studies.a6_unstated_choices.draws import at_draws, factors_of, slug
from studies.a6_unstated_choices.fits import CLOSE, TARGETS, Fit, fit, nearest, runs
from studies.a6_unstated_choices.loops import SCENARIOS, Reading
from workbench.study.study import Results
from workbench.study.uncertainty.factors import Factor
from workbench.validation.refusals import Array

WIDE = 0.5  # of a range: what is found over more of it is not determined


@dataclass(frozen=True, eq=False)
class Found:
    """What was found for one law.

    Attributes
    ----------
    fits
        By target.
    drawn, sought
        The misses of the independent draws and of the points of the search, by target.
    close
        By target the values (n, d) of the factors in all choices within 1 %, of draws and search together.
    """

    law: str
    fits: Mapping[str, Fit]
    drawn: Mapping[str, Array]
    sought: Mapping[str, Array]
    close: Mapping[str, Array]


@cache
def found_for(results: Results, law: str) -> Found:
    """Fits and counts of a law."""
    tuned = results.tuned(slug("search", law))
    checks = {scenario: results.sample(slug("check", law, scenario)) for scenario in SCENARIOS}
    random = {scenario: at_draws(results, "random", law, scenario) for scenario in SCENARIOS}
    fits = {target: fit(law, target, tuned, checks) for target in TARGETS}
    drawn = {target: nearest(law, target, random) for target in TARGETS}
    sought = {target: nearest(law, target, runs(tuned)) for target in TARGETS}
    both = np.concatenate([random["SS"].drawn, tuned.numbers])
    close = {target: both[np.concatenate([drawn[target], sought[target]]) <= CLOSE] for target in TARGETS}
    return Found(law, fits, drawn, sought, close)


def wide_factors(found: Found) -> tuple[str, ...]:
    """The factors whose values among the choices that meet the first scenario span more than half of their range."""
    factors, close = factors_of(found.law, "FS"), found.close["FS"]
    if not len(close):
        return ()
    return tuple(f.name for f, values in zip(factors, close.T, strict=False) if span_of(f, values) > WIDE)


def span_of(factor: Factor, values: Array) -> float:
    """What part of its range values of a factor span: of the logarithms, or of the readings, where it has these."""
    spread = factor.distribution
    if isinstance(spread, Reading):
        return len(np.unique(values)) / len(spread.names)
    u = np.linspace(0, 1, 2001)
    ends = np.interp([values.min(), values.max()], spread.quantile(u), u)
    return float(ends[1] - ends[0])


def words(factor: Factor) -> str:
    words = factor.distribution.words()
    return f"share of the card's own: {words}" if factor.share else words


def said(one: Fit, square: bool) -> str:
    """The numbers of a fit in words."""
    factors = factors_of(one.law, "SS" if square else "FS")
    return in_words(factors, [one.numbers[factor.name] for factor in factors])


def in_words(factors: Sequence[Factor], values: Iterable[float]) -> str:
    """Factors with their values."""
    parts = []
    for factor, value in zip(factors, values, strict=True):
        spread = factor.distribution
        shown = spread.names[round(value)] if isinstance(spread, Reading) else f"{value:.4g}"
        parts.append(f"{factor.name} {shown}")
    return ", ".join(parts)
