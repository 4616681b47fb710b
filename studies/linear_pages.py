"""How a5 reads: the findings, then each law at rest, its frequency responses, and its path."""

from collections.abc import Sequence

import numpy as np
from linear_arm import BOX, arm_section, deviations, rests, shown
from linear_figures import bode, margins_on_path, poles_on_path, sensitivities
from linear_loops import FINE, LEVEL, POSES, PROPOSED, SEVEN, AtRest, at_rest, late_gain, on_path
from paper_card import CARD

from workbench.design.linear import sensitivity
from workbench.study.document import Cell, Column, Paragraph, Section, Table, Verdict
from workbench.study.study import Outcome, Results

SHORT = 1.0  # ms, the period of a quick robot controller
ADAPTIVE = (PROPOSED, "ASMC", "Fuzzy-ASMC", "RBF-ASMC")
THIN = 0.2  # a disk margin below it allows gains off by a fifth, and no more
STIFFER = 4.0  # of an observer, to see what its gain is to blame for
WEAKER = 0.9  # of the torque that is commanded


def findings(results: Results) -> Section:
    """The answers first."""
    return Section(
        "What was found",
        (_rests(), _delay(results), _observer(), _slow(), _twisting(), _adaptation(), _frozen(results)),
    )


def _rests() -> Verdict:
    worst = deviations()["python-control's linearize"]
    low, high = BOX["q"]
    return Verdict(
        "holds" if rests().complete else "open",
        f"All rest points of the arm without torque are found, for both joints between {low:g} and {high:g} rad.",
        f"{len(rests().points)} of them, and intervals prove that there are no others. Linear models here are exact "
        f"Jacobians; python-control's own linearize, a forward difference, is off by up to {worst:.0e} of the largest "
        "entry of A and B (worst of 20 random states).",
    )


def _delay(results: Results) -> Verdict:
    first, late = delay(at_rest("SMC")), delay(at_rest("ASMC", LEVEL, late_gain(results["FS", "ASMC"])))
    return Verdict(
        "holds" if min(first, late) >= SHORT else "fails",
        f"SMC and ASMC stay stable with a delay of {SHORT:g} ms at one torque.",
        f"Delay margins of the linear loops at rest at the level of the second scenario, given exact positions and "
        f"velocities: {first:.2f} ms for SMC with K = {CARD['SMC: K'][0]:g} N m, and {late:.2g} ms for ASMC with the "
        f"gain that it has learned by the end of the first scenario, both in a layer of {CARD['phi']:g} rad/s. A wider "
        "layer or a smaller gain raises them. a1 compares loops in continuous time, without delay.",
    )


def _observer() -> Verdict:
    rest, thin = at_rest(PROPOSED), thinnest()
    weak, firm = at_rest(PROPOSED, thin), at_rest(PROPOSED, thin, stiffer=STIFFER)
    pole = float(np.linalg.eigvals(weak.loop.A - WEAKER * weak.loop.B @ weak.loop.C).real.max())
    return Verdict(
        "fails" if alpha(weak) < THIN else "holds",
        f"The repaired law has a disk margin of at least {THIN:g} at the torques in each of {len(POSES)} rest poses.",
        f"Linear loops at rest with the first gain K(0), given positions alone. The margin is {alpha(rest):.2f} at the "
        f"level of the second scenario and {alpha(weak):.3f} {thin}, the least: there, with torques at "
        f"{100 * WEAKER:g} % of what is commanded, the slowest pole is {pole:+.2f} 1/s. With L2 of the observer "
        f"{STIFFER:g} times as large the margin in this pose is {alpha(firm):.2f}. At the level of the second scenario "
        f"the loop stands a delay of {delay(rest):.0f} ms at one torque, that of SMC {delay(at_rest('SMC')):.2f} ms.",
    )


def _slow() -> Verdict:
    ours, pid, smc = (slow_gain(at_rest(law)) for law in (PROPOSED, "PID", "SMC"))
    return Verdict(
        "fails" if ours >= 1 else "holds",
        "The repaired law reduces a slow torque on the joints that is not in its D_hat.",
        f"Largest gain of the sensitivity at the torques at 0.001 rad/s, at rest at the level of the second scenario: "
        f"{ours:.1f}, a magnification; of SMC {smc:.4f}, of PID {pid:.0e}. The rivals are given velocities too. In a1 "
        "D_hat is filtered from the true disturbance, so that this is not seen there; an estimate of the disturbance "
        "from measurements could reverse it.",
    )


def thinnest() -> str:
    """The pose at which the proposed law has the least margin."""
    return min(POSES, key=lambda pose: alpha(at_rest(PROPOSED, pose)))


