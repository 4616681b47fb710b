"""The exam of planning: each kind of case a part of its own, and each solver a file of its own."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from .graders import Grader, Loaded

Part = Callable[[Loaded], tuple[bool | None, str]]

KINDS = ("plan", "conflict", "mpc", "loop", "offset")
HALVES = ("visible", "held")


def solve(case: dict[str, Any]) -> Any:
    """The answer to a case of any kind that has a solver."""
    return import_module(f".planning_{case['kind']}", __package__).solve(case)


def parts() -> Iterator[tuple[str, Part]]:
    """Each kind with the function that sits its cases; for a kind without a solver it says that it is not sat."""
    for kind in KINDS:

        def part(exam: Loaded, kind: str = kind) -> tuple[bool | None, str]:
            if not find_spec(f"{__package__}.planning_{kind}"):
                return None, "not sat, it has no solver here"
            lines = [line for half in _halves(exam) for line in _graded(exam, kind, half)]
            missed = [line for line in lines if ": MISSED" in line]
            return not missed, "; ".join([f"{len(lines) - len(missed)} of {len(lines)} passed", *missed])

        yield kind, part


def _halves(exam: Loaded) -> list[str]:
    folder = Path(str(exam.module.__file__)).parent
    return [half for half in HALVES if (folder / f"{half}.json").exists()]


def _graded(exam: Loaded, kind: str, half: str) -> list[str]:
    folder = Path(str(exam.module.__file__)).parent
    lines, _, _ = exam.module.grade_plans(solve, exam.module.load_plans(str(folder), half), kinds=[kind])
    return list(lines)


def asked(grader: Grader) -> bool:
    """Whether a grader asks for plans."""
    return "grade_plans" in grader.functions
