"""A study compiled: its works, tunings, sweeps and cases, as an order and the ledger of an earlier run ask for it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from workbench.engine.arithmetic import signature
from workbench.study import study_cost
from workbench.study.case_runs import CaseRuns, CompiledCase, compile_cases
from workbench.study.chosen_steps import ChosenSteps, kept_in
from workbench.study.compiled_sweep import CompiledSweep, compile_sweep
from workbench.study.ledger.ownership import LedgerError
from workbench.study.ledger.store import Ledger, about_in, steps_in
from workbench.study.ledger.study_record import StudyRecord
from workbench.study.run_and_sweep import Sweep, count_of, resize
from workbench.study.run_options import ArithmeticOf, StudyOptions
from workbench.study.study import Study
from workbench.study.study_part import AbstractPart, Description, RunContext
from workbench.study.study_results import Results
from workbench.study.study_works import compile_works
from workbench.study.sweep_runs import SweepRuns
from workbench.study.tuning.search import compile_tuning
from workbench.study.tuning_runs import TuningRuns
from workbench.study.user_values import UserValue
from workbench.study.work_runs import LaterWorkRuns, WorkRuns

MAX_NAMES = 3  # sweeps that a message names

Sweeps = tuple[Sweep, ...] | Callable[..., tuple[Sweep, ...]]


@dataclass(frozen=True, eq=False)
class CompiledStudy:
    """A study in an order, with all of its parts that are known so far compiled."""

    study: Study
    out: Path
    order: StudyOptions
    arithmetics: tuple[ArithmeticOf, str | None]  # of sweeps by their names, and of cases, as an earlier run had them
    steps: ChosenSteps
    works: WorkRuns
    tunings: TuningRuns
    sweeps: SweepRuns
    cases: CaseRuns

    @staticmethod
    def of(study: Study, out: Path, order: StudyOptions) -> CompiledStudy:
        """The study with what does not follow from results."""
        arithmetics = of_sweep, of_cases = arithmetics_of(out, order), arithmetic_of_cases(out, order)
        steps = ChosenSteps(() if order.fresh else steps_in(out))
        with kept_in(steps):
            tunings = TuningRuns(tuple(compile_tuning(tuning, of_sweep) for tuning in study.tunings))
            sweeps = compiled_sweeps(study.name, study.sweeps, order, of_sweep)
            cases = CaseRuns(compiled_cases(study, of_cases))
        works = WorkRuns(() if callable(study.works) else compile_works(study.works))
        runs = SweepRuns(sweeps, tunings.sweeps, steps, callable(study.sweeps))
        return CompiledStudy(study, out, order, arithmetics, steps, works, tunings, runs, cases)

    @property
    def first_parts(self) -> tuple[AbstractPart, ...]:
        """The parts from whose results sweeps and cases may follow."""
        return self.works, self.tunings

    @property
    def last_parts(self) -> tuple[AbstractPart, ...]:
        """The parts that may follow from results."""
        return self.sweeps, self.cases, LaterWorkRuns(self.study)

    def afford(self) -> None:
        """Refuse what takes too much time, memory or disk."""
        sweeps = (*self.tunings.sweeps, *self.sweeps.sweeps, *(one.sweep for one in self.cases.cases))
        study_cost.afford(sweeps, self.works.works, self.out, self.order)

    @property
    def remarks(self) -> tuple[str, ...]:
        """The sentences on what is slow here."""
        return tuple(study_cost.slow([*self.tunings.sweeps, *self.sweeps.sweeps]))

    def complete(self, ledger: Ledger) -> tuple[Study, Results]:
        """The study with its cases and sweeps known, and the results of all parts, of which the ledger has records."""
        about = StudyRecord.of(self.study.name, self.order.script, ledger.out, self.order.samples)
        description, results = Description(ledger, about), Results()
        site = RunContext(ledger, self.order, description)
        description.update(*(part.share for part in (*self.first_parts, *self.last_parts)))
        for part in self.first_parts:
            results = part.complete(site, results)
        plan = self.resolve({**{one.name: one for one in results.tunings}, **results.works}, ledger)
        description.update(*(part.share for part in plan.last_parts))
        for part in plan.last_parts:
            results = part.complete(site, results)
        return plan.study, results

    def resolve(self, answers: Mapping[str, UserValue], ledger: Ledger) -> CompiledStudy:
        """The study with the sweeps and cases that follow from tunings and works; their chosen steps are recorded."""
        study, (of_sweep, of_cases) = self.study.resolve(answers), self.arithmetics
        if not (callable(self.study.sweeps) or callable(self.study.cases)):
            return replace(self, study=study)
        sweeps, cases = self.sweeps, self.cases
        with kept_in(self.steps):
            if callable(self.study.cases):
                cases = CaseRuns(compiled_cases(study, of_cases))
            if callable(self.study.sweeps):
                sweeps = replace(sweeps, sweeps=compiled_sweeps(study.name, study.sweeps, self.order, of_sweep))
        ledger.add(self.steps.chunks.values())
        made = replace(self, study=study, sweeps=sweeps, cases=cases)
        runs = (*sweeps.sweeps, *(one.sweep for one in cases.cases))
        study_cost.afford(runs, self.works.works, self.out, self.order)
        return made


def arithmetics_of(out: Path, order: StudyOptions) -> ArithmeticOf:
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


def compiled_sweeps(
    name: str, sweeps: Sweeps, order: StudyOptions, arithmetic_of: ArithmeticOf
) -> tuple[CompiledSweep, ...]:
    """The sweeps of a study that are known, compiled, with as many samples as are asked for."""
    if callable(sweeps):
        return ()
    fixed = [one.name for one in sweeps if count_of(one) is None]
    if order.samples is not None and fixed:
        names = ", ".join(f"'{name}'" for name in fixed[:MAX_NAMES]) + (
            f" and {len(fixed) - MAX_NAMES} more" * (len(fixed) > MAX_NAMES)
        )
        if len(fixed) == len(sweeps):
            raise ValueError(
                f"`--samples` cannot change the study '{name}': the designs of its sweeps, {names}, have no "
                "number of samples; leave it out."
            )
        order.say(f"`--samples` changes nothing of {names}: their designs have no number of samples.")
    return compile_sweeps(sweeps, order.samples, arithmetic_of)


def arithmetic_of_cases(out: Path, order: StudyOptions) -> str | None:
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
    return tuple(compile_sweep(resize(one, samples), arithmetic_of(one.name)) for one in sweeps)
