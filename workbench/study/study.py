"""A study: a question, the runs that answer it, and how their results read."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from workbench.core import Ode
from workbench.core.layout import Array, nearest
from workbench.core.numbers import multiple, positive
from workbench.metrics import AbstractMetric, Measurement
from workbench.study.cells import check_name, check_text, several
from workbench.study.contract import Loop
from workbench.study.document import Section
from workbench.study.sample import Sample
from workbench.study.sweep import Sweep
from workbench.study.tuning import Tuned, Tuning

if TYPE_CHECKING:
    import pandas as pd


ENDS = ("", "_half")  # of the names of the two sweeps that each trial of a tuning becomes
TRUTH = "\N{DAGGER}"  # beside the name of a law that uses what no instrument gives


@dataclass(frozen=True, eq=False)
class Case:
    """One closed loop to be run: a law in a scenario.

    Attributes
    ----------
    scenario, law
        Together the name of the case.
    h, until, every
        Step, horizon and distance of the kept states, in s, each a multiple of the one before it (the horizon of
        both); values are taken at h / 2. Where h is None a pilot chooses the steps for the tolerance.
    style
        Which line of the figures belongs to the law.
    remark
        What a reader must know of this case, beside its name.
    tolerance
        By how much a metric may change, relative to its value, as the steps are halved: which does not keep
        it, is named below the tables. None asks for none.
    """

    scenario: str
    law: str
    loop: Loop
    metrics: tuple[AbstractMetric, ...]
    h: float | None
    until: float
    every: float
    style: int = 0
    remark: str = ""
    tolerance: float | None = None

    def __post_init__(self) -> None:
        for name in ("scenario", "law", "remark"):
            check_text(f"Case({name}=...)", getattr(self, name))
        object.__setattr__(self, "metrics", several("Case(metrics=...)", self.metrics, AbstractMetric, "metric"))
        if self.h is None and self.tolerance is None:
            raise ValueError(f"`Case(h=None)` needs a `tolerance`, for which a pilot chooses steps, in '{self.name}'.")
        for name, of in (("h", " of seconds"), ("until", " of seconds"), ("every", " of seconds"), ("tolerance", "")):
            value = getattr(self, name)
            if value is None and name in ("h", "tolerance"):
                continue
            positive(f"Case({name}=...)", value, of)
        for name, part in (("every", "h"), ("until", "h"), ("until", "every")):
            if (unit := getattr(self, part)) is not None:
                multiple(f"Case({name}=...)", getattr(self, name), unit, f"`{part}` of '{self.name}',")

    @property
    def name(self) -> str:
        """Scenario and law."""
        return f"{self.scenario}: {self.law}"


@dataclass(frozen=True, eq=False)
class Outcome:
    """A case that was run: its equations and what was measured."""

    case: Case
    ode: Ode
    measurement: Measurement

    @property
    def diverged_at(self) -> float | None:
        """When the run diverged, in s."""
        at = self.measurement.trajectories.diverged_at[0]
        return float(at) if at == at else None

    @property
    def label(self) -> str:
        """The law's name with its remark, marked where its observer uses the truth."""
        name = f"{self.case.law}, {self.case.remark}" if self.case.remark else self.case.law
        return f"{name} {TRUTH}" if self.ode.notes else name

    @property
    def notes(self) -> tuple[str, ...]:
        """What must stand below a table beside the law's name: truth used, step beyond its limit, tolerance missed."""
        limit, check = self.measurement.limits[0], self.measurement.check
        found = f"beyond the stability limit {limit.limit:.3g} s" if limit.checked else "checked at no state of the run"
        beyond = () if limit.holds else (f"step {limit.h:g} s {found}",)
        missed = () if check is None else tuple(a.miss for a in check.metrics if not a.met)
        return self.ode.notes + beyond + missed

    def within(self, metric: str) -> bool | None:
        """Whether a metric keeps the tolerance of its case; None where there is none."""
        check = self.measurement.check
        return None if check is None else {a.metric: a.met for a in check.metrics}[metric]

    def score(self, metric: str, joint: int) -> tuple[float, float]:
        """The value and error of a metric at one joint."""
        known = self.measurement.scores
        if metric not in known:
            raise LookupError(f"There is no metric '{metric}' in '{self.case.name}'.{nearest(metric, known)}")
        score = known[metric]
        _check_place(f"score('{metric}', joint)", joint, score.value.shape[1], self.case.name)
        return float(score.value[0, joint]), float(score.error[0, joint])

    def signal(self, name: str, joint: int) -> Array:
        """One number of an output or state over the kept times, (N,); a matrix counts row by row."""
        values = self.measurement.trajectories[name][0]
        rows = values.reshape(len(values), -1)
        _check_place(f"signal('{name}', joint)", joint, rows.shape[1], self.case.name)
        return np.asarray(rows[:, joint])

    @property
    def t(self) -> Array:
        """The kept times, (N,), in s."""
        return self.measurement.trajectories.t


def _check_place(call: str, joint: int, size: int, case: str) -> None:
    """Refuse a joint that is not there; negative ones too, which would be counted from the end."""
    if not isinstance(joint, int | np.integer) or not 0 <= joint < size:
        raise LookupError(f"`{call}` counts from 0 and knows 0 to {size - 1} in '{case}'; got {joint!r}.")


