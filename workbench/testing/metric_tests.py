"""The tests of a metric: its error, its bits in a batch, and runs that diverge."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from workbench.blocks.laws import PID
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.plants import DCMotor
from workbench.blocks.signals import Step as StepSignal
from workbench.core import Ode, SampledSystem
from workbench.core.units import UnitError, read
from workbench.core.validation.refusals import Array
from workbench.engine.metrics import AbstractMetric, Measurement, measure
from workbench.testing.failure_sentences import fail, no_refusal

RUNS = 4
FAR = 1.7e308  # of a state, whose rate is beyond all numbers
HALVINGS = 3
ROUNDING = 1e-10  # relative: of sums of thousands of steps
OWN = "correct the metric; if it reads signals that a motor does not have, return a loop with them in `equation`"
ROWS = "compute each row of `value` from the same row of its arguments alone"


class MetricTests(ABC):
    """Tests of a metric. Subclass it under a name that begins with `Test`, and return the metric.

    Attributes
    ----------
    until, h
        The horizon and the longest step of the runs in s; h must divide the grid of a metric that has one.

    Examples
    --------
    >>> class TestRmse(wb.testing.MetricTests):
    ...     def metric(self):
    ...         return wb.rmse()
    >>> TestRmse().test_its_error_bounds_the_change_to_a_shorter_step()
    """

    until: float = 1.0
    h: float = 1e-2

    @abstractmethod
    def metric(self) -> AbstractMetric:
        """The metric, made anew at each call."""

    def equation(self) -> Ode | SampledSystem:
        """The loop that is measured: a motor whose speed omega follows a step by PID, unless another is returned."""
        motor = DCMotor()
        law = PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0)
        return ClosedLoop(motor, controller=law, reference=StepSignal("omega", "rad/s", 1.0)).ode()

    def test_it_has_a_finite_value_with_a_unit(self) -> None:
        """Each number of it is finite, and its unit can be read."""
        for score in self._measure().scores:
            if not np.isfinite(score.value).all():
                fail(self._name(), "have a finite value", f"that of a loop that settles is {score.value[0]}", OWN)
            try:
                read(score.unit)
            except UnitError as error:
                fail(self._name(), "have a unit", f"'{score.unit}' is none, as {error}", "write one, as 'N m s' is")

    def test_it_is_the_same_each_time(self) -> None:
        """No state is hidden in it."""
        self._demand_equal(self._measure().values, self._measure().values, "when it is measured again", ROWS)

    def test_its_error_bounds_the_change_to_a_shorter_step(self) -> None:
        """The error of a value bounds its change to a step that is eight times shorter."""
        coarse, fine = self._measure(), self._measure(h=self.h / 2**HALVINGS)
        change, error = np.abs(coarse.values[0, -1] - fine.values[0, -1]), coarse.errors[0, -1]
        if (change > error + ROUNDING * np.abs(fine.values[0, -1])).any():
            came = f"the error is {error.max():.3g}, and the value changes by {change.max():.3g}"
            fail(self._name(), "have an error that bounds the change to a shorter step", came, "declare a shorter `h`")

    def test_its_error_shrinks_with_the_step(self) -> None:
        """At a step that is eight times shorter the error is at most half as large."""
        coarse, fine = (np.abs(self._measure(h=h).errors[0, -1]) for h in (self.h, self.h / 2**HALVINGS))
        size = np.abs(self._measure().values[0, -1])
        if (fine > 0.5 * coarse + ROUNDING * size).any():
            came = f"at {2**HALVINGS} times the steps it is {fine.max():.3g}, and was {coarse.max():.3g}"
            remedy = "accumulate it in `integrand` or `update`, and declare a shorter `h`"
            fail(self._name(), "have an error that shrinks with the step", came, remedy)

    def test_its_value_has_the_same_bits_however_runs_are_divided(self) -> None:
        """Chunks of runs, other kept times and another order give the same bits."""
        equation = self.equation()
        starts = self._starts(equation)
        whole = self._measure(starts=starts, every=self.until).values[:, -1]
        chunks = [self._measure(starts=part, every=self.until).values[:, -1] for part in (starts[:1], starts[1:])]
        self._demand_equal(whole, np.concatenate(chunks), "in chunks", ROWS)
        self._demand_equal(whole, self._measure(starts=starts[::-1]).values[::-1, -1], "in the opposite order", ROWS)
        often = self._measure(starts=starts, every=self.until / 10).values[:, -1]
        self._demand_equal(whole, often, "with other kept times", "accumulate it at each step and not at kept times")

    def test_a_run_that_diverges_has_no_value_and_changes_no_other(self) -> None:
        """Its row is NaN, is counted as diverged, and is part of no mean."""
        starts = self._starts(self.equation())
        alone = self._measure(starts=starts[1:]).values[:, -1]
        starts[0] = FAR
        beside = self._measure(starts=starts)
        if beside.diverged_count != 1 or np.isfinite(beside.values[0, -1]).any():
            fail(self._name(), "be NaN for a run that diverges", f"it is {beside.values[0, -1]}", ROWS)
        self._demand_equal(alone, beside.values[1:, -1], "beside a run that diverges", ROWS)

    def _measure(self, h: float | None = None, starts: Array | None = None, every: float | None = None) -> Measurement:
        with no_refusal(self._name(), "be measured", OWN):
            return measure(self.equation(), [self.metric()], None, starts, until=self.until, h=h or self.h, every=every)

    def _starts(self, equation: Ode | SampledSystem) -> Array:
        usual = equation.states.default
        return usual + 0.05 * np.random.default_rng(6).uniform(-1, 1, (RUNS, usual.size))

    def _name(self) -> str:
        metric: object = self.metric()
        if not isinstance(metric, AbstractMetric):
            fail(f"{type(self).__name__}.metric()", "return a metric", f"it returned {metric!r}", "return the metric")
        return f"{type(metric).__name__}({metric.name!r})"

    def _demand_equal(self, one: Array, other: Array, where: str, remedy: str) -> None:
        if one.shape != other.shape or not np.array_equal(one, other, equal_nan=True):
            fail(self._name(), "give the same bits in any batch", f"its values differ {where}", remedy)
