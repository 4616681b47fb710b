"""A study: a question, the runs that answer it, and the sections of its report."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from workbench.core.equations import answer
from workbench.core.validation.refusals import seed, several, whole
from workbench.core.validation.signatures import check_arguments
from workbench.study.design_knob import DesignKnob
from workbench.study.document.document import Page, Section
from workbench.study.document.phrases_and_tables import check_name
from workbench.study.knob import Knob
from workbench.study.pid_specification import PidSpecification
from workbench.study.run_and_sweep import Sweep
from workbench.study.study_results import Case as Case
from workbench.study.study_results import Outcome as Outcome
from workbench.study.study_results import Results as Results
from workbench.study.study_works import Work
from workbench.study.tuning import Tuning
from workbench.study.user_values import UserValue

ENDS = ("", "_half")  # of the names of the two sweeps that each trial of a tuning becomes


@dataclass(frozen=True, eq=False)
@check_arguments
class Study:
    """A question, the cases, sweeps, tunings and works that answer it, and the sections of its report.

    Attributes
    ----------
    name
        Lower-case letters, digits and underscores: it becomes the report's folder.
    sections, headlines
        Functions of the `Results`. `sections` returns the sections of the report, or a `Page` with its answer and
        findings. `headlines` returns the lines that the command prints; by default these are the answer, the findings
        and the verdicts of the report.
    measures_time
        True if the report holds times, which differ from one run to the next.
    least_samples
        The least number of samples that `--samples` may set, if sweeps that need it are made from tunings.
    seed
        The seed of whatever the study samples at random; None if it samples nothing.
    tunings, sweeps
        Tunings search for numbers of loops, and come first. A sweep is many runs of one loop. The folder of the report
        then keeps a ledger of all runs.
    works
        Functions of the study, each computed once for each of its items, before everything else. Or a function that
        makes works from the results of everything else. `results.work(name)` gives the answers.
    cases, sweeps
        Tuples, or functions that make them from a mapping by name. It has the result of each tuning and the answers of
        each work.
    live
        The numbers of its cases that a reader of the page can turn; without any, the factors of its sweeps are
        offered, and with None the page stays as it is printed.

    Examples
    --------
    >>> wb.Study("mine", "A title", "A question?", "A method.", sections=lambda results: []).name
    'mine'
    """

    name: str
    title: str
    question: str
    method: str
    sections: Callable[[Results], Sequence[Section] | Page]
    headlines: Callable[[Results], Sequence[str]] = field(default=lambda results: ())
    cases: tuple[Case, ...] | Callable[[Mapping[str, UserValue]], tuple[Case, ...]] = ()
    fingerprints: Mapping[str, str] = field(default_factory=dict)
    measures_time: bool = False
    seed: int | None = None
    sweeps: tuple[Sweep, ...] | Callable[[Mapping[str, UserValue]], tuple[Sweep, ...]] = ()
    tunings: tuple[Tuning, ...] = ()
    live: tuple[Knob | DesignKnob | PidSpecification, ...] | None = ()
    works: tuple[Work, ...] | Callable[[Results], tuple[Work, ...]] = ()
    least_samples: int | None = None

    def __post_init__(self) -> None:
        check_name("Study", self.name)
        if self.seed is not None:
            seed("Study(seed=...)", self.seed)
        if self.least_samples is not None:
            whole("Study(least_samples=...)", self.least_samples)
        for part in ("cases", "sweeps", "tunings"):
            if not callable(given := getattr(self, part)):
                self._check_names(part, [one.name for one in given])
            elif not self.tunings and (callable(self.works) or not self.works):
                raise ValueError(
                    f"`Study({part}=...)` is a function of what the tunings found, and this study has none: give the "
                    f"{part} themselves."
                )
        files = [f"{one.name}_{trial.name}{end}" for one in self.tunings for trial in one.trials for end in ENDS]
        sweeps = () if callable(self.sweeps) else self.sweeps
        self._check_names("sweeps and trials", names := [*files, *(one.name for one in sweeps)])
        if not callable(self.works):
            self._check_names("sweeps, trials and works", [*names, *(one.name for one in self.works)])
        if (callable(self.cases) or self.cases) and "cases" in names:
            raise ValueError("`Study(sweeps=...)` needs another name for 'cases': the table of its cases has that one.")

    def _check_names(self, part: str, names: Sequence[str]) -> None:
        if twice := {name for name in names if names.count(name) > 1}:
            raise ValueError(f"`Study({part}=...)` needs distinct {part}; {sorted(twice)} came more than once.")

    @check_arguments
    def resolve(self, answers: Mapping[str, UserValue]) -> Study:
        """The study with the cases and sweeps that follow from its tunings and works.

        Parameters
        ----------
        answers
            By name: the `TuningResult` of each tuning, and the tuple of answers of each work that was computed first.
        """
        cases, sweeps = self.cases, self.sweeps
        if callable(cases):
            call = "Study(cases=...)(answers)"
            cases = several(call, answer(call, cases, answers), Case)
        if callable(sweeps):
            call = "Study(sweeps=...)(answers)"
            sweeps = several(call, answer(call, sweeps, answers), Sweep)
        return replace(self, cases=cases, sweeps=sweeps)

    @check_arguments
    def works_from(self, results: Results) -> tuple[Work, ...]:
        """The works, also where a function makes them from the results of cases, sweeps and tunings."""
        make = self.works
        if not callable(make):
            return make
        call = "Study(works=...)(results)"
        works: tuple[Work, ...] = several(call, answer(call, make, results), Work)
        replace(self, works=works)  # refuses a name that is taken
        return works
