"""The pictures and tables of a5: the arm by itself, each law at rest, and its path."""

from typing import Any

import numpy as np

from studies.a1_paper_tables.study import STYLES
from studies.a5_linear_analysis.findings import alpha, arm, delay, rest_points, slow_gain
from studies.paper.linearization import LEVEL, POSES, PROPOSED, SEVEN, AtRest, at_rest, late_gain, on_path
from workbench.design.linear import (
    controllability,
    frequency_response,
    linearize,
    lyapunov_exponents,
    observability,
    one_loop,
    poles,
    sensitivity,
)
from workbench.study.document.document import Cell, Column, Figure, Panel, Paragraph, Section, Series, Table
from workbench.study.study import Results

ADAPTIVE = (PROPOSED, "ASMC", "Fuzzy-ASMC", "RBF-ASMC")
DRAWN = (PROPOSED, "RBF-ASMC", "PID", "SMC")
FREQUENCIES = np.geomspace(0.01, 1e5, 300)
RAD = "frequency [rad/s]"
NAMES = {
    (0.0, 0.0): "hanging",
    (0.0, np.pi): "folded down",
    (np.pi, 0.0): "upright",
    (np.pi, np.pi): "folded up",
}


def along_path(results: Results) -> Figure:
    """The disk margin, the slowest and the fastest frozen pole over time."""
    alphas, slow, fast = [], [], []
    for law in SEVEN:
        path, style = on_path(results["FS", law]), STYLES[law]
        alphas += [
            Series(law, path.sparse, path.alpha, style),
            Series(law, path.sparse, path.alpha, style, look="marks"),
        ]
        slow.append(Series(law, path.t, path.eigenvalues.real.max(axis=1), style))
        fast.append(Series(law, path.t, -path.eigenvalues.real.min(axis=1), style))
    panels = (
        Panel("disk margin", tuple(alphas), ylim=(0.0, 2.05), title="margin"),
        Panel("largest real part [1/s]", tuple(slow), title="slowest pole"),
        Panel("decay of the fastest [1/s]", tuple(fast), yscale="log", title="fastest pole"),
    )
    caption = (
        "The disk margin at the torques, every second within the layer, with the adaptive gains held, and the poles of "
        "the whole loop, every 0.1 s, frozen along the first scenario. A gain that is free to stay where it is leaves "
        "a pole at 0."
    )
    return Figure("frozen", caption, panels, columns=3)


def responses() -> Figure:
    """The loop gain of each joint with the other closed, and the largest singular values of S and T."""
    curves: dict[str, list[Series]] = {}

    def draw(name: str, law: str, y: Any) -> None:
        curves.setdefault(name, []).append(Series(law, FREQUENCIES, np.asarray(y), STYLES[law]))

    for law in DRAWN:
        S = frequency_response(sensitivity(at_rest(law).loop), FREQUENCIES)
        for joint in (0, 1):
            L = frequency_response(one_loop(at_rest(law).loop, joint), FREQUENCIES)[:, 0, 0]
            phase = np.mod(np.degrees(np.angle(L)) + 275, 360) - 275
            phase[1:][np.abs(np.diff(phase)) > 200] = np.nan  # a gap where it leaves at one end and comes back
            draw(f"gain, joint {joint + 1}", law, np.abs(L))
            draw(f"phase, joint {joint + 1} [deg]", law, phase)
        draw("largest gain of S", law, np.linalg.norm(S, 2, axis=(-2, -1)))
        draw("largest gain of T", law, np.linalg.norm(np.eye(2) - S, 2, axis=(-2, -1)))
    panels = (
        Panel(name, tuple(series), RAD, xscale="log", hlines=(-180.0,))
        if name.startswith("phase")
        else Panel(name, tuple(series), RAD, xscale="log", yscale="log", hlines=(1.0,))
        for name, series in curves.items()
    )
    caption = (
        "The loop gain at one torque while the other loop is closed, and the largest singular values of sensitivity S "
        "and complementary sensitivity T, at rest at the level of the second scenario. ASMC and Fuzzy-ASMC lie on SMC."
    )
    return Figure("responses", caption, tuple(panels), columns=2)


