"""The tests of an observer: it follows a plant, forgets a wrong start, and reads no truth that it does not declare."""

from __future__ import annotations

from abc import abstractmethod

import numpy as np

from workbench.blocks.loop import AbstractObserver, AbstractPlant, ClosedLoop
from workbench.blocks.loop.contracts import is_recursion
from workbench.core import Ode, SampledSystem
from workbench.core.validation.refusals import Array
from workbench.handover.recording import Recording
from workbench.handover.targets import TARGETS
from workbench.testing.bench_blocks import BenchLaw
from workbench.testing.block_tests import AbstractBlockTests
from workbench.testing.failure_sentences import fail, name_of_block, no_refusal, skip
from workbench.testing.form_checks import demand_python, demand_target, find_compiler, recording_of
from workbench.testing.shared_loops import observed_loop, observed_runs, ode_of_loop, sampled_of_loop

CONNECT = "correct its ports, or return the plant that it is for in `plant`"


class ObserverTests(AbstractBlockTests):
    """Tests of an observer. Subclass it under a name that begins with `Test`, and return the observer and its plant.

    Attributes
    ----------
    period
        The period in s of the computer, unless the observer has its own.
    until
        The time in s within which a wrong start is forgotten.
    tolerance
        The largest error of an estimate from a right start, relative to the largest value of the signal.

    Examples
    --------
    >>> class TestMotorObserver(wb.testing.ObserverTests):
    ...     def observer(self):
    ...         return wb.LinearObserver(wb.DCMotor(), [[20.0], [1.0]])
    >>> TestMotorObserver().test_it_follows_its_plant_from_a_right_start()
    """

    period: float = 1e-3
    until: float = 1.0
    tolerance: float = 1e-2

    @abstractmethod
    def observer(self) -> AbstractObserver:
        """The observer, made anew at each call."""

    def plant(self) -> AbstractPlant:
        """The plant that is observed: the model of the observer, unless another is returned here."""
        model: object = getattr(self.observer(), "model", None)
        if not isinstance(model, AbstractPlant):
            came = "it has no plant as its `model`"
            fail(name_of_block(self.observer()), "have a plant to observe", came, "return the plant in `plant`")
        return model

    def test_its_ports_fit_a_loop(self) -> None:
        """A loop can be made of it in continuous time, unless it moves at instants alone, and in a computer."""
        self._equation()
        self._sampled(self.plant())

    def test_it_follows_its_plant_from_a_right_start(self) -> None:
        """Estimates of signals of the plant are right where the observer starts right."""
        for name, (estimate, true) in self._estimates(0).items():
            error, size = np.abs(estimate - true).max(), np.abs(true).max()
            if not error <= self.tolerance * max(size, 1e-9) + 1e-12:
                fail(
                    name_of_block(self._block()),
                    f"estimate '{name}' to {self.tolerance:g} of its largest value, {size:.4g}, from a right start",
                    f"within {self.until:g} s it is {error:.4g} off",
                    "correct it, start it where its plant starts, or declare a larger `tolerance`",
                )

    def test_it_forgets_a_wrong_start(self) -> None:
        """Where the plant starts elsewhere, the error of each estimate is halved until `until`."""
        for name, (estimate, true) in self._estimates(1).items():
            error = np.abs(estimate - true).reshape(len(true), -1).max(axis=1)
            tenth = max(1, len(error) // 10)
            first, last = error[:tenth].max(), error[-tenth:].max()
            if not last <= max(0.5 * first, self.tolerance * np.abs(true).max()):
                fail(
                    name_of_block(self._block()),
                    f"forget a wrong start in {self.until:g} s",
                    f"the error of '{name}' is {first:.4g} at first and {last:.4g} at the end",
                    "correct the sign and the size of its gain, or declare a longer `until`",
                )

    def test_it_reads_no_truth_that_it_does_not_declare(self) -> None:
        """A law behind it is exported alone unless the observer `uses_truth`, and is refused by name if it does."""
        observer, sampled = self._block(), self._sampled(self.plant())
        if not observer.uses_truth:
            with no_refusal(name_of_block(observer), "be exported without a truth", "declare `uses_truth = True`"):
                sampled.law()
            return
        outputs = self.plant().outputs
        truths = [name for name in observer.reads.names if name not in outputs]
        try:
            sampled.law()
        except ValueError as error:
            if any(f"'{name}'" in str(error) for name in truths):
                return
        came = "a law behind it was handed over without it"
        fail(name_of_block(observer), "read the truth that it declares", came, "take `uses_truth` out")

    def test_it_runs_once_in_its_own_period(self) -> None:
        """A computer of another period is refused where it does not divide that of the observer."""
        observer = self._block()
        if observer.period is None:
            return
        loop = ClosedLoop(self.plant(), observer, BenchLaw(self.plant().inputs))
        try:
            loop.digital(0.7 * observer.period)
        except ValueError:
            return
        came = f"a computer ran it every {0.7 * observer.period:g} s"
        fail(name_of_block(observer), f"run every {observer.period:g} s", came, "declare its `period` as a field")

    def test_its_module_of_python_has_the_bits_of_its_loop(self) -> None:
        """The observer with the law behind it, as a module of Python and as a graph in NumPy."""
        name, recording = name_of_block(self._block()), self._recording()
        demand_target(name, TARGETS["numpy"], recording)
        demand_python(name, recording)

    def test_its_c_code_has_the_bits_of_its_loop(self) -> None:
        """The same in C, where a compiler is found."""
        demand_target(name_of_block(self._block()), TARGETS[f"{find_compiler()}-O2"], self._recording())

    def _estimates(self, run: int) -> dict[str, tuple[Array, Array]]:
        """Estimate and true value at each instant, of the states of the plant that the observer gives."""
        observer, plant = self._block(), self.plant()
        runs = observed_runs(self._loop(plant), self._period(plant), self.until)
        x, states = runs.x[run], runs.step.states
        held = {name: x[1:, states.slice(f"hold.{name}_hat")] for name in observer.gives.names}
        return {
            name: (estimate, x[:-1, states.slice(f"plant.{name}")])
            for name, estimate in held.items()
            if name in plant.states and f"plant.{name}" in states
        }

    def _recording(self) -> Recording:
        if not self._block().exportable:
            skip("the observer is declared not to be exportable")
        plant, observer = self.plant(), self._block()
        truths = tuple(name for name in observer.reads.names if name not in plant.outputs)
        return recording_of(name_of_block(observer), self._sampled(plant), truths)

    def _block(self) -> AbstractObserver:
        observer: object = self.observer()
        if not isinstance(observer, AbstractObserver):
            came = f"it returned {observer!r}"
            fail(f"{type(self).__name__}.observer()", "return a `wb.Observer`", came, "return the observer")
        return observer

    def _loop(self, plant: AbstractPlant) -> ClosedLoop:
        with no_refusal(name_of_block(self._block()), "fit a loop with its plant", CONNECT):
            return observed_loop(plant, self._block())

    def _period(self, plant: AbstractPlant) -> float:
        return self._block().period or plant.period or self.period

    def _equation(self) -> Ode | SampledSystem:
        loop = self._loop(self.plant())
        if is_recursion(loop.observer) or is_recursion(loop.plant) or loop.plant.noises:
            return self._sampled(loop.plant)
        with no_refusal(name_of_block(loop.observer), "fit its loop in continuous time", CONNECT):
            return ode_of_loop(loop)

    def _sampled(self, plant: AbstractPlant) -> SampledSystem:
        loop = self._loop(plant)
        with no_refusal(name_of_block(loop.observer), "fit its loop in a computer", CONNECT):
            return sampled_of_loop(loop, self._period(plant))
