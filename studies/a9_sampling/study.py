"""The paper's laws in a computer: which of them chatter, which runs are lost, and how long may the period be?

Runs in about four minutes on two idle cores.
"""

import workbench as wb
from studies.a9_sampling import pages, trust
from studies.a9_sampling.evidence import gather_evidence, plan, works
from studies.a9_sampling.findings import answer, findings
from studies.a9_sampling.loops import SEED, sweep
from studies.paper.citation import introduction
from studies.paper.comparison import PROPOSED_STEP, STEPS, STYLES
from studies.paper.linearization import SEVEN, loop_of
from studies.paper.quiet_periods import HORIZON, QUIET, RMSE, SCENARIOS, TV, metrics


def continuous(scenario: str, law: str) -> wb.Case:
    """A law without a computer, at the step of a1."""
    h = STEPS.get(law, PROPOSED_STEP) / 2
    run = wb.Run(loop_of(law, scenario), metrics(1e-3), HORIZON[scenario], 0.01, h)
    return wb.Case(scenario, law, run, STYLES[law])


def sections(results: wb.Results) -> wb.Page:
    """The whole page."""
    evidence = gather_evidence(results)
    pictures = (pages.over_periods(evidence, TV, "tv_periods"), pages.over_periods(evidence, RMSE, "rmse_periods"))
    return wb.Page(
        answer(evidence),
        findings(evidence),
        (
            wb.Section("Torque and error over the sampling period", pictures),
            pages.safe_section(evidence),
            pages.apart_section(evidence),
            pages.places_section(evidence),
            pages.periods_section(evidence),
            pages.computer_section(),
            trust.trust_section(evidence, results.work("steps")),
        ),
    )


study = wb.Study(
    name="a9_sampling",
    title="The paper's laws as sampled-data loops",
    question=(
        "A computer runs the paper's six laws and super-twisting with a period of 0.1 to 10 ms. Which of them chatter, "
        "and how long may the period be? Does a rule of thumb give this period? Which runs diverge, because of the law "
        "or of the integrator in the computer? Does the published order hold?"
    ),
    method=(
        f"{introduction(10, 34, 43)} Both scenarios, FS and SS, have the numbers of report a1. Law and observer run in "
        "a computer that holds the torque for a period. In between, the plant moves by Runge-Kutta steps, with each "
        "step and with half of it. All memories step by explicit Euler; those of AOSMC-RGS also by Cayley steps and by "
        f"fine Runge-Kutta steps. A period is quiet if the total variation of the torque is at most {QUIET:g} times "
        "its value in continuous time. Searches on runs give the longest quiet period, from the paper's start and from "
        "a start on the reference."
    ),
    cases=tuple(continuous(scenario, law) for scenario in SCENARIOS for law in SEVEN),
    sweeps=tuple(sweep(*one) for one in plan()),
    works=works(),
    sections=sections,
    seed=SEED,
)
