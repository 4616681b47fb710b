"""What does the Riccati part of AOSMC-RGS do?

Runs in about half a minute on two cores.
"""

from collections.abc import Sequence

from studies.a3_riccati_gains.loops import FORWARD, cases
from studies.a3_riccati_gains.sections import along, answers, apart, loops, matrices, usual
from studies.paper.comparison import SCENARIOS
from workbench.study.document.document import Section
from workbench.study.study import Results, Study


def sections(results: Results) -> Sequence[Section]:
    """What the report says."""
    return (
        answers(results),
        *(matrices(results, scenario) for scenario in SCENARIOS),
        *(loops(results, scenario) for scenario in SCENARIOS),
    )


def headlines(results: Results) -> Sequence[str]:
    """The findings in a line each."""
    return tuple(
        f"{title}: P(t) of {FORWARD} is at most {apart(path):.1%} from the algebraic solution, in the median over time "
        f"{usual(path):.2%}, and costs "
        f"{path.ratios['P(t) of (34)'] - 1:.2%} more than the least J."
        for scenario, title in SCENARIOS.items()
        for path in (along(results, scenario),)
    )


study = Study(
    name="a3_riccati_gains",
    title="AOSMC-RGS: what the Riccati part does",
    question=(
        "P(t) of (34) sets the rate at which the gain of the proposed law learns. How far is it from what the "
        "algebraic, the backward and the constant choice would give, what does that cost in (32), and does the loop "
        "track better with it than without?"
    ),
    method=(
        "The repaired law in both scenarios. Along each run A = -M^-1 K, B = Lambda of (31) are a path in time, on "
        "which each equation is solved with its certificate, and J of (32) by a linear equation. Then the loop with "
        "P solved for at each instant, left at P(0), without any adaptation, with plain ASMC and with an LQR."
    ),
    cases=(*cases("FS"), *cases("SS")),
    sections=sections,
    headlines=headlines,
)
