"""The pictures and tables of a5: the arm by itself, each law at rest, and its path."""

from functools import cache
from typing import Any

import numpy as np

from studies.a1_paper_tables.study import STYLES
from studies.paper.card import PROPOSED
from studies.paper.laws import ARM
from studies.paper.linearization import LEVEL, POSES, SEVEN, AtRest, at_rest, on_path
from workbench.core import Ode
from workbench.design import linear
from workbench.design.linear import Equilibria, frequency_response, linearize, sensitivity
from workbench.loop import open_loop
from workbench.plants import Manipulator
from workbench.study.document.document import Figure, Panel, Paragraph, Section, Series
from workbench.study.document.phrases import Cell, Column, Table
from workbench.study.study import Results

ADAPTIVE = (PROPOSED, "ASMC", "Fuzzy-ASMC", "RBF-ASMC")
DRAWN = (PROPOSED, "RBF-ASMC", "PID", "SMC")
FREQUENCIES = np.geomspace(0.01, 1e5, 300)
SEED = 1
BOX = {"q": (-1.0, 4.0), "qd": (-5.0, 5.0)}


@cache
def arm() -> Ode:
    """The paper's arm, driven by its torque, from near the state of FS."""
    return open_loop(Manipulator(ARM, q=np.array([np.pi, -np.pi]) + 0.1))


@cache
def rest_points() -> Equilibria:
    """Its rest points without torque."""
    return linear.equilibria(arm(), BOX, seed=SEED)


def learned(results: Results, law: str) -> AtRest:
    """A loop at rest with the adaptive gain of the end of the first scenario."""
    K = results["FS", law].measurement.trajectories["controller.K"][0][-1]
    return at_rest(law, LEVEL, tuple(np.ravel(K).tolist()))


def along_path(results: Results) -> Figure:
    """The disk margin, the slowest and the fastest frozen pole over time."""
    margins, slow, fast = [], [], []
    for law in SEVEN:
        path, style = on_path(results["FS", law]), STYLES[law]
        margins.append(Series(law, path.sparse, path.alpha, style))
        margins.append(Series(law, path.sparse, path.alpha, style, look="marks"))
        slow.append(Series(law, path.t, path.eigenvalues.real.max(axis=1), style))
        fast.append(Series(law, path.t, -path.eigenvalues.real.min(axis=1), style))
    panels = (
        Panel("disk margin", tuple(margins), ylim=(0.0, 2.05), title="margin"),
        Panel("largest real part [1/s]", tuple(slow), title="slowest pole"),
        Panel("decay of the fastest [1/s]", tuple(fast), yscale="log", title="fastest pole"),
    )
    caption = (
        "The disk margin at the torques, every second within the layer, with the adaptive gains held, and the poles of "
        "the whole loop, every 0.1 s, frozen along the first scenario. A gain that is free leaves a pole at 0."
    )
    return Figure("frozen", caption, panels, columns=3)


def responses() -> Figure:
    """The loop gain of each joint with the other closed, and the largest singular values of S and T."""
    curves: dict[str, list[Series]] = {}

    def draw(name: str, law: str, y: Any) -> None:
        curves.setdefault(name, []).append(Series(law, FREQUENCIES, np.asarray(y), STYLES[law]))

    for law in DRAWN:
        loop = at_rest(law).loop
        S = frequency_response(sensitivity(loop), FREQUENCIES)
        for joint in (0, 1):
            L = frequency_response(linear.one_loop(loop, joint), FREQUENCIES)[:, 0, 0]
            phase = np.mod(np.degrees(np.angle(L)) + 275, 360) - 275
            phase[1:][np.abs(np.diff(phase)) > 200] = np.nan  # a gap where it leaves at one end and comes back
            draw(f"gain, joint {joint + 1}", law, np.abs(L))
            draw(f"phase, joint {joint + 1} [deg]", law, phase)
        draw("largest gain of S", law, np.linalg.norm(S, 2, axis=(-2, -1)))
        draw("largest gain of T", law, np.linalg.norm(np.eye(2) - S, 2, axis=(-2, -1)))
    panels = []
    for name, series in curves.items():
        yscale, line = ("linear", -180.0) if name.startswith("phase") else ("log", 1.0)
        panels.append(Panel(name, tuple(series), "frequency [rad/s]", xscale="log", yscale=yscale, hlines=(line,)))
    caption = (
        "The loop gain at one torque while the other loop is closed, and the largest singular values of sensitivity S "
        "and complementary sensitivity T, at rest at the level of the second scenario. ASMC and Fuzzy-ASMC lie on SMC."
    )
    return Figure("responses", caption, tuple(panels), columns=2)


