"""The findings of a9 on quiet periods: the longest one of AOSMC-RGS by its start, and the rule of thumb."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from studies.a9_sampling.evidence import Evidence
from studies.a9_sampling.loops import SCENARIOS
from studies.a9_sampling.quiet_periods import (
    FACTORS,
    ON_REFERENCE,
    PAPERS,
    QUIET,
    RULE,
    STARTS,
    TRUTH,
    QuietPeriod,
    QuietSearch,
    at_hand_over,
    conditions,
    ends,
    in_ms,
)
from studies.a9_sampling.words import CHOSEN, FITTED, GIVEN, listed
from studies.paper.card import PROPOSED
from workbench.study.document.finding import Finding, Variation

BASE = QuietSearch(PROPOSED, delay=True)


def one_of(evidence: Evidence, **fields: object) -> QuietPeriod:
    """The search whose fields have these values."""
    (found,) = evidence.searched(**fields)
    return found


def base(evidence: Evidence) -> QuietPeriod:
    """The search of AOSMC-RGS from the paper's start in the first scenario, a period late."""
    return next(one for one in evidence.quiet if one.search == BASE)


def reference(evidence: Evidence) -> QuietPeriod:
    """The same search from a start on the reference."""
    return one_of(evidence, law=PROPOSED, scenario="FS", start=ON_REFERENCE, delay=True, observer=TRUTH)


def longest_period(evidence: Evidence) -> Finding:
    """The longest quiet period of AOSMC-RGS, by start."""
    late, near = base(evidence), reference(evidence)
    variations = [
        Variation(conditions(one.search), at_hand_over(one), detail(one))
        for one in evidence.searched(law=PROPOSED)
        if one.search != BASE
    ]
    variations += [
        Variation(
            f"at most {factor:g} times the total variation",
            at_hand_over(late, factor),
            f"up to {in_ms(ends(late, factor))} ms",
        )
        for factor in FACTORS
    ]
    return Finding(
        "longest_period",
        f"With a torque that is a period late, {PROPOSED} is quiet up to {in_ms(ends(late))} ms from the paper's start "
        f"and up to {in_ms(ends(near))} ms from a start on the reference.",
        f"Its gain K grows with the error at the start: to {late.K or 0:.2g} N m from the paper's, to "
        f"{near.K or 0:.2g} N m from a start on the reference. The next periods tried, {1e3 * ends(late)[1]:.2g} and "
        f"{1e3 * ends(near)[1]:.2g} ms, chatter.",
        statistic=f"The longest period tried up to which the total variation of the torque is at most {QUIET:g} times "
        "its value in continuous time, at both joints.",
        sample="One run a period, first scenario, exact readings.",
        given=GIVEN,
        chosen=f"{CHOSEN} The limit of {QUIET:g} times; explicit Euler; a torque without limit.",
        fitted=FITTED,
        answer=at_hand_over(late),
        variations=tuple(variations),
        untried="Noise in the readings; other numbers of the law.",
        cites=("b4_handover/longest_period",),
    )


def detail(one: QuietPeriod) -> str:
    """The longest quiet period, and the largest gain."""
    return f"up to {in_ms(ends(one))} ms; K up to {one.K or 0:.2g} N m"


# The rule of thumb


def ruled(quiet: Iterable[QuietPeriod], factor: float = QUIET) -> dict[str, tuple[float, float]]:
    """By law, the ends of its search over its rule of thumb, each the least of several scenarios."""
    by_law: dict[str, list[QuietPeriod]] = {}
    for one in quiet:
        if one.rule is not None and one.search.observer == TRUTH:
            by_law.setdefault(one.search.law, []).append(one)
    ratios = {}
    for law, each in by_law.items():
        rule = min(one.rule for one in each if one.rule is not None)
        low, high = (min(ends(one, factor)[i] for one in each) for i in (0, 1))
        ratios[law] = (low / rule, high / rule)
    return ratios


def too_long(ratios: Mapping[str, tuple[float, float]]) -> tuple[str, ...]:
    """The laws whose rule of thumb is too long: both ends of the search are below 1."""
    return tuple(law for law, (_, high) in ratios.items() if high < 1)


def undecided(ratios: Mapping[str, tuple[float, float]]) -> tuple[str, ...]:
    """The laws whose rule of thumb lies between the ends of the search, so that it is neither safe nor too long."""
    return tuple(law for law, (low, high) in ratios.items() if low < 1 <= high)


def rule_of_thumb(evidence: Evidence) -> Finding:
    """The rule of thumb beside the searches."""
    still = ruled(evidence.searched(start=PAPERS, delay=False))
    unsafe, open_ = too_long(still), undecided(still)
    safe = [law for law in still if law not in unsafe + open_]
    variations = []
    for start, delay, scenarios in (
        (start, delay, scenarios)
        for start in STARTS
        for delay in (False, True)
        for scenarios in (SCENARIOS, *((one,) for one in SCENARIOS))
    ):
        each = [one for one in evidence.searched(start=start, delay=delay) if one.search.scenario in scenarios]
        if (start, delay, scenarios) != (PAPERS, False, SCENARIOS) and each:
            ratios = ruled(each)
            words = f"{' and '.join(scenarios)}, {STARTS[start]}, {'torque a period late' if delay else 'no delay'}"
            variations.append(Variation(words, f"too long for {listed(too_long(ratios))}", ratio_words(ratios)))
    for factor in FACTORS:
        ratios = ruled(evidence.searched(start=PAPERS, delay=False), factor)
        words = f"at most {factor:g} times the total variation"
        variations.append(Variation(words, f"too long for {listed(too_long(ratios))}", ratio_words(ratios)))
    between = f"; for {listed(open_)} the search cannot decide" if open_ else ""
    return Finding(
        "rule_of_thumb",
        (
            "Without delay the period ",
            RULE,
            f" is quiet for {len(safe)} of {len(still)} laws with a gain K and too long for {listed(unsafe)}{between}.",
        ),
        f"The longest quiet period over the rule lies between: {ratio_words(still)}. A rule within these ends is "
        "neither quiet nor too long.",
        statistic="The two ends of the search for the longest quiet period, over the rule with the largest K of a run "
        "and the least eigenvalue of M along it. Error: the width of the search.",
        sample=f"{len(still)} laws, both scenarios, the paper's start, one run a period.",
        given=GIVEN,
        chosen=f"{CHOSEN} Quiet: at most {QUIET:g} times the total variation of continuous time.",
        fitted=FITTED,
        answer=f"too long for {listed(unsafe)}",
        variations=tuple(variations),
        untried="Arms with other masses.",
    )


def ratio_words(ratios: Mapping[str, tuple[float, float]]) -> str:
    """The ends of each law."""
    return ", ".join(f"{law} {low:.2f} to {high:.2f}" for law, (low, high) in ratios.items())
