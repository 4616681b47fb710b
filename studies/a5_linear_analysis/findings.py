"""The findings of a5, each over every pose, law and gain that the study has, and its one claim."""

from collections.abc import Mapping

import numpy as np

import workbench as wb
from studies.a5_linear_analysis.pages import (
    ADAPTIVE,
    BOX,
    DRAWN_LAWS,
    FREQUENCIES,
    STIFFER,
    late,
    paths,
    rests,
    stiffer,
)
from studies.paper.card import CARD, PROPOSED_LAW
from studies.paper.linearization import LEVEL, POSES, SEVEN, SLOW, AtRest, OnPath

WEAKER = 0.9  # of the torque that is commanded
HERE = "at rest at the level of the second scenario"
ALIKE = 0.02  # of the larger of two margins
GROWS = 1e-6  # 1/s: a pole at zero, of a gain that nothing holds, is found at less
EXACT = "exact positions and velocities"
GAINS = "The numbers of the paper where it states them; the unstated numbers as in report a1."
OTHERS = "Other gains of the laws and of the observer."


def findings(results: wb.Results) -> tuple[wb.Finding, ...]:
    """All findings: the laws at rest, then along their path."""
    return tuple(one(results) for one in (delays, observer, slow, twisting, frozen))


def rest_points(results: wb.Results) -> wb.document.Verdict:
    """The number of rest points."""
    points = results.work("arm")[0].rest_points
    return wb.document.Verdict(
        "holds" if points.complete else "open",
        f"The arm without torque has {len(points.points)} equilibria with both joints between {BOX['q'][0]:g} and "
        f"{BOX['q'][1]:g} rad.",
        "Intervals prove that there are no others.",
    )


def larger_gain(first: float, last: float) -> str:
    """The gain with the larger margin; 'equal' where they differ by less than `ALIKE`."""
    if abs(first - last) <= ALIKE * max(first, last):
        return "equal"
    return "first gain" if first > last else "learned gain"


def delays(results: wb.Results) -> wb.Finding:
    """The delay that SMC tolerates, and ASMC with the gain that it has learned."""
    every = rests(results)
    first, learned = every["SMC"][LEVEL].delay, every["ASMC"][late(LEVEL)].delay
    made = []
    for law in ADAPTIVE:
        for pose in POSES:
            one, other = every[law][pose], every[law][late(pose)]
            for words, pair in (("delay", (one.delay, other.delay)), ("disk margin", (one.alpha, other.alpha))):
                made.append(
                    wb.Variation(f"{law}, {words}, {pose}", larger_gain(*pair), f"{pair[0]:.3g} and {pair[1]:.3g}")
                )
    return wb.Finding(
        name="delay_and_learned_gain",
        statement=f"With its first gain, which is the gain of SMC, ASMC has a delay margin of {first:.2f} ms at one "
        f"torque; with its learned gain it has {learned:.2g} ms. The repaired {PROPOSED_LAW} has "
        f"{every[PROPOSED_LAW][LEVEL].delay:.0f} ms.",
        evidence=f"The first gain K is {CARD['SMC: K'][0]:g} N m; the learned gain is K of ASMC at the end of the "
        "first scenario. With a larger gain the crossover is at a higher frequency, where a delay turns the phase "
        f"more. The observer of {PROPOSED_LAW} gets the commanded torque, so the loop of law and observer has no "
        "delay.",
        statistic=f"Delay margin of the linear loop {HERE}, the smaller of both joints. The answer is the gain with "
        f"the larger margin, or 'equal' if both agree within {100 * ALIKE:g} %.",
        sample="One pose and one run of the first scenario, without noise.",
        information=f"SMC and ASMC: {EXACT}. {PROPOSED_LAW}: only positions.",
        assumptions=GAINS,
        answer=larger_gain(first, learned),
        variations=tuple(made),
        limitations=f"A layer wider than {CARD['phi']:g} rad/s; an observer of {PROPOSED_LAW} that gets the delayed "
        "torque, which puts the delay into the loop of law and observer: report a9 runs it.",
    )


def least_of(alphas: Mapping[str, float]) -> str:
    """The least disk margin over poses."""
    return f"{min(alphas.values()):.2g}"


