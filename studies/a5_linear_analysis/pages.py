"""The pictures and tables of a5: the arm by itself, each law at rest, and its path."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

import workbench as wb
from studies.paper.card import PROPOSED_LAW
from studies.paper.comparison import STYLES
from studies.paper.laws import ARM
from studies.paper.linearization import LEVEL, POSES, SEVEN, AtRest, OnPath, at_rest, loop_at_rest, motion, on_path

ADAPTIVE = (PROPOSED_LAW, "ASMC", "Fuzzy-ASMC", "RBF-ASMC")
TABLE_LAWS = ("Fuzzy-ASMC", "RBF-ASMC")  # in the table alone
DRAWN_LAWS = (PROPOSED_LAW, "RBF-ASMC", "PID", "SMC")
FREQUENCIES = np.geomspace(0.01, 1e5, 300)
SEED = 1
BOX = {"q": (-1.0, 4.0), "qd": (-5.0, 5.0)}
STIFFER = 4.0  # of an observer, to see what its gain is to blame for


def arm() -> wb.Ode:
    """The paper's arm, driven by its torque, from near the state of FS."""
    return wb.open_loop(wb.Manipulator(ARM, q=np.array([np.pi, -np.pi]) + 0.1))


@dataclass(frozen=True, eq=False)
class ArmAlone:
    """The rest points of the arm without torque, and the Lyapunov exponents of its fall.

    Of each rest point there are the margins by which it is controllable, observable by positions and velocities, and
    observable by positions alone.
    """

    rest_points: wb.linear.Equilibria
    margins: tuple[tuple[float, float, float], ...]
    exponents: wb.linear.LyapunovExponents


def arm_alone(seed: int) -> ArmAlone:
    """The rest points, from starts that are drawn with a seed, and the exponents."""
    ode = arm()
    found = wb.linear.equilibria(ode, BOX, seed=seed)
    models = [wb.linearize(ode, 0.0, point.x, at_rest=True) for point in found.points]
    margins = tuple((wb.linear.controllability(G).margin, *observability_margins(G)) for G in models)
    return ArmAlone(found, margins, wb.linear.lyapunov_exponents(ode, until=60.0, h=0.01, skip=20.0))


@dataclass(frozen=True)
class Law:
    """A law, and its adaptive gain at the end of the first scenario, in N m; None if it has none."""

    name: str
    K: tuple[float, ...] | None


def loops_at_rest(law: Law) -> dict[str, AtRest]:
    """The loop of a law at rest by pose, with its learned gain by pose, and with a stiffer observer by pose."""
    found = {pose: at_rest(law.name, pose) for pose in POSES}
    if law.K is not None:
        found |= {late(pose): at_rest(law.name, pose, law.K) for pose in POSES}
    if law.name == PROPOSED_LAW:
        found |= {stiffer(pose): at_rest(law.name, pose, stiffer=STIFFER) for pose in POSES}
    return found


def late(pose: str) -> str:
    """The name of the loop at a pose with the gain at the end of the first scenario."""
    return f"{pose}, learned gain"


def stiffer(pose: str) -> str:
    """The name of the loop with a stiffer observer at a pose."""
    return f"{pose}, stiffer observer"


def responses(laws: tuple[str, ...]) -> dict[str, dict[str, wb.Array]]:
    """By law: loop gain and phase of each joint with the other closed, and the largest gains of S and T."""
    found: dict[str, dict[str, wb.Array]] = {}
    for law in laws:
        loop = loop_at_rest(law)
        S = wb.linear.frequency_response(wb.linear.sensitivity(loop), FREQUENCIES)
        curves = found[law] = {}
        for joint in (0, 1):
            L = wb.linear.frequency_response(wb.linear.one_loop(loop, joint), FREQUENCIES)[:, 0, 0]
            phase = np.mod(np.degrees(np.angle(L)) + 275, 360) - 275
            phase[1:][np.abs(np.diff(phase)) > 200] = np.nan  # a gap where it leaves at one end and comes back
            curves[f"gain, joint {joint + 1}"] = np.abs(L)
            curves[f"phase, joint {joint + 1} [deg]"] = phase
        curves["largest gain of S"] = np.linalg.norm(S, 2, axis=(-2, -1))
        curves["largest gain of T"] = np.linalg.norm(np.eye(2) - S, 2, axis=(-2, -1))
    return found


def works(results: wb.Results) -> tuple[wb.Work, ...]:
    """The arm by itself, each law at rest, and each law along its run in the first scenario."""
    outcomes = {law: results["FS", law] for law in SEVEN}
    gains = {law: outcomes[law].measurement.trajectories["controller.K"][0][-1] for law in ADAPTIVE}
    laws = (Law(law, tuple(np.ravel(gains[law]).tolist()) if law in gains else None) for law in SEVEN)
    return (
        wb.Work("arm", arm_alone, (SEED,), seconds=1.0),
        wb.Work("at_rest", loops_at_rest, tuple(laws), seconds=0.4),
        wb.Work("responses", responses, (DRAWN_LAWS,), seconds=0.2),
        wb.Work("on_path", on_path, tuple(map(motion, outcomes.values())), seconds=0.4),
    )


