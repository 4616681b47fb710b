"""The verdicts of a5 on the arm and its laws, at rest and along the first scenario."""

from functools import cache

import numpy as np

from studies.paper.card import CARD
from studies.paper.laws import ARM
from studies.paper.linearization import FINE, LEVEL, POSES, PROPOSED, SEVEN, AtRest, at_rest, late_gain, on_path
from workbench.core import Ode
from workbench.design.linear import Equilibria, equilibria, forward_differences, linearize, sensitivity
from workbench.loop import open_loop
from workbench.plants import Manipulator
from workbench.study.document.document import Verdict
from workbench.study.study import Outcome, Results

SEED = 1
BOX = {"q": (-1.0, 4.0), "qd": (-5.0, 5.0)}
STIFFER = 4.0  # of an observer, to see what its gain is to blame for
WEAKER = 0.9  # of the torque that is commanded
SLOW = 1e-3  # rad/s
HERE = "at rest at the level of the second scenario"
EXACT = "exact positions and velocities"


@cache
def arm() -> Ode:
    """The paper's arm, driven by its torque, from the state of FS."""
    return open_loop(Manipulator(ARM, q=np.array([np.pi, -np.pi]) + 0.1))


@cache
def rest_points() -> Equilibria:
    """Its rest points without torque."""
    return equilibria(arm(), BOX, seed=SEED)


def rests() -> Verdict:
    """The number of rest points, and the error of A and B by forward differences in place of exact Jacobians."""
    rng, worst = np.random.default_rng(SEED), 0.0
    for _ in range(20):
        x, u = rng.uniform(-2, 2, 4), rng.uniform(-5, 5, 2)
        ours, theirs = (
            np.hstack([G.A, G.B]) for G in (of(arm(), 0.0, x, u=u) for of in (linearize, forward_differences))
        )
        worst = max(worst, float(np.abs(theirs - ours).max() / np.abs(ours).max()))
    return Verdict(
        "holds" if rest_points().complete else "open",
        f"The arm without torque has {len(rest_points().points)} rest points with both joints between "
        f"{BOX['q'][0]:g} and {BOX['q'][1]:g} rad.",
        "Intervals prove that there are no others. Linear models here are exact Jacobians; python-control's own "
        f"linearize, a forward difference, is off by up to {worst:.0e} of the largest entry of A and B (worst of 20 "
        "random states).",
        given="The arm with the numbers of section 5.",
    )


def delays(results: Results) -> Verdict:
    """The delay that SMC stands, and ASMC with the gain that it has learned."""
    first, late = delay(at_rest("SMC")), delay(at_rest("ASMC", LEVEL, late_gain(results["FS", "ASMC"])))
    return Verdict(
        "found",
        f"SMC stays stable with a delay of up to {first:.2f} ms at one torque, ASMC with the gain that it has "
        f"learned with up to {late:.2g} ms.",
        f"K is {CARD['SMC: K'][0]:g} N m for SMC, and for ASMC that of the end of the first scenario. a1 compares "
        "loops in continuous time, without delay.",
        estimand=f"The delay margin of the linear loop {HERE}, the lesser of the two joints.",
        given=f"Both laws: {EXACT}.",
        reversal=f"A layer wider than {CARD['phi']:g} rad/s or a smaller gain, which raise both margins.",
    )


def observer() -> Verdict:
    """The margin that the observer of the repaired law leaves."""
    rest, thin = at_rest(PROPOSED), thinnest()
    weak = at_rest(PROPOSED, thin)
    firm = {pose: alpha(at_rest(PROPOSED, pose, stiffer=STIFFER)) for pose in POSES}
    pole = float(np.linalg.eigvals(weak.loop.A - WEAKER * weak.loop.B @ weak.loop.C).real.max())
    return Verdict(
        "found",
        f"The disk margin of the repaired law at the torques is {alpha(weak):.3f} {thin}, the least of {len(POSES)} "
        f"rest poses, and {alpha(rest):.2f} at the level of the second scenario.",
        f"In the pose of the least, with torques at {100 * WEAKER:g} % of what is commanded, the slowest pole is "
        f"{pole:+.2f} 1/s. At the level of the second scenario the loop stands a delay of {delay(rest):.0f} ms at one "
        f"torque, that of SMC {delay(at_rest('SMC')):.2f} ms.",
        estimand="The disk margin of both torques at once, of the linear loop at rest with the first gain K(0).",
        given=f"AOSMC-RGS: positions alone. SMC: {EXACT}.",
        reversal=f"A stiffer observer: with L2 {STIFFER:g} times as large the margin {thin} is {firm[thin]:.2f}, the "
        f"least of the {len(POSES)} poses {min(firm.values()):.2f}.",
    )


