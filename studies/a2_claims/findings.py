"""The findings of a2: the count of printed equations by verdict, the two theorems, and the comparisons."""

from collections import Counter
from collections.abc import Mapping, Sequence

import workbench as wb
from studies.a2_claims.phrases import phrase
from studies.a2_claims.printed_statements import PRINTED_STATEMENTS, decisive
from studies.a2_claims.rivals import ALSO_AS_PUBLISHED, METRICS

SUBSTITUTIONS = ("(12)", "(13)", "(16)", "(18)", "(20)", "(37)", "(38)")
UNCHECKED_KINDS: Sequence[wb.proofs.Kind] = ("not checkable as published", "not checkable", "ill-posed", "not refuted")
WEIGHTS = "Q, R, l, the reading of (33) and the square wave, as in report a1, if a run needs them"
ROOM = "Proofs hold for all states. Each claim with a run has one run, with the error of its step."


def counts(ledger: wb.proofs.ClaimLedger) -> Mapping[wb.proofs.Kind, int]:
    """The number of printed equations of each verdict."""
    return Counter(decisive(ledger, item).ruling.kind for item in PRINTED_STATEMENTS)


def answer(ledger: wb.proofs.ClaimLedger) -> str:
    """The count of printed equations by verdict, in one line."""
    count = counts(ledger)
    theorems = all(
        decisive(ledger, item).ruling.kind == "refuted" for item in PRINTED_STATEMENTS if "Theorem" in item.name
    )
    return (
        f"Of the paper's {len(PRINTED_STATEMENTS)} printed equations, assumptions and theorems that assert something, "
        f"{count['proved']} are proved and {count['refuted']} are refuted{', among them both theorems' * theorems}; "
        f"{count['depends on']} depend on Q and R, which the paper does not state; "
        f"{sum(count[kind] for kind in UNCHECKED_KINDS)} cannot be checked."
    )


def findings(ledger: wb.proofs.ClaimLedger) -> tuple[wb.Finding, ...]:
    """The findings of the page."""
    return printed_equations(ledger), first_theorem(ledger), second_theorem(ledger), comparisons(ledger)


def refuted_count(lines: Sequence[wb.proofs.ClaimEntry], *kinds: wb.proofs.Kind) -> str:
    """The number of refuted lines among all, with other kinds that count as refuted."""
    return f"{sum(line.ruling.kind in ('refuted', *kinds) for line in lines)} of {len(lines)} refuted"


def printed_equations(ledger: wb.proofs.ClaimLedger) -> wb.Finding:
    """The count of printed equations that are refuted, and the same count by other rules."""
    items = [(item, decisive(ledger, item)) for item in PRINTED_STATEMENTS]
    lines = [line for _, line in items]
    split = [ledger[name] for name in dict.fromkeys(name for item in PRINTED_STATEMENTS for name in item.claims)]
    of_paper = [line for line in split if all(one.chosen_by == "source" or one.within for one in line.quantifiers)]
    published = [ledger[name] for name in (*(metric[0] for metric in METRICS), *ALSO_AS_PUBLISHED)]
    left = [line for item, line in items if item.name not in SUBSTITUTIONS]
    rules = {
        "a count of the single claims into which the items are split": refuted_count(split),
        "a count of the single claims whose ranges are the paper's": refuted_count(of_paper),
        "a count in which items that depend on Q and R are refuted": refuted_count(lines, "depends on"),
        "a count without the seven plain substitutions": refuted_count(left),
        "a count that includes the statements on simulations": refuted_count([*lines, *published]),
    }
    names = [item.name for item, line in items if line.ruling.kind == "refuted"]
    depending = [item.name for item, line in items if line.ruling.kind == "depends on"]
    return wb.Finding(
        "printed_equations",
        phrase(answer(ledger)),
        phrase(
            f"Refuted are {'; '.join(names)}. Those that depend on Q and R are {'; '.join(depending)}. Each refutation "
            "has a witness that anyone can replay. The count depends on the rule of counting; the verdicts do not."
        ),
        statistic="The number of printed items by verdict: each equation, assumption and theorem once.",
        sample="All 43 numbered equations, 2 theorems and 4 assumptions; definitions and repetitions are left out.",
        information="The printed page. Each item is judged in its most favourable reading.",
        assumptions=WEIGHTS,
        answer=refuted_count(lines),
        variations=tuple(wb.Variation(words, count) for words, count in rules.items()),
        limitations="A judge who reads 'sufficiently large' or 'bounded term' in another way.",
    )


