"""How a5 reads after its findings: each law at rest, its frequency responses, and its path."""

from collections.abc import Sequence

import numpy as np

from studies.a5_linear_analysis.arm import arm_section, shown
from studies.a5_linear_analysis.figures import bode, margins_on_path, poles_on_path, sensitivities
from studies.a5_linear_analysis.findings import alpha, delay, findings, slow_gain, thinnest
from studies.paper.linearization import LEVEL, POSES, PROPOSED, SEVEN, AtRest, at_rest, late_gain, on_path
from workbench.study.document.document import Cell, Column, Paragraph, Section, Table
from workbench.study.study import Results

ADAPTIVE = (PROPOSED, "ASMC", "Fuzzy-ASMC", "RBF-ASMC")


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
