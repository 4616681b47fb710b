"""What a4 found: what the observer's gains promise, what is proved of them, and which promise more."""

from studies.a4_observer_gains.candidates import (
    CHOSEN,
    INNER,
    MODEST,
    PAPER,
    REGION,
    SURFACE,
    audits,
    constants,
    followed,
    gains,
)
from workbench.study.document.document import Section, Verdict
from workbench.study.document.phrases import raised
from workbench.study.study import Results

SCENARIOS = ("first scenario", "first scenario, from y(0)", "second scenario")
BOX = f"|qd_i| ≤ {REGION.speed[0]:g} rad/s, |tau_i| ≤ {REGION.torque[0]:g} N m, any position"
OBSERVER = "The observer: positions, the torque and the exact model. It knows of no disturbance, and here is none."


def findings(results: Results) -> Section:
    """The answers first."""
    return Section("What was found", (_theorem(), _region(), _mismatch(), _better(), _tracking(results)))


def _theorem() -> Verdict:
    seen, along = audits()[PAPER].frozen, followed()[PAPER]
    return Verdict(
        "found",
        f"With L1 = 30, L2 = 50 a mode of the observer's error, frozen at a state and a torque, grows at "
        f"{100 * seen.unstable:.1f} % of the states of the region, by up to {max(-seen.slowest, 0.0):.1f} 1/s.",
        f"Along the desired motion of the first scenario the slowest mode decays at {along.slowest:.2f} 1/s, the "
        f"surface at {SURFACE:g} 1/s. Frozen modes that grow do not disprove Theorem 1; the false rest point of a2 "
        "does.",
        estimand=f"The share of {len(seen.rates):,} states and torques spread evenly over {BOX}, and "
        f"{len(along.rates)} instants of the desired motion.",
        given=OBSERVER,
        reversal="A smaller region: the share is of this one.",
    )


def _region() -> Verdict:
    found = audits()[PAPER]
    if found.certificate is None or found.reach is None or found.share is None:
        return Verdict("open", f"With the paper's gains no region is proved to decay at {MODEST:g} 1/s.", found.why)
    speed, torque = found.certificate.region.speed[0], found.certificate.region.torque[0]
    return Verdict(
        "holds",
        f"With the paper's gains the error decays at {MODEST:g} 1/s or faster where |qd_i| ≤ {speed:.2g} rad/s and "
        f"|tau_i| ≤ {torque:.2g} N m, from first errors |q - q_hat| up to {1e3 * found.reach.position:.2g} mrad.",
        f"These are {100 * found.share:.2g} % of the speeds and torques asked ({BOX}). The first scenario of section 5 "
        "begins with errors of pi in each joint, of which the proof says nothing.",
        estimand=f"Proved for all states and torques of the region, an arm that keeps {100 * INNER:g} % of its speeds, "
        "and qd_hat(0) = qd(0).",
        given=OBSERVER,
    )


def _mismatch() -> Verdict:
    rho, bears = constants()[1.0], audits()[PAPER].tolerated
    share = min(constants())
    return Verdict(
        "found",
        raised(
            f"With L1 = 30, L2 = 50 one quadratic form proves a decay for mismatches (15) up to rho = {bears:.2f}; "
            f"|df/dq| of the arm reaches {constants()[share].position.seen:.0f} 1/s^2 at {100 * share:g} % of the "
            "region's speeds and torques."
        ),
        raised(
            f"In the whole region |df/dq| reaches {rho.position.seen:.0f} 1/s^2 (proved: at most "
            f"{rho.position.proved:.0f}) and |df/dqd| {rho.velocity.seen:.1f} 1/s (at most {rho.velocity.proved:.1f}). "
            "A proof that knows more of the mismatch than its size can do better, as the one above does."
        ),
        estimand=raised(
            "The largest rho such that one quadratic form proves a decay for all |Delta| ≤ rho |x~|, decided in "
            "fractions, beside the largest |df/dq| that was seen."
        ),
        given=OBSERVER,
        reversal="A scaling of the error's velocities against its positions, in which rho and |df/dq| are others.",
    )


def _better() -> Verdict:
    whole = [name for name, found in audits().items() if found.share == 1.0 and name != PAPER]
    ours, theirs = audits()[CHOSEN], audits()[PAPER]
    L1, L2 = gains()[CHOSEN].L1[0, 0], gains()[CHOSEN].L2[0, 0]
    first = 1e3 * ours.reach.position if ours.reach else 0.0
    return Verdict(
        "holds" if CHOSEN in whole else "open",
        f"With L1 = {L1:.3g} I and L2 = {L2:.3g} I the error decays as fast as the surface, {SURFACE:g} 1/s, in the "
        f"whole region, from first errors |q - q_hat| up to {first:.2g} mrad.",
        f"Proved for {', '.join(whole) or 'none'}, each for first errors of its own. The price of these gains: "
        f"the H2 norm from the noise of the positions to the estimate of the velocities is "
        f"{ours.noise.velocity / theirs.noise.velocity:.0f} times that of the paper's gains, and |qd - qd_hat| peaks "
        f"at {ours.peaking:.0f} rad/s a rad of first error, with the paper's at {theirs.peaking:.1f}.",
        estimand=f"All states and torques of {BOX}, for arm and estimate; the arm keeps {100 * INNER:g} % of the "
        "speeds.",
        given=OBSERVER,
    )


def _tracking(results: Results) -> Verdict:
    theirs, ours, started = (results[SCENARIOS[i], name] for i, name in ((0, PAPER), (0, CHOSEN), (1, CHOSEN)))
    late = [max(o.score("late error", j)[0] for j in (0, 1)) for o in (theirs, ours)]
    jumps = [[results[SCENARIOS[2], name].score("late error", j)[0] for j in (0, 1)] for name in (PAPER, CHOSEN)]
    torque = [max(o.score("peak torque", j)[0] for j in (0, 1)) for o in (theirs, ours, started)]
    worse, L1, L2 = [max(pair) for pair in jumps], gains()[CHOSEN].L1[0, 0], gains()[CHOSEN].L2[0, 0]
    turns = (late[1] < late[0]) != (worse[1] < worse[0])
    return Verdict(
        "depends" if turns else "found",
        ("The gains of the smaller late error depend on the scenario. " if turns else "")
        + f"With L1 = {L1:.3g} I and L2 = {L2:.3g} I the larger late error of the two joints is {late[1]:.3f} rad in "
        f"the first scenario ({late[0]:.3f} with the paper's gains) and {worse[1]:.3f} in the second ({worse[0]:.3f}); "
        f"at joint 2 of the second it is {jumps[1][1]:.3f} against {jumps[0][1]:.3f}.",
        f"With q_hat(0) = 0, as printed, the peak of the estimate drives the torque to {torque[1]:.0f} N m, with the "
        f"paper's gains to {torque[0]:.0f}; with q_hat(0) at the measured positions the peak torque is {torque[2]:.0f} "
        "N m. The reference of the second scenario jumps, and its late error is that after the jumps.",
        estimand="Largest |e_i| from 5 s on, of the worse joint if none is named, one noiseless run each over 10 s.",
        given="The law: D_hat, filtered from the true disturbance. The observer: positions; (10) leaves D out.",
        reversal="Noise on the positions, which stiffer gains amplify; none is simulated here.",
    )
