"""Linear analysis of the arm and of each law: poles, margins, and what they leave out.

Runs in about 15 seconds on two cores.
"""

from collections.abc import Sequence

import numpy as np

from studies.a1_paper_tables.study import comparison
from studies.a5_linear_analysis import pages
from studies.a5_linear_analysis.pages import BOX, LATE, SEED, STIFFER, paths, rests, stiffer
from studies.paper.card import CARD, PROPOSED
from studies.paper.linearization import LEVEL, POSES, SEVEN, SLOW
from workbench.study.document.document import Section, Verdict
from workbench.study.study import Results, Study

WEAKER = 0.9  # of the torque that is commanded
HERE = "at rest at the level of the second scenario"
EXACT = "exact positions and velocities"


def rest_points(results: Results) -> Verdict:
    """The number of rest points."""
    found = results.work("arm")[0].rest_points
    return Verdict(
        "holds" if found.complete else "open",
        f"The arm without torque has {len(found.points)} rest points with both joints between {BOX['q'][0]:g} and "
        f"{BOX['q'][1]:g} rad.",
        "Intervals prove that there are no others.",
        given="The arm with the numbers of section 5.",
    )


def delays(results: Results) -> Verdict:
    """The delay that SMC stands, and ASMC with the gain that it has learned."""
    first, late = rests(results)["SMC"][LEVEL].delay, rests(results)["ASMC"][LATE].delay
    return Verdict(
        "found",
        f"SMC stays stable with a delay of up to {first:.2f} ms at one torque, ASMC with the gain that it has "
        f"learned with up to {late:.2g} ms.",
        f"K is {CARD['SMC: K'][0]:g} N m for SMC, and for ASMC that of the end of the first scenario.",
        estimand=f"The delay margin of the linear loop {HERE}, the lesser of the two joints.",
        given=f"Both laws: {EXACT}.",
        reversal=f"A layer wider than {CARD['phi']:g} rad/s or a smaller gain, which raise both margins.",
    )


def observer(results: Results) -> Verdict:
    """The margin that the observer of the repaired law leaves."""
    ours = rests(results)[PROPOSED]
    thin = min(POSES, key=lambda pose: ours[pose].alpha)
    rest, weak = ours[LEVEL], ours[thin]
    firm = {pose: ours[stiffer(pose)].alpha for pose in POSES}
    pole = float(np.linalg.eigvals(weak.A - WEAKER * weak.B @ weak.Cy).real.max())
    return Verdict(
        "found",
        f"The disk margin of the repaired law at the torques is {weak.alpha:.3f} {thin}, the least of {len(POSES)} "
        f"rest poses, and {rest.alpha:.2f} at the level of the second scenario.",
        f"In the pose of the least, with torques at {100 * WEAKER:g} % of what is commanded, the slowest pole is "
        f"{pole:+.2f} 1/s.",
        estimand="The disk margin of both torques at once, of the linear loop at rest with the first gain K(0).",
        given=f"AOSMC-RGS: positions alone. SMC: {EXACT}.",
        reversal=f"A stiffer observer: with L2 {STIFFER:g} times as large the margin {thin} is {firm[thin]:.2f}, the "
        f"least of the {len(POSES)} poses {min(firm.values()):.2f}.",
    )


def slow(results: Results) -> Verdict:
    """The gain of slow torques that no block is given."""
    ours, pid, smc = (rests(results)[law][LEVEL].slow_gain for law in (PROPOSED, "PID", "SMC"))
    return Verdict(
        "found",
        f"The repaired law multiplies a slow torque on the joints that is not in its D_hat by {ours:.1f}, SMC by "
        f"{smc:.4f}, PID by {pid:.0e}.",
        "In a1 D_hat is filtered from the true disturbance, so that this is not seen there.",
        estimand=f"The largest gain of the sensitivity at the torques at {SLOW:g} rad/s, of the linear loop {HERE}.",
        given=f"AOSMC-RGS: positions alone. SMC and PID: {EXACT}.",
        reversal="An estimate of the disturbance from measurements, which the law of the paper lacks.",
    )


def twisting(results: Results) -> Verdict:
    """The linear model of super-twisting in its layer."""
    rest = rests(results)["super-twisting"][LEVEL]
    return Verdict(
        "found",
        "With its sign spread over the boundary layer, the linear model of super-twisting at rest has "
        f"{f'a disk margin of {rest.alpha:.2f}' if rest.disk else 'no disk margin'}: its slowest poles are at "
        f"{abs(rest.poles[0].value):.1f} rad/s with a damping of {max(rest.poles[0].damping, 0.0):.2g}.",
        "The linear model at s = 0 lacks the term with the root of |s|, which may damp the loop: without it the loop "
        "oscillates at the root of k2 / phi.",
        estimand=f"Poles and the disk margin of both torques of the linear loop {HERE}.",
        given=f"The law: {EXACT}.",
        reversal="A layer that smooths the root of |s| too: then its term has a slope at s = 0.",
    )


def frozen(results: Results) -> Verdict:
    """The frozen poles along the first scenario, and within the layer alone."""
    every = paths(results)
    rate, worst = max((path.largest.max(), law) for law, path in every.items())
    shares = ", ".join(f"{law} {100 * path.share:.1f} %" for law, path in every.items() if law != "PID")
    least = ", ".join(f"{law} {np.nanmin(path.alpha):.3g}" for law, path in every.items())
    left, within = max((path.within, law) for law, path in every.items())
    return Verdict(
        "found",
        f"Along the first scenario the largest real part of a frozen pole is {rate:+.1f} 1/s, of {worst}; within the "
        f"layer it is {left:+.1f} 1/s, of {within}.",
        "Outside of the layer the saturation has no slope, and the law no feedback of s. Frozen poles do not decide "
        f"the stability of a loop that moves. Time within the layer: {shares}. Least disk margin there: {least}.",
        estimand=f"Poles of the whole linear loop every 0.1 s of one run without noise for each of {len(SEVEN)} laws.",
        given=f"AOSMC-RGS: positions and the true disturbance. All others: {EXACT}.",
        reversal="Other gains of the law or of its observer: none was tried along this path.",
    )


def findings(results: Results) -> tuple[Verdict, ...]:
    """The verdicts on the arm, on the laws at rest and on their path."""
    return (*(one(results) for one in (rest_points, delays, observer, slow, twisting, frozen)),)


def sections(results: Results) -> Sequence[Section]:
    """The whole page."""
    pictures = pages.along_path(results), pages.responses_figure(results)
    first = Section("What was found", (*pictures, *findings(results)))
    return (first, pages.arm_section(results), pages.at_rest_section(results))


study = Study(
    name="a5_linear_analysis",
    title="Linear analysis of the arm and of seven laws",
    question=(
        "How do the arm and the seven loops behave near rest and along the paper's path, how far are they from "
        "instability at the torque, and where does linear analysis say nothing?"
    ),
    method=(
        "Exact Jacobians of the equations; rest points by Newton's method, with intervals to prove that there are "
        "no others. Each loop is cut at the torque. The disk margin is bounded from below by the H-infinity norm of "
        "the scaled (S - T) / 2, found by a Hamiltonian matrix and not on a grid. Along the first scenario of a1 "
        "the equations are linearised at each kept state of its run."
    ),
    cases=comparison("FS"),
    works=pages.works,
    sections=sections,
    seed=SEED,
)