def rests(results: wb.Results) -> Mapping[str, Mapping[str, AtRest]]:
    """The loops at rest, by law and by name in `loops_at_rest`."""
    return dict(zip(SEVEN, results.work("at_rest"), strict=True))


def paths(results: wb.Results) -> Mapping[str, OnPath]:
    """The laws along their runs."""
    return dict(zip(SEVEN, results.work("on_path"), strict=True))


def along_path(results: wb.Results) -> wb.document.Figure:
    """The disk margin, the slowest and the fastest frozen pole over time."""
    margins, slow, fast = [], [], []
    for law, path in paths(results).items():
        if law in TABLE_LAWS:
            continue
        style = STYLES[law]
        margins.append(wb.document.Series(law, path.sparse, path.alpha, style))
        margins.append(wb.document.Series(law, path.sparse, path.alpha, style, look="marks"))
        later = path.t > 0.0  # the axis is logarithmic
        slow.append(wb.document.Series(law, path.t[later], path.largest[later], style))
        fast.append(wb.document.Series(law, path.t[later], -path.least[later], style))
    panels = (
        wb.document.Panel("disk margin", tuple(margins), ylim=(0.0, 2.05), title="margin"),
        wb.document.Panel("largest real part [1/s]", tuple(slow), xscale="log", title="slowest pole"),
        wb.document.Panel("decay of the fastest [1/s]", tuple(fast), xscale="log", yscale="log", title="fastest pole"),
    )
    caption = (
        "Margins and poles of the linear loops, frozen along the first scenario: the disk margin at the torques every "
        "second within the layer, with constant adaptive gains, and the poles of the whole loop every 0.1 s. An "
        "adaptive gain that is not constant gives a pole at 0. The poles have a logarithmic time axis, as they move at "
        "the start. Fuzzy-ASMC and RBF-ASMC are not drawn; the table has their numbers."
    )
    return wb.document.Figure("frozen", caption, panels, columns=3)


def path_table(results: wb.Results) -> wb.document.ReportTable:
    """The largest frozen poles, the time within the layer, and the least disk margin there."""
    rows = []
    for law, path in paths(results).items():
        inside = None if law == "PID" else 100 * path.share
        rows.append((law, float(path.largest.max()), path.within, inside, float(np.nanmin(path.alpha))))
    columns = (
        wb.document.TableColumn("law"),
        wb.document.TableColumn("largest real part", "1/s", "right", digits=3),
        wb.document.TableColumn("largest real part within the layer", "1/s", "right", digits=3),
        wb.document.TableColumn("time within the layer", "%", "right", digits=3),
        wb.document.TableColumn("least disk margin within the layer", "", "right", digits=3),
    )
    notes = ("PID has no layer: its numbers are over the whole run.",)
    return wb.document.ReportTable("path", "The frozen loops along the first scenario.", columns, tuple(rows), notes)


def responses_figure(results: wb.Results) -> wb.document.Figure:
    """Loop gain and phase of each joint with the other closed, and the largest singular values of S and T."""
    (found,) = results.work("responses")
    curves: dict[str, list[wb.document.Series]] = {}
    for law, held in found.items():
        for name, y in held.items():
            curves.setdefault(name, []).append(wb.document.Series(law, FREQUENCIES, y, STYLES[law]))
    panels = []
    for name, series in curves.items():
        yscale: Literal["linear", "log"] = "linear" if name.startswith("phase") else "log"
        line = -180.0 if name.startswith("phase") else 1.0
        panels.append(
            wb.document.Panel(name, tuple(series), "frequency [rad/s]", xscale="log", yscale=yscale, hlines=(line,))
        )
    caption = (
        "The loop gain at one torque with the other loop closed, and the largest singular values of sensitivity S "
        "and complementary sensitivity T, at rest at the level of the second scenario. The curves of ASMC and "
        "Fuzzy-ASMC coincide with that of SMC."
    )
    return wb.document.Figure("responses", caption, tuple(panels), columns=2)


def arm_blocks(results: wb.Results) -> tuple[wb.document.Block, ...]:
    """Rest points and the motion of the arm by itself."""
    alone: ArmAlone
    (alone,) = results.work("arm")
    exponents = alone.exponents
    top, error = float(exponents.values[0]), float(exponents.error[0])
    rows: list[tuple[wb.document.Cell, ...]] = []
    for point, margins in zip(alone.rest_points.points, alone.margins, strict=True):
        name = next(words for words, pose in POSES.items() if np.allclose(pose, point.x[:2], atol=1e-6))
        angles = (float(np.round(angle, 12)) + 0.0 for angle in point.x[:2])
        rows.append((name, *angles, ", ".join(sorted(set(map(pole_text, point.poles)))), *margins))
    columns = (
        wb.document.TableColumn("equilibrium"),
        wb.document.TableColumn("q1", "rad", digits=4),
        wb.document.TableColumn("q2", "rad", digits=4),
        wb.document.TableColumn("poles", "1/s"),
        wb.document.TableColumn("controllability margin", digits=2),
        wb.document.TableColumn("observability margin, q and qd", digits=2),
        wb.document.TableColumn("observability margin, q alone", digits=2),
    )
    note = (
        "The margins are those of the test of Popov, Belevitch and Hautus: the least singular value of [z I - A, B] or "
        "[z I - A; C] for z near an eigenvalue of A, divided by the norm of [A, B] or [A; C], in rad, s and N m. "
        "Observer (10) measures only positions."
    )
    words = (
        f"Without torque, for −1 to 4 rad in both joints: {alone.rest_points}. If the arm falls freely from near the "
        f"start of the first scenario, its largest Lyapunov exponent over {exponents.span:g} s is {top:.2f} 1/s, with "
        f"an estimated error of {error:.2f} 1/s."
    )
    caption = "The equilibria of the arm without torque, and their modes."
    return (wb.Paragraph(words), wb.document.ReportTable("rest_points", caption, columns, tuple(rows), (note,)))


