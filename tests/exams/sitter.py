"""Which exams there are below a folder, which of them the workbench sits, and how each went."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from . import (
    design,
    dre,
    durability,
    equations,
    identify,
    ode,
    planar,
    planning,
    plants,
    riccati,
    rigid,
    scales,
    sensitivity,
)
from .graders import Grader, Loaded, find, loaded

# What an exam asks for, by a function that only its grader has.
PARTS = {
    **ode.PARTS,
    **riccati.PARTS,
    **scales.PARTS,
    **sensitivity.PARTS,
    **durability.PARTS,
    "grade_dre": ("dre", dre.dre),
}


@dataclass(frozen=True)
class Verdict:
    """How one exam went: passed, missed (False), or not sat (None), in a line; and what its grader printed."""

    passed: bool | None
    line: str
    printed: str = ""


def sit(folder: Path) -> Iterator[Verdict]:
    """Sit the exams below a folder one by one; folders without a grader that is known are named."""
    graders = find(folder)
    for place in sorted(path for path in folder.iterdir() if path.is_dir()):
        if not any(place in grader.file.parents for grader in graders) and not place.name.startswith((".", "__")):
            yield Verdict(None, f"unknown: {place.name} (it has no grader)")
    for grader in graders:
        yield from _sit(grader)


def _sit(grader: Grader) -> Iterator[Verdict]:
    if grader.broken:
        yield Verdict(False, f"{grader.name}: MISSED, its grader cannot be read: {grader.broken}")
        return
    parts = [(name, part) for function, (name, part) in PARTS.items() if function in grader.functions]
    known = False
    for name, part in parts:
        known = True
        yield _run(grader, name, part)
    if "grade_robot" in grader.functions:
        known = True
        yield from _dynamics(grader)
    if equations.asked(grader):
        known = True
        for name, part in equations.parts():
            yield _run(grader, name, part)
    if plants.asked(grader):
        known = True
        yield _run(grader, "plants", plants.plants)
    if design.asked(grader):
        known = True
        for name, part in design.parts():
            yield _run(grader, name, part)
    if identify.asked(grader):
        known = True
        for name, part in identify.parts():
            yield _run(grader, name, part)
    if planning.asked(grader):
        known = True
        for name, part in planning.parts():
            yield _run(grader, name, part)
    if not known:
        yield Verdict(None, f"unknown: {grader.name} (its grader asks for nothing that is known here)")


Maker = Callable[[Loaded], dict[str, rigid.Answers]]


def _dynamics(grader: Grader) -> Iterator[Verdict]:
    for name, made in (("urdf", rigid.through_urdf), ("bodies", rigid.through_bodies), ("planar", planar.planar)):

        def part(exam: Loaded, name: str = name, made: Maker = made) -> tuple[bool, str]:
            robots = made(exam)
            return rigid.grade(exam, robots) if robots else (name != "bodies", "there is no such robot")

        yield _run(grader, name, part)


def _run(grader: Grader, name: str, part: Callable[[Loaded], tuple[bool | None, str]]) -> Verdict:
    """One part of an exam, missed (False) or not sat (None); a grader or an answer that breaks is a missed bar."""
    printed = ""
    try:
        with loaded(grader) as exam:
            try:
                passed, figure = part(exam)
            finally:
                printed = exam.printed.getvalue()
    except (Exception, SystemExit) as error:  # a foreign program: whatever it raises is its answer
        return Verdict(False, f"{grader.name}/{name}: MISSED, it broke: {type(error).__name__}: {error}", printed)
    return Verdict(passed, f"{grader.name}/{name}: {'MISSED, ' if passed is False else ''}{figure}", printed)
