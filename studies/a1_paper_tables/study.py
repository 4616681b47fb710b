"""The tables of the AOSMC-RGS paper, run again: as printed, with a repair of four slips, and beside five rivals.

Runs in some ten seconds on two cores.
"""

from collections.abc import Sequence

from studies.a1_paper_tables.equations import laws_section
from studies.a1_paper_tables.findings import findings_section, numbers_section, trust_section
from studies.a1_paper_tables.rankings import FIRM, claims_section, firm
from studies.a1_paper_tables.repairs import (
    CHANGES,
    LATE,
    LONG,
    PAIRS,
    PLANTS,
    SHORT,
    SMALL_Q,
    printed_section,
    repair_section,
    with_small_q,
    with_two_repairs,
)
from studies.paper.card import CARD, LAWS, PUBLISHED
from studies.paper.comparison import PROPOSED, SCENARIOS, scenario_section
from studies.paper.laws import RIVALS, proposed_as_printed, proposed_repaired, rival, with_change
from workbench import metrics
from workbench.controllers.aosmc_rgs import SHAPES
from workbench.study.contract import Run
from workbench.study.document.document import Section
from workbench.study.study import Case, Results, Study

PRINTED = metrics.sampled_rmse(CARD["sample time of (43)"])
TRACKING = (
    PRINTED,
    metrics.rmse(),
    metrics.rmse("e_hat", name="RMSE of e_hat"),
    metrics.iae(),
    metrics.ise(),
    metrics.itae(),
    metrics.peak_error(),
)
COST = (metrics.effort(), metrics.energy(), metrics.peak_torque(), metrics.total_variation(sample=1e-3))
OBSERVED = (metrics.observer_error("q_error"), metrics.observer_error("qd_error"), metrics.observer_error("d_error"))
AFTER_STEPS = (metrics.overshoot(), metrics.settling_time(band=0.05))
BRIEF = (PRINTED, metrics.rmse(), metrics.late_error(LATE))
METRICS = {
    "FS": (*TRACKING, metrics.late_error(LATE), *COST, *OBSERVED),
    "SS": TRACKING + COST + OBSERVED + AFTER_STEPS,
}

# Steps in s, each below the limit of stability; values are taken at half of them.
PROPOSED_STEP = 1e-3 / 12
STEPS = {"PID": 5e-4, "SMC": 5e-4, "super-twisting": 5e-4, "ASMC": 1e-4, "Fuzzy-ASMC": 1e-3 / 12, "RBF-ASMC": 1e-4}
STYLES = {law: i for i, law in enumerate((*LAWS, "super-twisting"))}


def comparison(scenario: str) -> tuple[Case, ...]:
    """The proposed law as repaired, its five rivals, and a seventh law."""
    loops = {PROPOSED: proposed_repaired(scenario)} | {law: rival(scenario, law) for law in RIVALS}
    steps = {PROPOSED: PROPOSED_STEP} | STEPS
    return tuple(
        Case(
            scenario,
            law,
            Run(loop, METRICS[scenario], CARD[f"{scenario}: horizon"], 0.01, steps[law] / 2),
            style=STYLES[law],
            remark="repaired" if law == PROPOSED else "",
        )
        for law, loop in loops.items()
    )


def readings() -> tuple[Case, ...]:
    """The law as printed, in each reading of (33), in both scenarios, on the derived arm and on the printed one."""
    return tuple(
        Case(f"{scenario} as printed, {plant}", shape, Run(loop, BRIEF, SHORT, 0.01, 5e-5), style=style)
        for scenario in SCENARIOS
        for plant, arm in PLANTS.items()
        for style, shape in enumerate(SHAPES)
        for loop in (proposed_as_printed(scenario, shape, arm),)
    )


def variants() -> tuple[Case, ...]:
    """A small Q, firmer gains of SMC, one slip put back at a time, and two repairs alone."""
    runs = {(SMALL_Q, shape): (with_small_q(shape), LONG, 5e-5) for shape in SHAPES}
    runs |= {
        (f"{scenario}, SMC", f"K = {K:g} N m"): (firm(scenario, K), CARD[f"{scenario}: horizon"], h / 2)
        for scenario in SCENARIOS
        for K, h in FIRM.items()
    }
    runs |= {("one change", change): (with_change("FS", change), SHORT, PROPOSED_STEP / 2) for change in CHANGES}
    runs |= {(pair, shape): (with_two_repairs(shape, Q), LONG, 5e-5) for pair, Q in PAIRS.items() for shape in SHAPES}
    return tuple(Case(*name, Run(loop, BRIEF, until, 0.01, h)) for name, (loop, until, h) in runs.items())


def sections(results: Results) -> Sequence[Section]:
    """The findings first, the numbers and laws behind them last."""
    return (
        findings_section(results),
        printed_section(results),
        repair_section(results),
        *(scenario_section(results, scenario) for scenario in SCENARIOS),
        claims_section(results),
        laws_section(),
        numbers_section(),
        trust_section(results),
    )


def headlines(results: Results) -> Sequence[str]:
    """The findings in a line each."""
    ours, printed = results["FS", PROPOSED], results["FS as printed, derived arm", "outer"]
    pair = [
        f"{ours.score('RMSE (43)', j)[0]:.4f} (printed {PUBLISHED['FS', j + 1].values[PROPOSED]:.4f})" for j in (0, 1)
    ]
    lost = f"diverges at {printed.diverged_at:.2f} s" if printed.diverged_at is not None else "does not diverge"
    return (
        f"AOSMC-RGS as printed (reading 'outer' of (33), first scenario) {lost}.",
        f"AOSMC-RGS repaired, first scenario: RMSE of q1 {pair[0]}, of q2 {pair[1]}.",
    )


study = Study(
    name="a1_paper_tables",
    title="AOSMC-RGS and its rivals: the published tables, run again",
    question=(
        "Does the printed law do what the paper says, which repair makes it track, and which of the published "
        "rankings hold when all six laws run side by side?"
    ),
    method=(
        "Both scenarios of section 5; every number is stated by the paper, derived, or assumed by a rule (the "
        "card). RK4 at a step and at half of it: values from the half step, errors from the difference. The law as "
        "printed in each reading of (33), with two choices of Q; then repaired, with each slip put back alone; with "
        "(3) and (28) repaired alone; SMC with three gains."
    ),
    cases=(*comparison("FS"), *comparison("SS"), *readings(), *variants()),
    sections=sections,
    headlines=headlines,
)
