"""The cost of deriving an arm, in time and in operations, and the errors of its equations.

Runs in about two minutes on two cores. It measures time: the page is not the same twice.
"""

from __future__ import annotations

from functools import cache
from statistics import median

import numpy as np

import workbench as wb
from studies.b0_robots.measurements import LINKS, PATIENCE, SEED, STATES, Chain, Robot, chain, robot

METHODS = ("Kane", "Lagrange")
SEVEN_JOINTS, LONGEST, FASTER = "panda", 0.3, 50.0
ROUNDING = 1e-13  # of the largest term, some hundred operations
robots = cache(lambda: tuple(map(robot, wb.arms.mechanics.CATALOGUE)))
chains = cache(lambda: tuple(map(chain, LINKS)))


def sections(results: wb.Results) -> wb.Page:
    """The findings, the picture and SymPy, then the catalogue."""
    del results
    return wb.Page(
        answer=answer(),
        findings=findings(),
        sections=(
            wb.Section(
                "Comparison with SymPy", (times(), peers(), wb.Paragraph(fairness()), wb.Paragraph(wb.study.testbed()))
            ),
            wb.Section("The catalogue", (counts(), oracles())),
        ),
    )


def word(is_reached: bool) -> str:
    """The answer to a target."""
    return "reached" if is_reached else "missed"


def seven() -> Robot:
    """The arm of seven joints."""
    return next(one for one in robots() if one.name == SEVEN_JOINTS)


def answer() -> str:
    """The page in one line."""
    beside = times_as_fast()
    faster = f"; those of planar chains are derived {beside} times as fast as by SymPy" if beside else ""
    engine = max((one.by_mujoco for one in robots() if one.by_mujoco is not None), default=None)
    agree = "" if engine is None else f"; all {len(robots())} arms agree with MuJoCo to {engine:.0e}"
    return (
        f"On one machine, deriving the equations of a seven-joint arm with all first derivatives takes "
        f"{median(seven().differentiation_seconds):.2g} s{faster}{agree}."
    )


def ratios() -> list[tuple[Chain, float]]:
    """The chains that SymPy has derived, with the ratio of our speed to that of its faster method."""
    return [(one, one.ratio) for one in chains() if one.ratio is not None]


MACHINE = "One machine, named on this page, and one run of the whole measurement."


def findings() -> tuple[wb.Finding, ...]:
    """The largest errors, and the two targets."""
    return error_finding(), time_finding(), *sympy_findings()


def time_finding() -> wb.Finding:
    """The time to an arm of seven joints, in each repetition."""
    spent, without = seven().differentiation_seconds, median(seven().derivation_seconds)
    middle = median(spent)
    steady = middle >= without  # a time with more work in it that is the shorter one shows how much they scatter
    scatter = (
        ""
        if steady
        else f" Without derivatives the time was {without:.3g} s; times therefore scatter by more than this range."
    )
    return wb.Finding(
        name="seven_joints",
        statement=f"Deriving the equations of a seven-joint arm ({SEVEN_JOINTS}) with all first derivatives takes "
        f"{middle:.3g} s of one core; the target is at most {LONGEST:g} s.",
        evidence=f"{len(spent)} repetitions took {min(spent):.3g} to {max(spent):.3g} s.{scatter}",
        statistic="Seconds of one core from the arm to the functions of M, C, G and of inverse and forward dynamics "
        "with first derivatives; median of the repetitions.",
        sample=f"{len(spent)} repetitions, one after the other in one process.",
        information=MACHINE,
        assumptions="The target.",
        answer=word(middle <= LONGEST),
        variations=tuple(
            wb.Variation(f"repetition {i}", word(one <= LONGEST), f"{one:.3g} s")
            for i, one in enumerate(spent, start=1)
        ),
        limitations="another machine, and a machine with other load",
        is_decided=steady,
    )


