"""The paper's laws in a computer: which of them chatter, which runs are lost, and how long may the period be?

Runs in about four minutes on two idle cores.
"""

import workbench as wb
from studies.a9_sampling import pages, trust
from studies.a9_sampling.evidence import gather_evidence, plan, works
from studies.a9_sampling.findings import answer, findings
from studies.a9_sampling.loops import SEED, sweep
from studies.paper.comparison import PROPOSED_STEP, STEPS, STYLES
from studies.paper.linearization import SEVEN, loop_of
from studies.paper.quiet_periods import HORIZON, RMSE, SCENARIOS, TV, metrics


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
        "and how long may the period be? Does a rule of thumb give that period? Which runs diverge, and is it the law "
        "or the integrator of the computer that loses them? Does the published order survive?"
    ),
    method=(
        "Both scenarios with the numbers of a1. Law and observer run in a computer that holds the torque for a period. "
        "The plant moves by Runge-Kutta steps in between, with each step and with half of it. All memories step by "
        "explicit Euler; those of AOSMC-RGS also by Cayley steps and by fine Runge-Kutta steps. A search on runs "
        "gives the longest quiet period, from the paper's start and from a start on the reference."
    ),
    cases=tuple(continuous(scenario, law) for scenario in SCENARIOS for law in SEVEN),
    sweeps=tuple(sweep(*one) for one in plan()),
    works=works(),
    sections=sections,
    seed=SEED,
)