def observer(results: wb.Results) -> wb.Finding:
    """The margin that the observer of the repaired law leaves."""
    every = rests(results)
    ours = {pose: every[PROPOSED_LAW][pose].alpha for pose in POSES}
    thin = min(ours, key=ours.__getitem__)
    weak: AtRest = every[PROPOSED_LAW][thin]
    pole = float(np.linalg.eigvals(weak.A - WEAKER * weak.B @ weak.Cy).real.max())
    made = [
        wb.Variation(f"without the pose '{pose}'", least_of({k: a for k, a in ours.items() if k != pose}))
        for pose in POSES
    ]
    made.append(wb.Variation("the learned gain", least_of({p: every[PROPOSED_LAW][late(p)].alpha for p in POSES})))
    firm = {pose: every[PROPOSED_LAW][stiffer(pose)].alpha for pose in POSES}
    made.append(wb.Variation(f"L2 of the observer {STIFFER:g} times as large", least_of(firm)))
    made += [
        wb.Variation(f"{law} in place of {PROPOSED_LAW}", least_of({p: every[law][p].alpha for p in POSES}))
        for law in SEVEN
        if law != PROPOSED_LAW and all(every[law][p].alpha for p in POSES)
    ]
    return wb.Finding(
        name="margin_of_the_observer",
        statement=f"The least disk margin of the repaired AOSMC-RGS over {len(POSES)} poses at rest is "
        f"{ours[thin]:.3f}, in the pose '{thin}'. At the level of the second scenario the margin is "
        f"{ours[LEVEL]:.2f}.",
        evidence=f"In the pose '{thin}', with torques at {100 * WEAKER:g} % of the commanded ones, the slowest pole is "
        f"at {pole:+.2f} 1/s.",
        statistic="The disk margin of the linear loop for both torques at once, the least over the poses.",
        sample=f"{len(POSES)} poses at rest, with the first gain K(0).",
        information=f"The repaired law: only positions. All others: {EXACT}.",
        assumptions=GAINS,
        answer=least_of(ours),
        variations=tuple(made),
        limitations="Other gains L1 of the observer.",
    )


def slow(results: wb.Results) -> wb.Finding:
    """The gain of slow torques that no block is given."""
    every = rests(results)
    gains = {law: every[law][LEVEL].slow_gain for law in SEVEN}
    made = [
        wb.Variation(words, largest({law: every[law][pose].slow_gain for law in SEVEN}))
        for words, pose in ((f"the pose '{pose}'", pose) for pose in POSES if pose != LEVEL)
    ]
    made.append(wb.Variation("learned gains", largest({law: every[law][late(LEVEL)].slow_gain for law in ADAPTIVE})))
    (responses,) = results.work("responses")
    for omega in (0.01, 0.1, 1.0, 10.0, 100.0):
        row = int(np.argmin(np.abs(np.log(FREQUENCIES / omega))))
        at = {law: float(responses[law]["largest gain of S"][row]) for law in DRAWN_LAWS}
        made.append(wb.Variation(f"a frequency of {omega:g} rad/s, among {len(DRAWN_LAWS)} laws", largest(at)))
    return wb.Finding(
        name="slow_torques",
        statement="The repaired AOSMC-RGS multiplies the effect of a slow unknown torque by "
        f"{gains[PROPOSED_LAW]:.1f}, SMC by {gains['SMC']:.4f}, and PID by {gains['PID']:.5f}.",
        evidence="Report a1 does not show this, because there D_hat is filtered from the true disturbance.",
        statistic=f"Largest gain of the sensitivity at the torques, at {SLOW:g} rad/s, for the linear loop {HERE}. "
        "The answer is the law with the largest gain.",
        sample=f"{len(SEVEN)} laws with their first gains.",
        information=f"The repaired law: only positions. All others: {EXACT}.",
        assumptions=GAINS,
        answer=largest(gains),
        variations=tuple(made),
        limitations="An estimate of the disturbance from measurements, which the law of the paper lacks.",
    )


def largest(gains: Mapping[str, float]) -> str:
    """The law with the largest number."""
    return max(gains, key=gains.__getitem__)


