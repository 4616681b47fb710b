"""The observer of the AOSMC-RGS paper: do its gains keep Theorem 1, and which would?

Runs in about half a minute on two cores.
"""

from collections.abc import Iterator, Sequence

from studies.a4_observer_gains.candidates import SCENARIOS, STYLES, gains
from studies.a4_observer_gains.findings import verdicts
from studies.a4_observer_gains.pages import gains_section, noise_and_rate, poles, promise_section, tracking_section
from studies.paper.card import CARD
from studies.paper.laws import ARM, proposed_repaired
from workbench.metrics import late_error, observer_error, peak_torque
from workbench.observers import Luenberger, OracleFilter, WithDisturbance
from workbench.study.contract import Run
from workbench.study.document.document import Section
from workbench.study.study import Case, Results, Study

METRICS = (late_error(5.0), observer_error("qd_error"), peak_torque())
UNTIL, EVERY, STEP = 10.0, 0.01, 1e-3 / 24  # s


def cases() -> Iterator[Case]:
    """The repaired law with each observer, started as in section 5 and at the measured positions."""
    starts = ("FS", CARD["q_hat(0)"]), ("FS", CARD["FS: q(0)"]), ("SS", CARD["q_hat(0)"])
    for name, (key, q) in zip(SCENARIOS, starts, strict=True):
        for law, mine in gains().items():
            state = Luenberger(ARM, mine.L1, mine.L2, q, CARD["qd_hat(0)"])
            loop = proposed_repaired(key, WithDisturbance(state, OracleFilter(2, CARD["l"])))
            yield Case(name, law, Run(loop, METRICS, UNTIL, EVERY, STEP), style=STYLES[law])


def sections(results: Results) -> Sequence[Section]:
    """The sections of the report."""
    return (
        Section("What was found", (poles(), noise_and_rate(), *verdicts(results))),
        gains_section(),
        tracking_section(results),
        promise_section(),
    )


def headlines(results: Results) -> Sequence[str]:
    """The findings, one a line."""
    return tuple(f"{verdict.kind}: {verdict.statement}" for verdict in verdicts(results))


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
