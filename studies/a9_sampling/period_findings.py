"""The findings of a9 on quiet periods: the longest one of AOSMC-RGS by its start, and the rule of thumb."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

import workbench as wb
from studies.a9_sampling.evidence import Evidence
from studies.a9_sampling.words import ASSUMPTIONS, COUNTS_ON, FITS, INFORMATION
from studies.paper.card import PROPOSED_LAW
from studies.paper.period_rules import BOUND, HALF, MATRIX, RULE
from studies.paper.quiet_periods import (
    ACTING_TORQUE,
    COMMANDED_TORQUE,
    FACTORS,
    HANDED_OVER,
    ON_REFERENCE,
    PAPERS,
    QUIET,
    SCENARIOS,
    STARTS,
    TRUTH,
    QuietPeriod,
    QuietSearch,
    at_hand_over,
    bracket_words,
    conditions,
    ends,
    in_ms,
)

BASE = QuietSearch(PROPOSED_LAW, delay=True)


def one_of(evidence: Evidence, **fields: object) -> QuietPeriod:
    """The search whose fields have these values."""
    (found,) = evidence.searches_with(**fields)
    return found


def base(evidence: Evidence) -> QuietPeriod:
    """The search of AOSMC-RGS from the paper's start in the first scenario, a period late."""
    return next(one for one in evidence.quiet if one.search == BASE)


def reference(evidence: Evidence, counts_on: str = ACTING_TORQUE) -> QuietPeriod:
    """The same search from a start on the reference."""
    fields = {"scenario": "FS", "start": ON_REFERENCE, "delay": True, "observer": TRUTH}
    return one_of(evidence, law=PROPOSED_LAW, counts_on=counts_on, **fields)


def commanded_search(evidence: Evidence) -> QuietPeriod:
    """The search of `base` with an observer that counts on the commanded torque."""
    return next(one for one in evidence.quiet if one.search == replace(BASE, counts_on=COMMANDED_TORQUE))


def longest_period(evidence: Evidence) -> wb.Finding:
    """The longest quiet period of AOSMC-RGS, by start."""
    late, near = base(evidence), reference(evidence)
    told, told_near = commanded_search(evidence), reference(evidence, COMMANDED_TORQUE)
    variations = [
        wb.Variation(conditions(one.search), at_hand_over(one), detail(one))
        for one in evidence.searches_with(law=PROPOSED_LAW)
        if one.search != BASE
    ]
    variations += [
        wb.Variation(
            f"at most {factor:g} times the total variation",
            at_hand_over(late, factor),
            f"{bracket_words(ends(late, factor))} ms",
        )
        for factor in FACTORS
    ]
    return wb.Finding(
        "longest_period",
        f"In the first scenario, with a torque one period late, {PROPOSED_LAW} is quiet up to {in_ms(ends(late))} ms "
        f"from the paper's start and up to {in_ms(ends(near))} ms from a start on the reference. Report b4 exports the "
        f"law with a period of {1e3 * HANDED_OVER:g} ms.",
        (
            "The period depends on ρ, the largest eigenvalue of ",
            MATRIX,
            ", which grows with the error at the start. The least ",
            HALF,
            f" along the run in continuous time is {period(late.rule)} ms from the paper's start and "
            f"{period(near.rule)} ms from a start on the reference. The searches end between "
            f"{' and '.join(f'{1e3 * end:.3g}' for end in ends(late))} ms, and between "
            f"{' and '.join(f'{1e3 * end:.3g}' for end in ends(near))} ms. If observer (10) uses the commanded "
            f"torque, the law is quiet up to {in_ms(ends(told))} ms and {in_ms(ends(told_near))} ms.",
        ),
        statistic="The longest tried period up to which the total variation of the torque is at most "
        f"{QUIET:g} times its value in continuous time, at both joints.",
        sample="One run for each period, in the first scenario with exact readings.",
        information=INFORMATION,
        assumptions=f"{ASSUMPTIONS} {COUNTS_ON} The limit of {QUIET:g} times; explicit Euler; a torque without limit.",
        fitted_numbers=FITS,
        answer=at_hand_over(late),
        variations=tuple(variations),
        limitations="Noise in the readings; other numbers of the law.",
        cites=("b4_handover/longest_period",),
    )


def period(seconds: float | None) -> str:
    """A period in ms with three digits."""
    return f"{1e3 * (seconds or 0):.3g}"


def detail(one: QuietPeriod) -> str:
    """The two ends of a search, and the period that the rule gives."""
    return f"{bracket_words(ends(one))} ms; rule {period(one.rule)} ms"


# The rules


