"""The findings of a9, each with the variations of its answer over laws, starts, delays and periods."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

import workbench as wb
from studies.a9_sampling.evidence import APART, PERIODS, PLACES, Evidence, Scores, printed_pairs
from studies.a9_sampling.loops import MS, NOISY, REALISTIC, WAYS
from studies.a9_sampling.period_findings import base, longest_period, reference, rule_of_thumb
from studies.a9_sampling.words import ASSUMPTIONS, FITS, INFORMATION, two_digits
from studies.paper.card import MARGIN, PROPOSED_LAW
from studies.paper.linearization import SEVEN
from studies.paper.quiet_periods import ACTING_TORQUE, FACTORS, PAPERS, QUIET, RMSE, SCENARIOS, TRUTH, TV, ends, in_ms

PAIR = {"euler": "Euler", "cayley": "Cayley"}
ROUGH = {"late": (True, False), "noisy": (False, True), "late and noisy": (True, True)}  # with a delay, with noise
LOST_ABOVE = (1.5, 2.0, 5.0)  # times the RMSE of continuous time: other meanings of a lost run
MARGINS = (0.0, 0.05)  # in place of `MARGIN`
CELLS = tuple((scenario, period) for scenario in SCENARIOS for period in APART)


def findings(evidence: Evidence) -> tuple[wb.Finding, ...]:
    """All findings."""
    return (
        chattering(evidence),
        longest_period(evidence),
        rule_of_thumb(evidence),
        lost_runs(evidence),
        published_order(evidence),
    )


def answer(evidence: Evidence) -> str:
    """The answer of the page in one line."""
    late, near = base(evidence), reference(evidence)
    change = worst_change(evidence)[1]
    quiet = wb.document.join_names(quiet_laws(evidence, evidence.computer_scores(TV, REALISTIC)))
    return (
        f"At {MS} without noise, only {quiet} avoid chattering; RMSE differs at most {100 * change:.1f} % from "
        f"continuous time. With one-period delay, {PROPOSED_LAW}'s longest period without chattering is "
        f"{in_ms(ends(late))} ms, or {in_ms(ends(near))} ms if started on the reference."
    )


# Chattering


def quiet_laws(
    evidence: Evidence, now: Scores, factor: float = QUIET, scenarios: tuple[str, ...] = SCENARIOS
) -> tuple[str, ...]:
    """The laws whose total variation is at most `factor` times that of continuous time."""
    return tuple(law for law in SEVEN if evidence.growth(TV, law, now, scenarios) <= factor)


class ComputerWay(NamedTuple):
    """A way to compute a law: a period in s, the stepping of AOSMC-RGS, and whether delay and noise are there."""

    period: float
    stepping: str = "euler"
    delay: bool = False
    noisy: bool = False

    def scores(self, evidence: Evidence, metric: str) -> Scores:
        """The scores of a metric by law, scenario and joint."""
        return evidence.computer_scores(metric, *self)


def computers() -> Iterator[tuple[str, ComputerWay]]:
    """All computers of the study in words, with period, stepping of AOSMC-RGS, delay and noise."""
    for way, name in PAIR.items():
        stepping = f", {PROPOSED_LAW} by {name} steps" if way != "euler" else ""
        for period in PERIODS:
            yield f"{1e3 * period:g} ms{stepping}", ComputerWay(period, way)
            yield f"{1e3 * period:g} ms, noisy{stepping}", ComputerWay(period, way, noisy=True)
        for delay, noisy in ((True, False), (True, True)):
            yield f"{MS}, late{' and noisy' * noisy}{stepping}", ComputerWay(REALISTIC, way, delay, noisy)


def chattering(evidence: Evidence) -> wb.Finding:
    """The laws that chatter in a computer."""
    now = evidence.computer_scores(TV, REALISTIC)
    quiet = quiet_laws(evidence, now)
    growth = {law: evidence.growth(TV, law, now) for law in SEVEN}
    loudest, (place, change, error) = max(growth, key=growth.__getitem__), worst_change(evidence)
    law, scenario, joint = place
    variations = [
        wb.Variation(words, wb.document.join_names(quiet_laws(evidence, how.scores(evidence, TV))))
        for words, how in computers()
        if how != ComputerWay(REALISTIC)
    ]
    variations += [
        wb.Variation(f"quiet at up to {factor:g} times", wb.document.join_names(quiet_laws(evidence, now, factor)))
        for factor in FACTORS
    ]
    variations += [
        wb.Variation(f"{one} alone", wb.document.join_names(quiet_laws(evidence, now, scenarios=(one,))))
        for one in SCENARIOS
    ]
    return wb.Finding(
        "chattering",
        f"At a period of {MS}, with exact readings, only {wb.document.join_names(quiet)} keep the total "
        f"variation of their torque "
        f"within {QUIET:g} times its value in continuous time; {loudest} has {two_digits(growth[loudest])} times that "
        "value.",
        "The sampled RMSE, (43), does not show this: it changes by at most "
        f"{100 * change:.2f} ± {100 * error:.2f} % ({law}, {scenario}, joint {joint + 1}).",
        statistic="The ratio of the total variation of the torque in the computer to its value in continuous time, the "
        "largest over joints and scenarios.",
        sample=f"{len(SEVEN)} laws in two scenarios, one run each with exact readings and no delay. Variations with "
        f"noise have the mean of {NOISY} runs.",
        information=INFORMATION,
        assumptions=f"{ASSUMPTIONS} The limit of {QUIET:g} times. Memories step by explicit Euler.",
        fitted_numbers=FITS,
        answer=wb.document.join_names(quiet),
        variations=tuple(variations),
        limitations="A wider boundary layer or smaller gains, with which fewer laws chatter.",
    )


def worst_change(evidence: Evidence) -> tuple[tuple[str, str, int], float, float]:
    """The law, scenario and joint whose RMSE changes most at `REALISTIC`, with the change and its error, in parts."""
    still, now = evidence.continuous_scores(RMSE), evidence.computer_scores(RMSE, REALISTIC)
    change = {(law, *at): abs(now(law, *at)[0] / still(law, *at)[0] - 1) for law in SEVEN for at in PLACES}
    place = max(change, key=change.__getitem__)
    return place, change[place], now(*place)[1] / still(*place)[0]


# Lost runs


def blame(
    evidence: Evidence,
    above: float = np.inf,
    cells: Iterable[tuple[str, float]] | None = None,
    delay: bool = False,
) -> tuple[int, ...]:
    """Of the runs that Euler loses: those lost by the integrator, by the law, and unsettled."""
    chosen = [(scenario, period) for scenario in SCENARIOS for period in APART] if cells is None else list(cells)
    each = [evidence.causes(*cell, above, delay) for cell in chosen]
    flow, law, unsettled = (
        sum(getattr(one, by) for one in each) for by in ("by_integrator", "by_law", "undecided_runs")
    )
    return flow, law, unsettled


def blame_words(integrator: int, law: int, undecided_runs: int) -> str:
    """The answer to the question what loses the runs."""
    if undecided_runs:
        return "unsettled"
    if integrator and law:
        return "both"
    return "the integrator" if integrator else "the law" if law else "no run is lost"


def lost_runs(evidence: Evidence) -> wb.Finding:
    """The runs that diverge, and what loses them."""
    counts = blame(evidence)
    total = sum(counts)
    causes = [evidence.causes(*cell) for cell in CELLS]
    kept = sum(int((one.diverges["cayley34"] == 0).sum()) for one in causes)
    others = (
        sum(int(evidence.audit(law, at, T).is_lost.sum()) for law in SEVEN for at in SCENARIOS for T in PERIODS) - total
    )
    runs = len(SEVEN) * len(SCENARIOS) * len(PERIODS) * (1 + NOISY)
    variations = [
        wb.Variation(f"judged only by {WAYS[way]}", *judged_by(evidence, way)) for way in WAYS if way != "euler"
    ]
    variations += [
        wb.Variation(f"{scenario}, {1e3 * period:g} ms", blame_words(*blame(evidence, cells=[(scenario, period)])))
        for scenario, period in CELLS
        if sum(blame(evidence, cells=[(scenario, period)]))
    ]
    late = blame(evidence, delay=True)
    if sum(late):
        variations.append(wb.Variation("torque one period late", blame_words(*late), loss_words(*late)))
    for above in LOST_ABOVE:
        by = blame(evidence, above)
        words = f"a run is lost if its RMSE is more than {above:g} times the value in continuous time"
        variations.append(wb.Variation(words, blame_words(*by), loss_words(*by)))
    return wb.Finding(
        "lost_runs",
        f"With explicit Euler {total} of {runs} runs diverge, all of {PROPOSED_LAW} at {apart()}. Of these {kept} stay "
        f"finite if only (34) takes a Cayley step, and {counts[0]} with {WAYS['fine']} per period."
        if not others
        else f"With explicit Euler {total + others} of {runs} runs diverge, {total} of them of {PROPOSED_LAW}.",
        "If finer steps keep a run finite, the integrator caused the divergence, otherwise the law. A finite run need "
        f"not be accurate: at {1e3 * max(APART):g} ms {longest_rmse(evidence)}. In the searches, with exact readings "
        f"and a torque one period late, these runs diverge: {late_losses(evidence)}.",
        statistic=f"Counts of runs that diverge. The RMSE is the largest over {len(PLACES)} joints and scenarios, with "
        "exact readings.",
        sample=f"{len(SEVEN)} laws, two scenarios, {len(PERIODS)} periods up to {1e3 * max(PERIODS):g} ms, no delay: "
        f"one run with exact readings and {NOISY} with noise. {PROPOSED_LAW} at {apart()}: four ways to step, each "
        "without delay and with a delay of one period.",
        information=f"{PROPOSED_LAW}: positions, the true disturbance and the exact model.",
        assumptions=ASSUMPTIONS,
        fitted_numbers=FITS,
        answer=blame_words(*counts),
        variations=tuple(variations),
        limitations="Delay together with noise for the other laws; longer periods.",
        is_decided=total > 0 and not counts[2],
    )


def late_losses(evidence: Evidence) -> str:
    """The runs that diverge in the searches with a torque that is a period late, from the paper's start."""
    lost: dict[tuple[str, str], list[str]] = {}
    for one in evidence.searches_with(delay=True, start=PAPERS, observer=TRUTH, counts_on=ACTING_TORQUE):
        for period, share in zip(one.largest_setting.threshold.values, one.largest_setting.worst(TV), strict=True):
            if np.isinf(share):
                lost.setdefault((one.search.law, one.search.scenario), []).append(f"{1e3 * period:.3g}")
    each = [f"{law} in {scenario} at {wb.document.join_names(periods)} ms" for (law, scenario), periods in lost.items()]
    return "; ".join(each) or "none"


