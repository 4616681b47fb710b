"""Once round the loop: blocks in their sockets become one `Ode`, or a computer's part of them one `Sampled`."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Ode, Roles, Sampled, Step, block, lift
from workbench.loop.contracts import AbstractController, AbstractObserver, AbstractPlant, AbstractReference
from workbench.loop.instruments import Instruments
from workbench.loop.ports import Measurement
from workbench.loop.roles import roles
from workbench.loop.sampled import FINE, digital
from workbench.loop.wiring import SOCKETS, UNITS, above, below, dense, memory, notes, outputs, signals, visible
from workbench.validation.doors import door
from workbench.validation.words import one_of, seconds


@block
class ClosedLoop:
    """A plant, an observer, a controller and a wanted motion, all of the same number of joints."""

    plant: AbstractPlant
    observer: AbstractObserver
    controller: AbstractController
    reference: AbstractReference

    def __post_init__(self) -> None:
        sizes = {socket: getattr(self, socket).dof for socket in ("plant", "observer", "controller", "reference")}
        if len(set(sizes.values())) > 1:
            raise ValueError(
                "`ClosedLoop(...)` needs blocks of the same number of joints; got "
                + ", ".join(f"{socket} with {n}" for socket, n in sizes.items())
                + "."
            )

    @property
    def uses_truth(self) -> bool:
        """Whether the observer needs what no instrument can give it."""
        return self.observer.uses_truth

    @property
    def roles(self) -> Roles:
        """What the law is given, see `roles`."""
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

    def ode(self, name: str = "loop") -> Ode:
        """The closed loop as x' = f(t, x, p), every parameter a symbol keyed by its path.

        The outputs are the motion (q, qd), the wanted one (q_ref, qd_ref), the tracking error
        e = q - q_ref and its rate ed, the error e_hat that the observer sees, the torque commanded
        (tau) and applied (tau_applied), the disturbance d, the observer's errors (q_error, qd_error,
        d_error: true minus estimated), and the controller's own signals.

        Raises
        ------
        ValueError
            If the law is one that only a computer can run, as an implicit relay is, or calls a signal of its
            own as the loop calls one.
        """
        return _around(self, name, broken=False)

    def broken(self, name: str = "loop") -> Ode:
        """The loop cut at the plant's input: the plant moves by the torque 'drive' (n,), the declared input.

        The only output is the torque 'tau' that the controller commands, which the observer counts on. With
        drive = tau the loop is that of `ode`; its gain is L, from drive to -tau.

        Raises
        ------
        ValueError
            If the law is one that only a computer can run.
        """
        return _around(self, name, broken=True)

    def digital(
        self,
        period: float,
        instruments: Instruments | None = None,
        *,
        delay: bool = False,
        integrator: str = "declared",
        name: str = "loop",
    ) -> Sampled:
        """The closed loop with observer and controller in a computer, which runs them once in `period` seconds.

        At t_k = k period the computer reads the instruments, and its observer estimates from the readings;
        the law sees the estimates and the reference of that instant; its torque, limited, is held until
        t_(k+1) while the plant moves. With `delay` the torque computed at t_k waits as the state 'hold.next'
        and is held from t_(k+1) on; what that state is at the start, zero unless set, is held until t_1.
        Then observer and controller move their memories on by the method that each declares, explicit Euler unless
        it has an `integrator` of its own; the observer counts on the torque that is held. `methods` of what comes
        back names them.

        The outputs are those of `ode`. The estimates and the controller's own signals are held as the torque
        is ('hold.tau', 'hold.q_hat', ...), so between two instants q_error, say, is that of an old estimate.

        Parameters
        ----------
        instruments
            Noise and steps of the readings, limits of the torque; without any, readings are exact.
        integrator
            "declared", or "fine" for 16 Runge-Kutta steps a period through all memories, with readings, estimate,
            reference and torque held: near the exact flow of their own equations, which tells what diverges by its
            integrator from what diverges by its law.

        Raises
        ------
        ValueError
            If the period is no positive finite number, the instruments are none or for other joints, `delay` is
            neither True nor False, the integrator is neither of the two, "fine" is asked of a law whose memory has
            no rate in continuous time, or the law calls a signal of its own as the loop calls one.
        """
        fine = one_of("ClosedLoop.digital(integrator=...)", integrator, ("declared", "fine")) == "fine"
        length = seconds("ClosedLoop.digital(period=...)", period)
        return digital(self, length, instruments, delay, FINE if fine else 0, name)

    def sampled(
        self,
        period: float,
        substeps: int = 1,
        instruments: Instruments | None = None,
        *,
        delay: bool = False,
        name: str = "loop",
    ) -> Step:
        """One period of `digital` as a `Step`, in which the plant moves by `substeps` Runge-Kutta steps.

        Raises
        ------
        ValueError
            If `digital` refuses, or `substeps` is no positive whole number.
        """
        return self.digital(period, instruments, delay=delay, name=name).step(substeps)


def _around(closed: ClosedLoop, name: str, *, broken: bool) -> Ode:
    """Once round a loop, whose plant moves by the controller's torque or, where it is broken, by one from outside."""
    lifted = lift(closed)
    loop, states = lifted.block, memory(closed)
    outside = Layout((Entry("drive", np.zeros(closed.plant.dof), "N m"),)) if broken else Layout()
    t, x, drive = ca.SX.sym("t"), states.symbols(), outside.symbols()
    z = {socket: below(socket, states.view(x)) for socket in SOCKETS}

    ref = loop.reference.at(t)
    y = loop.plant.measure(t, z["plant"])
    seen = visible(closed, y)
    est = loop.observer.estimate(t, z["observer"], seen)
    tau = ca.densify(loop.controller.torque(t, z["controller"], est, ref))
    rates = {
        "plant": loop.plant.rate(t, z["plant"], drive if broken else tau),
        "observer": loop.observer.rate(t, z["observer"], seen, est, tau),
        "controller": loop.controller.rate(t, z["controller"], est, ref),
    }
    watched = (
        {"tau": tau}
        if broken
        else {
            **outputs(y, ref, est, tau, loop.plant.applied(z["plant"], tau)),
            **signals(loop.controller, z["controller"], est, ref),
        }
    )
    symbols = (t, x, ca.vertcat(lifted.symbols, drive))
    ode = Ode.of(name, states, lifted.layout + outside, symbols, above(rates), dense(watched), UNITS)
    return replace(ode, notes=notes(closed), inputs=outside.names)


@door
def open_loop(plant: AbstractPlant, name: str = "plant") -> Ode:
    """The plant alone, driven by the torque 'tau' (n,), which is a parameter and the declared input.

    Raises
    ------
    ValueError
        If `plant` is none.
    """
    lifted = lift(plant)
    drive = Layout((Entry("tau", np.zeros(plant.dof), "N m"),))
    tau = drive.symbols()
    states = plant.memory
    t, x = ca.SX.sym("t"), states.symbols()
    z = states.view(x)
    y: Measurement = lifted.block.measure(t, z)
    ode = Ode.of(
        name,
        states,
        lifted.layout + drive,
        (t, x, ca.vertcat(lifted.symbols, tau)),
        lifted.block.rate(t, z, tau),
        dense({"q": y.q, "qd": y.qd}),
        UNITS,
    )
    return replace(ode, inputs=("tau",))
