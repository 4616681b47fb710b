"""How long does it take to derive an arm, how many operations are its equations, and are they right?

Runs in about two minutes on two cores. It measures time: the page is not the same twice.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Literal

import numpy as np

from studies.b0_robots.measurements import LINKS, PATIENCE, Chain, Robot, chain, robot
from workbench.robots import CATALOGUE
from workbench.study.document.document import Cell, Column, Figure, Panel, Paragraph, Section, Series, Strong, Table
from workbench.study.processor import machine
from workbench.study.study import Results, Study

METHODS = {"kane": "Kane", "lagrange": "Lagrange"}
LOOKS: tuple[Literal["line", "marks"], ...] = ("line", "marks")
SEVEN_JOINTS, LONGEST, FASTER = "panda", 0.3, 50.0


@cache
def robots() -> tuple[Robot, ...]:
    """The catalogue, measured once."""
    return tuple(robot(name) for name in CATALOGUE)


@cache
def chains() -> tuple[Chain, ...]:
    """Planar chains, measured once."""
    return tuple(map(chain, LINKS))


def sections(results: Results) -> Sequence[Section]:
    """What the report says."""
    del results
    return (
        Section("The bars", (Paragraph(where()), bars())),
        Section("The catalogue", (counts(), oracles(), Paragraph(errors()))),
        Section("Beside SymPy", (peers(), times(), Paragraph(fairness()))),
    )


def where() -> str:
    """The processor, the versions, and what the page cannot promise."""
    about = machine()
    versions = ", ".join(f"{name} {about[name]}" for name in ("python", "casadi", "numpy"))
    return (
        f"Measured on {about['cpu']} with {versions}. These are times: another run of this study gives other digits, "
        "and another machine other numbers."
    )


def bars() -> Table:
    """What was asked, and what was measured."""
    columns = (Column("what"), Column("measured", digits=3), Column("bar"), Column("verdict"))
    derivatives, beside = (Strong("MISSED") if verdict == "missed" else verdict for verdict in reached())
    rows = (
        ("7 joints (panda) with all derivatives, in s", seven().differentiated, f"at most {LONGEST:g}", derivatives),
        ("6 links, M, C and G: times as fast as SymPy", chains()[-1].ratio, f"at least {FASTER:g}", beside),
    )
    return Table("bars", "What was asked of the derivation, and what was measured.", columns, rows)


def seven() -> Robot:
    """The arm of seven joints."""
    return next(found for found in robots() if found.name == SEVEN_JOINTS)


def reached() -> tuple[str, str]:
    """Whether each bar is reached."""
    faster = chains()[-1].ratio
    second = "not measured" if faster is None else "reached" if faster >= FASTER else "missed"
    return "reached" if seven().differentiated <= LONGEST else "missed", second


def counts() -> Table:
    """Operations of the equations."""
    heads = ("M", "C", "G", "M, C, G", "in numbers", "torque")
    columns = (Column("robot"), Column("joints"), Column("letters"), *(Column(head) for head in heads))
    rows: tuple[tuple[Cell, ...], ...] = tuple((r.name, r.joints, r.letters, *r.operations) for r in robots())
    notes = (
        "M, C, G: all three together; in numbers: the same with the arm's numbers in place of letters; torque: inverse "
        "dynamics, which the spatial arms have by recursion.",
    )
    return Table("operations", "Additions, products, sines and so on, equal ones once.", columns, rows, notes)


def oracles() -> Table:
    """Times and errors."""
    columns = (
        Column("robot"),
        Column("made", unit="ms", digits=2),
        Column("derived", unit="ms", digits=3),
        Column("with derivatives", unit="ms", digits=3),
        Column("error by energies", digits=2),
        Column("error by MuJoCo", digits=2),
    )
    rows = tuple(
        (r.name, 1e3 * r.made, 1e3 * r.derived, 1e3 * r.differentiated, r.by_energies, r.by_mujoco) for r in robots()
    )
    notes = (
        "made: the arm with its checks, which for spatial arms hold two derivations against each other; derived: M, C, "
        "G and the torque over letters, and the function of M, C and G; with derivatives: and inverse and forward "
        "dynamics with their five first derivatives; a dash: not installed here.",
    )
    return Table("oracles", "Seconds of a core to each arm, and its largest errors.", columns, rows, notes)


def errors() -> str:
    """What an error of that size is."""
    worst = max(r.by_energies for r in robots())
    return (
        f"The largest error against the energies is {worst:.1g}, of the size of rounding. MuJoCo asks for positive "
        "moments of inertia: those of point masses are raised there to 2e-15 kg m\N{SUPERSCRIPT TWO}, which shows in "
        "the paper's arm."
    )


def peers() -> Table:
    """SymPy beside us."""
    columns = (
        Column("links"),
        Column("ours: M, C, G", unit="s", digits=3),
        *(Column(f"{name}: M, C qd + G", unit="s", digits=3) for name in METHODS.values()),
        *(Column(f"{name}: M, C, G", unit="s", digits=3) for name in METHODS.values()),
        Column("times as fast", digits=3),
        Column("difference", digits=2),
    )
    rows = []
    for row in chains():
        answers = [row.sympy[method] for method in METHODS]
        known = [answer.error for answer in answers if answer is not None]
        bias = (None if answer is None else answer.bias for answer in answers)
        whole = (None if answer is None else answer.matrices for answer in answers)
        rows.append((row.links, row.ours, *bias, *whole, row.ratio, max(known, default=None)))
    note = f"A dash: SymPy is not installed, or had no answer in {PATIENCE:g} s. The factor is to the faster method."
    return Table("sympy", "Seconds of a core to the equations of a planar chain.", columns, tuple(rows), (note,))


def times() -> Figure:
    """The seconds over the links."""
    curves = {"workbench": [(row.links, row.ours) for row in chains()]}
    for method, name in METHODS.items():
        answers = ((row.links, row.sympy[method]) for row in chains())
        curves[f"SymPy, {name}"] = [(links, answer.matrices) for links, answer in answers if answer is not None]
    series = []
    for style, (label, points) in enumerate(curves.items()):
        if points:
            x, y = np.array(points, dtype=float).T
            series += [Series(label, x, y, style=style, look=look) for look in LOOKS]
    panel = Panel("time to M, C and G [s]", tuple(series), xlabel="links", yscale="log")
    return Figure("chains", "Seconds of a core to M, C and G of a planar chain, over its links.", (panel,))


def fairness() -> str:
    """What each side has to do."""
    longest = chains()[-1]
    bias = min((answer.bias for answer in longest.sympy.values() if answer is not None), default=None)
    less = (
        ""
        if bias is None
        else f" M and the bias alone, less than we give, take it {bias / longest.ours:.0f} times as long."
    )
    return (
        "Ours is counted up to a function that can be called with any numbers, SymPy's up to expressions: to "
        "simplify or compile them would come on top. Its methods give M and the whole bias; for the matrix C the "
        "Christoffel symbols are formed from its M with each derivative taken once, and for G its potential energies "
        f"are differentiated.{less} Importing is not counted on either side. Our rods have "
        "one number more, the offset of the centre of mass. The last column compares the numbers of both at one state."
    )


def headlines(results: Results) -> Sequence[str]:
    """The bars, and the largest errors."""
    del results
    faster = chains()[-1].ratio
    beside = "SymPy is not installed" if faster is None else f"{faster:.0f} times as fast as SymPy on six links"
    known = [r.by_mujoco for r in robots() if r.by_mujoco is not None]
    engine = f", against MuJoCo {max(known):.1g}" if known else ""
    derivatives, peers = reached()
    return (
        f"Seven joints with all derivatives: {seven().differentiated:.2f} s ({derivatives}); {beside} ({peers}).",
        f"Largest error: against the energies {max(r.by_energies for r in robots()):.1g}{engine}.",
    )


study = Study(
    name="b0_robots",
    title="The catalogue of arms: what deriving them costs, and how right they are",
    question=(
        "What does the derivation of each arm of the catalogue cost in time and in operations, how much faster is "
        "it than sympy.physics.mechanics on planar chains, and how far are the equations from independent roads?"
    ),
    method=(
        "Every arm is derived with a letter for each of its numbers, up to functions that can be called; times are "
        "seconds of one core, medians of five. Equal operations are counted once. Errors are the largest over 50 "
        "random states, relative to the largest term: against Lagrange's equation of the energies, and against "
        "MuJoCo. SymPy derives the same chains in a process of its own, once, by Kane's and by Lagrange's method."
    ),
    sections=sections,
    headlines=headlines,
    measures_time=True,
)