def arm_section() -> Section:
    """Rest points and the motion of the arm by itself."""
    exponents = lyapunov_exponents(arm(), until=60.0, h=0.01, skip=20.0)
    top, error = float(exponents.values[0]), float(exponents.error[0])
    radii = [point.radius for point in rest_points().points]
    known = None not in radii
    within = f"within 1e{int(np.ceil(np.log10(max(radii))))} rad of where it is said to be" if known else "not at all"
    rows: list[tuple[Cell, ...]] = []
    for point in rest_points().points:
        G = linearize(arm(), 0.0, point.x, at_rest=True)
        name = next(words for pose, words in NAMES.items() if np.allclose(pose, point.x[:2], atol=1e-6))
        angles = (float(np.round(angle, 12)) + 0.0 for angle in point.x[:2])
        modes = ", ".join(sorted({shown(pole.value) for pole in poles(G)}))
        rows.append((name, *angles, modes, controllability(G).margin, *observed(G)))
    columns = (
        Column("rest point"),
        Column("q1", "rad", digits=4),
        Column("q2", "rad", digits=4),
        Column("poles", "1/s"),
        Column("controllable by", digits=2),
        Column("observable by, q and qd", digits=2),
        Column("observable by, q alone", digits=2),
    )
    note = (
        "Controllable and observable by: the margin of the test of Popov, Belevitch and Hautus, which is the least "
        "singular value of [z I - A, B] or [z I - A; C] for z near an eigenvalue of A, as a share of the norm of "
        "[A, B] or [A; C], in rad, s and N m. Positions alone are all that observer (10) is given.",
    )
    words = (
        f"Without torque, for -1 to 4 rad in both joints: {rest_points()}. Each is proved to lie "
        f"{within}. Falling freely from near the state at which FS begins, the arm has a largest Lyapunov exponent of "
        f"{top:.2f} 1/s over {exponents.span:g} s, with an estimated error of {error:.2f} 1/s: its sign is "
        f"{'known' if abs(top) > error else 'open'}. Volumes in phase space are kept, in coordinates of momentum: the "
        f"four exponents sum to {exponents.values.sum():.1g} 1/s."
    )
    caption = "The rest points of the arm without torque, and their modes."
    return Section("The arm by itself", (Paragraph(words), Table("rest_points", caption, columns, tuple(rows), note)))


def observed(G: Any) -> tuple[float, float]:
    """The margins of observability of the arm's linear model by positions and velocities, and by positions alone."""
    positions = [i for i, label in enumerate(G.output_labels) if label.startswith("q[")]
    return observability(G).margin, observability(G[positions, :]).margin


def shown(value: complex) -> str:
    """A pole as it is printed; of a pair both."""
    parts = [part if abs(part) > 1e-9 * abs(value) else 0.0 for part in (value.real, abs(value.imag))]
    real, imag = ((f"{p:.0f}" if abs(p) >= 100 else f"{p:.3g}").replace("-", "\N{MINUS SIGN}") for p in parts)
    return f"{real} \N{PLUS-MINUS SIGN} {imag}i" if parts[1] else real


def at_rest_section(results: Results) -> Section:
    """Poles and margins at rest."""
    first = {law: at_rest(law) for law in SEVEN}
    loops = first | {f"{law}, late K": at_rest(law, LEVEL, late_gain(results["FS", law])) for law in ADAPTIVE}
    words = (
        "Each loop is cut at the torque, with its adaptive gains held; L goes from the torque that moves the plant to "
        "minus the torque that the law commands, with the observer counting on the latter. Margins of one joint are "
        "those with the other closed, the worse of the two; the disk margin and the last three columns are of both "
        "torques at once. Late K: with the gain at the end of the first scenario. Largest S: by how much the loop "
        "leaves, or amplifies, a torque at 0.001 rad/s that no block is given. A disk margin is 2 at most, and "
        "thin below 0.2. A dash: the loop is not asymptotically stable."
    )
    poses = Table(
        "poses",
        "The disk margin at rest, pose by pose, with first gains.",
        (Column("law"), *(Column(pose, digits=3) for pose in POSES)),
        tuple((law, *(alpha(at_rest(law, pose)) or None for pose in POSES)) for law in SEVEN),
    )
    return Section("The laws at rest", (Paragraph(words), _poles(loops), _margins(loops), poses))


def _poles(loops: dict[str, AtRest]) -> Table:
    columns = (
        Column("law"),
        Column("slowest pole", "1/s"),
        Column("fastest pole", "1/s"),
        Column("least damping", digits=3),
        Column("largest S at rest", digits=3),
    )
    rows = []
    for name, rest in loops.items():
        damping = float(np.round(min(pole.damping for pole in rest.poles), 9)) + 0.0
        rows.append((name, shown(rest.poles[0].value), shown(rest.poles[-1].value), damping, slow_gain(rest)))
    return Table("at_rest", "Poles at rest at the level of the second scenario.", columns, tuple(rows))


def _margins(loops: dict[str, AtRest]) -> Table:
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
    rows: list[tuple[Cell, ...]] = []
    for name, rest in loops.items():
        if rest.disk is None:
            rows.append((name, *(8 * (None,))))
            continue
        gains, phase = [m.gain for m in rest.channels], min(m.phase for m in rest.channels)
        ends = max(low for low, _ in gains), min(high for _, high in gains)
        rows.append((name, *ends, phase, delay(rest), rest.disk.alpha, *rest.disk.gain, rest.disk.phase))
    caption = "Margins at the torque, at rest at the level of the second scenario."
    return Table("margins", caption, columns, tuple(rows))