@dataclass(frozen=True, eq=False)
class Results:
    """The outcomes of a study, by scenario and law, the samples of its sweeps, and what its tunings found."""

    outcomes: tuple[Outcome, ...] = ()
    samples: tuple[Sample, ...] = ()
    tunings: tuple[Tuned, ...] = ()

    def __getitem__(self, key: tuple[str, str]) -> Outcome:
        for outcome in self.outcomes:
            if (outcome.case.scenario, outcome.case.law) == key:
                return outcome
        names = [outcome.case.name for outcome in self.outcomes]
        raise LookupError(f"There is no case '{key[0]}: {key[1]}'.{nearest(f'{key[0]}: {key[1]}', names)}")

    def sample(self, name: str) -> Sample:
        """What the sweep of that name gave."""
        for sample in self.samples:
            if sample.name == name:
                return sample
        raise LookupError(f"There is no sweep '{name}'.{nearest(name, [sample.name for sample in self.samples])}")

    def tuned(self, name: str) -> Tuned:
        """What the tuning of that name found."""
        for one in self.tunings:
            if one.name == name:
                return one
        raise LookupError(f"There is no tuning '{name}'.{nearest(name, [one.name for one in self.tunings])}")

    @property
    def all_samples(self) -> tuple[Sample, ...]:
        """Those of the sweeps, and all runs of the tunings."""
        held = (sample for one in self.tunings for sample in (*one.samples.values(), *one.halves.values()))
        return (*self.samples, *held)

    def to_frame(self) -> pd.DataFrame:
        """One row a case, metric and joint: value, error, unit, and when the run diverged.

        If a case has a tolerance: that too, and whether the metric, all joints together, is within it.
        """
        import pandas as pd

        asked = any(outcome.case.tolerance is not None for outcome in self.outcomes)
        rows = [
            {
                "scenario": outcome.case.scenario,
                "law": outcome.case.law,
                "metric": name,
                "unit": score.metric.unit,
                "joint": joint + 1,
                "value": value,
                "error": score.error[0, joint],
                "diverged_at": outcome.diverged_at,
                **({"tolerance": outcome.case.tolerance, "within": outcome.within(name)} if asked else {}),
            }
            for outcome in self.outcomes
            for name, score in outcome.measurement.scores.items()
            for joint, value in enumerate(score.value[0])
        ]
        return pd.DataFrame(rows)

    def scenario(self, name: str) -> tuple[Outcome, ...]:
        """The outcomes of one scenario in the order they were declared."""
        return tuple(outcome for outcome in self.outcomes if outcome.case.scenario == name)


@dataclass(frozen=True, eq=False)
class Study:
    """A question, the cases, sweeps and tunings that answer it, and the sections that say how.

    Attributes
    ----------
    name
        Lower-case letters, digits and underscores: it becomes the report's folder.
    sections, headlines
        What the report says of the results, and the findings that the command line prints, one a line.
    measures_time
        Whether the report holds times, which differ from one run to the next.
    seed
        Of what the study draws at random; None where nothing is.
    tunings, sweeps
        Searches for the numbers of loops, which come first, and many runs of a loop each; the folder of the report
        then keeps a ledger of them.
    cases, sweeps
        As they are, or a function that makes them from what the tunings found, by the tunings' names.
    """

    name: str
    title: str
    question: str
    method: str
    sections: Callable[[Results], Sequence[Section]]
    headlines: Callable[[Results], Sequence[str]] = field(default=lambda results: ())
    cases: tuple[Case, ...] | Callable[[Mapping[str, Tuned]], tuple[Case, ...]] = ()
    fingerprints: Mapping[str, str] = field(default_factory=dict)
    measures_time: bool = False
    seed: int | None = None
    sweeps: tuple[Sweep, ...] | Callable[[Mapping[str, Tuned]], tuple[Sweep, ...]] = ()
    tunings: tuple[Tuning, ...] = ()

    def __post_init__(self) -> None:
        check_name("Study", self.name)
        for name in ("title", "question", "method"):
            check_text(f"Study({name}=...)", getattr(self, name))
        for name in ("sections", "headlines"):
            if not callable(getattr(self, name)):
                raise ValueError(f"`Study({name}=...)` must be a function of the results; got {getattr(self, name)!r}.")
        for part, kind in (("cases", Case), ("sweeps", Sweep), ("tunings", Tuning)):
            given = getattr(self, part)
            if part != "tunings" and callable(given):
                self._check_later(part)
                continue
            object.__setattr__(self, part, several(f"Study({part}=...)", given, kind, part[:-1]))
            self._check_names(part, [one.name for one in getattr(self, part)])
        files = [f"{one.name}_{trial.name}{end}" for one in self.tunings for trial in one.trials for end in ENDS]
        sweeps = () if callable(self.sweeps) else self.sweeps
        self._check_names("sweeps and trials", [*files, *(one.name for one in sweeps)])

    def _check_later(self, part: str) -> None:
        if not self.tunings:
            raise ValueError(
                f"`Study({part}=...)` is a function of what the tunings found, and this study has none: give the "
                f"{part} themselves."
            )

    def _check_names(self, part: str, names: Sequence[str]) -> None:
        if twice := {name for name in names if names.count(name) > 1}:
            raise ValueError(f"`Study({part}=...)` needs distinct {part}; {sorted(twice)} came more than once.")

    def resolved(self, tuned: Mapping[str, Tuned]) -> Study:
        """The study with the cases and sweeps that follow from what its tunings found."""
        later: dict[str, Any] = {part: getattr(self, part) for part in ("cases", "sweeps")}
        return replace(self, **{part: make(tuned) for part, make in later.items() if callable(make)})
