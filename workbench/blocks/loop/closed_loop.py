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
from workbench.blocks.loop.port_checks import refuse_instants, refuse_misfits, refuse_odd_ports, refuse_shared_names
from workbench.blocks.loop.sampled_loop import FINE, INTEGRATORS, digital
from workbench.core import Ode, Roles, SampledSystem, Signals, block, lift
from workbench.core.block import Vector, socket
from workbench.core.ode import time_beside
from workbench.core.publications import origins
from workbench.core.validation.refusals import one_of, refusal, seconds
from workbench.core.validation.signatures import check_arguments


@block
class ClosedLoop:
    """A plant, an observer, a controller and a reference, whose ports fit one another.

    A linear system of python-control stands for its `LinearPlant`, `LinearFilter` or `LinearLaw`: as a law it is given
    y, as that of `lqg` is, and not the error. Where there is no observer, the law reads what the instruments read;
    where there is no reference, it follows nothing.

    Raises
    ------
    ValueError
        If there is no plant or no controller; if a block asks for a signal that no other gives, or in another shape
        or unit; if an input of the plant is driven by nothing, or a reference followed by nothing; if a name means two
        things; or if a law of python-control, as it stands, makes the loop unstable, and its opposite does not.

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
        """The outputs of the plant that the law is to make follow the reference."""
        law, outputs = self.controller.follows, self.plant.outputs
        return tuple(name for name in self.reference.primary if name in law and name in outputs)

    @property
    def roles(self) -> Roles:
        """The inputs that reach the law's command, see `roles`."""
        return roles(self)

    def ablations(self) -> dict[str, ClosedLoop]:
        """The loop less each part that its observer and its controller are made of, by the name of the part.

        A loop without the state observer is given exact positions and velocities. Parts that are one number of the
        equations, as an integral gain is, are gone where that is zero.

        Raises
        ------
        ValueError
            If observer and controller call a part of theirs by one name.
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
        """The closed loop as x' = f(t, x, p), every parameter a symbol keyed by its path.

        The outputs are those of the plant, and of each what is wanted (`x_ref`), the error e_x = x - x_ref and the same
        by the estimate, e_hat_x = x_hat - x_ref; commands and what acts (`u_applied`); the truths; the errors of the
        observer, x_error = x - x_hat, true minus estimated; and the law's own signals. An arm calls e_q, e_qd and
        e_hat_q e, ed and e_hat.

        With `inputs` there are parameters, zero unless set, for what is added to each wanted signal (`x_ref`), to each
        input where it acts (`u_load`) and to each reading (`x_noise`): the declared inputs. With `at` the loop is cut
        as by `cut`; with both, 'drive' comes first among the inputs, and the outputs are what arrives at the cut and
        then all others.

        Raises
        ------
        ValueError
            If the law is one that only a computer can run, or calls a signal of its own as the loop calls one.
        LookupError
            If a name of `at` is none of an input or an output.
        """
        return _around(self, name, injected_signals("ClosedLoop.ode", self, inputs, at))

    def cut(self, name: str = "loop", *, at: str | tuple[str, ...] | None = None) -> Ode:
        """The loop cut by the declared input 'drive' at inputs of the plant, all unless named by `at`, or at outputs.

        The outputs are the signals that arrive at the cut, in the same order: commands, which the observer still counts
        on, or outputs of the plant. With drive = output the loop is that of `ode`; its gain L is from drive to -output.

        Raises
        ------
        ValueError
            If the law is one that only a computer can run.
        LookupError
            If a name is none of an input or an output.
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
        """The closed loop with observer and controller in a computer, which runs them once in `period` seconds.

        At t_k = k period the computer reads the instruments, and its observer estimates from the readings; the law sees
        the estimates and the reference of that instant; its command, limited, is held until t_(k+1) while the plant
        moves. Then observer and law move their memories by their `methods`; the observer counts on the command that is
        held. A block with a `period` of its own, a whole multiple of this one, runs once in that. The outputs are those
        of `ode`; commands, estimates and the law's own signals are held ('hold.tau', 'hold.q_hat', ... of an arm).

        Parameters
        ----------
        instruments
            Noise and steps of the readings, limits of the commands; without any, readings are exact.
        delay, initial_commands
            True if a command waits a period; or how many, a whole number for all inputs, or one for each that is named.
            They wait at 'hold.next.2', ..., 'hold.next'; at first `initial_commands` by input, else the inputs' own.
        integrator
            "declared", or "fine" for 16 Runge-Kutta steps a period through all memories, with readings, estimate,
            reference and command held: near their exact flow, which tells what diverges by its integrator.
        inputs, at
            As of `ode`: signals from outside, which are held over a period.

        Raises
        ------
        ValueError
            If the period is no positive finite number, or does not divide that of a block; the instruments are none or
            for another plant; the delay is no whole number of periods; a waiting command has another shape or no delay;
            the integrator is neither of the two; the law calls a signal of its own as the loop calls one; or signals
            from outside meet the inputs of a plant in discrete time.
        LookupError
            If a delay or a waiting command is for a name that is no input of the plant.
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


@check_arguments
def open_loop(plant: AbstractPlant, name: str = "plant") -> Ode:
    """The plant alone, driven by its inputs, which are parameters and the declared inputs.

    Raises
    ------
    ValueError
        If `plant` is none, moves in discrete time, or has one name for two of its states, inputs and parameters.

    Examples
    --------
    >>> wb.open_loop(wb.CartPole()).inputs, wb.open_loop(wb.CartPole()).outputs.names
    (('F',), ('x', 'phi'))
    """
    if is_recursion(plant):
        raise ValueError(
            f"`{type(plant).__name__}` moves in discrete time and has no rate: take it in a `digital` loop."
        )
    refuse_instants(plant)
    refuse_shared_names(plant)
    lifted = lift(plant)
    states, inputs, outputs = plant.states, plant.inputs, plant.outputs
    u, t, x = inputs.symbols(), time_beside(states, inputs, lifted.layout), states.symbols()
    z = Signals(states.view(x))
    rate = wiring.call_block(lifted.block, "rate", states, t, z, Signals(inputs.view(u)))
    y = wiring.call_block(lifted.block, "measure", outputs + plant.truths, t, z)
    watched = outputs.flatten({name: ca.densify(part) for name, part in y.only(outputs).items()})
    p = ca.vertcat(lifted.symbols, u)
    equations, ends = (t, x, p, states.flatten(rate), watched), wiring.horizon(plant)
    ode = Ode(name, states, lifted.layout + inputs, outputs, *equations, inputs=inputs.names, horizon=ends)
    drawing = wiring.plant_drawing(lifted.block, t, z, p, ode.parameters)
    return replace(ode, counts=plant.counts, drawing=drawing, origins=origins(plant))
