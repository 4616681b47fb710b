"""The exam of identification: each kind of case a part of its own, and each solver a file of its own."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from .graders import Grader, Loaded

Solve = Callable[[dict[str, Any]], dict[str, Any]]
Part = Callable[[Loaded], tuple[bool | None, str]]

# The file of the solver of each kind; a kind whose file is not there is not sat.
FILES = {
    **dict.fromkeys(("clean", "noisy", "coverage", "models"), "identify_fits"),
    **dict.fromkeys(("filters", "nees"), "identify_filters"),
    **{kind: f"identify_{kind}" for kind in ("logs", "loops")},
}
HALVES = ("visible", "held")


def solvers() -> dict[str, Solve]:
    """The solver of each kind that has one."""
    return {
        kind: import_module(f".{file}", __package__).solve
        for kind, file in FILES.items()
        if find_spec(f"{__package__}.{file}")
    }


def parts() -> Iterator[tuple[str, Part]]:
    """Each kind with the function that sits its cases; for a kind without a solver it says that it is not sat."""
    known = solvers()
    for kind in FILES:

        def part(exam: Loaded, kind: str = kind) -> tuple[bool | None, str]:
            if kind not in known:
                return None, "not sat, it has no solver here"
            lines = [line for half in _halves(exam) for line in _graded(exam, kind, known[kind], half)]
            missed = [line for line in lines if ": MISSED" in line]
            return not missed, "; ".join([f"{len(lines) - len(missed)} of {len(lines)} passed", *missed])

        yield kind, part


def _halves(exam: Loaded) -> list[str]:
    folder = Path(str(exam.module.__file__)).parent
    return [half for half in HALVES if (folder / f"{half}.json").exists()]


def _graded(exam: Loaded, kind: str, solve: Solve, half: str) -> list[str]:
    folder = Path(str(exam.module.__file__)).parent
    lines, _, _ = exam.module.grade_fits(solve, exam.module.load_fits(str(folder), half), kinds=[kind])
    return list(lines)


def asked(grader: Grader) -> bool:
    """Whether a grader asks for fits."""
    return "grade_fits" in grader.functions
