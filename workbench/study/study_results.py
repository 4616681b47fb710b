"""The case of a study, its outcome, and the results of all that a study declares."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from workbench.core import Ode, SampledSystem
from workbench.core.validation.refusals import Array, known_name, refusal
from workbench.core.validation.refusals import name as printable_name
from workbench.core.validation.signatures import check_arguments
from workbench.engine.metrics import Measurement, Score
from workbench.engine.metrics.score import MetricColumn
from workbench.study.run_and_sweep import Run
from workbench.study.sample import Sample
from workbench.study.tuning import TuningResult
from workbench.study.user_values import UserValue

if TYPE_CHECKING:
    import pandas as pd

TRUTH = "\N{DAGGER}"  # beside the name of a law that uses what no instrument gives


@dataclass(frozen=True, eq=False)
@check_arguments
class Case:
    """One closed loop to be run: a law in a scenario.

    Attributes
    ----------
    scenario, law
        Together they are the name of the case.
    run
        The run. Values are computed at its step, and their errors with half the step; the states are kept.
    style
        The number of the line style of the law in figures, see `wb.document.Series`.
    remark
        A remark that is printed beside the name of the law.

    Examples
    --------
    >>> wb.Case("speed", "no law", wb.Run(wb.open_loop(wb.DCMotor()), (wb.effort("omega"),), until=1.0)).name
    'speed: no law'
    """

    scenario: str
    law: str
    run: Run
    style: int = 0
    remark: str = ""

    def __post_init__(self) -> None:
        printable_name("Case(scenario=...)", self.scenario)
        printable_name("Case(law=...)", self.law)

    @property
    def name(self) -> str:
        """The scenario and the law, as 'scenario: law'."""
        return f"{self.scenario}: {self.law}"


@dataclass(frozen=True, eq=False)
@check_arguments
class Outcome:
    """A case that was run: its equations and its measurement."""

    case: Case
    ode: Ode | SampledSystem
    measurement: Measurement

    def __repr__(self) -> str:
        return f"<Outcome of '{self.case.name}': {self.measurement.summary}>"

    @property
    def digest(self) -> str:
        """A hash of equations, parameters, initial state, steps, horizon and noise (64 hexadecimal digits)."""
        run, ode = self.case.run, self.ode
        spans = [None if span is None else float(span) for span in (run.h, run.until, run.every, run.tolerance)]
        seed = (run.seed,) if isinstance(ode, SampledSystem) and ode.w.numel() else ()  # that of its noise
        digest = hashlib.sha256(repr((ode.fingerprint, spans, *seed)).encode())
        digest.update(np.concatenate([ode.parameters.default, ode.states.default]).astype("<f8").tobytes())
        return digest.hexdigest()

    @property
    def diverged_at(self) -> float | None:
        """The time at which the run diverged, in s; None for a run that stayed finite."""
        at = self.measurement.diverged_at[0]
        return float(at) if at == at else None

    @property
    def label(self) -> str:
        """The law's name with its remark, marked where its observer uses the truth."""
        name = f"{self.case.law}, {self.case.remark}" if self.case.remark else self.case.law
        return f"{name} {TRUTH}" if self.ode.notes else name

    @property
    def notes(self) -> tuple[str, ...]:
        """The notes below a table beside the law's name: truth used, a computer's methods, steps, tolerance, bounds."""
        limit, check, run = self.measurement.limit, self.measurement.check, self.case.run
        how = (
            f"is beyond the stability limit of {limit.limit:.3g} s"
            if limit.checked_states
            else "was checked at no state of the run"
        )
        beyond = () if limit.holds else (f"the step of {limit.h:g} s {how}",)
        by = self.measurement.choice.by if self.measurement.choice else ""
        steps = () if run.h else (f"steps of {self.measurement.h:.3g} s{by}, for a tolerance of {run.tolerance:g}",)
        missed = () if check is None else tuple(a.miss for a in check.metrics if not a.is_met)
        methods = self.ode.methods if isinstance(self.ode, SampledSystem) else ()
        return (
            self.ode.notes
            + methods
            + steps
            + beyond
            + missed
            + self.ode.switches.warnings
            + self.measurement.excursions
            + self.measurement.pulse_warnings
        )

    @check_arguments
    def within(self, metric: str) -> bool | None:
        """True if the error of a metric is within the tolerance of its case; None if the case has no tolerance."""
        check = self.measurement.check
        if check is None:
            return None
        met = {a.metric: a.is_met for a in check.metrics}
        return met[known_name(metric, met, f"metrics of '{self.case.name}'")]

    @check_arguments
    def score(self, metric: str, signal: int | str = 0) -> Score:
        """A metric of one signal, by the signal's label or its number from 0; its `pair` is the value and the error."""
        self.column(metric, signal)
        return self.measurement.score(metric, signal)

    @check_arguments
    def column(self, metric: str, signal: int | str = 0) -> MetricColumn:
        """The name of the metric, the number of the score from 0, its unit, and the label of its signal."""
        try:
            return self.measurement.column(metric, signal)
        except LookupError as error:
            raise LookupError(f"'{self.case.name}': {error}") from None

    @check_arguments
    def signal(self, name: str, component: int = 0) -> Array:
        """One component of an output or state over the kept times, (N,); a matrix counts row by row."""
        values = self.measurement.trajectories[name][0]
        rows = values.reshape(len(values), -1)
        if not 0 <= component < rows.shape[1]:  # a negative number would be counted from the end
            raise LookupError(
                f"`signal('{name}', component)` counts from 0 and knows 0 to {rows.shape[1] - 1} in "
                f"'{self.case.name}'; got {component!r}."
            )
        return np.asarray(rows[:, component])

    @property
    def t(self) -> Array:
        """The kept times, (N,), in s."""
        return self.measurement.trajectories.t


