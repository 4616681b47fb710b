"""The cost of deriving an arm, in time and in operations, and the errors of its equations.

Runs in about two minutes on two cores. It measures time: the page is not the same twice.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np

from studies.b0_robots.measurements import LINKS, PATIENCE, chain, robot
from workbench.robots import CATALOGUE
from workbench.study.document.document import Column, Figure, Panel, Paragraph, Section, Series, Table, Verdict
from workbench.study.study import Results, Study
from workbench.study.writeup import testbed

METHODS = ("Kane", "Lagrange")
SEVEN_JOINTS, LONGEST, FASTER = "panda", 0.3, 50.0
robots = cache(lambda: tuple(map(robot, CATALOGUE)))
chains = cache(lambda: tuple(map(chain, LINKS)))


def sections(results: Results) -> Sequence[Section]:
    """The bars with their picture, the catalogue, and SymPy."""
    del results
    return (
        Section("What was found", (times(), *findings(), Paragraph(testbed()))),
        Section("The catalogue", (counts(), oracles())),
        Section("Beside SymPy", (peers(), Paragraph(fairness()))),
    )


def findings() -> tuple[Verdict, Verdict, Verdict]:
    """The two bars, and the largest errors."""
    seven = next(one for one in robots() if one.name == SEVEN_JOINTS).differentiated
    ratio = chains()[-1].ratio
    energies = max(one.by_energies for one in robots())
    engine = max((one.by_mujoco for one in robots() if one.by_mujoco is not None), default=None)
    return (
        Verdict(
            "holds" if seven <= LONGEST else "fails",
            f"Seven joints ({SEVEN_JOINTS}) with all derivatives take at most {LONGEST:g} s.",
            f"{seven:.3g} s of one core.",
        ),
        Verdict(
            "open" if ratio is None else "holds" if ratio >= FASTER else "fails",
            f"M, C and G of six links are derived at least {FASTER:g} times as fast as by SymPy.",
            "SymPy is not installed." if ratio is None else f"{ratio:.3g} times as fast as its faster method.",
        ),
        Verdict(
            "found",
            f"The largest error against the energies is {energies:.1g} of the largest term.",
            f"Against MuJoCo {engine:.1g}; a point mass has a moment of 2e-15 kg m\N{SUPERSCRIPT TWO} there."
            if engine
            else "MuJoCo is not installed.",
        ),
    )


def counts() -> Table:
    """Operations of the equations."""
    heads = ("robot", "joints", "letters", "M", "C", "G", "M, C, G", "in numbers", "torque")
    rows = tuple((r.name, r.joints, r.letters, *r.operations) for r in robots())
    notes = (
        "M, C, G: all three together; in numbers: the same with the arm's numbers in place of letters; torque: inverse "
        "dynamics, which the spatial arms have by recursion.",
    )
    caption = "Additions, products, sines and so on, equal ones once."
    return Table("operations", caption, tuple(map(Column, heads)), rows, notes)


def oracles() -> Table:
    """Times and errors."""
    columns = (
        Column("robot"),
        Column("made", unit="ms", digits=2),
        *(Column(head, unit="ms", digits=3) for head in ("derived", "with derivatives")),
        *(Column(head, digits=2) for head in ("error by energies", "error by MuJoCo")),
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


def peers() -> Table:
    """SymPy beside us."""
    times = [f"{name}: {what}" for what in ("M, C qd + G", "M, C, G") for name in METHODS]
    columns = (
        Column("links"),
        *(Column(head, unit="s", digits=3) for head in ("ours: M, C, G", *times)),
        Column("times as fast", digits=3),
        Column("difference", digits=2),
    )
    rows = tuple((one.links, one.ours, *one.bias, *one.matrices, one.ratio, one.error) for one in chains())
    note = f"A dash: SymPy is not installed, or had no answer in {PATIENCE:g} s. The factor is to the faster method."
    return Table("sympy", "Seconds of a core to the equations of a planar chain.", columns, rows, (note,))


def times() -> Figure:
    """The seconds over the links."""
    curves = {"workbench": [one.ours for one in chains()]}
    curves |= {f"SymPy, {name}": [one.matrices[i] for one in chains()] for i, name in enumerate(METHODS)}
    series = []
    for style, (label, spent) in enumerate(curves.items()):
        points = [(links, one) for links, one in zip(LINKS, spent, strict=True) if one is not None]
        if points:
            series += [Series(label, *np.array(points, dtype=float).T, style, look) for look in ("line", "marks")]
    panel = Panel("time to M, C and G [s]", tuple(series), xlabel="links", yscale="log")
    return Figure("chains", "Seconds of a core to M, C and G of a planar chain, over its links.", (panel,))


def fairness() -> str:
    """The work of either side."""
    longest = chains()[-1]
    bias = [one / longest.ours for one in longest.bias if one is not None]
    less = f" M and the bias alone, less than we give, take it {min(bias):.0f} times as long." if bias else ""
    return (
        "Ours is counted up to a function that can be called with any numbers, SymPy's up to expressions: to "
        "simplify or compile them would come on top. Its methods give M and the whole bias; for the matrix C the "
        "Christoffel symbols are formed from its M with each derivative taken once, and for G its potential energies "
        f"are differentiated.{less} Importing is not counted on either side. Our rods have "
        "one number more, the offset of the centre of mass. The last column compares the numbers of both at one state."
    )


def headlines(results: Results) -> Sequence[str]:
    """The verdicts in a line each."""
    del results
    return tuple(f"{one.kind}: {one.statement} {one.evidence}" for one in findings())


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