def loss_words(integrator: int, law: int, undecided_runs: int) -> str:
    """The lost runs by what loses them, in words."""
    unknown = f", {undecided_runs} unsettled" if undecided_runs else ""
    return f"of {integrator + law + undecided_runs} runs {integrator} by the integrator, {law} by the law{unknown}"


def judged_by(evidence: Evidence, way: str) -> tuple[str, str]:
    """The answer if only this way of stepping is beside Euler, with its counts."""
    lost = np.concatenate([evidence.causes(at, T).diverges[way] for at in SCENARIOS for T in APART])
    return blame_words(int((lost == 0).sum()), int(lost.sum()), 0), f"{int((lost == 0).sum())} of {lost.size} finite"


def longest_rmse(evidence: Evidence) -> str:
    """By way of stepping, the RMSE of AOSMC-RGS at the longest period over its value in continuous time, in words."""
    found = {
        words: evidence.growth(RMSE, PROPOSED_LAW, evidence.computer_scores(RMSE, max(APART), way))
        for way, words in WAYS.items()
    }
    finite = wb.document.join_names(f"{ratio:.2f} ({words})" for words, ratio in found.items() if np.isfinite(ratio))
    lost = [words for words, ratio in found.items() if np.isinf(ratio)]
    diverged = f"; the run by {wb.document.join_names(lost)} diverges" if lost else ""
    return f"the ratio of the RMSE to its value in continuous time is {finite}{diverged}"