def ratios_of(
    quiet: Iterable[QuietPeriod], factor: float = QUIET, by: str = "rule"
) -> dict[tuple[str, str], tuple[float, float]]:
    """By law and scenario, the two ends of a search over the rule, or over the bound."""
    ratios = {}
    for one in quiet:
        rule: float | None = getattr(one, by)
        if rule is not None and one.search.observer == TRUTH:
            low, high = ends(one, factor)
            ratios[one.search.law, one.search.scenario] = (low / rule, high / rule)
    return ratios


Ratios = Mapping[tuple[str, str], tuple[float, float]]


def too_long(ratios: Ratios) -> str:
    """The loops whose rule is too long: both ends of the search are below it."""
    return wb.document.join_names(f"{law} in {scenario}" for (law, scenario), (_, high) in ratios.items() if high <= 1)


def within(ratios: Ratios) -> int:
    """The number of loops whose rule lies between the ends of the search."""
    return sum(low <= 1 <= high for low, high in ratios.values())


def farthest(ratios: Ratios) -> tuple[tuple[str, str], float]:
    """The loop whose rule is farthest off the ends of its search, and the distance in parts of the rule."""
    off = {loop: max(low - 1, 1 - high, 0.0) for loop, (low, high) in ratios.items()}
    worst = max(off, key=off.__getitem__)
    return worst, off[worst]


def rule_variations(evidence: Evidence) -> Iterator[wb.Variation]:
    """The loops for which a rule is too long: the bound, each scenario, other starts and delays, other limits."""
    still = evidence.searches_with(start=PAPERS, delay=False)
    cases = [("the bound in place of the eigenvalue", ratios_of(still, by="bound"))]
    cases += [(f"{one} alone", ratios_of(each for each in still if each.search.scenario == one)) for one in SCENARIOS]
    for start in STARTS:
        for delay in (False, True):
            for told in (ACTING_TORQUE, COMMANDED_TORQUE) if delay else (ACTING_TORQUE,):
                if (start, delay) != (PAPERS, False):
                    words = f"{STARTS[start]}, {'torque one period late' if delay else 'no delay'}"
                    words += f", only {PROPOSED_LAW}, whose observer uses the commanded torque" * (
                        told == COMMANDED_TORQUE
                    )
                    cases.append((words, ratios_of(evidence.searches_with(start=start, delay=delay, counts_on=told))))
    for factor in FACTORS:
        cases.append((f"at most {factor:g} times the total variation", ratios_of(still, factor)))
    for words, ratios in cases:
        yield wb.Variation(
            words, f"too long for {too_long(ratios)}", f"between the ends in {within(ratios)} of {len(ratios)}"
        )


def rule_of_thumb(evidence: Evidence) -> wb.Finding:
    """The period that the eigenvalues of M^-1 K give, and the bound, beside the longest quiet period."""
    still = evidence.searches_with(start=PAPERS, delay=False)
    ratios, bounds = ratios_of(still), ratios_of(still, by="bound")
    _, off = farthest(ratios)
    others = f" In the other loops it is off by at most {100 * off:.2g} %." if off else ""
    own = wb.document.join_names(
        f"{ratio_words(bounds[PROPOSED_LAW, one])} times the bound in {one}" for one in SCENARIOS
    )
    return wb.Finding(
        "rule_of_thumb",
        (
            "Without delay the rule ",
            RULE,
            f" lies between the last quiet period and the next one tried in {within(ratios)} of {len(ratios)} loops "
            f"of laws with a gain K.{others} The rule is too long for {too_long(ratios)}.",
        ),
        (
            "The bound ",
            BOUND,
            f" needs no eigenvalue of a product, but may be much shorter: the longest quiet period of {PROPOSED_LAW} "
            f"is {own}; over all loops the ratio is {min(low for low, _ in bounds.values()):.2g} to "
            f"{max(high for _, high in bounds.values()):.2g}.",
        ),
        statistic=(
            "The last quiet period and the next one tried, divided by the rule, by law and scenario. ρ is the largest "
            "eigenvalue of ",
            MATRIX,
            " along the run in continuous time, while s is in the layer of width φ. With a torque one period late the "
            "rule is halved.",
        ),
        sample=f"{len(ratios)} loops: {len({law for law, _ in ratios})} laws in two scenarios, from the paper's start, "
        "one run for each period.",
        information=INFORMATION,
        assumptions=f"{ASSUMPTIONS} Quiet: at most {QUIET:g} times the total variation of continuous time.",
        fitted_numbers=FITS,
        answer=f"too long for {too_long(ratios)}",
        variations=tuple(rule_variations(evidence)),
        limitations="Arms with other masses.",
    )


def ratio_words(ends: tuple[float, float]) -> str:
    """The two ends of a search over a period."""
    return f"{ends[0]:.2f} to {ends[1]:.2f}"
