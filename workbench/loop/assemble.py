"""Once round the loop: blocks in their sockets become one `Ode`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Ode, block, lift
from workbench.core.sockets import require
from workbench.loop.contracts import AbstractController, AbstractObserver, AbstractPlant, AbstractReference
from workbench.loop.ports import Measurement, Parts

UNITS = {
    "q": "rad",
    "qd": "rad/s",
    "q_ref": "rad",
    "qd_ref": "rad/s",
    "e": "rad",
    "e_hat": "rad",
    "ed": "rad/s",
    "tau": "N m",
    "tau_applied": "N m",
    "d": "N m",
    "q_error": "rad",
    "qd_error": "rad/s",
    "d_error": "N m",
    "s": "rad/s",
}


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

    def ode(self, name: str = "loop") -> Ode:
        """The closed loop as x' = f(t, x, p), every parameter a symbol keyed by its path.

        The outputs are the motion (q, qd), the wanted one (q_ref, qd_ref), the tracking error
        e = q - q_ref and its rate ed, the error e_hat that the observer sees, the torque commanded
        (tau) and applied (tau_applied), the disturbance d, the observer's errors (q_error, qd_error,
        d_error: true minus estimated), and the controller's own signals.
        """
        lifted = lift(self)
        loop = lifted.block
        layouts = {"plant": self.plant.memory, "observer": self.observer.memory, "controller": self.controller.memory}
        states = sum((layout.prefixed(f"{socket}.") for socket, layout in layouts.items()), Layout())
        t, x = ca.SX.sym("t"), states.symbols()
        z = {socket: _parts(states.view(x), f"{socket}.") for socket in layouts}

        ref = loop.reference.at(t)
        y = loop.plant.measure(t, z["plant"])
        d = y.d if y.d is not None else ca.SX.zeros(self.plant.dof)
        seen = y if self.observer.uses_truth else y._replace(d=None)
        est = loop.observer.estimate(t, z["observer"], seen)
        tau = ca.densify(loop.controller.torque(t, z["controller"], est, ref))
        rates = {
            "plant": loop.plant.rate(t, z["plant"], tau),
            "observer": loop.observer.rate(t, z["observer"], seen, est, tau),
            "controller": loop.controller.rate(t, z["controller"], est, ref),
        }
        outputs = {
            "q": y.q,
            "qd": y.qd,
            "q_ref": ref.q,
            "qd_ref": ref.qd,
            "e": y.q - ref.q,
            "e_hat": est.q - ref.q,
            "ed": y.qd - ref.qd,
            "tau": tau,
            "tau_applied": loop.plant.applied(z["plant"], tau),
            "d": d,
            "q_error": y.q - est.q,
            "qd_error": y.qd - est.qd,
            "d_error": d - est.d,
            **loop.controller.signals(z["controller"], est, ref),
        }
        ode = Ode.of(name, states, lifted.layout, (t, x, lifted.symbols), _flat(rates), _dense(outputs), UNITS)
        truth = ("the observer uses the true disturbance, which no instrument gives",)
        return replace(ode, notes=truth) if self.uses_truth else ode


def open_loop(plant: AbstractPlant, name: str = "plant") -> Ode:
    """The plant alone, driven by the torque 'tau' (n,), which is a parameter and the declared input.

    Raises
    ------
    ValueError
        If `plant` is none.
    """
    require("open_loop(plant=...)", plant, AbstractPlant)
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
        _dense({"q": y.q, "qd": y.qd}),
        UNITS,
    )
    return replace(ode, inputs=("tau",))


def _parts(view: Parts, prefix: str) -> Parts:
    return {name.removeprefix(prefix): part for name, part in view.items() if name.startswith(prefix)}


def _flat(rates: Mapping[str, Parts]) -> Parts:
    return {f"{socket}.{name}": part for socket, parts in rates.items() for name, part in parts.items()}


def _dense(parts: Mapping[str, ca.SX | None]) -> dict[str, ca.SX]:
    return {name: ca.densify(ca.SX(part)) for name, part in parts.items() if part is not None}