def _twisting() -> Verdict:
    rest = at_rest("super-twisting")
    return Verdict(
        "fails" if rest.disk is None else "holds",
        "With its sign spread over the boundary layer, super-twisting has a disk margin at rest.",
        f"Of its linear model at s = 0 the term with the root of |s| is missing, as it is of higher order, and what is "
        f"left oscillates undamped at {abs(rest.poles[0].value):.1f} rad/s, the root of k2 / phi. A loop that is not "
        "asymptotically stable has no margin; whether the missing term damps it, the linear model cannot say.",
    )


def _adaptation() -> Verdict:
    same = [abs(alpha(at_rest(law)) - alpha(at_rest("SMC"))) for law in ("ASMC", "Fuzzy-ASMC", "RBF-ASMC")]
    network, plain = (slow_gain(at_rest(law)) for law in ("RBF-ASMC", "SMC"))
    return Verdict(
        "holds" if max(same) < 2e-3 else "fails",
        "At rest and with the same gain, SMC, ASMC, Fuzzy-ASMC and RBF-ASMC have the same disk margin.",
        f"It differs by at most {max(same):.0e} at the level of the second scenario, with "
        f"{CARD['SMC: K'][0]:g} N m for all: adaptation is of second order in s, and the network of RBF-ASMC is slow "
        f"and weak, so that of a constant torque it leaves {100 * network:.2f} % where SMC leaves "
        f"{100 * plain:.2f} %. The gains that they learn tell them apart.",
    )


def _frozen(results: Results) -> Verdict:
    growing = [(law, _growth(results["FS", law])) for law in SEVEN]
    worst, rate = max(growing, key=lambda pair: pair[1])
    within, left = max(((law, _growth(results["FS", law], True)) for law in SEVEN), key=lambda pair: pair[1])
    return Verdict(
        "fails" if rate > 0 else "holds",
        "Along the first scenario all frozen poles of all seven loops decay.",
        f"Poles frozen every 0.1 s of one run a law. Outside of the layer the saturation has no slope, and the law no "
        f"feedback of s: there those of {worst} reach {rate:+.1f} 1/s. Within the layer the largest is {left:+.1f} "
        f"1/s, of {within}. Frozen poles do not decide the stability of a loop that moves.",
    )


def _growth(outcome: Outcome, within: bool = False) -> float:
    """The largest real part of a frozen pole, of all instants or of those within the layer."""
    path = on_path(outcome)
    largest = path.eigenvalues.real.max(axis=1)
    return float(largest[path.inside[::FINE]].max() if within else largest.max())


def at_rest_section(results: Results) -> Section:
    """Poles and margins at rest."""
    return Section(
        "The laws at rest",
        (
            Paragraph(
                "Each loop is cut at the torque, with its adaptive gains held; L goes from the torque that moves the "
                "plant to minus the torque that the law commands, with the observer counting on the latter. Margins of "
                "one joint are those with the other closed; the disk margin is that of both torques at once."
            ),
            _poles_table(results),
            _margins_table(results),
            _poses_table(),
        ),
    )


def _loops(results: Results) -> dict[str, AtRest]:
    """Each law with its first gain, and with the gain at the end of the first scenario where it learns one."""
    first = {law: at_rest(law) for law in SEVEN}
    return first | {f"{law}, late K": at_rest(law, LEVEL, late_gain(results["FS", law])) for law in ADAPTIVE}


def _poles_table(results: Results) -> Table:
    columns = (
        Column("law"),
        Column("slowest pole", "1/s"),
        Column("fastest pole", "1/s"),
        Column("least damping", digits=3),
        Column("largest S at rest", digits=3),
    )
    rows = []
    for name, rest in _loops(results).items():
        damping = float(np.round(min(pole.damping for pole in rest.poles), 9)) + 0.0
        rows.append((name, shown(rest.poles[0].value), shown(rest.poles[-1].value), damping, slow_gain(rest)))
    note = (
        "Late K: with the gain at the end of the first scenario. Largest S at rest: by how much the loop leaves, or "
        "amplifies, a constant torque that no block is given, at 0.001 rad/s.",
    )
    return Table("at_rest", "Poles at rest at the level of the second scenario.", columns, tuple(rows), note)


