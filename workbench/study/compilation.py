"""A study compiled: its works, tunings, sweeps and cases, as an order and the ledger of an earlier run ask for it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from workbench.simulate.arithmetic import signature
from workbench.study import cost
from workbench.study.case_runs import CompiledCase, about_cases, compile_cases
from workbench.study.chosen_steps import ChosenSteps, kept_in
from workbench.study.compiled import CompiledSweep, compile_sweep
from workbench.study.contract import Sweep, count_of, resized
from workbench.study.ledger.about import WorkAbout
from workbench.study.ledger.ownership import LedgerError
from workbench.study.ledger.store import Ledger, about_in, steps_in
from workbench.study.order import ArithmeticOf, Order
from workbench.study.study import Study
from workbench.study.tuning.search import Search, compile_tuning
from workbench.study.work import CompiledWork, compile_works

NAMED = 3  # sweeps that a message names

Sweeps = tuple[Sweep, ...] | Callable[..., tuple[Sweep, ...]]


@dataclass(frozen=True, eq=False)
class CompiledStudy:
    """A study in an order, with all of its parts that are known so far compiled."""

    study: Study
    out: Path
    order: Order
    arithmetics: tuple[ArithmeticOf, str | None]  # of sweeps by their names, and of cases, as an earlier run had them
    steps: ChosenSteps
    works: tuple[CompiledWork, ...]
    searches: tuple[Search, ...]
    sweeps: tuple[CompiledSweep, ...]
    cases: tuple[CompiledCase, ...]

    @staticmethod
    def of(study: Study, out: Path, order: Order) -> CompiledStudy:
        """The study with what does not follow from results."""
        arithmetics = of_sweep, of_cases = arithmetics_of(out, order), arithmetic_of_cases(out, order)
        steps = ChosenSteps(() if order.fresh else steps_in(out))
        with kept_in(steps):
            searches = tuple(compile_tuning(tuning, of_sweep) for tuning in study.tunings)
            sweeps = compiled_sweeps(study.name, study.sweeps, order, of_sweep)
            cases = compiled_cases(study, of_cases)
        works = () if callable(study.works) else compile_works(study.works)
        return CompiledStudy(study, out, order, arithmetics, steps, works, searches, sweeps, cases)

    @property
    def searched(self) -> tuple[CompiledSweep, ...]:
        """The sweeps of the tunings."""
        return tuple(one for search in self.searches for one in search.sweeps)

    @property
    def about(self) -> dict[str, Any]:
        """The parts as a ledger describes them, but sweeps and tunings."""
        works = tuple(WorkAbout(one.work.name, one.names) for one in self.works)
        return {"works": works, "more": callable(self.study.works), "cases": about_cases(self.cases)}

    def afford(self, searched: bool = True) -> None:
        """Refuse what takes too much time, memory or disk."""
        sweeps = (*(self.searched if searched else ()), *self.sweeps, *(one.sweep for one in self.cases))
        afford(sweeps, self.works, self.out, self.order)

    def resolved(self, found: Mapping[str, Any], ledger: Ledger) -> CompiledStudy:
        """The study with the sweeps and cases that follow from tunings and works; their chosen steps are recorded."""
        study, later = self.study.resolved(found), callable(self.study.sweeps) or callable(self.study.cases)
        if not later:
            return replace(self, study=study)
        sweeps, cases, (of_sweep, of_cases) = self.sweeps, self.cases, self.arithmetics
        with kept_in(self.steps):
            if callable(self.study.cases):
                cases = compiled_cases(study, of_cases)
            if callable(self.study.sweeps):
                sweeps = compiled_sweeps(study.name, study.sweeps, self.order, of_sweep)
        ledger.add(self.steps.chunks.values())
        made = replace(self, study=study, sweeps=sweeps, cases=cases)
        made.afford(searched=False)
        return made


def afford(sweeps: Sequence[CompiledSweep], works: Sequence[CompiledWork], out: Path, order: Order) -> None:
    """Refuse sweeps and works that take too much time, memory or disk."""
    if not (order.yes or order.only_report):
        cost.check(cost.cost_of(sweeps, order.workers, works), out)


def arithmetics_of(out: Path, order: Order) -> ArithmeticOf:
    """The arithmetic of a sweep, by its name: the one that is asked for, or else that of its chunks in the ledger."""
    about = None if order.fresh else about_in(out)
    kept = {sweep.name: sweep.arithmetic for sweep in about.sweeps} if about else {}

    def arithmetic_of(name: str) -> str | None:
        if name not in kept:
            return order.arithmetic
        chosen = order.arithmetic or kept[name].partition(" ")[0]
        if signature(chosen) != kept[name]:
            raise LedgerError(
                f"The ledger in '{out}' holds runs of '{name}' in the arithmetic '{kept[name]}', and this run would "
                f"compute in '{signature(chosen)}': two do not mix. Take the other one by `--arithmetic` or its own "
                "version, name another folder with `--out`, or begin anew with `--fresh`."
            )
        return chosen

    return arithmetic_of


def compiled_sweeps(name: str, sweeps: Sweeps, order: Order, arithmetic_of: ArithmeticOf) -> tuple[CompiledSweep, ...]:
    """The sweeps of a study that are known, compiled, with as many samples as are asked for."""
    if callable(sweeps):
        return ()
    fixed = [one.name for one in sweeps if count_of(one) is None]
    if order.samples is not None and fixed:
        names = ", ".join(f"'{name}'" for name in fixed[:NAMED]) + (
            f" and {len(fixed) - NAMED} more" * (len(fixed) > NAMED)
        )
        if len(fixed) == len(sweeps):
            raise ValueError(
                f"`--samples` cannot change the study '{name}': the designs of its sweeps, {names}, have no "
                "number of samples; leave it out."
            )
        order.say(f"`--samples` changes nothing of {names}: their designs have no number of samples.")
    return compile_sweeps(sweeps, order.samples, arithmetic_of)


def arithmetic_of_cases(out: Path, order: Order) -> str | None:
    """The arithmetic of all cases: the one that is asked for, or else the only one of their runs in the ledger."""
    about = None if order.fresh else about_in(out)
    held = about.cases.arithmetic.split("; ") if about and about.cases else ()
    names = {one.partition(" ")[0] for one in held}
    return order.arithmetic or (names.pop() if len(names) == 1 else None)


def compiled_cases(study: Study, arithmetic: str | None) -> tuple[CompiledCase, ...]:
    """The cases of a study that are known, compiled."""
    return () if callable(study.cases) else compile_cases(study.cases, arithmetic)


def compile_sweeps(
    sweeps: Sequence[Sweep], samples: int | None, arithmetic_of: ArithmeticOf
) -> tuple[CompiledSweep, ...]:
    """Sweeps compiled, with so many samples each."""
    return tuple(compile_sweep(resized(one, samples), arithmetic_of(one.name)) for one in sweeps)
