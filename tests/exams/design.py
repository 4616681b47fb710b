"""The exam of linear design: margins, norms, zeros and sampled loops, each kind of case a part of its own."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from workbench.design.frequency import CertifiedValue, Crossover, stability_margins

from .graders import Grader, Loaded

Solve = Callable[[dict[str, Any]], dict[str, Any]]
Part = Callable[[Loaded], tuple[bool | None, str]]

# The kinds that have a solver in a file of their own, by the name of that file.
ELSEWHERE = {
    **dict.fromkeys(("norms", "zeros"), "design_norms"),
    **{kind: f"design_{kind}" for kind in ("sampled", "synthesis", "mu", "pid", "reduction")},
}
KINDS = ("margins", "norms", "zeros", "sampled", "synthesis", "mu", "pid", "reduction")
FILES = ("visible.json", "held.json")


def margins(case: dict[str, Any]) -> dict[str, Any]:
    """All margins of one loop; those without a meaning for an unstable one are left out."""
    import control

    loop = control.tf(case["num"], case["den"], case["dt"] or 0)
    found = stability_margins(loop, case["delay"], case.get("band"))
    answer: dict[str, Any] = {"stable": found.stable}
    answer["gain_crossovers"], answer["phase_margins"] = _columns(found.gain_crossovers)
    answer["phase_crossovers"], answer["gain_margins"] = _columns(found.phase_crossovers)
    if (inside := found.margins) is not None:
        for name in ("gain_low", "gain_high", "phase_margin", "delay_margin", "disk_margin"):
            answer[name] = _number(getattr(inside, name))
        for name, peak in (("Ms", inside.Ms), ("Mt", inside.Mt)):
            answer |= {name: _number(peak.gain), f"w{name}": "inf" if math.isinf(peak.frequency) else peak.frequency}
    return answer


def _number(value: CertifiedValue) -> float | str:
    return "inf" if math.isinf(value.value) else value.value


def _columns(crossovers: tuple[Crossover, ...]) -> tuple[list[float | str], list[float | str]]:
    return [_number(row.frequency) for row in crossovers], [_number(row.margin) for row in crossovers]


def solvers() -> dict[str, Solve]:
    """The solver of each kind that has one."""
    known: dict[str, Solve] = {"margins": margins}
    for kind, file in ELSEWHERE.items():
        if find_spec(f"{__package__}.{file}"):
            known[kind] = import_module(f".{file}", __package__).solve
    return known


def parts() -> Iterator[tuple[str, Part]]:
    """Each kind with the function that sits its cases; for a kind without a solver it says that it is not sat."""
    known = solvers()
    for kind in KINDS:

        def part(exam: Loaded, kind: str = kind) -> tuple[bool | None, str]:
            cases = [case for case in _cases(exam) if case["kind"] == kind]
            if kind not in known or not cases:
                return None, f"not sat, it has no {'cases' if kind in known else 'solver'} here"
            return _figure(exam.module.grade_designs(known[kind], cases), len(cases))

        yield kind, part


def _cases(exam: Loaded) -> list[dict[str, Any]]:
    """All cases beside the grader: those that are shown, and those that are kept aside where they are there."""
    folder = Path(str(exam.module.__file__)).parent
    return [case for name in FILES if (folder / name).exists() for case in exam.module.load_designs(folder / name)]


def _figure(report: dict[str, Any], count: int) -> tuple[bool, str]:
    outcomes: dict[str, int] = {}
    for part in report["counts"].values():
        for outcome, times in part.items():
            outcomes[outcome] = outcomes.get(outcome, 0) + times
    right = outcomes.pop("right", 0)
    others = "".join(f", {times} {outcome}" for outcome, times in sorted(outcomes.items()))
    missed = "; ".join(line for line in report["lines"] if ": right" not in line)
    return bool(report["passed"]), f"{right} of {count} right{others}" + (f"; {missed}" if missed else "")


def asked(grader: Grader) -> bool:
    """Whether a grader asks for designs."""
    return "grade_designs" in grader.functions
