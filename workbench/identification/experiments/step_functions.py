"""Steps with the derivatives by all unknown numbers in one state, for derivatives of these by the inputs."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import casadi as ca
import numpy as np

from workbench.core import Ode
from workbench.core.recorded_step import SignalRecord, recorded_step


class StepFunctions(NamedTuple):
    """Functions of one step along a record; X = [x; vec S] with the derivatives S (nx, nz) by unknown numbers."""

    plain: ca.Function  # (x, d, p) -> x+
    wide: ca.Function  # (X, d, p) -> X+
    slopes: ca.Function  # (x, d, p) -> derivatives of x+ by x and d, row by row
    outputs: ca.Function  # (X, t, u, p) -> derivatives of the outputs by the numbers, vec (ny, nz)
    pulls: ca.Function  # (X, t, u, p, G) -> derivatives of sum(G * those) by X and u


@lru_cache(maxsize=16)
def step_functions(
    ode: Ode, inputs: tuple[str, ...], kinds: tuple[tuple[str, str], ...], outputs: tuple[tuple[str, str], ...]
) -> StepFunctions:
    """The functions of an equation, for inputs by label, numbers by kind and label, and outputs."""
    record = SignalRecord(np.arange(2.0), inputs, np.zeros((1, len(inputs))), np.zeros((1, len(inputs))))
    rule, nx, nz = recorded_step(ode, record).rule, ode.states.size, len(kinds)
    x, p, d = rule.x, rule.p, rule.d
    S = ca.SX.sym("S", nx, nz)
    X = ca.vertcat(x, ca.vec(S))
    after = rule.F(1.0, 0.0, x, p, ca.SX(0, 1), d)
    by_p, unit = ca.jacobian(after, p), _parameter_columns(ode, kinds)
    direct = by_p @ unit + _delay_columns(after, d, inputs, kinds)
    wide = ca.vertcat(after, ca.vec(ca.jacobian(after, x) @ S + direct))
    plain = ca.Function("plain", [x, d, p], [ca.densify(after)], {"cse": True})
    slopes = ca.densify(ca.jacobian(after, ca.vertcat(x, d)))
    J, t, u = _outputs(ode, inputs, kinds, outputs, X, S)
    G = ca.SX.sym("G", *J.shape)
    pulls = ca.gradient(ca.dot(G, J), ca.vertcat(X, u))
    return StepFunctions(
        plain,
        ca.Function("wide", [X, d, p], [ca.densify(wide)], {"cse": True}),
        ca.Function("slopes", [x, d, p], [ca.vec(slopes.T)], {"cse": True}),
        ca.Function("derivatives", [X, t, u, p], [ca.densify(ca.vec(J))]),
        ca.Function("pulls", [X, t, u, p, ca.vec(G)], [ca.densify(pulls)]),
    )


def _delay_columns(after: ca.SX, d: ca.SX, inputs: tuple[str, ...], kinds: tuple[tuple[str, str], ...]) -> ca.SX:
    """(nx, nz), the derivatives of a step by delays: an input on a straight line is lower by its slope times the delay.

    d = [middle time, length, middles (nu), changes (nu)] of the step.
    """
    columns = ca.SX(after.numel(), len(kinds))
    for i, (kind, label) in enumerate(kinds):
        if kind == "delay":
            place = inputs.index(label)
            middle, change = d[2 + place], d[2 + len(inputs) + place]
            columns[:, i] = -ca.jacobian(after, middle) * (change / d[1])
    return columns


def _parameter_columns(ode: Ode, kinds: tuple[tuple[str, str], ...]) -> ca.DM:
    """(np, nz), a 1 where a number is a parameter."""
    unit = ca.DM.zeros(ode.p.numel(), len(kinds))
    for i, (kind, label) in enumerate(kinds):
        if kind == "parameter":
            unit[ode.parameters.labels.index(label), i] = 1.0
    return ca.sparsify(unit)


def _outputs(
    ode: Ode,
    inputs: tuple[str, ...],
    kinds: tuple[tuple[str, str], ...],
    outputs: tuple[tuple[str, str], ...],
    X: ca.SX,
    S: ca.SX,
) -> tuple[ca.SX, ca.SX, ca.SX]:
    """The derivatives (ny, nz) of the outputs by the numbers, and the symbols t and u of which they depend."""
    u, nx = ca.SX.sym("u", len(inputs)), ode.x.numel()
    labels = (*ode.states.labels, *ode.outputs.labels)
    y = ca.vertcat(ode.x, ode.output)[[labels.index(label) for _, label in outputs]]
    J = ca.densify(ca.jacobian(y, ode.x) @ S + ca.jacobian(y, ode.p) @ _parameter_columns(ode, kinds))
    names = [signal for signal, _ in outputs]
    for i, (kind, label) in enumerate(kinds):
        if kind in ("offset", "scale"):
            J[names.index(label), i] = 1.0 if kind == "offset" else y[names.index(label)]
    places = [ode.parameters.labels.index(label) for label in inputs]
    J = ca.substitute(J, ca.vertcat(ode.x, ode.p[places]), ca.vertcat(X[:nx], u))
    return J, ode.t, u


@lru_cache(maxsize=64)
def march(step: ca.Function, count: int) -> ca.Function:
    """The states after each of `count` steps, of the first state, the numbers of all steps, and the parameters."""
    start, p = ca.MX.sym("x", step.sparsity_in(0)), ca.MX.sym("p", step.sparsity_in(2))
    d = ca.MX.sym("d", step.size1_in(1), count)
    states = step.mapaccum(count)(start, d, ca.repmat(p, 1, count))
    return ca.Function("march", [start, d, p], [states])


@lru_cache(maxsize=64)
def backward(run: ca.Function) -> ca.Function:
    """The derivatives of sum(seeds * states) of a march by the numbers of its steps."""
    arguments = [ca.MX.sym(name, run.sparsity_in(i)) for i, name in enumerate("xdp")]
    states, seeds = (ca.MX.sym(name, run.sparsity_out(0)) for name in ("states", "seeds"))
    pulls = run.reverse(1)(*arguments, states, seeds)
    return ca.Function("backward", [*arguments, states, seeds], [pulls[1]])