def fails(line: wb.proofs.ClaimEntry) -> str:
    """The answer of a line: fails, holds, or its verdict in words."""
    return (
        "fails"
        if line.ruling.kind in wb.proofs.BREAKING_KINDS
        else "holds"
        if line.ruling.kind == "proved"
        else line.ruling.verdict
    )


def comparison_count(line: wb.proofs.ClaimEntry) -> str:
    """The comparisons of a line, counted."""
    evidence = line.ruling.evidence
    return evidence[evidence.index("below in") :].rstrip(".")


def first_theorem(ledger: wb.proofs.ClaimLedger) -> wb.Finding:
    """Theorem 1 under the gains of section 5 and others."""
    main = ledger["Theorem 1, gains of section 5"]
    lines = {
        "the plainest positive definite gains, L1 = L2 = I": "Theorem 1",
        "the step (22) of its proof, with the best of all gains": "(22)",
        "small errors beside an arm at rest, hanging or upright": "Theorem 1, small errors at rest",
    }
    return wb.Finding(
        "theorem_1",
        phrase(
            "Theorem 1 fails for the gains of section 5: beside an arm at rest, observer (10) can stay at an "
            "equilibrium far from the arm for ever."
        ),
        phrase(main.ruling.evidence),
        statistic="Equilibria of (10), proved by interval arithmetic; linear modes, by Routh's array.",
        sample="The arm at rest, hanging or upright; gains of 1, 10 and 100 times those of section 5, and L1 = L2 = I.",
        information="The positions, the torque and the exact model, without disturbance, as in (9).",
        answer=fails(main),
        variations=tuple(wb.Variation(words, fails(ledger[name]), name) for words, name in lines.items()),
        limitations=phrase(
            "Gains above 100 times those of section 5, and other ratios of L2 to L1. Report a4 has regions where the "
            "theorem holds."
        ),
    )


def second_theorem(ledger: wb.proofs.ClaimLedger) -> wb.Finding:
    """Theorem 2 under each of its readings."""
    main = ledger["(41), along (35)"]
    lines = {
        "the estimates obey (10), with the repaired law and D_hat = eta": "(41), along (10)",
        "the bound (42) of the settling time": "(42)",
        "boundedness of all signals": "Theorem 2, bounded signals",
        "the step (40) of its proof": "(40)",
    }
    return wb.Finding(
        "theorem_2",
        phrase(
            "Theorem 2 fails for every Q and R: s and e1 tend to zero only if D - D_hat tends to zero, and with the "
            "sines of section 5 it does not."
        ),
        phrase(main.ruling.evidence),
        statistic="The exact normal form of M e2' where s = 0 and e1 = 0; then the largest |s| and |e1| late in a run.",
        sample=ROOM,
        information="Estimates that obey (35), the best case for the observer.",
        assumptions=WEIGHTS,
        answer=fails(main),
        variations=tuple(wb.Variation(words, fails(ledger[name]), name) for words, name in lines.items()),
        limitations="No disturbance, or a disturbance that vanishes: Assumption 4 allows both.",
    )


def comparisons(ledger: wb.proofs.ClaimLedger) -> wb.Finding:
    """The statements on the simulations, as published and with the numbers of a1."""
    published = [ledger[name] for name in (*(metric[0] for metric in METRICS), *ALSO_AS_PUBLISHED)]
    unchecked = sum(line.ruling.kind == "not checkable as published" for line in published)
    lines = {name: ledger[f"{name}, numbers of a1"] for name, *_ in METRICS}
    broken = sum(line.ruling.kind in wb.proofs.BREAKING_KINDS for line in lines.values())
    return wb.Finding(
        "comparisons",
        f"{unchecked} of {len(published)} statements on the simulations cannot be checked as published; with the "
        f"numbers of a1, {broken} of {len(lines)} fail against at least one rival.",
        "The paper states neither Q, R and l nor the horizons, the square wave or any gain of a rival.",
        statistic="The metric that a statement names, as in report a1, against each rival at each joint.",
        sample="One run of each law in each scenario.",
        information="Rivals: exact positions and velocities. AOSMC-RGS: positions, and the true disturbance, filtered.",
        assumptions=WEIGHTS,
        answer="cannot be checked",
        variations=tuple(
            wb.Variation(f"{name}, with the numbers of a1", fails(line).split(" in ")[0], comparison_count(line))
            for name, line in lines.items()
        ),
        limitations="Tuned gains of the rivals, and noise: report a8 has both.",
    )