def arm_section() -> Section:
    """Rest points and the motion of the arm by itself."""
    exponents = linear.lyapunov_exponents(arm(), until=60.0, h=0.01, skip=20.0)
    top, error = float(exponents.values[0]), float(exponents.error[0])
    rows: list[tuple[Cell, ...]] = []
    for point in rest_points().points:
        G = linearize(arm(), 0.0, point.x, at_rest=True)
        name = next(words for words, pose in POSES.items() if np.allclose(pose, point.x[:2], atol=1e-6))
        angles = (float(np.round(angle, 12)) + 0.0 for angle in point.x[:2])
        modes = ", ".join(sorted({shown(pole.value) for pole in linear.poles(G)}))
        rows.append((name, *angles, modes, linear.controllability(G).margin, *observed(G)))
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
        "[A, B] or [A; C], in rad, s and N m. Positions alone are all that observer (10) is given."
    )
    words = (
        f"Without torque, for -1 to 4 rad in both joints: {rest_points()}. Falling freely from near the state at which "
        f"FS begins, the arm has a largest Lyapunov exponent of {top:.2f} 1/s over {exponents.span:g} s, with an "
        f"estimated error of {error:.2f} 1/s."
    )
    caption = "The rest points of the arm without torque, and their modes."
    return Section(
        "The arm by itself", (Paragraph(words), Table("rest_points", caption, columns, tuple(rows), (note,)))
    )


def observed(G: Any) -> tuple[float, float]:
    """The margins of observability of the arm's linear model by positions and velocities, and by positions alone."""
    positions = [i for i, label in enumerate(G.output_labels) if label.startswith("q[")]
    return linear.observability(G).margin, linear.observability(G[positions, :]).margin


def shown(value: complex) -> str:
    """A pole as it is printed; of a pair both."""
    parts = [part if abs(part) > 1e-9 * abs(value) else 0.0 for part in (value.real, abs(value.imag))]
    real, imag = ((f"{p:.0f}" if abs(p) >= 100 else f"{p:.3g}").replace("-", "\N{MINUS SIGN}") for p in parts)
    return f"{real} \N{PLUS-MINUS SIGN} {imag}i" if parts[1] else real


def at_rest_section(results: Results) -> Section:
    """Poles and margins at rest."""
    loops = {law: at_rest(law) for law in SEVEN} | {f"{law}, late K": learned(results, law) for law in ADAPTIVE}
    words = (
        "L goes from the torque that moves the plant to minus the torque that the law commands, with the observer "
        "counting on the latter and the adaptive gains held. Margins of one joint are those with the other closed, the "
        "worse of the two; the disk margin, 2 at most, and the last three columns are of both torques at once. Late K: "
        "with the gain at the end of the first scenario. Largest S: of a torque at 0.001 rad/s that no block is given. "
        "A dash: the loop is not asymptotically stable."
    )
    poses = Table(
        "poses",
        "The disk margin at rest, pose by pose, with first gains.",
        (Column("law"), *(Column(pose, digits=3) for pose in POSES)),
        tuple((law, *(at_rest(law, pose).alpha or None for pose in POSES)) for law in SEVEN),
    )
    return Section("The laws at rest", (Paragraph(words), poles_table(loops), margins_table(loops), poses))


def poles_table(loops: dict[str, AtRest]) -> Table:
    """The poles, and the gain of slow torques."""
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
        rows.append((name, shown(rest.poles[0].value), shown(rest.poles[-1].value), damping, rest.slow_gain))
    return Table("at_rest", "Poles at rest at the level of the second scenario.", columns, tuple(rows))


def margins_table(loops: dict[str, AtRest]) -> Table:
    """The margins of one torque, and of both at once."""
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
        rows.append((name, *ends, phase, rest.delay, rest.disk.alpha, *rest.disk.gain, rest.disk.phase))
    return Table("margins", "Margins at the torque, as in the table before.", columns, tuple(rows))
