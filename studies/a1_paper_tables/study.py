"""The tables of the AOSMC-RGS paper, run again: as printed, with a repair of four slips, and beside five rivals.

Runs in some ten seconds on two cores.
"""

from collections.abc import Sequence

from studies.a1_paper_tables.assumptions import FIRM, SMALL_Q, firm, small_q, table, with_small_q
from studies.a1_paper_tables.equations import laws_section
from studies.a1_paper_tables.printed import CHANGES, LATE, PLANTS, SHORT, printed_section, repair_section
from studies.a1_paper_tables.repairs import PAIRS, tracking, with_two_repairs
from studies.a1_paper_tables.sections import numbers_section, summary, trust_section
from studies.paper.card import CARD, LAWS, PUBLISHED
from studies.paper.comparison import claims_section, scenario_section
from studies.paper.laws import RIVALS, proposed_as_printed, proposed_repaired, rival, with_change
from workbench.controllers.aosmc_rgs import SHAPES
from workbench.loop import ClosedLoop
from workbench.metrics import (
    effort,
    energy,
    iae,
    ise,
    itae,
    late_error,
    observer_error,
    overshoot,
    peak_error,
    peak_torque,
    rmse,
    sampled_rmse,
    settling_time,
    total_variation,
)
from workbench.study.contract import Run
from workbench.study.document.document import Section
from workbench.study.study import Case, Results, Study

PRINTED = sampled_rmse(CARD["sample time of (43)"])
TRACKING = (PRINTED, rmse(), rmse("e_hat", name="RMSE of e_hat"), iae(), ise(), itae(), peak_error())
COST = (effort(), energy(), peak_torque(), total_variation(sample=1e-3))
OBSERVED = (observer_error("q_error"), observer_error("qd_error"), observer_error("d_error"))
AFTER_STEPS = (overshoot(), settling_time(band=0.05))
BRIEF = (PRINTED, rmse(), late_error(LATE))
METRICS = {"FS": (*TRACKING, late_error(LATE), *COST, *OBSERVED), "SS": TRACKING + COST + OBSERVED + AFTER_STEPS}

# Steps in s, each below the stability limit that the report prints; values are taken at half of them.
PROPOSED_STEP = 1e-3 / 12
STEPS = {"PID": 5e-4, "SMC": 5e-4, "super-twisting": 5e-4, "ASMC": 1e-4, "Fuzzy-ASMC": 1e-3 / 12, "RBF-ASMC": 1e-4}
STYLES = {law: i for i, law in enumerate((*LAWS, "super-twisting"))}


def comparison(scenario: str) -> tuple[Case, ...]:
    """The proposed law as repaired, its five rivals, and a seventh law."""
    horizon = CARD[f"{scenario}: horizon"]

    def run(loop: ClosedLoop, h: float) -> Run:
        return Run(loop, METRICS[scenario], horizon, 0.01, h / 2)

    ours = Case(scenario, "AOSMC-RGS", run(proposed_repaired(scenario), PROPOSED_STEP), remark="repaired")
    rivals = (Case(scenario, law, run(rival(scenario, law), STEPS[law]), style=STYLES[law]) for law in RIVALS)
    return (ours, *rivals)


def readings() -> tuple[Case, ...]:
    """The law as printed, in each reading of (33), in both scenarios, on the derived arm and on the printed one."""
    return tuple(
        Case(f"{scenario} as printed, {plant}", shape, Run(loop, BRIEF, SHORT, 0.01, 5e-5), style=style)
        for scenario in ("FS", "SS")
        for plant, arm in PLANTS.items()
        for style, shape in enumerate(SHAPES)
        for loop in (proposed_as_printed(scenario, shape, arm),)
    )


def other_numbers() -> tuple[Case, ...]:
    """The law as printed with a small Q, and SMC with firmer gains: numbers that the paper does not state either."""
    until = {scenario: CARD[f"{scenario}: horizon"] for scenario in ("FS", "SS")}
    small = (Case(SMALL_Q, shape, Run(with_small_q(shape), BRIEF, until["FS"], 0.01, 5e-5)) for shape in SHAPES)
    gains = (
        Case(f"{scenario}, SMC", f"K = {K:g} N m", Run(firm(scenario, K), BRIEF, until[scenario], 0.01, h / 2))
        for scenario in until
        for K, h in FIRM.items()
    )
    return (*small, *gains)


def changes() -> tuple[Case, ...]:
    """The repaired law with one slip of the print put back at a time, or one repair more, in the first scenario."""
    return tuple(
        Case("one change", change, Run(with_change("FS", change), BRIEF, SHORT, 0.01, PROPOSED_STEP / 2))
        for change in CHANGES
    )


def two_repairs() -> tuple[Case, ...]:
    """The law with (3) and (28) repaired alone, in each reading of (33), with two choices of Q."""
    until = CARD["FS: horizon"]
    return tuple(
        Case(pair, shape, Run(with_two_repairs(shape, Q), BRIEF, until, 0.01, 5e-5))
        for pair, Q in PAIRS.items()
        for shape in SHAPES
    )


def sections(results: Results) -> Sequence[Section]:
    """What the report says."""
    return (
        summary(results),
        numbers_section(),
        laws_section(),
        printed_section(results, small_q(results)),
        repair_section(results, tracking(results)),
        scenario_section(results, "FS"),
        scenario_section(results, "SS"),
        claims_section(results, table(results)),
        trust_section(results),
    )


def headlines(results: Results) -> Sequence[str]:
    """The findings in a line each."""
    ours = results["FS", "AOSMC-RGS"]
    pair = [
        f"{ours.score('RMSE (43)', j)[0]:.4f} (printed {PUBLISHED['FS', j + 1].values['AOSMC-RGS']:.4f})"
        for j in (0, 1)
    ]
    printed = results["FS as printed, derived arm", "outer"]
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
    cases=(*comparison("FS"), *comparison("SS"), *readings(), *other_numbers(), *changes(), *two_repairs()),
    sections=sections,
    headlines=headlines,
)
