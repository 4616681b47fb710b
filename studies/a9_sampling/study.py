"""The paper's laws run by a computer: which survive a sampling period, a delay and noise, and which only chatter?

Runs in about a minute on two idle cores, twenty seconds more the first time.
"""

from collections.abc import Sequence

import numpy as np

from studies.a1_paper_tables.study import PROPOSED_STEP, STEPS, STYLES
from studies.a9_sampling import pages
from studies.a9_sampling.evidence import (
    APART,
    PERIODS,
    PLACES,
    QUIET,
    RULE,
    Curve,
    Evidence,
    gathered,
    plan,
    printed,
    tally,
    works,
)
from studies.a9_sampling.loops import HORIZON, MS, NOISY, REALISTIC, RMSE, SCENARIOS, SEED, TV, WAYS, metrics, sweep
from studies.paper.card import MARGIN, PROPOSED
from studies.paper.linearization import SEVEN, loop_of
from workbench.study.contract import Run
from workbench.study.document.document import Section, Verdict
from workbench.study.study import Case, Results, Study

GIVEN = "AOSMC-RGS: positions and the true disturbance. Others: positions and velocities. All: exact model."
QUIETLY = f"Quiet: at most {QUIET:g} times the total variation of continuous time."


def finite(evidence: Evidence) -> Verdict:
    """The runs that stay finite, with the steps that keep (34) definite and with Euler."""
    cells = [(law, scenario, period) for period in PERIODS for law in SEVEN for scenario in SCENARIOS]
    total = len(cells) * (1 + NOISY)
    ways = {way: {cell: int(evidence.found(*cell, way).lost.sum()) for cell in cells} for way in ("euler", "cayley")}
    left = {way: total - sum(lost.values()) for way, lost in ways.items()}
    named = {
        way: ", ".join(f"{n} of {law} at {1e3 * T:g} ms ({at})" for (law, at, T), n in lost.items() if n) or "none"
        for way, lost in ways.items()
    }
    return Verdict(
        "found",
        f"With AOSMC-RGS by Cayley steps of (34) and (10), {left['cayley']} of {total} runs of all laws stay finite up "
        f"to {1e3 * max(PERIODS):g} ms; with explicit Euler of all memories {left['euler']} do.",
        f"Diverged of {1 + NOISY} each, by Cayley steps: {named['cayley']}; by explicit Euler: {named['euler']}.",
        estimand=f"Counts over {len(SEVEN)} laws, both scenarios and {len(PERIODS)} periods without delay: one run "
        f"with exact readings and {NOISY} with noise.",
        given=GIVEN,
        reversal="A single run that diverges by these steps.",
    )


def integrator(evidence: Evidence) -> Verdict:
    """The runs of AOSMC-RGS that explicit Euler alone loses, and what is left of its error without."""
    causes = [evidence.causes(scenario, period) for scenario in SCENARIOS for period in APART]
    flow, law, unsettled = (sum(getattr(one, by) for one in causes) for by in ("by_integrator", "by_law", "unsettled"))
    kept, total = sum(int((one.lost["cayley34"] == 0).sum()) for one in causes), flow + law + unsettled
    longest, still = max(APART), evidence.still(RMSE)
    worst = {
        words: max(evidence.at(RMSE, longest, way)(PROPOSED, *at)[0] / still(PROPOSED, *at)[0] for at in PLACES)
        for way, words in WAYS.items()
    }
    return Verdict(
        "found" if law or flow == kept == total > 0 else "open",
        f"Of {total} runs of {PROPOSED} that explicit Euler loses, {kept} stay finite with a Cayley step of (34) "
        f"alone; the law itself loses {law}, and {unsettled} are unsettled.",
        f"{flow} stay finite near the exact flow of the memories with the same noise. Finite is less than good: at "
        f"{1e3 * longest:g} ms the RMSE (43) over that of continuous time: "
        f"{', '.join(f'{factor:.2f} by {words}' for words, factor in worst.items()).replace('inf', 'diverged')}.",
        estimand=f"All runs that explicit Euler loses at {' and '.join(f'{1e3 * T:g}' for T in APART)} ms, without "
        f"delay. RMSE: the largest of {len(PLACES)} joints and scenarios, with exact readings.",
        given=f"{PROPOSED}: positions, the true disturbance and the exact model.",
        reversal="A run that is lost in every way, and so by the law itself.",
    )


def unseen(evidence: Evidence) -> Verdict:
    """The share of what a computer does that the paper's own figure shows."""
    still, now = evidence.still(RMSE), evidence.at(RMSE, REALISTIC)
    change = {(law, *at): abs(now(law, *at)[0] / still(law, *at)[0] - 1) for law in SEVEN for at in PLACES}
    worst = law, scenario, joint = max(change, key=change.get)
    factor = {law: max(evidence.factor(law, *place) for place in PLACES) for law in SEVEN}
    return Verdict(
        "found",
        f"A computer of {MS} changes the RMSE (43) of a law by up to {100 * change[worst]:.2f} %, and the total "
        f"variation of its torque by a factor of up to {_round(max(factor.values()))}.",
        f"The RMSE of {law} ({scenario}, joint {joint + 1}) changes most, with an error of "
        f"{100 * now(*worst)[1] / still(*worst)[0]:.2f} %; "
        f"the variation that of {max(factor, key=factor.get)}. Within {QUIET:g} times: "
        f"{', '.join(law for law in SEVEN if factor[law] <= QUIET) or 'none'}.",
        estimand=f"Each over continuous time, the largest of {len(SEVEN)} laws and {len(PLACES)} joints and scenarios, "
        "one run each with exact readings, without delay, by explicit Euler.",
        given=GIVEN,
        reversal="A wider layer or a smaller gain, with which the laws do not chatter at this period.",
    )


