"""Planar arms of n links under a reference: loops of any size, to see how compile time grows."""

from __future__ import annotations

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Ode
from workbench.core.dynamics import solve_definite


def inverse_dynamics(q: ca.SX, qd: ca.SX, qdd: ca.SX, mass: ca.SX, length: ca.SX, gravity: ca.SX) -> ca.SX:
    """The torques (n, 1) of a motion: accelerations outwards, forces inwards.

    Point masses at the ends of massless links, the first angle from the downward vertical.

    References
    ----------
    Featherstone (2008), Rigid Body Dynamics Algorithms, section 5.3.
    """
    angle, speed, turn = (ca.cumsum(v) for v in (q, qd, qdd))
    forward, outward = ca.horzcat(ca.cos(angle), ca.sin(angle)), ca.horzcat(ca.sin(angle), -ca.cos(angle))
    end, ends = ca.horzcat(ca.SX(0), gravity), []
    for i in range(q.numel()):
        end = end + length[i] * (turn[i] * forward[i, :] - speed[i] ** 2 * outward[i, :])
        ends.append(end)
    force, torque, torques = ca.SX.zeros(1, 2), ca.SX(0), []
    for i in reversed(range(q.numel())):
        force = force + mass[i] * ends[i]
        torque = torque + length[i] * (outward[i, 0] * force[1] - outward[i, 1] * force[0])
        torques.append(torque)
    return ca.vertcat(*reversed(torques))


def mass_matrix(q: ca.SX, mass: ca.SX, length: ca.SX) -> ca.SX:
    """M (n, n), column by column the torque of one acceleration alone."""
    n, rest = q.numel(), ca.SX.zeros(q.numel())
    columns = (inverse_dynamics(q, rest, ca.SX.eye(n)[:, i], mass, length, ca.SX(0)) for i in range(n))
    return ca.horzcat(*map(ca.densify, columns))


def chain(n: int) -> Ode:
    """An arm of n links that follows sines by proportional and derivative action."""
    states = Layout((Entry("q", np.zeros(n), "rad"), Entry("qd", np.zeros(n), "rad/s")))
    parameters = Layout(
        (
            Entry("mass", np.ones(n), "kg"),
            Entry("length", np.ones(n), "m"),
            Entry("gravity", np.array(9.81), "m/s^2"),
            Entry("Kp", np.full(n, 400.0), "N m/rad"),
            Entry("Kd", np.full(n, 80.0), "N m s/rad"),
        )
    )
    t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
    q, qd, c = x[:n], x[n:], parameters.view(p)
    e = q - 0.5 * ca.sin(t * ca.DM(range(1, n + 1)) / n)
    tau = -c["Kp"] * e - c["Kd"] * qd
    bias = inverse_dynamics(q, qd, ca.SX.zeros(n), c["mass"], c["length"], c["gravity"])
    qdd = solve_definite(mass_matrix(q, c["mass"], c["length"]), tau - bias)
    return Ode.of(f"{n} links", states, parameters, (t, x, p), {"q": qd, "qd": qdd}, {"e": e, "tau": tau})