def sympy_findings() -> tuple[wb.Finding, ...]:
    """The ratio to SymPy, for each chain and each of its methods; none where it is not installed."""
    first, longest = chains()[0], chains()[-1]
    if longest.ratio is None:
        return ()
    made = [
        wb.Variation(f"{one.links} links", word(one.ratio >= FASTER), f"{one.ratio:.3g} times")
        for one in chains()[:-1]
        if one.ratio is not None
    ]
    for what, spent in (("M, C and G", longest.matrices), ("M and the bias only", longest.bias)):
        for name, one in zip(METHODS, spent, strict=True):
            if one is not None:
                made.append(
                    wb.Variation(
                        f"{name}, {what}", word(one >= FASTER * longest.ours), f"{one / longest.ours:.3g} times"
                    )
                )
    return (
        wb.Finding(
            name="beside_sympy",
            statement=f"M, C and G of planar chains of {first.links} to {longest.links} links are derived "
            f"{times_as_fast()} times as fast as by the faster method of SymPy. The target is {FASTER:g} times for "
            f"{longest.links} links, where the ratio is {longest.ratio:.3g}.",
            evidence="Our time ends with a function that can be called, SymPy's time with expressions; compiling these "
            "is not counted. SymPy gives M and the whole bias. This study computes C and G from them, and the time for "
            "this counts for SymPy.",
            statistic="Ratio of seconds of one core: one run of SymPy over the median of several repetitions of ours.",
            sample=f"Planar chains of {first.links} to {longest.links} links, each once by either method of SymPy.",
            information=MACHINE,
            assumptions="The target, and the chain to which it applies.",
            answer=word(longest.ratio >= FASTER),
            variations=tuple(made),
            limitations="simplified or compiled expressions of SymPy, and spatial arms",
        ),
    )


def error_finding() -> wb.Finding:
    """The largest errors of all arms: against MuJoCo where it is installed, and against their own energies."""
    energies = max(one.by_energies for one in robots())
    by_engine = {one.name: one.by_mujoco for one in robots() if one.by_mujoco is not None}
    engine = max(by_engine.values(), default=None)
    own = f"{energies:.1g} against Lagrange's equation of the arm's energies"
    both = own if engine is None else f"{engine:.1g} against MuJoCo, and {own}"
    ends = [(f"{name}, MuJoCo", one) for name, one in by_engine.items()]
    ends += [(f"{one.name}, energies", one.by_energies) for one in robots()]
    return wb.Finding(
        name="errors_of_equations",
        statement=f"The largest error of any arm, relative to the largest term, is {both}.",
        evidence="MuJoCo shares only the numbers of the arm with this workbench; in MuJoCo a point mass has a moment "
        "of inertia of 2e-15 kg m\N{SUPERSCRIPT TWO}. M and G of a planar arm come from the same energies, so that the "
        "second error tests the algebra alone. M and the torque of a spatial arm come from a recursion.",
        statistic=f"Largest error over random states, relative to the largest term. The answer is whether it is below "
        f"{ROUNDING:g}.",
        sample=f"{len(robots())} arms, {STATES} states for each.",
        information="The same numbers of each arm.",
        assumptions="Ranges of the states.",
        answer=size(energies if engine is None else engine),
        variations=tuple(wb.Variation(words, size(one), f"{one:.1g}") for words, one in ends),
    )


def times_as_fast() -> str:
    """The ratios of our speed to that of SymPy, in words."""
    return wb.document.span([ratio for _, ratio in ratios()], "{:.3g}".format)


def size(error: float) -> str:
    """The error as rounding or as more."""
    return f"below {ROUNDING:g}" if error < ROUNDING else f"not below {ROUNDING:g}"


def counts() -> wb.document.ReportTable:
    """Operations of the equations."""
    heads = ("robot", "joints", "symbols", "M", "C", "G", "M, C, G", "with numbers", "torque")
    rows: tuple[tuple[wb.document.Cell, ...], ...] = tuple(
        (r.name, r.joints, r.letters, *r.operations) for r in robots()
    )
    notes = (
        "Symbols: the count of the arm's numbers, each of which stays a symbol. M, C, G: all three together. With "
        "numbers: M, C and G with the arm's numbers in place of symbols. Torque: inverse dynamics, which spatial arms "
        "compute by recursion.",
    )
    caption = (
        "The number of operations in the equations of each arm: additions, products, sines and others. Equal "
        "operations count once."
    )
    return wb.document.ReportTable("operations", caption, tuple(map(wb.document.TableColumn, heads)), rows, notes)


