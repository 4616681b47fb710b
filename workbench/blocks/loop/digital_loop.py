"""The declaration of a loop in a computer, whose equations are built when a run asks for them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from workbench.blocks.loop.closed_loop import ClosedLoop
from workbench.blocks.loop.command_queue import Queue
from workbench.blocks.loop.environment import AbstractInstruments
from workbench.blocks.loop.sampled_loop import INTEGRATORS
from workbench.core import SampledSystem
from workbench.core.block import Vector
from workbench.core.validation.refusals import one_of, seconds
from workbench.core.validation.signatures import check_arguments


@dataclass(frozen=True, eq=False)
@check_arguments
class DigitalLoop:
    """A closed loop with its observer and controller in a computer, whose equations are built later by `ode`.

    `ClosedLoop.digital` builds the equations at once. A study with many loops declares a `DigitalLoop` for each. A
    `Run` takes it like a `ClosedLoop`, and builds the equations when it runs.

    Parameters
    ----------
    loop
        The closed loop.
    period
        The sampling period of the computer in s.
    instruments, delay, initial_commands, integrator
        As of `ClosedLoop.digital`.

    Raises
    ------
    ValueError, LookupError
        If `ClosedLoop.digital` refuses the period, the delay or the integrator; `ode` checks everything else.

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0)
    >>> loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    >>> runs = [wb.Run(wb.DigitalLoop(loop, T, delay=True), (wb.rmse(),), until=2.0, h=T / 2) for T in (1e-3, 1e-2)]
    >>> runs[1].loop.ode().period
    0.01
    """

    loop: ClosedLoop
    period: float
    instruments: AbstractInstruments | None = None
    delay: bool | float | Mapping[str, float] = False
    initial_commands: Mapping[str, Vector] | None = None
    integrator: str = "declared"

    def __post_init__(self) -> None:
        seconds("DigitalLoop(period=...)", self.period)
        one_of("DigitalLoop(integrator=...)", self.integrator, INTEGRATORS)
        Queue.of(self.loop.plant.inputs, self.delay, self.initial_commands)  # refuses a delay that is none

    def ode(
        self, name: str = "loop", *, inputs: bool = False, at: str | tuple[str, ...] | None = None
    ) -> SampledSystem:
        """The equations of the loop with its computer; the arguments are those of `ClosedLoop.ode`."""
        return self.loop.digital(
            self.period,
            self.instruments,
            delay=self.delay,
            initial_commands=self.initial_commands,
            integrator=self.integrator,
            name=name,
            inputs=inputs,
            at=at,
        )

    def ablations(self) -> dict[str, DigitalLoop]:
        """Copies of the loop, each without one part of its observer or controller, by the name of that part."""
        return {name: replace(self, loop=less) for name, less in self.loop.ablations().items()}
