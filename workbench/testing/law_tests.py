"""The tests of a control law: its ports, units and numbers, its runs, and its forms for other machines."""

from __future__ import annotations

from abc import abstractmethod
from importlib.util import find_spec

from workbench.blocks.loop import AbstractController, ClosedLoop
from workbench.blocks.loop.contracts import is_recursion
from workbench.core import Ode, SampledSystem
from workbench.handover.recording import Recording
from workbench.handover.targets import TARGETS
from workbench.testing.bench_blocks import bench_loop
from workbench.testing.block_tests import AbstractBlockTests
from workbench.testing.failure_sentences import fail, name_of_block, no_refusal, skip
from workbench.testing.form_checks import (
    demand_finite_run,
    demand_forms,
    demand_python,
    demand_refused_forms,
    demand_target,
    find_compiler,
    recording_of,
)
from workbench.testing.live_checks import demand_live_page, demand_printed_page
from workbench.testing.shared_loops import ode_of_loop, sampled_of_loop

CONNECT = "correct its ports, or return the loop that it is for in `loop`"


class LawTests(AbstractBlockTests):
    """Tests of a control law. Subclass it under a name that begins with `Test`, and return the law.

    A law that only a computer can run is returned as `law.run_every(period)`, and is tested in a computer alone.

    Attributes
    ----------
    period
        The period in s of the computer, unless the law has its own.

    Examples
    --------
    >>> class TestPI(wb.testing.LawTests):
    ...     def law(self):
    ...         return wb.PID(wb.DCMotor().outputs, wb.DCMotor().inputs, Kp=100.0, Ki=200.0)
    >>> TestPI().test_each_number_refuses_a_bad_value_by_its_name()
    """

    period: float = 0.01

    @abstractmethod
    def law(self) -> AbstractController:
        """The law, made anew at each call."""

    def loop(self) -> ClosedLoop:
        """A loop with the law: one with the signals of its ports on a bench, unless another is returned here."""
        return bench_loop(self.law())

    def test_its_ports_fit_a_loop(self) -> None:
        """A loop can be made of it in continuous time, unless it moves at instants alone, and in a computer."""
        self._equation()
        self._sampled()

    def test_a_run_in_a_computer_is_finite(self) -> None:
        """With readings, a reference and commands that are held over a period."""
        if self.law().exportable:
            self._recording()
        else:
            demand_finite_run(self._name(), self._sampled())

    def test_its_graph_has_the_bits_of_its_loop(self) -> None:
        """The law alone, taken out of the loop, in NumPy."""
        demand_target(self._name(), TARGETS["numpy"], self._exported())

    def test_its_module_of_python_has_the_bits_of_its_loop(self) -> None:
        """The exported module, which needs no package."""
        demand_python(self._name(), self._exported())

    def test_its_c_code_has_the_bits_of_its_loop(self) -> None:
        """The exported C, where a compiler is found."""
        recording = self._exported()
        demand_target(self._name(), TARGETS[f"{find_compiler()}-O2"], recording)

    def test_it_has_the_bits_of_its_loop_in_a_browser(self) -> None:
        """WebAssembly in the engine of a browser, where Node is found."""
        if find_spec("llvmlite") is None:
            skip("nothing is compiled for a browser without llvmlite")
        demand_target(self._name(), TARGETS["browser"], self._exported())

    def test_it_is_written_in_each_form(self) -> None:
        """Each export writes it, or refuses it by name if it is declared not to be exportable."""
        law = self._sampled().law(truths=self._truths())
        demand = demand_forms if self.law().exportable else demand_refused_forms
        demand(self._name(), law)

    def test_its_live_page_computes_the_same_numbers(self) -> None:
        """The page of the loop can be turned, and JavaScript gives the bits of the portable arithmetic."""
        demand = demand_live_page if self.law().exportable else demand_printed_page
        demand(self._name(), self._equation(), self.h)

    def _block(self) -> AbstractController:
        law: object = self.law()
        if not isinstance(law, AbstractController):
            fail(f"{type(self).__name__}.law()", "return a `wb.Controller`", f"it returned {law!r}", "return the law")
        return law

    def _name(self) -> str:
        return name_of_block(self._block())

    def _equation(self) -> Ode | SampledSystem:
        loop = self.loop()
        blocks = loop.controller, loop.observer, loop.plant
        if any(is_recursion(block) for block in blocks) or loop.controller.period is not None:
            return self._sampled()
        with no_refusal(self._name(), "fit its loop in continuous time", CONNECT):
            return ode_of_loop(loop)

    def _sampled(self) -> SampledSystem:
        with no_refusal(self._name(), "fit its loop in a computer", CONNECT):
            return sampled_of_loop(self.loop(), self.law().period or self.period)

    def _recording(self) -> Recording:
        return recording_of(self._name(), self._sampled(), self._truths())

    def _truths(self) -> tuple[str, ...]:
        loop = self.loop()
        return tuple(name for name in loop.observer.reads.names if name not in loop.plant.outputs)

    def _exported(self) -> Recording:
        if not self.law().exportable:
            skip("the law is declared not to be exportable")
        return self._recording()