def _margins_table(results: Results) -> Table:
    columns = (
        Column("law"),
        Column("gain down to", digits=2),
        Column("up to", digits=3),
        Column("phase", "deg", digits=3),
        Column("delay", "ms", digits=2),
        Column("disk margin", digits=3),
        Column("all gains from", digits=2),
        Column("to", digits=3),
        Column("all phases", "deg", digits=3),
    )
    rows = tuple((name, *_margins(rest)) for name, rest in _loops(results).items())
    notes = (
        "Gain, phase and delay of one torque, the worse of the two; the last four columns are of both torques at "
        "once, each changed independently. A dash: the loop is not asymptotically stable.",
    )
    caption = "Margins at the torque, at rest at the level of the second scenario."
    return Table("margins", caption, columns, rows, notes)


def _margins(rest: AtRest) -> tuple[Cell, ...]:
    if rest.disk is None:
        return (None,) * 8
    least, most = max(m.gain[0] for m in rest.channels), min(m.gain[1] for m in rest.channels)
    phase = min(m.phase for m in rest.channels)
    return (least, most, phase, delay(rest), rest.disk.alpha, *rest.disk.gain, rest.disk.phase)


def slow_gain(rest: AtRest) -> float:
    """The largest singular value of S at 0.001 rad/s."""
    S = np.asarray(sensitivity(rest.loop)(1e-3j))
    return float(np.linalg.norm(S, 2))


def _poses_table() -> Table:
    columns = (Column("law"), *(Column(pose, digits=3) for pose in POSES))
    rows = tuple((law, *(alpha(at_rest(law, pose)) or None for pose in POSES)) for law in SEVEN)
    note = ("A dash: no margin. 2 is the most that there is; below 0.2 a margin is thin.",)
    return Table("poses", "The disk margin at rest, pose by pose, with first gains.", columns, rows, note)


def responses_section() -> Section:
    """Frequency responses."""
    return Section(
        "Frequency responses",
        (
            Paragraph(
                "By python-control from the exact matrices, at rest at the level of the second scenario. ASMC and "
                "Fuzzy-ASMC lie on SMC."
            ),
            bode(),
            sensitivities(),
        ),
    )


def path_section(results: Results) -> Section:
    """Frozen poles and margins along the first scenario."""
    shares = [100 * float(on_path(results["FS", law]).inside.mean()) for law in SEVEN if law != "PID"]
    return Section(
        "Along the first scenario",
        (
            Paragraph(
                f"The linear models of each whole loop, frozen at each instant of its run. Its laws are within the "
                f"layer for {min(shares):.0f} to {max(shares):.0f} % of the time; a disk margin is taken there alone, "
                "with the adaptive gains held at their values."
            ),
            poles_on_path(results),
            margins_on_path(results),
            _path_table(results),
        ),
    )


def _path_table(results: Results) -> Table:
    columns = (
        Column("law"),
        Column("within the layer", "%", digits=3),
        Column("slowest frozen pole, at most", "1/s", digits=3),
        Column("fastest frozen pole", "1/s", digits=3),
        Column("least disk margin", digits=3),
        Column("largest", digits=3),
    )
    rows = []
    for law in SEVEN:
        path = on_path(results["FS", law])
        known = path.alpha[np.isfinite(path.alpha)]
        share = None if law == "PID" else 100 * float(path.inside.mean())
        real = path.eigenvalues.real
        rows.append((law, share, float(real.max()), float(real.min()), float(known.min()), float(known.max())))
    note = ("Poles every 0.1 s, margins every second.",)
    return Table("path", "Frozen poles and margins along the first scenario.", columns, tuple(rows), note)


def delay(rest: AtRest) -> float:
    """The delay that a loop stands at either torque, in ms."""
    return 1e3 * min((m.delay for m in rest.channels), default=0.0)


def alpha(rest: AtRest) -> float:
    """The disk margin; 0 where there is none."""
    return rest.disk.alpha if rest.disk else 0.0


def sections(results: Results) -> Sequence[Section]:
    """The whole page."""
    return (
        findings(results),
        arm_section(),
        at_rest_section(results),
        responses_section(),
        path_section(results),
    )


def headlines(results: Results) -> Sequence[str]:
    """The findings in a line each."""
    late = at_rest("ASMC", LEVEL, late_gain(results["FS", "ASMC"]))
    margins = ", ".join(f"{law} {alpha(at_rest(law)):.2f}" for law in SEVEN)
    return (
        f"Disk margins at the torque, at rest: {margins}.",
        f"Delay at the torque: SMC stands {delay(at_rest('SMC')):.2f} ms, ASMC late {delay(late):.2g} ms, AOSMC-RGS "
        f"{delay(at_rest(PROPOSED)):.0f} ms.",
        f"The thinnest disk margin of AOSMC-RGS is {alpha(at_rest(PROPOSED, thinnest())):.3f}, {thinnest()}.",
    )
