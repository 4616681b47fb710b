"""The observer of the AOSMC-RGS paper: do its gains keep Theorem 1, and which would?

Runs in about half a minute on two cores.
"""

from collections.abc import Iterator, Sequence

from studies.a1_paper_tables.study import PROPOSED_STEP
from studies.a4_observer_gains.candidates import CHOSEN, PAPER, audits, constants, followed, gains
from studies.a4_observer_gains.figures import STYLES
from studies.a4_observer_gains.findings import SCENARIOS, findings
from studies.a4_observer_gains.sections import (
    gains_section,
    price_section,
    promise_section,
    stability_section,
    tracking_section,
)
from studies.paper.card import CARD
from studies.paper.laws import ARM, proposed_repaired
from workbench.metrics import late_error, observer_error, peak_torque
from workbench.observers import Luenberger, OracleFilter, WithDisturbance
from workbench.study.contract import Run
from workbench.study.document.document import Section
from workbench.study.study import Case, Results, Study

METRICS = (
    late_error(5.0),
    observer_error("qd_error"),
    peak_torque(),
)
UNTIL = 10.0  # s


def cases() -> Iterator[Case]:
    """The repaired law with each observer, started as in section 5 and at the measured positions."""
    starts = ("FS", CARD["q_hat(0)"]), ("FS", CARD["FS: q(0)"]), ("SS", CARD["q_hat(0)"])
    for name, (key, q) in zip(SCENARIOS, starts, strict=True):
        for law, mine in gains().items():
            state = Luenberger(ARM, mine.L1, mine.L2, q, CARD["qd_hat(0)"])
            loop = proposed_repaired(key, WithDisturbance(state, OracleFilter(2, CARD["l"])))
            yield Case(name, law, Run(loop, METRICS, UNTIL, 0.01, PROPOSED_STEP / 2), style=STYLES[law])


def sections(results: Results) -> Sequence[Section]:
    """What the report says."""
    return (
        findings(results),
        promise_section(),
        gains_section(),
        stability_section(),
        price_section(),
        tracking_section(results),
    )


def headlines(results: Results) -> Sequence[str]:
    """The findings, one a line."""
    theirs, ours = audits()[PAPER], audits()[CHOSEN]
    noisier = ours.noise.velocity / theirs.noise.velocity
    late = [max(results[SCENARIOS[0], name].score("late error", j)[0] for j in (0, 1)) for name in (PAPER, CHOSEN)]
    share = 0.0 if theirs.share is None else theirs.share
    return (
        f"L1 = 30, L2 = 50: a frozen mode grows at {100 * theirs.frozen.unstable:.1f} % of the states, the slowest "
        f"along the path decays at {followed()[PAPER].slowest:.2f} 1/s; a decay is proved in {100 * share:.2g} % of "
        "the region.",
        f"Of a mismatch that is known by its size alone they bear {theirs.tolerated:.2f} |x~|; |df/dq| reaches "
        f"{constants()[1.0].position.seen:.0f} 1/s^2.",
        f"A double pole that is proved in the whole region: late error {late[1]:.3f} rad instead of {late[0]:.3f}, "
        f"noise {noisier:.0f} times.",
    )


study = Study(
    name="a4_observer_gains",
    title="The gains of the observer: what is promised, what is proved, and better ones",
    question=("Do the paper's L1 = 30, L2 = 50 give what Theorem 1 promises, and what gains would?"),
    method=(
        "The exact Jacobian of the error, frozen at states of a region and along the path; Lipschitz constants and "
        "quadratic certificates over the region, proposed by linear matrix inequalities and proved by intervals and "
        "in rational arithmetic; gains by pole placement, high gain, Kalman's filter and one inequality; then the "
        "repaired law of a1 with each observer, RK4 at a step and at half of it."
    ),
    cases=tuple(cases()),
    sections=sections,
    headlines=headlines,
)
