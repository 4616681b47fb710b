"""A period of a plant as a predictive law sees it: Runge-Kutta steps of the plant's own rate, and their Jacobians."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from workbench.blocks.loop.contracts import AbstractPlant
from workbench.blocks.loop.wiring import call_block
from workbench.core import Layout, Signals
from workbench.core.bounded_loop import bounded_loop
from workbench.core.methods import runge_kutta


@dataclass(frozen=True)
class PlantStages:
    """x+ = F(t, x, u), classical Runge-Kutta steps of a plant over a period with held inputs.

    Parameters
    ----------
    model
        The plant, or its twin with symbols.
    period
        The period in s.
    steps
        The number of steps in it. Several steps are a loop of the graph.
    """

    model: AbstractPlant
    period: float
    steps: int

    def rate(self, t: ca.SX, x: ca.SX, u: ca.SX) -> ca.SX:
        """The rate of the plant, (nx, 1)."""
        signals = Signals(self.model.states.view(x)), Signals(self.model.inputs.view(u))
        port = self.model.states
        return ca.densify(port.flatten(call_block(self.model, "rate", port, t, *signals)))

    def after(self, t: ca.SX, x: ca.SX, u: ca.SX) -> ca.SX:
        """The states (nx, 1) after a period."""
        h = self.period / self.steps
        if self.steps == 1:
            return runge_kutta(self.rate, t, x, u, h)
        nx = x.numel()

        def step(both: ca.SX, own: ca.SX) -> tuple[ca.SX, ...]:
            return (ca.vertcat(runge_kutta(self.rate, both[nx], both[:nx], own, h), both[nx] + h),)

        (end,) = bounded_loop(self.steps, step, ca.vertcat(x, t), constants=(u,))
        return end[:nx]

    def after_with_slopes(self, t: ca.SX, x: ca.SX, u: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
        """The states (nx, 1) after a period with their exact Jacobians by x and u, (nx, nx) and (nx, nu).

        They are the Runge-Kutta steps of the states and of their sensitivities together, S' = f_x S + [0 f_u].
        """
        nx, nu, h = x.numel(), u.numel(), self.period / self.steps
        s, w = ca.SX.sym("s", nx), ca.SX.sym("w", nu)
        time = ca.SX.sym("time")
        rate = self.rate(time, s, w)
        slope = ca.densify(ca.jacobian(rate, ca.vertcat(s, w)))

        def rates(t: ca.SX, z: ca.SX, own: ca.SX) -> ca.SX:
            f, J = ca.substitute([rate, slope], [time, s, w], [t, z[:nx], own])
            S = ca.reshape(z[nx:], nx, nx + nu)
            return ca.vertcat(f, ca.vec(J[:, :nx] @ S + ca.horzcat(ca.SX.zeros(nx, nx), J[:, nx:])))

        start = ca.vertcat(x, ca.vec(ca.horzcat(ca.SX.eye(nx), ca.SX.zeros(nx, nu))))
        if self.steps == 1:
            end = runge_kutta(rates, t, start, u, h)
        else:
            size = start.numel()

            def step(both: ca.SX, own: ca.SX) -> tuple[ca.SX, ...]:
                return (ca.vertcat(runge_kutta(rates, both[size], both[:size], own, h), both[size] + h),)

            (end,) = bounded_loop(self.steps, step, ca.vertcat(start, t), constants=(u,))
        S = ca.reshape(end[nx : nx + nx * (nx + nu)], nx, nx + nu)
        return end[:nx], S[:, :nx], S[:, nx:]


def signals_of(model: AbstractPlant) -> Layout:
    """The states of a model, and its outputs that are no states."""
    states = model.states
    return states + Layout(tuple(entry for entry in model.outputs.entries if entry.name not in states))


def limited_rows(model: AbstractPlant, labels: tuple[str, ...], t: ca.SX, x: ca.SX) -> ca.SX:
    """The states and outputs with these labels at states x (nx, 1), (nr, 1)."""
    if not labels:
        return ca.SX(0, 1)
    values, port = Signals(model.states.view(x)), model.states
    if any(label not in port.labels for label in labels):
        port, outputs = signals_of(model), model.outputs + model.truths
        values = call_block(model, "measure", outputs, t, values) | values
    column = port.flatten({name: values[name] for name in port.names})
    return ca.densify(ca.vertcat(*(column[port.labels.index(label)] for label in labels)))