def oracles() -> wb.document.ReportTable:
    """Times and errors."""
    columns = (
        wb.document.TableColumn("robot"),
        wb.document.TableColumn("construction", unit="ms", digits=2),
        *(wb.document.TableColumn(head, unit="ms", digits=3) for head in ("equations derived", "with derivatives")),
        *(wb.document.TableColumn(head, digits=2) for head in ("error against MuJoCo", "error against energies")),
    )
    rows = tuple(
        (
            r.name,
            *(1e3 * median(one) for one in (r.making_seconds, r.derivation_seconds, r.differentiation_seconds)),
            r.by_mujoco,
            r.by_energies,
        )
        for r in robots()
    )
    notes = (
        "Construction: the arm with its checks, which for spatial arms compare two derivations. Equations derived: M, "
        "C, G and the torque as expressions of symbols, and the function of M, C and G. With derivatives: also inverse "
        "and forward dynamics with their five first derivatives. Each time is measured separately. Two times that "
        "differ by less than their scatter may therefore be in the wrong order. A dash: MuJoCo is not installed here.",
    )
    return wb.document.ReportTable(
        "oracles", "Times of one core for each arm, and the largest errors of its equations.", columns, rows, notes
    )


def peers() -> wb.document.ReportTable:
    """The times of SymPy and of the workbench."""
    times = [f"{name}: {what}" for what in ("M, C qd + G", "M, C, G") for name in METHODS]
    columns = (
        wb.document.TableColumn("links"),
        *(wb.document.TableColumn(head, unit="s", digits=3) for head in ("ours: M, C, G", *times)),
        wb.document.TableColumn("ratio of times", digits=3),
        wb.document.TableColumn("difference", digits=2),
    )
    rows = tuple((one.links, one.ours, *one.bias, *one.matrices, one.ratio, one.error) for one in chains())
    note = (
        f"A dash: SymPy is not installed, or had no answer in {PATIENCE:g} s. Ratio of times: SymPy's faster method "
        "over ours. Difference: between the numbers of both at one state, relative to the largest entry."
    )
    return wb.document.ReportTable(
        "sympy", "Seconds of one core to derive the equations of a planar chain.", columns, rows, (note,)
    )


def times() -> wb.document.Figure:
    """The seconds over the links."""
    curves: dict[str, list[float | None]] = {"workbench": [one.ours for one in chains()]}
    curves |= {f"SymPy, {name}": [one.matrices[i] for one in chains()] for i, name in enumerate(METHODS)}
    series = []
    for style, (label, spent) in enumerate(curves.items()):
        points = [(links, one) for links, one in zip(LINKS, spent, strict=True) if one is not None]
        if points:
            x, y = np.array(points, dtype=float).T
            series += [
                wb.document.Series(label, x, y, style, "line"),
                wb.document.Series(label, x, y, style, "marks"),
            ]
    panel = wb.document.Panel("time to M, C and G [s]", tuple(series), xlabel="links", yscale="log")
    return wb.document.Figure(
        "chains", "Seconds of one core to derive M, C and G of a planar chain, over its number of links.", (panel,)
    )


def fairness() -> str:
    """The work of either side."""
    longest = chains()[-1]
    bias = [one / longest.ours for one in longest.bias if one is not None]
    less = (
        f" For M and the bias alone, SymPy takes {min(bias):.0f} times as long as ours for M, C and G." if bias else ""
    )
    return (
        "Our time ends with a function that can be called with any numbers, SymPy's time with expressions; simplifying "
        "or compiling these is not counted. The methods of SymPy give M and the whole bias. The study forms the matrix "
        "C from SymPy's M by Christoffel symbols, with each derivative taken once, and G from SymPy's potential "
        f"energies by differentiation.{less} Imports are not counted on either side. Our rods have one more number, "
        "the offset of the centre of mass."
    )


study = wb.Study(
    name="b0_robots",
    title="The catalogue of arms: the time to derive them, and the errors of their equations",
    question=(
        "How much time does the derivation of each arm of the catalogue take, and how many operations do the equations "
        "have? How much faster is the derivation than sympy.physics.mechanics on planar chains? And how far are the "
        "equations from MuJoCo, and from Lagrange's equation of their energies?"
    ),
    method=(
        "Every arm is derived with a symbol for each of its numbers, up to functions that can be called. Times are "
        "seconds of one core of one machine, each the median of five. Errors are the largest over 50 random states, "
        "relative to the largest term: against MuJoCo, and against Lagrange's equation of the energies. SymPy derives "
        "the same chains once by Kane's method and once by Lagrange's method, in a separate process."
    ),
    sections=sections,
    seed=SEED,
    measures_time=True,
)
