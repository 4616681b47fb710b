"""The arm by itself: where it rests, how it moves there, and how well others linearise it."""

from functools import cache
from typing import Any

import numpy as np

from studies.paper.laws import ARM
from workbench.core import Ode
from workbench.design.linear import (
    Equilibria,
    LyapunovExponents,
    controllability,
    equilibria,
    forward_differences,
    linearize,
    lyapunov_exponents,
    observability,
    poles,
)
from workbench.loop import open_loop
from workbench.plants import Manipulator
from workbench.study.document.document import Cell, Column, Paragraph, Section, Table
from workbench.validation.refusals import Array

NAMES = {
    (0.0, 0.0): "hanging",
    (0.0, np.pi): "folded down",
    (np.pi, 0.0): "upright",
    (np.pi, np.pi): "folded up",
}
SEED = 1
BOX = {"q": (-1.0, 4.0), "qd": (-5.0, 5.0)}
STEPS = 10.0 ** -np.arange(2.0, 9.0, 0.5)


@cache
def arm() -> Ode:
    """The paper's arm, driven by its torque, from the state of FS."""
    return open_loop(Manipulator(ARM, q=np.array([np.pi, -np.pi]) + 0.1))


@cache
def rests() -> Equilibria:
    """Its rest points without torque."""
    return equilibria(arm(), BOX, seed=SEED)


@cache
def falling() -> LyapunovExponents:
    """The Lyapunov exponents of the arm as it falls from near the state at which FS begins."""
    return lyapunov_exponents(arm(), until=60.0, h=0.01, skip=20.0)


@cache
def deviations() -> dict[str, float]:
    """How far other ways to A and B are from ours, over 20 random states: relative to the largest entry, the worst."""
    rng, ode = np.random.default_rng(SEED), arm()
    worst = {"python-control's linearize": 0.0, "central differences, the best step": 0.0}
    for _ in range(20):
        x, u = rng.uniform(-2, 2, 4), rng.uniform(-5, 5, 2)
        G = linearize(ode, 0.0, x, u=u)
        ours = np.hstack([G.A, G.B])
        theirs = forward_differences(ode, 0.0, x, u=u)
        central = [_central(ode, x, u, h) for h in STEPS]
        found = (np.hstack([theirs.A, theirs.B]), min(central, key=lambda J: float(np.abs(J - ours).max())))
        for name, matrix in zip(worst, found, strict=True):
            worst[name] = max(worst[name], float(np.abs(matrix - ours).max() / np.abs(ours).max()))
    return worst


def _central(ode: Ode, x: Array, u: Array, h: float) -> Array:
    """[A, B] by central differences of step h."""
    z = np.concatenate([x, u])

    def rate(at: Array) -> Array:
        return ode.rate_at(0.0, at[:4], ode.parameters.pack({"tau": at[4:]})[0])

    return np.transpose([(rate(z + d) - rate(z - d)) / (2 * h) for d in h * np.eye(len(z))])


def arm_section() -> Section:
    """Rest points and the accuracy of linear models."""
    exponents = falling()
    top = float(exponents.values[0])
    return Section(
        "The arm by itself",
        (
            Paragraph(f"Without torque, for -1 to 4 rad in both joints: {rests()}. {_within()}"),
            _table(),
            Paragraph(
                f"Falling freely from near the state at which FS begins, its largest Lyapunov exponent over "
                f"{exponents.span:g} s is {top:.2f} 1/s, with an estimated error of {exponents.error[0]:.2f} 1/s"
                f"{': two nearby falls part' if top > exponents.error[0] else ', so its sign is open'}. "
                "Volumes in phase space are kept, in coordinates of momentum: the four exponents sum to "
                f"{exponents.values.sum():.1g} 1/s."
            ),
            _accuracy(),
        ),
    )


def _within() -> str:
    """How near to the true rest points they are proved to be, as a power of ten."""
    radii = [point.radius for point in rests().points]
    known = [radius for radius in radii if radius is not None]
    if len(known) < len(radii):
        return "Not each of them is proved to exist."
    return f"Each is proved to lie within 1e{int(np.ceil(np.log10(max(known))))} rad of where it is said to be."


def _table() -> Table:
    columns = (
        Column("rest point"),
        Column("q1", "rad", digits=4),
        Column("q2", "rad", digits=4),
        Column("poles", "1/s"),
        Column("controllable by", digits=2),
        Column("observable by, q and qd", digits=2),
        Column("observable by, q alone", digits=2),
    )
    rows: list[tuple[Cell, ...]] = []
    for point in rests().points:
        G = linearize(arm(), 0.0, point.x, at_rest=True)
        name = next(words for pose, words in NAMES.items() if np.allclose(pose, point.x[:2], atol=1e-6))
        seen = sorted({shown(pole.value) for pole in poles(G)})
        angles = (float(np.round(angle, 12)) + 0.0 for angle in point.x[:2])
        rows.append((name, *angles, ", ".join(seen), controllability(G).margin, *observed(G)))
    note = (
        "Controllable and observable by: the margin of the test of Popov, Belevitch and Hautus, which is the least "
        "singular value of [z I - A, B] or [z I - A; C] for z near an eigenvalue of A, as a share of the norm of "
        "[A, B] or [A; C], in rad, s and N m; below 1e-9 a mode would count as lost. The outputs are positions and "
        "velocities, or positions alone, which are all that observer (10) is given.",
    )
    return Table(
        "rest_points", "The rest points of the arm without torque, and their modes.", columns, tuple(rows), note
    )


def observed(G: Any) -> tuple[float, float]:
    """The margins of observability of the arm's linear model by positions and velocities, and by positions alone."""
    positions = [i for i, label in enumerate(G.output_labels) if label.startswith("q[")]
    return observability(G).margin, observability(G[positions, :]).margin


def _accuracy() -> Table:
    columns = (Column("A and B by"), Column("largest deviation", digits=1, align="right"))
    rows: tuple[tuple[Cell, ...], ...] = tuple(deviations().items())
    note = (
        "Relative to the largest entry, the worst of 20 random states. Ours meet the reference derivatives of the "
        "exam of dynamics within 1e-12; a test holds that.",
    )
    return Table("accuracy", "How far others are from the exact Jacobians of the same arm.", columns, rows, note)


def shown(value: complex) -> str:
    """A pole as it is printed; of a pair both."""
    if abs(value.imag) <= 1e-9 * abs(value):
        return _number(value.real)
    real = "0" if abs(value.real) <= 1e-9 * abs(value) else _number(value.real)
    return f"{real} \N{PLUS-MINUS SIGN} {_number(abs(value.imag))}i"


def _number(value: float) -> str:
    return (f"{value:.0f}" if abs(value) >= 100 else f"{value:.3g}").replace("-", "\N{MINUS SIGN}")
