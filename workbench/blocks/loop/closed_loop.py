"""The closed loop: blocks in their sockets become one `Ode`, or one `SampledSystem` where a computer closes it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import casadi as ca

from workbench.blocks.loop import wiring
from workbench.blocks.loop.block_roles import roles
from workbench.blocks.loop.command_queue import Queue
from workbench.blocks.loop.contracts import AbstractController, AbstractObserver, AbstractPlant, is_recursion
from workbench.blocks.loop.environment import AbstractInstruments, AbstractReference, NoReference, Readings
from workbench.blocks.loop.feedback_sign import opposite, refuse_wrong_sign
from workbench.blocks.loop.injected_signals import (
    InjectedSignals,
    Outputs,
    cut_loop,
    injected_signals,
    refuse_inputs_of_recursion,
)
from workbench.blocks.loop.instruments import Instruments
from workbench.blocks.loop.linear_blocks import LinearLaw, LinearPlant, block_maker, law_of_system
from workbench.blocks.loop.linear_filter import LinearFilter, observer_of_system
from workbench.blocks.loop.port_checks import refuse_instants, refuse_misfits, refuse_odd_ports
from workbench.blocks.loop.sampled_loop import FINE, INTEGRATORS, digital
from workbench.core import Ode, Roles, SampledSystem, block, lift
from workbench.core.block import Vector, socket
from workbench.core.publications import origins
from workbench.core.validation.refusals import one_of, refusal, seconds


@block
class ClosedLoop:
    """A closed loop of a plant, an observer, a controller and a reference, which are connected by the names of signals.

    A linear system of python-control may be given for plant, observer or controller: it becomes a `LinearPlant`, a
    `LinearFilter` or a `LinearLaw`. As a controller its input is y, as for the law of `lqg`, and not the error.

    Parameters
    ----------
    plant
        The plant.
    observer
        The observer, or None: the controller then reads the outputs as the instruments measure them.
    controller
        The control law.
    reference
        The reference, or None for a controller that follows no reference.

    Raises
    ------
    ValueError
        If there is no plant or no controller; if a block needs a signal that no other block gives, or needs it in
        another shape or unit; if an input of the plant is not driven, or a signal of the reference is not followed; if
        one name means two things; or if the loop is unstable with a system of python-control as the controller, and
        stable with the opposite sign.

    Examples
    --------
    >>> law = wb.PID(wb.DCMotor().outputs, wb.DCMotor().inputs, Kp=100.0, Ki=200.0)
    >>> wb.ClosedLoop(wb.DCMotor(), controller=law, reference=wb.Step("omega", "rad/s", 1.0)).ode().outputs.names
    ('omega', 'omega_ref', 'e_omega', 'e_hat_omega', 'v', 'v_applied', 'omega_error')
    """

    noun = ""  # it is called what its blocks are called

    plant: AbstractPlant = socket(block_maker(LinearPlant))
    observer: AbstractObserver = socket(block_maker(LinearFilter), default=None)
    controller: AbstractController = socket(block_maker(law_of_system), default=None)
    reference: AbstractReference = None  # type: ignore[assignment]

    def __post_init__(self) -> None:
        empty = {socket for socket, block in vars(self).items() if block is None}
        if "controller" in empty:
            raise refusal("ClosedLoop(controller=...)", "an `AbstractController`", None)
        refuse_odd_ports(self)
        if "observer" in empty:
            object.__setattr__(self, "observer", Readings(self.plant.outputs))
        object.__setattr__(self, "observer", observer_of_system(self.plant, self.observer))
        if "reference" in empty:
            object.__setattr__(self, "reference", NoReference())
        refuse_misfits(self)
        plant = self.plant
        if not (is_recursion(plant) or is_recursion(self.observer) or plant.noises or plant.sampled_states.size):
            _refuse_wrong_sign(self, lambda loop: _around(loop, "loop", InjectedSignals()), recursion=False)

    @property
    def follows(self) -> tuple[str, ...]:
        """The names of the outputs of the plant that should follow the reference."""
        law, outputs = self.controller.follows, self.plant.outputs
        return tuple(name for name in self.reference.primary if name in law and name in outputs)

    @property
    def roles(self) -> Roles:
        """The signals on which the command depends, and the models that it uses, see `wb.loop.roles`."""
        return roles(self)

    def ablations(self) -> dict[str, ClosedLoop]:
        """Copies of the loop, each without one part of its observer or controller, by the name of that part.

        A loop without the state observer of an arm gets exact positions and velocities. A part that is a number of the
        equations, such as an integral gain, is removed by setting it to zero.

        Raises
        ------
        ValueError
            If the observer and the controller use the same name for a part.
        """
        observers, controllers = self.observer.without(), self.controller.without()
        if both := sorted(set(observers) & set(controllers)):
            raise ValueError(
                f"`ClosedLoop.ablations()` needs one name for each part; the observer and the controller both have "
                f"'{both[0]}'."
            )
        less_observer = {name: replace(self, observer=block) for name, block in observers.items()}
        return less_observer | {name: replace(self, controller=block) for name, block in controllers.items()}

    def ode(self, name: str = "loop", *, inputs: bool = False, at: str | tuple[str, ...] | None = None) -> Ode:
        """The closed loop in continuous time as x' = f(t, x, p); each parameter is named by its path, as `plant.J`.

        For an output x and an input u of the plant, the outputs of the loop are: x; the reference `x_ref`; the error
        `e_x` = x - x_ref and its estimate `e_hat_x` = x_hat - x_ref; the command `u` and the input that acts,
        `u_applied`; the truths; the errors of the observer, `x_error` = x - x_hat, true minus estimated; and the
        signals of the law. In the loop of an arm, `e_q`, `e_qd` and `e_hat_q` are called `e`, `ed` and `e_hat`.

        Parameters
        ----------
        name
            The name of the equations.
        inputs
            True to declare inputs for signals from outside. They are parameters with the value zero by default:
            `x_ref` is added to the reference, `u_load` to the input that acts, and `x_noise` to the reading of x.
        at
            Inputs or outputs of the plant at which the loop is cut, as by `cut`. With `inputs` as well, 'drive' is the
            first input, and the first outputs are the signals that arrive at the cut.

        Raises
        ------
        ValueError
            If only a computer can run the law, or if a signal of the law has a name that the loop uses.
        LookupError
            If a name in `at` is neither an input nor an output of the plant.
        """
        return _around(self, name, injected_signals("ClosedLoop.ode", self, inputs, at))

    def cut(self, name: str = "loop", *, at: str | tuple[str, ...] | None = None) -> Ode:
        """The open loop: the loop cut at inputs or outputs of the plant, with the input 'drive' behind the cut.

        The outputs are the signals that arrive at the cut, in the same order: commands, which the observer still uses,
        or outputs of the plant. With drive = output it is the loop of `ode`. The loop gain L is from drive to -output.

        Parameters
        ----------
        name
            The name of the equations.
        at
            Names of inputs, or of outputs, of the plant. The default is all inputs.

        Raises
        ------
        ValueError
            If only a computer can run the law.
        LookupError
            If a name is neither an input nor an output of the plant.
        """
        return _around(self, name, cut_loop("ClosedLoop.cut", self, at))

    def digital(
        self,
        period: float,
        instruments: AbstractInstruments | None = None,
        *,
        delay: bool | float | Mapping[str, float] = False,
        initial_commands: Mapping[str, Vector] | None = None,
        integrator: str = "declared",
        name: str = "loop",
        inputs: bool = False,
        at: str | tuple[str, ...] | None = None,
    ) -> SampledSystem:
        """The closed loop with observer and controller in a computer, which runs them once in every `period` [s].

        At t_k = k period the computer reads the instruments, the observer estimates from the readings, and the law
        computes the command from the estimates and the reference. The limited command is held until t_(k+1). Observer
        and law then update their memories, each by its `method`; the observer uses the held command. The outputs are
        those of `ode`. Held commands, estimates and signals of the law are states, such as 'hold.v' and 'hold.v_hat'.

        Parameters
        ----------
        period
            The sampling period in s. A block with a `period` must have a whole multiple of it, and runs with that one.
        instruments
            Noise and quantisation of the readings, and limits of the commands. By default readings are exact.
        delay, initial_commands
            The delay of commands in periods: True for 1, a whole number, or a mapping by input. Delayed commands are
            the states 'hold.next.2', ..., 'hold.next'. They begin at `initial_commands`, by input, or as inputs do.
        integrator
            "declared" for the method of each block, or "fine" for 16 Runge-Kutta steps per period of all memories, with
            held signals. A loop that diverges only with "declared" does so by its integration method.
        name, inputs, at
            As of `ode`. Signals from outside are held over a period.

        Raises
        ------
        ValueError
            If a number is out of range; the period does not divide that of a block; the instruments are for another
            plant; an initial command has a wrong shape, or its input no delay; there is no such integrator; a signal
            of the law has a name of the loop; or `inputs` are asked for with a plant in discrete time.
        LookupError
            If a delay or an initial command is for a name that is not an input of the plant.
        """
        fine = one_of("ClosedLoop.digital(integrator=...)", integrator, INTEGRATORS) == "fine"
        length = seconds("ClosedLoop.digital(period=...)", period)
        outside = injected_signals("ClosedLoop.digital", self, inputs, at)
        queue, nothing = Queue.of(self.plant.inputs, delay, initial_commands), InjectedSignals()
        gauges = Instruments() if instruments is None else instruments
        _refuse_wrong_sign(self, lambda loop: digital(loop, length, gauges, queue, 0, name, nothing), recursion=True)
        return digital(self, length, gauges, queue, FINE if fine else 0, name, outside)


def _refuse_wrong_sign(
    loop: ClosedLoop, equations: Callable[[ClosedLoop], Ode | SampledSystem], *, recursion: bool
) -> None:
    """Refuse a law of python-control, given as it stands, by whose sign the loop of these equations is unstable."""
    law = loop.controller
    if isinstance(law, LinearLaw) and law.stands and law.recursion == recursion and not law.follows.size:
        turned = replace(loop, controller=opposite(law))
        refuse_wrong_sign(law.system, equations(loop), equations(turned))


def _refuse_instants(loop: ClosedLoop, outside: InjectedSignals) -> None:
    """Refuse a loop in continuous time with a block that moves at instants alone."""
    refuse_instants(loop.plant)
    refuse_inputs_of_recursion(loop, outside)
    for part in (loop.plant, loop.observer, loop.controller):
        if is_recursion(part):
            cut = outside.cut_signals.size
            way = "digital(period, at=...)` in place of `cut()" if cut else "digital(period)` in place of `ode()"
            raise ValueError(
                f"`{type(part).__name__}` is a recursion in discrete time, which only a computer runs: take "
                f"`ClosedLoop.{way}`."
            )


def _around(closed_loop: ClosedLoop, name: str, outside: InjectedSignals) -> Ode:
    _refuse_instants(closed_loop, outside)
    lifted = lift(closed_loop)
    loop, states, inputs = lifted.block, wiring.memory(closed_loop), closed_loop.plant.inputs
    observer, law = loop.observer, loop.controller
    t, x = ca.SX.sym("t"), states.symbols()
    z = wiring.split(states.view(x))

    ref = outside.inject("references", wiring.reference_signals(loop, t))
    y = wiring.measurements(loop, t, z["plant"])
    seen, est = wiring.estimates(loop, t, z["observer"], outside.inject("readings", y))
    u = wiring.commands(loop, t, z["controller"], est, ref)
    acts = outside.inject("inputs", u)
    moves = {"plant": wiring.call_block(loop.plant, "rate", closed_loop.plant.states, t, z["plant"], acts)}
    told, heard, followed = u.only(observer.inputs), est.only(law.reads), ref.only(law.follows)
    moves["observer"] = wiring.call_block(observer, "rate", observer.memory, t, z["observer"], seen, est, told)
    moves["controller"] = wiring.call_block(law, "rate", law.memory, t, z["controller"], heard, followed)

    def outputs_of_loop() -> Outputs:
        applied = wiring.call_block(loop.plant, "applied_inputs", inputs, t, z["plant"], acts)
        return wiring.loop_outputs(loop, y, ref, est, u, applied, wiring.signals(loop, z["controller"], est, ref))

    outputs, watched = outside.outputs(y | u, outputs_of_loop)
    parameters, p = lifted.layout + outside.layout, ca.vertcat(lifted.symbols, outside.symbols)
    equations = (t, x, p, states.flatten(wiring.prefix_names(moves)), outputs.flatten(watched))
    return Ode(
        name,
        states,
        parameters,
        outputs,
        *equations,
        inputs=outside.layout.names,
        notes=wiring.notes(closed_loop, continuous=True),
        follows=() if outside.cut_signals.size else closed_loop.follows,
        drives=inputs.names,
        measures=wiring.measures(closed_loop),
        differences=wiring.differences(closed_loop),
        power=wiring.power(closed_loop),
        horizon=wiring.horizon(closed_loop),
        counts=closed_loop.plant.counts,
        drawing=wiring.plant_drawing(loop.plant, t, z["plant"], p, parameters),
        origins=origins(closed_loop),
    )
