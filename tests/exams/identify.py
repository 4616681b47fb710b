"""The exam of identification: fits, logs, filters and loops, each kind of case a part of its own.

The solver of a kind is the function `solve` of the file `identify_KIND.py`; a kind without such a file is not sat.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from .graders import Grader, Loaded

Solve = Callable[[dict[str, Any]], dict[str, Any]]
Part = Callable[[Loaded], tuple[bool | None, str]]

# The kinds with the kinds of the cases that the grader asks for in them.
KINDS = {
    **{kind: (kind,) for kind in ("clean", "noisy", "models", "logs", "filters", "loops")},
    "coverage": ("noisy", "loops"),
    "nees": ("filters",),
}
HALVES = ("visible", "held")


def solvers() -> dict[str, Solve]:
    """The solver of each kind of case that has one."""
    kinds = {kind for asked in KINDS.values() for kind in asked}
    there = (kind for kind in sorted(kinds) if find_spec(f"{__package__}.identify_{kind}"))
    return {kind: import_module(f".identify_{kind}", __package__).solve for kind in there}


def parts() -> Iterator[tuple[str, Part]]:
    """Each kind with the function that sits its cases; for a kind without a solver it says that it is not sat."""
    known = solvers()
    for kind, needed in KINDS.items():

        def part(exam: Loaded, kind: str = kind, needed: tuple[str, ...] = needed) -> tuple[bool | None, str]:
            cases = _cases(exam, kind)
            if not cases or not set(needed) <= known.keys():
                return None, f"not sat, it has no {'cases' if cases == {} else 'solver'} here"
            lines, passed, score = exam.module.grade_fits(lambda case: known[case["kind"]](case), cases)
            missed = "; ".join(line for line in lines if "MISSED" in line)
            return bool(passed), f"{score[kind]} right" + (f"; {missed}" if missed else "")

        yield kind, part


def _cases(exam: Loaded, kind: str) -> dict[str, Any]:
    """The cases of a kind beside the grader: those that are shown, and those that are kept aside if they are there."""
    folder, cases = Path(str(exam.module.__file__)).parent, {}
    for half in HALVES:
        if (folder / f"{half}.json").exists():
            loaded = exam.module.load_fits(str(folder), half)
            cases |= {f"{half} {name}": pair for name, pair in loaded.items() if pair[0]["kind"] == kind}
    return cases


def asked(grader: Grader) -> bool:
    """Whether a grader asks for fits."""
    return "grade_fits" in grader.functions
