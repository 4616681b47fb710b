"""The findings of a4: frozen modes, the region of a proof, the mismatch, better gains, and the tracking error."""

from typing import NamedTuple

import workbench as wb
from studies.a4_observer_gains.candidates import (
    BOX,
    CLEAR,
    DOUBLE_POLE,
    HOW,
    INNER,
    LATE,
    MODEST,
    PAPER,
    SCENARIOS,
    SMALL,
    SURFACE,
    WHOLE,
    WITH_JUMPS,
    Candidate,
    candidates,
)

AFTER = 5.0  # s, from which an error is late
ERROR_LABELS = {CLEAR: LATE, 0.5: "late error, 0.5 s", 1.5: "late error, 1.5 s"}  # by the seconds left out after a jump
OBSERVER = "The observer has positions, the torque and the exact model. It knows no disturbance, and none acts here."
REGION = f"The region: {BOX}."
OTHERS = tuple(name for name in HOW if name != PAPER)


def answer(results: wb.Results) -> str:
    """The promise of the paper's gains, and what better ones do, in one line."""
    paper, chosen = (candidates(results)[name] for name in (PAPER, DOUBLE_POLE))
    ratios = sorted(late(results, s, PAPER) / late(results, s, DOUBLE_POLE) for s in (SCENARIOS[0], SCENARIOS[-1]))
    share = f"up to {100 * paper.share:.2g} %" if paper.share else "up to no share"
    errors = f"from starts within {1e3 * (chosen.admitted_radius or 0.0):.2g} mrad"
    reached = f"100 %, {errors}" if chosen.share == WHOLE else "no share"
    return (
        f"The paper's observer provably converges for speeds and torques {share} of their limits. Better gains reach "
        f"{reached}, divide steady-state tracking errors by {ratios[0]:.2g} to {ratios[1]:.2g}, and multiply velocity "
        f"noise by {chosen.noise / paper.noise:.0f}."
    )


def findings(results: wb.Results) -> tuple[wb.Finding, ...]:
    """The findings of the page."""
    return tuple(one(results) for one in (frozen_modes, region, mismatch, better_gains, late_error))


def _gains(one: Candidate) -> str:
    return f"L1 = {one.L1[0, 0]:.3g} I, L2 = {one.L2[0, 0]:.3g} I"


def late(results: wb.Results, scenario: str, law: str, metric: str = LATE, joints: tuple[int, ...] = (0, 1)) -> float:
    """The larger of the two joints by a metric, in rad."""
    return max(results[scenario, law].score(metric, joint).pair[0] for joint in joints)


def frozen_modes(results: wb.Results) -> wb.Finding:
    """The frozen modes of the paper's gains."""
    every = candidates(results)
    one = every[PAPER]

    def answer_for(grows: bool) -> str:
        return "some modes grow" if grows else "no mode grows"

    others = (
        wb.Variation(
            f"the gains '{name}'",
            answer_for(every[name].growing_share > 0),
            f"{100 * every[name].growing_share:.1f} % of states",
        )
        for name in OTHERS
    )
    return wb.Finding(
        "frozen_modes",
        f"With L1 = 30 I, L2 = 50 I a mode of the observer's error grows at {100 * one.growing_share:.1f} % of the "
        f"states of the region, by up to {max(-one.slowest, 0.0):.1f} 1/s.",
        "State and torque are frozen. Frozen modes that grow do not disprove Theorem 1; the false equilibrium of "
        "report a2 does.",
        statistic="The share of states at which a mode of the exact Jacobian, frozen at the state, grows.",
        sample=f"{one.states:,} states and torques spread evenly over the region. {REGION}",
        information=OBSERVER,
        assumptions="The region, which the paper does not name.",
        answer=answer_for(one.growing_share > 0),
        variations=(
            wb.Variation(
                "the states along the desired motion of the first scenario",
                answer_for(one.path < 0),
                f"{one.path:.2f} 1/s",
            ),
            *others,
        ),
        limitations="Smaller regions; modes along motions of the closed loop.",
    )


