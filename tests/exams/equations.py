"""The exam of printed equations: each case read as text and as LaTeX, and held against a model derived here.

A robot of the exam is derived here if it is a chain of point masses or of rods, a cart with a pole, or a
turning slide (as `convention` says), and is proved to be the exam's; else the exam's own truth is read.
"""

from __future__ import annotations

import functools
import json
from collections.abc import Callable, Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from workbench.arms.dynamics import Dynamics
from workbench.arms.identity_proofs import judge_zero
from workbench.arms.mechanics import Link, PlanarArm, lagrange
from workbench.arms.mechanics.planar_arm import PointMass
from workbench.arms.paper_equations.entry_comparison import compare_sheet, entry_verdicts
from workbench.arms.paper_equations.entry_diagnosis import first_wrong
from workbench.arms.paper_equations.printed_equations import Sheet, read_sheet
from workbench.arms.paper_equations.statements import statements
from workbench.core import Entry, Layout

from .graders import Grader, Loaded

Case = Mapping[str, Any]
LANGUAGES = ("text", "latex")
CASES = "cases.json"


def asked(grader: Grader) -> bool:
    """Whether a grader asks for printed equations: it has one function, and its cases lie beside it."""
    return "grade" in grader.functions and (grader.file.parent / CASES).is_file()


class Candidate:
    """The workbench, as the grader calls it: with one case, in one of the two languages."""

    def __init__(self, exam: Loaded) -> None:
        assert exam.module.__file__ is not None
        self.exam: Case = json.loads(Path(exam.module.__file__).with_name(CASES).read_text(encoding="utf-8"))
        self.robots: dict[str, Dynamics] = {}

    def robot(self, name: str) -> Dynamics:
        """The model to judge by."""
        if name not in self.robots:
            truth = self.exam["truth"][name]
            given = _of_truth(name, truth, self.exam.get("params", {}))
            self.robots[name] = next((d for d in _derived(given) if _same(d, given)), given)
        return self.robots[name]

    @cached_property
    def derived(self) -> list[str]:
        """The names of the robots met that are derived here."""
        return [name for name, dynamics in self.robots.items() if dynamics.name != "as the exam has it"]

    def sheet(self, case: Case, language: str) -> Sheet:
        """The case as it would be typed into a file."""
        return read_sheet(_typed(case, language), self.robot(case["robot"]), "latex" if language == "latex" else "text")

    def check(self, case: Case, language: str) -> dict[str, str | None]:
        """The answer that the grader asks for."""
        return answer(self.sheet(case, language), self.robot(case["robot"]))

    def readings_agree(self, case: Case) -> bool:
        """Whether text and LaTeX are proved to be the same entries."""
        robot = self.robot(case["robot"])
        one, other = (compare_sheet(self.sheet(case, language), robot) for language in LANGUAGES)
        pairs = zip(one, other, strict=True)
        return all(_equal(a.printed_entry, b.printed_entry, robot) for a, b in pairs)


def answer(sheet: Sheet, robot: Dynamics) -> dict[str, str | None]:
    """Match, mismatch with the entry, or another factorisation of the same torques."""
    verdicts = compare_sheet(sheet, robot)
    if all(verdict.kind != "differs" for verdict in verdicts):
        return {"verdict": "match", "where": None}
    first = first_wrong(sheet, verdicts, robot)
    if first is None:
        return {"verdict": "match_dynamics_only", "where": None}
    return {"verdict": "mismatch", "where": f"{first.matrix}[{first.row},{first.column}]"}


def parts() -> Iterator[tuple[str, Callable[[Loaded], tuple[bool, str]]]]:
    """The exam in each language, and whether the two readings of every case agree."""
    for language in LANGUAGES:
        yield language, lambda exam, language=language: _graded(exam, language)
    yield "both readings", _agreeing


def _graded(exam: Loaded, language: str) -> tuple[bool, str]:
    candidate = Candidate(exam)
    report = exam.module.grade(lambda case: candidate.check(case, language), verbose=True)
    total = report["total"]
    figure = (
        f"{len(report['missed'])} missed, {len(report['false_alarms'])} false alarms in {total} cases, "
        f"{report['located']:.1%} located; {len(candidate.derived)} of {len(candidate.robots)} robots derived here"
    )
    return bool(report["passed"]) and total > 0, figure


def _agreeing(exam: Loaded) -> tuple[bool, str]:
    candidate = Candidate(exam)
    cases = candidate.exam["cases"]
    agree = sum(candidate.readings_agree(case) for case in cases)
    return agree == len(cases) > 0, f"text and LaTeX are the same entries in {agree} of {len(cases)} cases"


def _typed(case: Case, language: str) -> str:
    if language == "latex":
        return "\n\n".join(f"\\[ {matrix} = {case['latex'][matrix]} \\]" for matrix in "MCG")
    rows = {m: ", ".join(f"[{', '.join(row)}]" for row in case[m]) for m in "MC"}
    return "\n".join([*(f"{m} = [{row}]" for m, row in rows.items()), f"G = [{', '.join(case['G'])}]"])