def apart() -> str:
    """The periods at which all ways of stepping were run."""
    return " and ".join(f"{1e3 * period:g}" for period in APART) + " ms"


# The published order


def published_order(evidence: Evidence) -> wb.Finding:
    """The pairs of the published tables that hold in continuous time, and in a computer."""
    still, now = evidence.continuous_scores(RMSE), evidence.computer_scores(RMSE, REALISTIC, delay=True, noisy=True)
    before, after = printed_pairs(still), printed_pairs(now)
    kept = len(before["below"] & after["below"])
    variations = [
        wb.Variation(words, f"{len(before['below'] & printed_pairs(how.scores(evidence, RMSE))['below'])}")
        for words, how in computers()
        if how != ComputerWay(REALISTIC, delay=True, noisy=True)
    ]
    for margin in MARGINS:
        one, other = printed_pairs(still, margin), printed_pairs(now, margin)
        words = f"a margin of {100 * margin:g} %"
        held = len(one["below"] & other["below"])
        variations.append(wb.Variation(words, f"{held}", f"{len(one['below'])} in continuous time"))
    total = sum(map(len, before.values()))
    return wb.Finding(
        "published_order",
        f"Of the {total} pairs of laws in the published tables, {len(before['below'])} have the printed order in "
        f"continuous time; {kept} of these keep it at a period of {MS} with delay and noise.",
        f"In continuous time {len(before['above'])} pairs have the opposite order and {len(before['undecided'])} are "
        f"too close to call; in the computer these are {len(after['above'])} and {len(after['undecided'])} pairs.",
        statistic=f"The order of two laws by the sampled RMSE, (43), if they differ by more than {100 * MARGIN:g} % "
        "and by more than both errors.",
        sample=f"{total} pairs of six laws, both joints and scenarios; with noise the mean of {NOISY} runs.",
        information=INFORMATION,
        assumptions=f"{ASSUMPTIONS} The margin of {100 * MARGIN:g} %; the numbers of all rivals, which the paper does "
        "not state.",
        fitted_numbers=FITS,
        answer=f"{kept}",
        variations=tuple(variations),
        limitations="Other numbers of the rivals, which report a6 varies.",
    )
