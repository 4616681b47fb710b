"""The observer of the AOSMC-RGS paper: do its gains keep Theorem 1, and which would?

Runs in about half a minute on two cores.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from studies.a4_observer_gains.candidates import (
    BOX,
    CHOSEN,
    HOW,
    INNER,
    MODEST,
    PAPER,
    SCENARIOS,
    SMALL,
    STYLES,
    SURFACE,
    WORKS,
    candidates,
    gains_section,
    noise_and_rate,
    poles,
    promise_section,
    tracking_section,
)
from studies.paper.card import CARD
from studies.paper.laws import ARM, proposed_repaired
from workbench.metrics import late_error, observer_error, peak_torque
from workbench.observers import Luenberger, OracleFilter, WithDisturbance
from workbench.study.contract import Run
from workbench.study.document.document import Section, Verdict
from workbench.study.document.phrases import raised
from workbench.study.study import Case, Results, Study

METRICS = (late_error(5.0), observer_error("qd_error"), peak_torque())
UNTIL, EVERY, STEP = 10.0, 0.01, 1e-3 / 24  # s
OBSERVER = "The observer: positions, the torque and the exact model. It knows of no disturbance, and here is none."


def cases(found: Mapping[str, Any]) -> tuple[Case, ...]:
    """The repaired law with each observer, started as in section 5 and at the measured positions."""
    starts = ("FS", CARD["q_hat(0)"]), ("FS", CARD["FS: q(0)"]), ("SS", CARD["q_hat(0)"])
    made = []
    for name, (key, q) in zip(SCENARIOS, starts, strict=True):
        for law, mine in zip(HOW, found["gains"], strict=True):
            state = Luenberger(ARM, mine.L1, mine.L2, q, CARD["qd_hat(0)"])
            loop = proposed_repaired(key, WithDisturbance(state, OracleFilter(2, CARD["l"])))
            made.append(Case(name, law, Run(loop, METRICS, UNTIL, EVERY, STEP), style=STYLES[law]))
    return tuple(made)


def theorem(results: Results) -> Verdict:
    """The frozen modes of the paper's gains."""
    one = candidates(results)[PAPER]
    return Verdict(
        "found",
        f"With L1 = 30, L2 = 50 a mode of the observer's error, frozen at a state and a torque, grows at "
        f"{100 * one.growing:.1f} % of the states of the region, by up to {max(-one.slowest, 0.0):.1f} 1/s.",
        f"Along the desired motion of the first scenario the slowest mode decays at {one.path:.2f} 1/s. Frozen "
        "modes that grow do not disprove Theorem 1; the false rest point of a2 does.",
        f"The share of {one.states:,} states and torques spread evenly over {BOX}, and {one.instants} "
        "instants of the desired motion.",
        OBSERVER,
        "A smaller region: the share is of this one.",
    )


def region(results: Results) -> Verdict:
    """The region in which a decay is proved for the paper's gains."""
    one = candidates(results)[PAPER]
    if one.share is None or one.admitted is None:
        return Verdict("open", f"With the paper's gains no region is proved to decay at {MODEST:g} 1/s.", one.why)
    return Verdict(
        "holds",
        f"With the paper's gains the error decays at {MODEST:g} 1/s or faster where |qd_i| ≤ {one.speed:.2g} rad/s and "
        f"|tau_i| ≤ {one.torque:.2g} N m, from first errors |q - q_hat| up to {1e3 * one.admitted:.2g} mrad.",
        f"These are {100 * one.share:.2g} % of the speeds and torques asked ({BOX}). The first scenario of section 5 "
        "begins with errors of pi in each joint, of which the proof says nothing.",
        f"Proved for all states and torques of the region, an arm that keeps {100 * INNER:g} % of its speeds, "
        "and qd_hat(0) = qd(0).",
        OBSERVER,
    )


