"""The exam of identification: each kind of case a part of its own, and each solver a file of its own."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from .graders import Grader, Loaded

Part = Callable[[Loaded], tuple[bool | None, str]]

# The file of the solver of each kind of case, and the kinds of the cases of which a further part is made.
FILES = {
    **dict.fromkeys(("clean", "noisy", "models"), "identify_fits"),
    **{kind: f"identify_{kind}" for kind in ("logs", "filters", "loops")},
}
PARTS = {kind: (kind,) for kind in FILES} | {"nees": ("filters",), "coverage": ("noisy", "loops")}
HALVES = ("visible", "held")


def solve(case: dict[str, Any]) -> dict[str, Any]:
    """The answer to a case of any kind that has a solver."""
    answer: dict[str, Any] = import_module(f".{FILES[case['kind']]}", __package__).solve(case)
    return answer


def parts() -> Iterator[tuple[str, Part]]:
    """Each kind with the function that sits its cases; for a kind without a solver it says that it is not sat."""
    for name, kinds in PARTS.items():

        def part(exam: Loaded, name: str = name, kinds: tuple[str, ...] = kinds) -> tuple[bool | None, str]:
            if not all(find_spec(f"{__package__}.{FILES[kind]}") for kind in kinds):
                return None, "not sat, it has no solver here"
            lines = [line for half in _halves(exam) for line in _graded(exam, name, half)]
            missed = [line for line in lines if ": MISSED" in line]
            return not missed, "; ".join([f"{len(lines) - len(missed)} of {len(lines)} passed", *missed])

        yield name, part


def _halves(exam: Loaded) -> list[str]:
    folder = Path(str(exam.module.__file__)).parent
    return [half for half in HALVES if (folder / f"{half}.json").exists()]


def _graded(exam: Loaded, kind: str, half: str) -> list[str]:
    folder = Path(str(exam.module.__file__)).parent
    lines, _, _ = exam.module.grade_fits(solve, exam.module.load_fits(str(folder), half), kinds=[kind])
    return list(lines)


def asked(grader: Grader) -> bool:
    """Whether a grader asks for fits."""
    return "grade_fits" in grader.functions
