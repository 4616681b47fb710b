"""Linear marches: the motion of a loop that is cut, and its Jacobians, as modules that a browser runs."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca

from workbench.core import Layout, Ode, SampledSystem, rk4
from workbench.design.linear.linear_period import jump_of
from workbench.design.linear.switching_functions import REACH, SwitchingFunctions
from workbench.design.linear_loop.kernel_values import KernelFlow, evaluation
from workbench.report.live.marches import Modules, march


def drive_part(equations: Ode, drives: int) -> Ode:
    """The equations of a loop that is cut, with its `drives` numbers as inputs and what arrives there as outputs."""
    entries = equations.outputs.entries
    count = next(k for k in range(len(entries) + 1) if sum(entry.size for entry in entries[:k]) == drives)
    outputs = Layout(entries[:count])
    return replace(equations, inputs=("drive",), outputs=outputs, output=equations.output[: outputs.size])


def values_march(ode: Ode, closed_loop: Ode | None, modules: Modules, rates: bool = True) -> dict[str, object]:
    """Rates and arrivals, their Jacobian by states and drives, corners, and of `closed_loop` its motion with time.

    Without `rates` it has the arrivals alone. The values stand behind the states, in this order: `heights` of them
    from the row `first` on, the entries of the Jacobian at `rows` and `columns`, the switching functions and their
    reach (`corners` each), and three numbers for each state if time drives any.
    """
    z, first = ca.vertcat(ode.x, ode.input_symbols), 0 if rates else ode.states.size
    heights = ca.densify(ca.vertcat(ode.rate, ode.output)[first:])
    J, sigma = ca.jacobian(heights, z), SwitchingFunctions.of(ode).sigma
    size = ca.fabs(ca.jacobian(sigma, z)) @ (REACH * (1 + ca.fabs(z)))
    timed = ca.SX(0, 1) if closed_loop is None else _by_time(closed_loop)
    values = ca.vertcat(heights, J.nz[:], ca.densify(sigma), ca.densify(size), timed)
    rows, columns = J.sparsity().get_triplet()
    return march(evaluation(ode, values), 1, modules) | {
        "first": first,
        "heights": heights.numel(),
        "rows": [first + row for row in rows],
        "columns": columns,
        "corners": sigma.numel(),
        "timed": timed.numel() // 3,
    }


def _by_time(closed: Ode) -> ca.SX:
    """The first and second derivative of each rate by time, and the size of its terms; empty if time drives none."""
    if not ca.depends_on(closed.rate, closed.t):
        return ca.SX(0, 1)
    first = ca.jacobian(closed.rate, closed.t)
    terms = ca.fabs(ca.jacobian(closed.rate, closed.x)) @ (1 + ca.fabs(closed.x)) + 1
    return ca.vertcat(*(ca.densify(part) for part in (first, ca.jacobian(first, closed.t), terms)))


def flow_march(sampled_loop: SampledSystem, flow: Ode, substeps: int, modules: Modules) -> dict[str, object] | None:
    """The flow of a period with its sensitivities, in Runge-Kutta steps; None where nothing moves.

    Its states are those that move, at `rows`, and behind them their derivatives by the `columns` of states and
    drives, column by column, which start at `start`. Its parameters are those of the loop, the `others` among the
    states, and the time of the instant.
    """
    kernel = KernelFlow(flow, sampled_loop.period)
    if not kernel.moving_states:
        return None
    ode, rows, columns = kernel.sensitive
    return march(rk4(ode, sampled_loop.period / substeps), substeps, modules) | {
        "substeps": substeps,
        "rows": rows,
        "columns": columns,
        "others": [i for i in range(flow.states.size) if i not in rows],
        "start": ode.states.default[len(rows) :].tolist(),
    }


def continuous_marches(open_loop: Ode, drives: int, modules: Modules) -> dict[str, object]:
    """The marches of a loop in continuous time."""
    own = drive_part(open_loop, drives)
    return {"values": values_march(own, closed_by(own, own), modules), "jump": None, "flow": None}


def computer_marches(open_loop: SampledSystem, drives: int, substeps: int, modules: Modules) -> dict[str, object]:
    """The marches of a loop in a computer: its jump, what arrives after it, and the flow to the next instant."""
    flow = drive_part(open_loop.flow, drives)
    jump = replace(jump_of(open_loop), inputs=flow.inputs)
    if ca.depends_on(jump.rate, jump.input_symbols):
        raise ValueError("The computer of this loop reads what drives its plant at the same instant.")
    return {
        "values": values_march(flow, closed_by(flow, flow), modules, rates=False),
        "jump": values_march(jump, jump, modules),
        "flow": flow_march(open_loop, flow, substeps, modules),
    }


def closed_by(ode: Ode, cut: Ode) -> Ode:
    """The equations whose drives are what arrives there.

    Raises
    ------
    ValueError
        If what arrives depends on what drives at the same instant.
    """
    if ca.depends_on(cut.output, cut.input_symbols):
        raise ValueError("What arrives at the cut of this loop depends on what drives there at the same instant.")
    return replace(ode, rate=ca.substitute(ode.rate, cut.input_symbols, ca.densify(cut.output)))