def twisting(results: wb.Results) -> wb.Finding:
    """The linear model of super-twisting in its layer."""
    every = rests(results)["super-twisting"]
    rest = every[LEVEL]

    def verdict(one: AtRest) -> str:
        return f"a disk margin of {one.alpha:.2f}" if one.disk else "no disk margin"

    return wb.Finding(
        name="super_twisting_in_its_layer",
        statement="With the boundary layer in place of its sign function, the linear model of super-twisting at rest "
        f"has {verdict(rest)}: its slowest poles are at {abs(rest.poles[0].value):.1f} rad/s with a damping of "
        f"{max(rest.poles[0].damping, 0.0):.2g}.",
        evidence="The linear model at s = 0 lacks the term with the square root of |s|, which may damp the loop. "
        "Without that term the loop oscillates at sqrt(k2 / phi).",
        statistic=f"Poles, and the disk margin for both torques at once, of the linear loop {HERE}.",
        sample="One pose; the other poses are variations.",
        information=f"The law: {EXACT}.",
        assumptions="The boundary layer in place of the sign function, with the width that the other laws have.",
        answer=verdict(rest),
        variations=tuple(wb.Variation(f"the pose '{pose}'", verdict(every[pose])) for pose in POSES if pose != LEVEL),
        limitations="A layer that also smooths the square root of |s|, so that its term has a slope at s = 0.",
    )


def frozen(results: wb.Results) -> wb.Finding:
    """The frozen poles along the first scenario, and within the layer alone."""
    every = paths(results)
    rates = {law: float(path.largest.max()) for law, path in every.items()}
    within = {law: path.within for law, path in every.items()}
    margins = {law: float(np.nanmin(path.alpha)) for law, path in every.items()}
    shares = {law: float((path.largest > GROWS).mean()) for law, path in every.items()}
    made = (
        wb.Variation("only times within the layer", largest(within), f"{max(within.values()):+.1f} 1/s"),
        wb.Variation("the least disk margin within the layer", min(margins, key=margins.__getitem__)),
        wb.Variation(
            "the share of times at which a pole grows", largest(shares), f"{100 * max(shares.values()):.1f} %"
        ),
        *(late_rates(every, after) for after in (1.0, 5.0)),
    )
    worst = largest(rates)
    return wb.Finding(
        name="frozen_poles",
        statement=f"Along the first scenario the largest real part of a frozen pole is {rates[worst]:+.1f} 1/s, for "
        f"{worst}. Within the layer it is {max(within.values()):+.1f} 1/s, for {largest(within)}.",
        evidence="Outside the layer the saturation has no slope, so the law has no feedback of s. Frozen poles "
        "do not decide the stability of a loop that moves.",
        statistic="The largest real part of a pole of the whole linear loop, every 0.1 s. The answer is the law that "
        "has it.",
        sample=f"One run without noise for each of {len(SEVEN)} laws.",
        information=f"The repaired law: positions and the true disturbance. All others: {EXACT}.",
        assumptions=GAINS,
        answer=worst,
        variations=made,
        limitations=OTHERS,
    )


def late_rates(every: Mapping[str, OnPath], after: float) -> wb.Variation:
    """The law with the largest frozen pole after the start."""
    rates = {law: float(path.largest[path.t >= after].max()) for law, path in every.items()}
    words = f"times after the first {after:g} s"
    if max(rates.values()) <= GROWS:
        return wb.Variation(words, "none", "no pole grows")
    return wb.Variation(words, largest(rates), f"{max(rates.values()):+.1f} 1/s")


def answer(results: wb.Results) -> str:
    """The page in one line."""
    every = rests(results)
    ours = {pose: every[PROPOSED_LAW][pose].alpha for pose in POSES}
    first, learned = every["SMC"][LEVEL].delay, every["ASMC"][late(LEVEL)].delay
    return (
        f"At rest, SMC tolerates a delay of {first:.2f} ms, ASMC with its learned gain {learned:.2g} ms. "
        f"{PROPOSED_LAW} tolerates {every[PROPOSED_LAW][LEVEL].delay:.0f} ms if its observer gets the torque before "
        f"the delay. Its disk margin is {ours[LEVEL]:.2f}, but {ours['upright']:.3f} in the upright pose."
    )