@dataclass(frozen=True, eq=False)
@check_arguments
class Results:
    """The results of a study: outcomes of cases, samples of sweeps, results of tunings, and answers of works.

    Examples
    --------
    >>> motor = wb.Run(wb.open_loop(wb.DCMotor(), "motor"), (wb.effort("omega"),), until=1.0, h=1e-2)
    >>> study = wb.Study("s", "T", "Q?", "M.", lambda results: [], cases=(wb.Case("speed", "no law", motor),))
    >>> results = wb.study.run(study)
    >>> results["speed", "no law"].score("effort of omega").unit
    'rad/s'
    """

    outcomes: tuple[Outcome, ...] = ()
    samples: tuple[Sample, ...] = ()
    tunings: tuple[TuningResult, ...] = ()
    works: Mapping[str, tuple[UserValue, ...]] = field(default_factory=dict)

    def __getitem__(self, key: tuple[str, str]) -> Outcome:
        if not (isinstance(key, tuple) and len(key) == 2 and all(isinstance(name, str) for name in key)):
            raise refusal("results[scenario, law]", "named by a scenario and a law", key)
        held = {outcome.case.name: outcome for outcome in self.outcomes}
        return held[known_name(": ".join(key), held, "cases of this study")]

    @check_arguments
    def sample(self, name: str) -> Sample:
        """The sample of the sweep of that name."""
        held = {sample.name: sample for sample in self.samples}
        return held[known_name(name, held, "sweeps of this study")]

    @check_arguments
    def tuning(self, name: str) -> TuningResult:
        """The `TuningResult` of the tuning of that name."""
        held = {one.name: one for one in self.tunings}
        return held[known_name(name, held, "tunings of this study")]

    @check_arguments
    def work(self, name: str) -> tuple[UserValue, ...]:
        """The answers of the work of that name, in the order of its items."""
        return self.works[known_name(name, self.works, "works of this study")]

    @property
    def all_samples(self) -> tuple[Sample, ...]:
        """The samples of the sweeps, and of all runs of the tunings."""
        held = (sample for one in self.tunings for sample in (*one.samples.values(), *one.final_samples.values()))
        return (*self.samples, *held)

    @property
    def rows(self) -> list[dict[str, object]]:
        """A row for each case, metric and signal: value, error, unit, and the time of divergence.

        If a case has a tolerance: that too, and whether the metric is within it.
        """
        asked = any(outcome.case.run.tolerance is not None for outcome in self.outcomes)
        return [
            {
                "scenario": outcome.case.scenario,
                "law": outcome.case.law,
                "metric": score.metric,
                "unit": score.unit,
                "signal": score.label,
                "value": score.value[0],
                "error": score.error[0],
                "diverged_at": outcome.diverged_at,
                **({"tolerance": outcome.case.run.tolerance, "within": outcome.within(score.metric)} if asked else {}),
            }
            for outcome in self.outcomes
            for score in outcome.measurement.scores
        ]

    def to_frame(self) -> pd.DataFrame:
        """The `rows` as a table of pandas."""
        import pandas as pd

        return pd.DataFrame(self.rows)

    @check_arguments
    def scenario(self, name: str) -> tuple[Outcome, ...]:
        """The outcomes of one scenario in the order they were declared."""
        return tuple(outcome for outcome in self.outcomes if outcome.case.scenario == name)