def region(results: wb.Results) -> wb.Finding:
    """The region in which a decay is proved for the paper's gains."""
    every = candidates(results)
    one = every[PAPER]
    proved = one.share is not None and one.admitted_radius is not None

    def answer_for(share: float | None) -> str:
        return "no proof" if share is None else "whole region" if share == WHOLE else "part of the region"

    statement = f"With the paper's gains no region is proved to decay at {MODEST:g} 1/s."
    if proved:
        statement = (
            f"With the paper's gains the error is proved to decay at {MODEST:g} 1/s or faster where |qd_i| ≤ "
            f"{one.speed:.2g} rad/s and |tau_i| ≤ {one.torque:.2g} N m, from |q - q_hat| up to "
            f"{1e3 * (one.admitted_radius or 0):.2g} mrad."
        )
    return wb.Finding(
        "region",
        statement,
        f"Each of these bounds is {100 * (one.share or 0):.2g} % of the region's bound. The first scenario begins "
        "with an error of pi in each joint, which the proof does not cover. The bound is sufficient, not sharp.",
        statistic="The largest share of the region's bounds up to which one quadratic form proves the rate.",
        sample=f"All states of the region, by proof. {REGION} The arm keeps {100 * INNER:g} % of its speeds, and "
        "qd_hat(0) = qd(0).",
        information=OBSERVER,
        assumptions=f"The region, and the rates: {MODEST:g} 1/s for the paper's gains, {SURFACE:g} 1/s for all others.",
        answer=answer_for(one.share),
        variations=tuple(
            wb.Variation(
                f"the gains '{name}', at {SURFACE:g} 1/s",
                answer_for(every[name].share),
                f"first errors up to {1e3 * (every[name].admitted_radius or 0):.2g} mrad",
            )
            for name in OTHERS
        ),
        limitations="Functions that are not quadratic, which may prove more.",
        is_decided=proved,
    )


def mismatch(results: wb.Results) -> wb.Finding:
    """The mismatch that each of the gains bears, beside that of the arm."""
    small, whole = results.work("lipschitz")
    every = candidates(results)
    coarse = [
        name for name in OTHERS if every[name].tolerated_mismatch < small.position.lower and every[name].share == WHOLE
    ]

    def answer_for(name: str, mismatch: float) -> str:
        less = every[name].tolerated_mismatch < mismatch
        return "tolerate less than the arm has" if less else "tolerate what the arm has"

    part = f"{'all' if len(coarse) == len(OTHERS) else f'{len(coarse)} of the'} {len(OTHERS)} other gains"
    places = ((SMALL, small), (WHOLE, whole))
    return wb.Finding(
        "mismatch",
        wb.document.superscript_powers(
            f"The paper's gains tolerate a mismatch (15) of rho = {every[PAPER].tolerated_mismatch:.2f}. But "
            f"|df/dq| of the arm reaches {small.position.lower:.0f} 1/s^2 within {100 * SMALL:g} % of the region's "
            "bounds."
        ),
        wb.document.superscript_powers(
            f"In the whole region |df/dq| reaches {whole.position.lower:.0f} 1/s^2 (proved: at most "
            f"{whole.position.upper:.0f}) and |df/dqd| {whole.velocity.lower:.1f} 1/s (at most "
            f"{whole.velocity.upper:.1f}). The bound (15) is coarse: {part} also tolerate less, "
            "and are proved to converge in the whole region."
        ),
        statistic="The largest rho for which one quadratic form proves a decay for all |Delta| ≤ rho |x~|, in rad and "
        "rad/s, compared with the largest |df/dq| that was found.",
        sample=REGION,
        information=OBSERVER,
        assumptions="The region, and the units of |x~|, in which positions and velocities have the same weight.",
        answer=answer_for(PAPER, small.position.lower),
        variations=tuple(
            wb.Variation(
                f"the gains '{name}', up to {100 * share:g} % of the bounds",
                answer_for(name, found.position.lower),
                f"{every[name].tolerated_mismatch:.2g} against {found.position.lower:.0f}",
            )
            for name in HOW
            for share, found in places
            if (name, share) != (PAPER, SMALL)
        ),
        limitations="Other scalings of velocities against positions, in which both numbers differ.",
    )