def survives(evidence: Evidence) -> Verdict:
    """The part of the published ranking that a realistic computer leaves."""
    before, now = printed(evidence.still(RMSE)), printed(evidence.at(RMSE, REALISTIC, delay=True, noisy=True))
    return Verdict(
        "found",
        f"Of {len(before['below'])} printed pairs of laws that hold in continuous time "
        f"{len(before['below'] & now['below'])} hold at {MS}, a period late, with noise.",
        f"{len(before['below'] & now['above'])} are turned and {len(before['below'] & now['undecided'])} become too "
        f"close to call. Of all printed pairs, in continuous time {tally(before)}; with this computer {tally(now)}.",
        estimand=f"Order by RMSE (43): with noise the mean of {NOISY} runs, apart by more than {100 * MARGIN:g} % and "
        "twice the standard errors.",
        given=GIVEN,
        reversal="A longer period, or other numbers of the rivals, which the paper does not state (a6).",
    )


def thumb(evidence: Evidence) -> Verdict:
    ruled = {law: safe for law, safe in evidence.safe.items() if np.isfinite(safe.rule)}
    ratios = {law: (safe.quiet[0].largest / safe.rule, safe.quiet[0].next / safe.rule) for law, safe in ruled.items()}
    listed = ", ".join(f"{law} {low:.2f} to {high:.2f}" for law, (low, high) in ratios.items())
    late = ", ".join(law for law, safe in ruled.items() if safe.quiet[1].next < safe.rule)
    safe_for = sum(low >= 1 for low, _ in ratios.values())
    return Verdict(
        "found",
        (
            "Without delay ",
            RULE,
            f", with the least eigenvalue of M, is a safe period of {safe_for} of {len(ratios)} laws.",
        ),
        f"The ends of the search for the longest quiet period over the rule, which is too long below 1: {listed}. With "
        f"a period of delay it is too long for: {late or 'none'}.",
        estimand=f"The rule with the largest gain of a run and the worst pose, beside a search by runs in both "
        f"scenarios. {QUIETLY}",
        given=GIVEN,
        reversal="A period of delay." if late else "A larger gain than those of these runs.",
    )


def computers(evidence: Evidence, curves: Sequence[Curve]) -> Verdict:
    """The parts of chattering that belong to the computer and to the simulation."""
    laws = " and ".join(sorted({c.law for c in curves}))
    spread = max(float(np.ptp(c.TV, axis=0).max() / c.TV.min()) for c in curves if c.digital)
    layers = [c for c in curves if c.switching == "clip" and not c.digital]
    own, worst = max((float((c.TV.max(axis=0) / c.TV[np.argmin(c.h)]).max()), c.law) for c in layers)
    return Verdict(
        "found",
        f"A shorter step of the simulation changes the total variation of {laws} with a computer of {MS} in the first "
        f"scenario by at most {100 * spread:.2g} % (of all laws, in both scenarios, by up to "
        f"{100 * evidence.worst_step(TV, REALISTIC):.2g} %); in continuous time the step changes it up to "
        f"{_round(own)} times.",
        f"The latter is {worst} with its layer, beyond the stability limit of RK4, over what the shortest step shows. "
        "There it is the step that chatters. A relay in continuous time varies the more the shorter the step is.",
        estimand=f"TV of one run a law and step in the first scenario, of {laws} with layer and relay; of all laws, "
        "half the substep in place of the whole one, with the layer.",
        given=GIVEN,
    )


def _round(value: float) -> str:
    return f"{float(f'{value:.2g}'):,.6g}"


def continuous(scenario: str, law: str) -> Case:
    """A law without a computer, at the step of a1."""
    h = STEPS.get(law, PROPOSED_STEP) / 2
    run = Run(loop_of(law, scenario), metrics(1e-3), HORIZON[scenario], 0.01, h)
    return Case(scenario, law, run, STYLES[law])


def sections(results: Results) -> Sequence[Section]:
    found, by_step = gathered(results), results.work("steps")
    pictures = (pages.over_periods(found, TV, "tv_periods"), pages.over_periods(found, RMSE, "rmse_periods"))
    verdicts = (
        finite(found),
        integrator(found),
        unseen(found),
        survives(found),
        thumb(found),
        computers(found, by_step),
    )
    return (
        Section("What was found", (*pictures, *verdicts)),
        pages.computer_section(),
        pages.periods_section(found),
        pages.apart_section(found),
        pages.places_section(found),
        pages.safe_section(found),
        pages.trust_section(found, pages.steps_figure(by_step)),
    )


study = Study(
    name="a9_sampling",
    title="The paper's laws as sampled-data loops",
    question=(
        "What becomes of the six laws, of super-twisting beside them and of their ranking when a computer runs them "
        "once in 0.1 to 10 ms? How long may the period be, does a rule of thumb tell, and what comes of the law, "
        "what of the computer's integrator, what of the step of the simulation?"
    ),
    method=(
        "Both scenarios with the numbers of a1. The law and its observer in a computer, the plant by RK4 in "
        "between, at two substeps; the memories by explicit Euler, those of AOSMC-RGS by Cayley steps beside it, "
        "and near their exact flow; delay and noise. Longest safe periods by a search on runs, beside a rule of thumb."
    ),
    cases=tuple(continuous(scenario, law) for scenario in SCENARIOS for law in SEVEN),
    sweeps=tuple(sweep(*one) for one in plan()),
    works=works,
    sections=sections,
    seed=SEED,
)
