"""The tests of a target: another machine that computes the one graph of a law with the bits of its loop."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from workbench.blocks.laws import PID
from workbench.blocks.loop import AbstractController, ClosedLoop, Instruments
from workbench.blocks.plants import DCMotor
from workbench.blocks.signals import Step as StepSignal
from workbench.handover.c99.c_files import c_code
from workbench.handover.recording import Recording, record
from workbench.handover.targets import AbstractTarget, TargetCost
from workbench.handover.targets.external_programs import PACKAGES, TargetError, missing_programs
from workbench.testing.bench_blocks import EveryOperation
from workbench.testing.failure_sentences import fail, skip
from workbench.testing.form_checks import LIMIT, NAME, first_difference

PERIODS = 200
PERIOD = 0.01  # s
SAME = "compute the graph of the law operation by operation, each rounded by itself"


class TargetTests(ABC):
    """Tests of a target. Subclass it under a name that begins with `Test`, and return the target.

    Examples
    --------
    >>> class TestNumPy(wb.testing.TargetTests):
    ...     def target(self):
    ...         return wb.handover.targets.TARGETS["numpy"]
    >>> TestNumPy().test_a_law_of_all_operations_has_the_bits_of_its_loop()
    """

    @abstractmethod
    def target(self) -> AbstractTarget:
        """The target, made anew at each call."""

    def test_the_programs_that_it_needs_can_be_installed(self) -> None:
        """Each has its packages in the table of `workbench.handover.targets.external_programs`."""
        for program in self._target().programs:
            if program not in PACKAGES:
                remedy = "name it in `PACKAGES`"
                fail(self._name(), "need programs whose packages are known", f"'{program}' is another one", remedy)

    def test_a_pid_law_has_the_bits_of_its_loop(self) -> None:
        """With limits and an integral, behind a noisy instrument."""
        motor = DCMotor()
        law = PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0, Kd=10.0, low=-24.0, high=24.0)
        self._demand(law)

    def test_a_law_of_all_operations_has_the_bits_of_its_loop(self) -> None:
        """Each operation of a graph, with the time, and at the edges of its functions."""
        self._demand(EveryOperation())

    def test_it_runs_a_recording_of_one_period(self) -> None:
        """The shortest recording, whose memory is that of the start."""
        self._demand(EveryOperation(), 1)

    def test_it_tells_its_cost_or_that_it_knows_none(self) -> None:
        """Instructions, stack and bytes, as far as they are known."""
        self._demand(EveryOperation(), 1, cost=True)

    def _demand(self, law: AbstractController, periods: int = PERIODS, cost: bool = False) -> None:
        target = self._target()
        if lacks := missing_programs(target.programs):
            skip(lacks)
        recording = _recording(law, periods)
        code = c_code(recording.law, NAME)
        with TemporaryDirectory(prefix="workbench-") as place:
            try:
                answers = target.answers(code, recording, Path(place), LIMIT)
                figures: object = target.figures(code, recording, Path(place), LIMIT) if cost else TargetCost()
            except TargetError as error:
                fail(self._name(), "run a law", f"it said '{error}'", "correct its `answers` and `figures`")
        if np.shape(answers.u) != recording.u.shape:
            came = f"it gave commands of shape {np.shape(answers.u)}"
            fail(self._name(), f"give commands of shape {recording.u.shape}", came, "give a row for each period")
        if difference := first_difference(answers, recording):
            fail(self._name(), "give the bits of the loop", difference, SAME)
        if not isinstance(figures, TargetCost):
            fail(self._name(), "give `TargetCost`", f"it gave {figures!r}", "return `TargetCost()` if it knows none")

    def _target(self) -> AbstractTarget:
        target: object = self.target()
        if not isinstance(target, AbstractTarget):
            came = f"it returned {target!r}"
            fail(f"{type(self).__name__}.target()", "return an `AbstractTarget`", came, "return the target")
        return target

    def _name(self) -> str:
        return self._target().name


def _recording(law: AbstractController, periods: int) -> Recording:
    motor = DCMotor()
    loop = ClosedLoop(motor, controller=law, reference=StepSignal("omega", "rad/s", 1.0))
    instruments = Instruments.of(motor, noise={"omega": 1e-3}, quantum={"omega": 1e-3})
    return record(loop.digital(PERIOD, instruments), None, periods, seed=1)