def better_gains(results: wb.Results) -> wb.Finding:
    """The gains that are proved in the whole region, and their price."""
    every = candidates(results)
    ours, theirs = every[DOUBLE_POLE], every[PAPER]

    def answer_for(name: str) -> str:
        return "proved" if every[name].share == WHOLE and name != PAPER else "not proved"

    def times_the_noise(name: str) -> str:
        return f"{every[name].noise / theirs.noise:.1f} times the noise"

    return wb.Finding(
        "better_gains",
        f"With {_gains(ours)} the error is proved to decay at {SURFACE:g} 1/s, as fast as the surface, in the whole "
        f"region, from |q - q_hat| up to {1e3 * (ours.admitted_radius or 0.0):.2g} mrad.",
        f"The price: noise in the estimate of the velocities is {ours.noise / theirs.noise:.0f} times as large as with "
        f"the paper's gains, and |qd - qd_hat| peaks at {ours.peaking:.0f} rad/s for a first error of 1 rad "
        f"({theirs.peaking:.1f} rad/s with the paper's gains).",
        statistic="A quadratic certificate for the whole region; the H2 norm of the noise and the peak of the error.",
        sample=f"All states of the region, by proof. {REGION} The arm keeps {100 * INNER:g} % of the speeds.",
        information=OBSERVER,
        assumptions="The region and the rate.",
        fitted_numbers="The double pole: the least one for which the decay is proved.",
        answer=answer_for(DOUBLE_POLE),
        variations=tuple(
            wb.Variation(f"the gains '{name}'", answer_for(name), times_the_noise(name))
            for name in HOW
            if name != DOUBLE_POLE
        ),
        limitations="A run with noise, in which larger gains cost more.",
        is_decided=answer_for(DOUBLE_POLE) == "proved",
    )


class Place(NamedTuple):
    """The late error that is compared with that of the paper's gains: its scenario, gains, metric and joints."""

    scenario: str
    law: str = DOUBLE_POLE
    metric: str = LATE
    joints: tuple[int, ...] = (0, 1)


def late_error(results: wb.Results) -> wb.Finding:
    """The late tracking error with the chosen gains beside that with the paper's."""

    def answer_for(at: Place) -> tuple[str, str]:
        ours, theirs = (late(results, at.scenario, name, at.metric, at.joints) for name in (at.law, PAPER))
        return "smaller" if ours < theirs else "not smaller", f"{ours:.3f} against {theirs:.3f} rad"

    first, again, second = SCENARIOS
    cases = {
        **{f"{s}": Place(s) for s in (again, second)},
        **{f"{s}, joint {j + 1} alone": Place(s, joints=(j,)) for s in SCENARIOS for j in (0, 1)},
        **{f"{s}, gains '{name}'": Place(s, name) for s in SCENARIOS for name in OTHERS if name != DOUBLE_POLE},
        **{
            f"{second}, {clear:g} s left out after a jump": Place(second, metric=name)
            for clear, name in ERROR_LABELS.items()
            if name != LATE
        },
        **{
            f"{second}, nothing left out, joint {j + 1} alone": Place(second, DOUBLE_POLE, WITH_JUMPS, (j,))
            for j in (0, 1)
        },
    }
    ours = {scenario: answer_for(Place(scenario))[1] for scenario in (first, second)}
    early = answer_for(Place(second, metric=ERROR_LABELS[0.5]))[1]
    peaks = [late(results, s, law, "peak torque") for s in (first, again) for law in (DOUBLE_POLE, PAPER)]
    return wb.Finding(
        "late_error",
        f"With {_gains(candidates(results)[DOUBLE_POLE])} the late error is {ours[first]} with the paper's gains in "
        f"the first scenario. In the second scenario, {CLEAR:g} s and more after a jump, it is {ours[second]}.",
        f"No law follows a jump at once: 0.5 s after a jump the error is {early}. With q_hat(0) = 0, as printed, "
        f"the torque peaks at {peaks[0]:.0f} N m ({peaks[1]:.0f} N m with the paper's gains). With "
        f"q_hat(0) at the measured positions it peaks at {peaks[2]:.0f} N m ({peaks[3]:.0f} N m).",
        statistic=f"The largest |e_i| from {AFTER:g} s on, of the worse joint, without the first {CLEAR:g} s after a "
        "jump.",
        sample="One run of 10 s without noise for each observer and scenario.",
        information="The law has D_hat, filtered from the true disturbance. The observer has positions; (10) leaves D "
        "out.",
        assumptions="Q, R, l and the square wave, as in report a1.",
        fitted_numbers="Q, R and l, to the printed RMSE of the first scenario, with the paper's gains.",
        answer=answer_for(Place(first))[0],
        variations=tuple(wb.Variation(words, *answer_for(case)) for words, case in cases.items()),
        limitations="Noise on the positions, which larger gains amplify more.",
    )