def _of_truth(name: str, truth: Case, numbers: Mapping[str, float]) -> Dynamics:
    """The exam's own equations as a model, its parameters those that they name."""
    n = len(truth["G"])
    joints = {f"{letter}{i + 1}" for letter in ("q", "qd", "dq", "theta", "thetad", "dtheta") for i in range(n)}
    said = _typed({"M": truth["M"], "C": truth["C"], "G": truth["G"]}, "text")
    tokens = (token for statement in statements(said, "text") for token in statement.right)
    named = {token.text for token in tokens if token.kind == "name"} | numbers.keys()
    entries = tuple(Entry(p, np.array(numbers.get(p, 1.0)), symbol=p) for p in sorted(named - joints - {"pi"}))
    blank = _dynamics(name, Layout(entries), n)
    verdicts = compare_sheet(read_sheet(said, blank, "text"), blank)
    values = {verdict.label: verdict.printed_entry for verdict in verdicts}
    M, C = (ca.blockcat([[values[f"{m}[{i + 1},{j + 1}]"] for j in range(n)] for i in range(n)]) for m in "MC")
    G = ca.vertcat(*(values[f"G[{i + 1}]"] for i in range(n)))
    return Dynamics("as the exam has it", blank.q, blank.qd, M, C, G, blank.p, blank.symbols)


def _dynamics(name: str, p: Layout, n: int) -> Dynamics:
    q, qd = (Layout((Entry(letter, np.zeros(n)),)).symbols() for letter in ("q", "qd"))
    return Dynamics(name, q, qd, ca.SX(n, n), ca.SX(n, n), ca.SX(n, 1), p, p.symbols())


def _derived(given: Dynamics) -> Iterator[Dynamics]:
    """The models derived here that may be meant, in the parameters of another one."""
    names = dict(zip(given.p.labels, ca.vertsplit(given.symbols), strict=True)) if given.p.size else {}
    rods = tuple(Link(1.0, 1.0, 1.0, 0.0, 1.0) for _ in range(given.dof))
    letters = {"mass": "m", "length": "l", "com": "lc", "inertia": "I"}
    for links in (rods, tuple(PointMass(1.0, 1.0) for _ in range(given.dof))):
        arm = Dynamics.of(PlanarArm(links))
        values = [names.get(_letter(label, letters), ca.SX(0)) for label in arm.p.labels]
        old, new = ca.vertcat(arm.q, arm.qd, arm.symbols), ca.vertcat(given.q, given.qd, *values)
        yield _like(given, *ca.substitute([arm.M, arm.C, arm.G], [old], [new]))
    if given.dof == 2 and {"m1", "m2", "I2", "g"} <= names.keys():
        for kinetic, potential in _slides(names):
            M = lagrange.mass_matrix(kinetic, given.q)
            C = lagrange.coriolis_matrix(functools.partial(lagrange.mass_matrix, kinetic), given.q, given.qd)
            yield _like(given, M, C, lagrange.gravity_vector(potential, given.q))


def _letter(label: str, letters: Mapping[str, str]) -> str:
    """`links[0].mass` as m1, gravity as g; a name that nothing has where the exam has no such number."""
    if label == "gravity":
        return "g"
    place, _, field = label.partition(".")
    return f"{letters.get(field, '?')}{int(place[len('links[') : -1]) + 1}"


def _slides(p: Mapping[str, ca.SX]) -> Iterator[tuple[Callable[..., ca.SX], Callable[[ca.SX], ca.SX]]]:
    """Kinetic and potential energy of the cart with a hanging pole, and of the slide on a turning arm."""
    lc2, I1 = p.get("lc2", ca.SX(0)), p.get("I1", ca.SX(0))

    def cart(q: ca.SX, qd: ca.SX) -> ca.SX:
        speed = qd[0] ** 2 + 2 * lc2 * ca.cos(q[1]) * qd[0] * qd[1] + lc2**2 * qd[1] ** 2
        return (p["m1"] * qd[0] ** 2 + p["m2"] * speed + p["I2"] * qd[1] ** 2) / 2

    def slide(q: ca.SX, qd: ca.SX) -> ca.SX:
        return ((I1 + p["I2"]) * qd[0] ** 2 + p["m2"] * (qd[1] ** 2 + q[1] ** 2 * qd[0] ** 2)) / 2

    yield cart, lambda q: -p["m2"] * p["g"] * lc2 * ca.cos(q[1])
    yield slide, lambda q: -p["m2"] * p["g"] * q[1] * ca.cos(q[0])


def _like(given: Dynamics, M: ca.SX, C: ca.SX, G: ca.SX) -> Dynamics:
    return Dynamics("derived here", given.q, given.qd, *map(ca.densify, (M, C, G)), given.p, given.symbols)


def _same(one: Dynamics, other: Dynamics) -> bool:
    """Whether two models in the same symbols are proved to be one."""
    entries = {
        (name, i + 1, j + 1): matrix[i, j]
        for name, matrix in (("M", one.M), ("C", one.C), ("G", one.G))
        for i in range(matrix.shape[0])
        for j in range(matrix.shape[1])
    }
    return all(verdict.kind == "same" for verdict in entry_verdicts(entries, other))


def _equal(a: ca.SX, b: ca.SX, robot: Dynamics) -> bool:
    return judge_zero(a - b, ca.vertcat(a, b), robot).kind == "proved"
