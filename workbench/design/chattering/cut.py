"""Where a loop is cut: its linear part from the switched torque of one joint to the sliding variable of that joint."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from workbench.core import Ode, Step
from workbench.design.certificates import Refused
from workbench.design.chattering.linear_part import LinearPart
from workbench.validation.refusals import Array, known, positive, require, vector
from workbench.validation.signatures import door

REST = 1e-8  # how far from rest a state may be, by the rate at which the linear loop would move it
INSTANTS = (0, 1009)  # at which a rest is asked for; nothing may depend on time


@door
def cut(
    loop: Ode | Step,
    x: Any,
    p: Any = None,
    *,
    gain: str = "controller.K[0]",
    variable: str = "s[0]",
    width: str = "controller.phi",
) -> LinearPart:
    """The linear part W of a loop at rest whose law has a switched term -K sat(s / phi), from that term to s; exact.

    Within the layer the linear loop is A(K) = A(0) - (K / phi) b c, so two Jacobians of the whole loop give W: c is
    that of s, b follows from A(phi) - A(0). Everything else of the loop stays as it is: the lag of its
    drives, the observer, the other joints with their own layers; a `Step` of a sampled loop keeps its
    hold and its delay. The loop must have a smooth or clipped layer, even if the relay is to be studied.

    Parameters
    ----------
    x, p
        The state (nx,) at rest with s = 0, and the parameters (np,). A sampled loop's held states settle by themselves.
    gain, variable, width
        What the loop calls K, s and phi: labels of a parameter, of an output, and of a parameter.

    Raises
    ------
    Refused
        If the state is no rest, the gain does not act, or it does not act as -K sat(s / phi) does.
    ValueError
        If x or p has not its size, or W cannot be a `LinearPart`.
    LookupError
        If a label is none of the loop's.
    """
    if not isinstance(loop, Step):
        require("cut(loop=...)", loop, Ode, ": a loop becomes one by its method `ode()`, or a `Step` by `sampled(...)`")
    point = vector("cut(x=...)", x, loop.states.size, "states")
    row = loop.parameters.default if p is None else vector("cut(p=...)", p, loop.parameters.size, "parameters")
    place, phi = _label(loop.parameters.labels, gain), float(row[_label(loop.parameters.labels, width)])
    after, A, C = _functions(loop)
    off, on = row.copy(), row.copy()
    off[place], on[place] = 0.0, positive(f"cut(width='{width}')", phi)
    point = _rest(loop, after, point, off)
    loose, held = (np.array(A(INSTANTS[0], point, values)) for values in (off, on))
    c = np.array(C(INSTANTS[0], point, off))[_label(loop.outputs.labels, variable)]
    _check_rest(after, A, point, off, isinstance(loop, Step))
    b = _driven(loose - held, c, f"cut(gain='{gain}', variable='{variable}', width='{width}')")
    return LinearPart(loose, b, c, loop.h if isinstance(loop, Step) else 0.0)


def _driven(step: Array, c: Array, call: str) -> Array:
    """The b of b c = A(0) - A(phi), or a refusal where that is no such product."""
    if not np.any(c) or not np.any(step):
        raise Refused(
            f"`{call}` must close a linear loop, and has no effect at this state: a "
            "law with saturation='sign' has no derivative. Cut the loop of the same law with 'clip'."
        )
    b: Array = step @ c / (c @ c)
    if np.abs(step - np.outer(b, c)).max() > 1e-9 * np.abs(step).max():
        raise Refused(
            f"`{call}` must be a term -K sat(s / phi) with these "
            "three; what the gain multiplies here is not this s alone."
        )
    return b


def _functions(loop: Ode | Step) -> tuple[ca.Function, ca.Function, ca.Function]:
    """What the state becomes (or its rate), its Jacobian, and the outputs' Jacobian, each of (t or k, x, p)."""
    if isinstance(loop, Ode):
        return loop.f, loop.A, loop.Cy
    rule = loop.rule
    symbols = [rule.k, rule.x, rule.p]
    noiseless = ca.substitute(
        ca.vertcat(rule.next, rule.output),
        ca.vertcat(rule.t, rule.h, rule.w),
        ca.vertcat(rule.k * loop.h, loop.h, ca.SX.zeros(rule.w.numel())),
    )
    after, output = ca.vertsplit(noiseless, [0, loop.states.size, noiseless.numel()])
    return (
        ca.Function("after", symbols, [after]),
        ca.Function("A", symbols, [ca.densify(ca.jacobian(after, rule.x))]),
        ca.Function("Cy", symbols, [ca.densify(ca.jacobian(output, rule.x))]),
    )


def _rest(loop: Ode | Step, after: ca.Function, x: Array, p: Array) -> Array:
    """The state, with what a computer holds brought up to date."""
    if isinstance(loop, Step):
        for _ in range(3):
            x = np.array(after(INSTANTS[0], x, p)).ravel()
    return x


def _check_rest(after: ca.Function, A: ca.Function, x: Array, p: Array, recursion: bool) -> None:
    for t in INSTANTS:
        moved = np.array(after(t, x, p)).ravel() - (x if recursion else 0.0)
        scale = max(1.0, float(np.abs(np.array(A(t, x, p))).max())) * max(1.0, float(np.abs(x).max()))
        if not np.abs(moved).max() <= REST * scale:
            i = int(np.argmax(np.abs(moved)))
            raise Refused(
                f"`cut(x=...)` must be a rest of the loop, about which it chatters; state {i} moves by "
                f"{moved[i]:.3g} {'in one period' if recursion else 'a second'}. Hold the reference, set the drives "
                "to what rest needs."
            )


def _label(labels: tuple[str, ...], name: str) -> int:
    return labels.index(known(name, labels, "labels of this loop"))
