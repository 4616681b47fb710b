"""Once round a loop that a computer closes: what it does at an instant, and how the plant moves until the next."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Lifted, Ode, Sampled, lift
from workbench.loop.contracts import euler
from workbench.loop.instruments import Instruments
from workbench.loop.ports import Estimate, Parts
from workbench.loop.wiring import UNITS, Blocks, above, below, dense, memory, methods, notes, outputs, signals, visible

NEXT = "hold.next"  # the torque that waits for the next instant
FINE = 16  # steps of Runge-Kutta a period: stable up to 44 / period, where (34) at 500 N m and 4 ms has 23
HELD = {"tau": "N m", "q_hat": "rad", "qd_hat": "rad/s", "d_hat": "N m"} | UNITS


def digital(loop: Blocks, period: float, instruments: Instruments | None, delay: bool, fine: int, name: str) -> Sampled:
    """The loop as a flow and a jump, see `ClosedLoop.digital`."""
    joints = loop.plant.dof
    if instruments is not None and instruments.dof != joints:
        raise ValueError(
            f"`ClosedLoop.digital(instruments=...)` must be for the {joints} joints of the loop; got instruments for "
            f"{instruments.dof}."
        )
    lifted = lift(loop)
    gauges = Lifted(None, Layout(), ca.SX(0, 1)) if instruments is None else lift(instruments, "instruments.")
    own = memory(loop) + (Layout((Entry(NEXT, np.zeros(joints), "N m"),)) if delay else Layout())
    k, w = ca.SX.sym("k"), ca.SX.sym("w", instruments.entries if instruments is not None else 0)
    x = own.symbols()
    after = dense(_after(lifted.block, gauges.block, period, k, own.view(x), w, fine))
    held = Layout(tuple(_entry(key, part) for key, part in after.items() if key not in own))
    states, x = own + held, ca.vertcat(x, held.symbols())
    t = ca.SX.sym("t")
    rates, watched = _between(lifted.block, t, states.view(x))
    parameters, p = lifted.layout + gauges.layout, ca.vertcat(lifted.symbols, gauges.symbols)
    flow = Ode.of(name, states, parameters, (t, x, p), rates, dense(watched), UNITS)
    jump = states.flatten(after)
    return Sampled(replace(flow, notes=notes(loop)), period, k, w, jump, methods(loop, fine))


def _after(
    loop: Blocks, instruments: Instruments | None, period: float, k: ca.SX, z: Parts, w: ca.SX, fine: int
) -> dict[str, ca.SX]:
    """What the states z become at the instant t_k: all that the computer remembers and holds."""
    t, law = k * period, loop.controller.run_every(period)
    plant, observer, controller = (below(socket, z) for socket in ("plant", "observer", "controller"))
    ref = loop.reference.at(t)
    y = loop.plant.measure(t, plant)
    seen = visible(loop, y if instruments is None else instruments.read(y, w))
    est = loop.observer.estimate(t, observer, seen)
    tau = law.torque(t, controller, est, ref)
    if instruments is not None:
        tau = instruments.limited(tau)
    held = z.get(NEXT, tau)

    def observed(z: Parts) -> Parts:
        return loop.observer.rate(t, z, seen, loop.observer.estimate(t, z, seen), held)

    def adapted(z: Parts) -> Parts:
        return loop.controller.rate(t, z, est, ref)

    moved = {
        "observer": _refined(observed, observer, period, fine)
        if fine
        else loop.observer.advance(t, observer, seen, est, held, period),
        "controller": _refined(adapted, controller, period, fine)
        if fine
        else law.advance(t, controller, est, ref, period),
    }
    return {
        **above({"plant": plant}),
        **above(moved),
        **({NEXT: tau} if NEXT in z else {}),
        **above({"hold": {"tau": held, "q_hat": est.q, "qd_hat": est.qd, "d_hat": est.d}}),
        **above({"hold": {name: ca.vec(part) for name, part in signals(law, controller, est, ref).items()}}),
    }


def _refined(rate: Callable[[Parts], Parts], z: Parts, period: float, steps: int) -> Parts:
    """A memory after so many classical Runge-Kutta steps of a period together."""
    h = period / steps
    for _ in range(steps):
        a = rate(z)
        b = rate(euler(z, a, h / 2))
        c = rate(euler(z, b, h / 2))
        d = rate(euler(z, c, h))
        z = euler(z, {name: a[name] + 2 * b[name] + 2 * c[name] + d[name] for name in a}, h / 6)
    return z


def _between(loop: Blocks, t: ca.SX, z: Parts) -> tuple[dict[str, ca.SX], dict[str, ca.SX]]:
    """The rates of all states z between two instants, where only the plant moves, and what is watched then."""
    plant, held = below("plant", z), below("hold", z)
    tau, est = held.pop("tau"), Estimate(held.pop("q_hat"), held.pop("qd_hat"), held.pop("d_hat"))
    held.pop("next", None)
    still = {name: ca.SX.zeros(part.shape) for name, part in z.items()}
    rates = still | above({"plant": loop.plant.rate(t, plant, tau)})
    y, ref = loop.plant.measure(t, plant), loop.reference.at(t)
    return rates, {**outputs(y, ref, est, tau, loop.plant.applied(plant, tau)), **held}


def _entry(name: str, part: ca.SX) -> Entry:
    return Entry(name, np.zeros(part.numel()), HELD.get(name.removeprefix("hold."), ""))