def observability_margins(G: Any) -> tuple[float, float]:
    """The margins of observability of the arm's linear model by positions and velocities, and by positions alone."""
    positions = [i for i, label in enumerate(G.output_labels) if label.startswith("q[")]
    return wb.linear.observability(G).margin, wb.linear.observability(G[positions, :]).margin


def pole_text(value: complex) -> str:
    """A pole as it is printed; of a pair both."""
    parts = [part if abs(part) > 1e-9 * abs(value) else 0.0 for part in (value.real, abs(value.imag))]
    real, imag = ((f"{p:.0f}" if abs(p) >= 100 else f"{p:.3g}").replace("-", "\N{MINUS SIGN}") for p in parts)
    return f"{real} \N{PLUS-MINUS SIGN} {imag}i" if parts[1] else real


def at_rest_section(results: wb.Results) -> wb.Section:
    """Poles and margins at rest."""
    every = rests(results)
    loops = {law: every[law][LEVEL] for law in SEVEN}
    loops |= {f"{law}, learned gain": every[law][late(LEVEL)] for law in ADAPTIVE}
    words = (
        "The loop gain L is taken from the torque that moves the plant to minus the torque that the law commands. The "
        "observer gets the commanded torque, and the adaptive gains are constant. The margin of one joint has the loop "
        "of the other joint closed; the table has the worse of both. The disk margin, which is at most 2, and the last "
        "three columns are for both torques at once. The learned gain is the gain at the end of the first scenario. "
        "'Largest S' is the largest gain of S for a torque at 0.001 rad/s that no block measures. A dash: the loop is "
        "not asymptotically stable."
    )
    poses = wb.document.ReportTable(
        "poses",
        "The disk margin at rest in each pose, with the first gains.",
        (wb.document.TableColumn("law"), *(wb.document.TableColumn(pose, digits=3) for pose in POSES)),
        tuple((law, *(every[law][pose].alpha or None for pose in POSES)) for law in SEVEN),
    )
    return wb.Section("The laws at rest", (wb.Paragraph(words), poles_table(loops), margins_table(loops), poses))


def poles_table(loops: dict[str, AtRest]) -> wb.document.ReportTable:
    """The poles, and the gain of slow torques."""
    columns = (
        wb.document.TableColumn("law"),
        wb.document.TableColumn("slowest pole", "1/s"),
        wb.document.TableColumn("fastest pole", "1/s"),
        wb.document.TableColumn("least damping", digits=3),
        wb.document.TableColumn("largest S at rest", digits=3),
    )
    rows = []
    for name, rest in loops.items():
        damping = float(np.round(min(pole.damping for pole in rest.poles), 9)) + 0.0
        rows.append((name, pole_text(rest.poles[0].value), pole_text(rest.poles[-1].value), damping, rest.slow_gain))
    return wb.document.ReportTable(
        "at_rest", "Poles at rest at the level of the second scenario.", columns, tuple(rows)
    )


def margins_table(loops: dict[str, AtRest]) -> wb.document.ReportTable:
    """The margins of one torque, and of both at once."""
    columns = (
        wb.document.TableColumn("law"),
        wb.document.TableColumn("gain down to", digits=2),
        wb.document.TableColumn("up to", digits=3),
        wb.document.TableColumn("phase", "deg", digits=3),
        wb.document.TableColumn("delay", "ms", digits=2),
        wb.document.TableColumn("disk margin", digits=3),
        wb.document.TableColumn("all gains from", digits=2),
        wb.document.TableColumn("to", digits=3),
        wb.document.TableColumn("all phases", "deg", digits=3),
    )
    rows: list[tuple[wb.document.Cell, ...]] = []
    for name, rest in loops.items():
        if rest.disk is None:
            rows.append((name, *(8 * (None,))))
            continue
        gains, phase = [m.gain for m in rest.channels], min(m.phase for m in rest.channels)
        ends = max(low for low, _ in gains), min(high for _, high in gains)
        rows.append((name, *ends, phase, rest.delay, rest.disk.alpha, *rest.disk.gain, rest.disk.phase))
    return wb.document.ReportTable(
        "margins", "Margins at the torque, for the loops of the table before.", columns, tuple(rows)
    )
