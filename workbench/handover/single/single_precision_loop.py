"""A sampled loop whose law computes in single precision, as a step of the engine: for sweeps of closed loops."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, SampledLaw, SampledSystem
from workbench.core.crossing import without_crossings
from workbench.core.numbers import Bounds
from workbench.core.validation.signatures import check_arguments

LARGEST = float(np.finfo(np.float64).max)
SPLIT = 2.0**29 + 1  # leaves 24 of 53 bits: Veltkamp's constant
UNIT = "computer.unit"  # 1, as a parameter that no simplification sees through
EXACT = {  # of numbers in single precision these are such numbers themselves
    ca.OP_ASSIGN, ca.OP_NEG, ca.OP_TWICE, ca.OP_FABS, ca.OP_SIGN, ca.OP_FLOOR, ca.OP_CEIL, ca.OP_FMIN, ca.OP_FMAX,
    ca.OP_COPYSIGN, ca.OP_IF_ELSE_ZERO, ca.OP_NOT, ca.OP_AND, ca.OP_OR, ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE,
}  # fmt: skip


@check_arguments
def in_single_precision(sampled_loop: SampledSystem, law: SampledLaw) -> SampledSystem:
    """The loop whose readings, references, memory and every operation of the law are rounded to single precision.

    Each operation is made in double precision and rounded to 24 bits, which is what a machine in single precision does
    with sums, products, quotients and roots (Figueroa 1995); sines, exponentials and the like are those of double
    precision, rounded, where a library in single precision may be off by a bit or two. Expressions of the time or of
    parameters alone are computed in double precision and rounded once. Overflow and underflow of a float are not
    modelled. The plant stays in double precision.

    Parameters
    ----------
    law
        The law of the same loop, `sampled_loop.law(...)`.

    Raises
    ------
    LookupError
        If the law is of another loop.

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> law = wb.PID(motor.outputs, motor.inputs, Kp=10.0, Ki=20.0)
    >>> loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0)).digital(0.01)
    >>> single = wb.handover.in_single_precision(loop, loop.law())
    >>> voltages = [wb.simulate(one.step(1), until=0.1)["hold.v"][0, -1, 0] for one in (loop, single)]
    >>> bool(0 < abs(voltages[0] - voltages[1]) < 1e-5)
    True

    References
    ----------
    Dekker (1971), A floating-point technique for extending the available precision, Numer. Math. 18, section 5.
    Figueroa (1995), When is double rounding innocuous?, ACM SIGNUM Newsletter 30(3).
    """
    unit, flow, states = ca.SX.sym("unit"), sampled_loop.flow, sampled_loop.states
    named = law.memory.names + law.commands.with_prefix("hold.").names
    places = [i for name in named for i in states.indices(name)]
    p = [i for name in law.parameters.names for i in sampled_loop.parameters.indices(name)]
    z = [i for name in law.memory.names for i in states.indices(name)]
    taken = sampled_loop.computer_inputs
    given = (
        sampled_loop.k,
        flow.x[z],
        ca.vertcat(*(ca.vec(taken[f"y.{name}"]) for name in law.readings.names), ca.SX(0, 1)),
        ca.vertcat(*(ca.vec(taken[f"r.{name}"]) for name in law.references.names), ca.SX(0, 1)),
        flow.p[p],
    )
    new = _rounded(law.F, given, unit)
    crossed = ca.vertcat(sampled_loop.after, flow.x[sampled_loop.jump.numel() :, 0])
    for i, part in zip(places, new, strict=True):
        crossed[i] = part
    one = Layout((Entry(UNIT, np.ones(()), "1", Bounds(1.0, 1.0)),))
    wider = replace(flow, parameters=flow.parameters + one, p=ca.vertcat(flow.p, unit))
    return replace(
        sampled_loop, flow=wider, jump=without_crossings(sampled_loop.crossings, crossed), crossing_jump=crossed
    )


def single(x: ca.SX, unit: ca.SX) -> ca.SX:
    """x rounded to 24 bits: (C x) + (x - C x), where each operation is rounded by itself."""
    if x.is_constant():
        return ca.SX(float(np.float32(float(x))))
    big = ca.fmin(SPLIT * x, LARGEST)  # no bare product, which a fused arithmetic would round together with the sum
    return big + unit * (x - big)


def _rounded(F: ca.Function, given: tuple[ca.SX, ...], unit: ca.SX) -> list[ca.SX]:
    """The outputs of a law (k, z, y, r, p) -> z+, u, one by one, in single precision."""
    values: dict[int, ca.SX] = {}  # of the places of work
    moving: dict[int, bool] = {}  # whether a value depends on more than time and parameters
    outputs: dict[tuple[int, int], ca.SX] = {}
    for number in range(F.n_instructions()):
        op, ins, outs = F.instruction_id(number), F.instruction_input(number), F.instruction_output(number)
        if op == ca.OP_CONST:
            values[outs[0]], moving[outs[0]] = ca.SX(F.instruction_constant(number)), False
        elif op == ca.OP_INPUT:
            moving[outs[0]] = 1 <= ins[0] <= 3
            value = given[ins[0]][ins[1]]
            values[outs[0]] = single(value, unit) if moving[outs[0]] else value
        elif op == ca.OP_OUTPUT:
            value = values[ins[0]]
            outputs[outs[0], outs[1]] = value if moving[ins[0]] else single(value, unit)
        else:
            moves = any(moving[i] for i in ins)
            parts = [values[i] if moving[i] or not moves else single(values[i], unit) for i in ins]
            value = ca.SX.binary(op, *parts) if len(parts) == 2 else ca.SX.unary(op, *parts)
            values[outs[0]] = single(value, unit) if moves and op not in EXACT else value
            moving[outs[0]] = moves
    return [outputs[key] for key in sorted(outputs)]
