"""The paper's laws run by a computer: which survive a sampling period, a delay and noise, and which only chatter?

Runs in about a minute on two idle cores, twenty seconds more the first time.
"""

from collections.abc import Sequence
from functools import cache

from studies.a1_paper_tables.study import PROPOSED_STEP, STEPS, STYLES
from studies.a9_sampling import findings, pages
from studies.a9_sampling.evidence import Evidence, curves, gathered, printed, tally
from studies.a9_sampling.loops import HORIZON, REALISTIC, RMSE, SCENARIOS, SEED, TV, metrics
from studies.paper.linearization import SEVEN, loop_of
from workbench.study.contract import Run
from workbench.study.document.document import Section
from workbench.study.study import Case, Results, Study


def continuous(scenario: str, law: str) -> Case:
    """A law without a computer, at the step of a1."""
    h = STEPS.get(law, PROPOSED_STEP) / 2
    run = Run(loop_of(law, scenario), metrics(1e-3), HORIZON[scenario], 0.01, h)
    return Case(scenario, law, run, STYLES[law])


@cache
def evidence(results: Results) -> Evidence:
    """All that was measured, once for sections and headlines."""
    return gathered(results)


def sections(results: Results) -> Sequence[Section]:
    """The whole page."""
    found, by_step = evidence(results), curves()
    pictures = (pages.over_periods(found, TV, "tv_periods"), pages.over_periods(found, RMSE, "rmse_periods"))
    verdicts = (
        findings.finite(found),
        findings.integrator(found),
        findings.unseen(found),
        findings.survives(found),
        findings.thumb(found),
        findings.computers(found, by_step),
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


def headlines(results: Results) -> Sequence[str]:
    """The findings in a line each."""
    found = evidence(results)
    rough = printed(found.at(RMSE, REALISTIC, delay=True, noisy=True))
    quiet = ", ".join(f"{law} {safe.quiet[0].text}" for law, safe in found.safe.items())
    return (
        f"Published pairs in continuous time: {tally(printed(found.still(RMSE)))}.",
        f"At {1e3 * REALISTIC:g} ms, a period late and noisy: {tally(rough)}.",
        f"Longest quiet period in ms: {quiet}.",
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
        "and near their exact flow; delay and noise. Longest safe periods by bisection on runs, beside a rule of thumb."
    ),
    cases=tuple(continuous(scenario, law) for scenario in SCENARIOS for law in SEVEN),
    sections=sections,
    headlines=headlines,
    seed=SEED,
)