def mismatch(results: Results) -> Verdict:
    """The mismatch that the paper's gains bear, beside that of the arm."""
    small, rho = results.work("lipschitz")
    return Verdict(
        "found",
        raised(
            f"With L1 = 30, L2 = 50 one quadratic form proves a decay for mismatches (15) up to rho = "
            f"{candidates(results)[PAPER].tolerated:.2f}; |df/dq| of the arm reaches {small.position.seen:.0f} 1/s^2 "
            f"at {100 * SMALL:g} % of the region's speeds and torques."
        ),
        raised(
            f"In the whole region |df/dq| reaches {rho.position.seen:.0f} 1/s^2 (proved: at most "
            f"{rho.position.proved:.0f}) and |df/dqd| {rho.velocity.seen:.1f} 1/s (at most {rho.velocity.proved:.1f})."
        ),
        "The largest rho such that one quadratic form proves a decay for all |Delta| ≤ rho |x~|, decided in fractions, "
        "beside the largest |df/dq| that was seen.",
        OBSERVER,
        "A scaling of the error's velocities against its positions, in which rho and |df/dq| are others.",
    )


def better(results: Results) -> Verdict:
    """The gains that are proved in the whole region."""
    every = candidates(results)
    whole = [name for name, one in every.items() if one.share == 1.0 and name != PAPER]
    ours, theirs = every[CHOSEN], every[PAPER]
    first = 1e3 * (ours.admitted or 0.0)
    return Verdict(
        "holds" if CHOSEN in whole else "open",
        f"With L1 = {ours.L1[0, 0]:.3g} I and L2 = {ours.L2[0, 0]:.3g} I the error decays as fast as the surface, "
        f"{SURFACE:g} 1/s, in the whole region, from first errors |q - q_hat| up to {first:.2g} mrad.",
        f"Proved for {', '.join(whole) or 'none'}, each for first errors of its own. The price: the H2 norm from the "
        f"noise of the positions to the estimate of the velocities is "
        f"{ours.noise / theirs.noise:.0f} times that of the paper's gains, and |qd - qd_hat| peaks "
        f"at {ours.peaking:.0f} rad/s a rad of first error, with the paper's at {theirs.peaking:.1f}.",
        f"All states and torques of {BOX}, for arm and estimate; the arm keeps {100 * INNER:g} % of the speeds.",
        OBSERVER,
    )


def tracking(results: Results) -> Verdict:
    """The tracking with the chosen gains beside that with the paper's."""

    def worse(scenario: str, law: str, metric: str) -> float:
        return max(results[scenario, law].score(metric, joint).pair[0] for joint in (0, 1))

    first, again, second = SCENARIOS
    late = {(s, law): worse(s, law, "late error") for s in (first, second) for law in (PAPER, CHOSEN)}
    turns = (late[first, CHOSEN] < late[first, PAPER]) != (late[second, CHOSEN] < late[second, PAPER])
    ours, theirs = (results[second, law].score("late error", 1).pair[0] for law in (CHOSEN, PAPER))
    chosen = candidates(results)[CHOSEN]
    return Verdict(
        "depends" if turns else "found",
        f"With L1 = {chosen.L1[0, 0]:.3g} I and L2 = {chosen.L2[0, 0]:.3g} I the larger late error of the two joints "
        f"is {late[first, CHOSEN]:.3f} rad in the first scenario ({late[first, PAPER]:.3f} with the paper's gains) and "
        f"{late[second, CHOSEN]:.3f} in the second ({late[second, PAPER]:.3f}); at joint 2 of the second it is "
        f"{ours:.3f} against {theirs:.3f}.",
        "With q_hat(0) = 0, as printed, the peak of the estimate drives the torque to "
        f"{worse(first, CHOSEN, 'peak torque'):.0f} N m, with the paper's gains to "
        f"{worse(first, PAPER, 'peak torque'):.0f}; with q_hat(0) at the measured positions the peak torque is "
        f"{worse(again, CHOSEN, 'peak torque'):.0f} N m.",
        "Largest |e_i| from 5 s on, of the worse joint if none is named, one noiseless run each over 10 s.",
        "The law: D_hat, filtered from the true disturbance. The observer: positions; (10) leaves D out.",
        "Noise on the positions, which stiffer gains amplify; none is simulated here.",
    )


def verdicts(results: Results) -> tuple[Verdict, ...]:
    """The findings."""
    return (*(one(results) for one in (theorem, region, mismatch, better, tracking)),)


def sections(results: Results) -> Sequence[Section]:
    """The findings with their pictures, then the tables behind them."""
    return (
        Section("What was found", (poles(results), noise_and_rate(results), *verdicts(results))),
        gains_section(results),
        tracking_section(results),
        promise_section(),
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
    works=WORKS,
    cases=cases,
    sections=sections,
)