def slow() -> Verdict:
    """The gain of slow torques that no block is given."""
    ours, pid, smc = (slow_gain(at_rest(law)) for law in (PROPOSED, "PID", "SMC"))
    return Verdict(
        "found",
        f"The repaired law multiplies a slow torque on the joints that is not in its D_hat by {ours:.1f}, SMC by "
        f"{smc:.4f}, PID by {pid:.0e}.",
        "In a1 D_hat is filtered from the true disturbance, so that this is not seen there.",
        estimand=f"The largest gain of the sensitivity at the torques at {SLOW:g} rad/s, of the linear loop {HERE}.",
        given=f"AOSMC-RGS: positions alone. SMC and PID: {EXACT}.",
        reversal="An estimate of the disturbance from measurements, which the law of the paper lacks.",
    )


def twisting() -> Verdict:
    """The linear model of super-twisting in its layer."""
    rest = at_rest("super-twisting")
    return Verdict(
        "found",
        "With its sign spread over the boundary layer, the linear model of super-twisting at rest has "
        f"{f'a disk margin of {alpha(rest):.2f}' if rest.disk else 'no disk margin'}: its slowest poles are at "
        f"{abs(rest.poles[0].value):.1f} rad/s with a damping of {max(rest.poles[0].damping, 0.0):.2g}.",
        "The linear model at s = 0 lacks the term with the root of |s|, which is of higher order; without it the loop "
        "oscillates at the root of k2 / phi. That term may damp the loop: the linear model cannot say.",
        estimand=f"Poles and the disk margin of both torques of the linear loop {HERE}.",
        given=f"The law: {EXACT}.",
        reversal="A layer that smooths the root of |s| too: then its term has a slope at s = 0.",
    )


def adaptation() -> Verdict:
    """The margins of laws that differ by adaptation alone."""
    same = [abs(alpha(at_rest(law)) - alpha(at_rest("SMC"))) for law in ("ASMC", "Fuzzy-ASMC", "RBF-ASMC")]
    network, plain = (slow_gain(at_rest(law)) for law in ("RBF-ASMC", "SMC"))
    return Verdict(
        "found",
        f"At rest and with the same gain, the disk margins of SMC, ASMC, Fuzzy-ASMC and RBF-ASMC agree within "
        f"{max(same):.0e}.",
        "Adaptation is of second order in s, and the network of RBF-ASMC is slow and weak: of a constant torque it "
        f"leaves {100 * network:.2f} % where SMC leaves {100 * plain:.2f} %.",
        estimand=f"The disk margin of both torques of the linear loop {HERE}, with {CARD['SMC: K'][0]:g} N m for all.",
        given=f"All four: {EXACT}.",
        reversal="The gains that they learn: the table of margins has those of the end of the first scenario.",
    )


def frozen(results: Results) -> Verdict:
    """The frozen poles along the first scenario, and within the layer alone."""
    rate, worst = max((growth(results["FS", law]), law) for law in SEVEN)
    paths = {law: on_path(results["FS", law]) for law in SEVEN}
    shares = ", ".join(f"{law} {100 * path.inside.mean():.1f} %" for law, path in paths.items() if law != "PID")
    least = ", ".join(f"{law} {np.nanmin(path.alpha):.3g}" for law, path in paths.items())
    left, within = max((growth(results["FS", law], within=True), law) for law in SEVEN)
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


def growth(outcome: Outcome, within: bool = False) -> float:
    """The largest real part of a frozen pole, of all instants or of those within the layer."""
    path = on_path(outcome)
    largest = path.eigenvalues.real.max(axis=1)
    return float(largest[path.inside[::FINE]].max() if within else largest.max())


def thinnest() -> str:
    """The pose at which the proposed law has the least margin."""
    return min(POSES, key=lambda pose: alpha(at_rest(PROPOSED, pose)))


def slow_gain(rest: AtRest) -> float:
    """The largest singular value of S at 0.001 rad/s."""
    return float(np.linalg.norm(np.asarray(sensitivity(rest.loop)(1j * SLOW)), 2))


def delay(rest: AtRest) -> float:
    """The delay that a loop stands at either torque, in ms."""
    return 1e3 * min((m.delay for m in rest.channels), default=0.0)


def alpha(rest: AtRest) -> float:
    """The disk margin; 0 where there is none."""
    return rest.disk.alpha if rest.disk else 0.0
