"""The paper's laws run by a computer: which survive a sampling period, a delay and noise, and which only chatter?

Runs in about a minute on two idle cores, twenty seconds more the first time.
"""

from collections.abc import Sequence
from functools import cache

from studies.a1_paper_tables.study import PROPOSED_STEP, STEPS, STYLES
from studies.a9_sampling.card import REALISTIC, SEED
from studies.a9_sampling.details import rough_section, switching_section, theory_section, trust_section
from studies.a9_sampling.evidence import Evidence, gathered, printed
from studies.a9_sampling.findings import findings
from studies.a9_sampling.folded import PERIODS, row
from studies.a9_sampling.integrator import apart_section
from studies.a9_sampling.loops import RMSE, horizon, metrics
from studies.a9_sampling.sections import computer_section, periods_section, places_section, safe_section
from studies.a9_sampling.steps import curves
from studies.paper.linearization import SEVEN, loop_of
from workbench.study.contract import Run
from workbench.study.document.document import Section
from workbench.study.study import Case, Results, Study


def continuous(scenario: str) -> tuple[Case, ...]:
    """Each law without a computer, at the steps of a1."""
    until = horizon(scenario)
    return tuple(
        Case(
            scenario,
            law,
            Run(loop_of(law, scenario), metrics(scenario, 1e-3), until, 0.01, STEPS.get(law, PROPOSED_STEP) / 2),
            STYLES[law],
        )
        for law in SEVEN
    )


@cache
def evidence(results: Results) -> Evidence:
    """What the computers gave, once for sections and headlines."""
    return gathered(results)


def sections(results: Results) -> Sequence[Section]:
    """What the report says."""
    found, steps = evidence(results), curves()
    return (
        findings(found, steps),
        computer_section(),
        periods_section(found),
        apart_section(found),
        places_section(found),
        safe_section(found),
        switching_section(found),
        rough_section(found),
        theory_section([row(period, delay) for period in PERIODS for delay in (False, True)]),
        trust_section(found, steps),
    )


def headlines(results: Results) -> Sequence[str]:
    """The findings in a line each."""
    found = evidence(results)
    rough = printed(found.at(RMSE, REALISTIC, delay=True, noisy=True))
    quiet = ", ".join(f"{law} {safe.quiet.text}" for law, safe in found.safe.items())
    return (
        f"Published pairs in continuous time: {printed(found.still(RMSE)).text}.",
        f"At {1e3 * REALISTIC:g} ms, a period late and noisy: {rough.text}.",
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
        "and near their exact flow; a layer, a relay and an implicit relay; delay and noise. Longest safe periods "
        "by bisection on runs, beside the multipliers of the frozen loops and a rule of thumb."
    ),
    cases=(*continuous("FS"), *continuous("SS")),
    sections=sections,
    headlines=headlines,
    seed=SEED,
)
