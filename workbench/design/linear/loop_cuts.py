"""The gain L of a loop that is cut, at rest under what its law commands there, or frozen at a state of a run."""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from workbench.core import Ode, SampledSystem
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.design.linear.linear_path import LinearPath
from workbench.design.linear.linear_period import jump_of, one_period
from workbench.design.linear.linearization import linear_model, motion, step_motion
from workbench.design.linear.operating_point import names_of, places_of, row_of, time_of, vector_of
from workbench.design.linear.switching_functions import Mask, Sides

if TYPE_CHECKING:
    import control

    from workbench.design.linear.pointed_systems import PointedSpace

CUT_TOLERANCE = 1e-6  # of its size: by how much what acts may differ from what arrives at the cut, as a run prints it


@check_arguments
def broken_loop(
    ode: Ode | SampledSystem,
    t: float,
    x: Numbers,
    p: Numbers | None = None,
    u: Numbers | None = None,
    *,
    is_frozen: bool = False,
    side: Sides = None,
) -> control.StateSpace:
    """The loop gain L about a state of a loop that is cut: from its inputs to its outputs, with the sign reversed.

    The outputs of `ode`, in their order, were its inputs before the cut, as `ClosedLoop.cut()` gives it; a
    `SampledSystem` comes from `ClosedLoop.digital(at=...)`. Without u the inputs are what arrives at the cut at this
    state: what the law itself commands there.

    Parameters
    ----------
    t, x, p
        As of `linearize`; x holds the memory of law and observer too.
    u
        The inputs (nu,), in the place of what arrives at the cut.
    is_frozen
        True if the loop need not rest there: L is then for the loop frozen at a state of a run, and proves nothing
        about the run. A state on which no Jacobian depends need not rest; in a linear loop this holds for every state.
    side
        The side of a corner, as of `linearize`.

    Raises
    ------
    ValueError
        As `linearize`; if there are not as many outputs as inputs; if an input that is cut reaches its own output at
        once; or if the loop does not rest there and `is_frozen` is False.

    Examples
    --------
    >>> from workbench.design.linear import along, broken_loop, broken_loops
    >>> law = wb.PID(wb.DCMotor().outputs, wb.DCMotor().inputs, Kp=10.0, Ki=20.0)
    >>> cut = wb.ClosedLoop(wb.DCMotor(), controller=law, reference=wb.Step("omega", "rad/s", 1.0)).cut()
    >>> p = cut.parameters.pack({"drive": [10.0]})[0]  # the voltage that arrives at the cut
    >>> broken_loop(cut, 0.0, cut.states.default, p).nstates
    4
    >>> len(broken_loops(along(cut, [0.0], [cut.states.default], p)))
    1
    """
    import control

    flow = ode.flow if isinstance(ode, SampledSystem) else ode
    ports = names_of(flow)
    _refuse_odd("broken_loop(ode)", f"'{ode.name}'", len(ports["inputs"]), len(ports["outputs"]))
    row, state, time = row_of(flow, p, u), vector_of("x", x, ode.states), time_of(t)
    if u is None:
        row[places_of(flow)] = _arrivals(ode, time, state, row)
    n = ode.states.size
    G = linear_model(
        "broken_loop", ode, time, state, row, side=side, used_entries=lambda pattern: loop_entries(pattern, n)
    )
    if not is_frozen:
        _refuse_motion(ode, time, state, row, G)
    name = f"{ode.name}, frozen at t = {time:g} s" if is_frozen else ode.name
    return control.ss(G.A, G.B, -G.C, -G.D, G.dt, name=name, **ports)


def _arrivals(ode: Ode | SampledSystem, t: float, x: Array, row: Array) -> Array:
    """The values that arrive at the cut where they also act there: handed on, once for each signal that is cut."""
    flow, p = ode.flow if isinstance(ode, SampledSystem) else ode, row.copy()
    places = places_of(flow)
    for _ in range(len(places) + 1):
        at = jump_of(ode).rate_at(round(t / ode.period), x, p) if isinstance(ode, SampledSystem) else x
        arriving = np.array(flow.h(t, at, p)).ravel()
        if not np.isfinite(arriving).all():
            name = flow.outputs.labels[int(np.argmin(np.isfinite(arriving)))]
            raise ValueError(f"`broken_loop(x=...)`: '{name}' is not finite at this state of '{ode.name}'.")
        if np.array_equal(arriving, p[places]):
            return arriving
        p[places] = arriving
    raise ValueError(
        f"`broken_loop(ode)` must have inputs that do not reach their own outputs at once, or be given u=...; what "
        f"arrives at the cut of '{ode.name}' changes as it is handed on."
    )


def loop_entries(pattern: Mask, n: int) -> Mask:
    """True for the entries of (A, B; Cy, D) on which L and the poles of the closed loop depend.

    A state that reaches no output, and not itself again through the state that drives it, is in neither.
    """
    steps = np.eye(len(pattern), dtype=bool)
    steps[:, :n] |= pattern[:, :n]
    reach = closure(steps)  # reach[i, j]: j reaches i
    used = np.ones(pattern.shape, dtype=bool)
    out = np.asarray(reach[n:, :n].any(axis=0))
    used[:n, :n] = out[:, np.newaxis] | reach[:n, :n].T
    used[:n, n:] = out[:, np.newaxis]
    return used


def closure(steps: Mask) -> Mask:
    """The pairs that any number of steps joins."""
    for _ in range(max(len(steps).bit_length(), 1)):
        joined = steps.astype(float)  # counts up to the number of places, exact; of floats a product takes a tenth
        steps = np.asarray(joined @ joined > 0)
    return steps


def entries_of(pattern: ca.Sparsity) -> Mask:
    """True where a pattern has an entry, without the numbers of a dense matrix on the way."""
    mask = np.zeros(pattern.shape, dtype=bool)
    rows, columns = (np.array(places, dtype=int) for places in pattern.get_triplet())
    mask[rows, columns] = True
    return mask


def _moves(ode: Ode | SampledSystem) -> Mask:
    """True for each state whose motion changes a Jacobian in the closed loop, at once or by what it moves, (nx,)."""
    n, m = ode.states.size, ode.outputs.size
    steps, bends = np.eye(n + m, dtype=bool), np.zeros(n + m, dtype=bool)
    for each in (ode.flow, jump_of(ode)) if isinstance(ode, SampledSystem) else (ode,):
        z, values = ca.vertcat(each.x, each.input_symbols), ca.vertcat(each.rate, each.output)
        J = ca.jacobian(values, z)
        steps[: values.numel()] |= entries_of(J.sparsity())
        bends |= entries_of(ca.jacobian_sparsity(ca.vec(ca.densify(J)), z)).any(axis=0)
    return np.asarray(closure(steps)[bends][:, :n].any(axis=0))


def _refuse_motion(ode: Ode | SampledSystem, t: float, x: Array, row: Array, G: PointedSpace) -> None:
    """Refuse a loop in which a state moves that a Jacobian follows, or another signal acts than arrives at the cut."""
    outputs, acting, arriving = ode.outputs.labels, G.u0, G.y0
    remedy = (
        "Give plant, law and observer their states at rest, as `operating_point(loop.ode(), {...})` finds them, or ask "
        "for the loop as it is frozen there: `frozen=True`."
    )
    mask = _moves(ode)
    if not mask.any():
        return
    apart = np.abs(acting - arriving) / (1e-300 + np.maximum(np.abs(acting), np.abs(arriving)).max())
    if apart.max() > CUT_TOLERANCE:
        worst = int(apart.argmax())
        raise ValueError(
            f"`broken_loop(u=...)` must be what arrives at the cut, or the loop does not rest: "
            f"{acting[worst]:.6g} acts in the place of '{outputs[worst]}', and {arriving[worst]:.6g} arrives. {remedy}"
        )
    if isinstance(ode, SampledSystem):
        moving = step_motion(ode, x, one_period("broken_loop", ode, t, x, row).end, G.A, mask)
    else:
        moving = motion(ode, t, x, row, G.A, mask)
    if moving:
        held = ", ".join(f"{name} = {value:.6g}" for name, value in zip(outputs, acting, strict=True))
        raise ValueError(
            f"`broken_loop(x=...)` must be a state at which '{ode.name}' rests under what arrives at its cut; at "
            f"t = {t:g} and {held} {moving}. {remedy}"
        )


@check_arguments
def broken_loops(path: LinearPath) -> tuple[control.StateSpace, ...]:
    """The loop gain L at each time of a path of a loop that is cut, frozen there; it proves nothing about the motion.

    Raises
    ------
    ValueError
        If there are not as many outputs as inputs, or the input that acts is not the one that arrives at the cut: the
        rows p of `along(p=...)` must hold the value that this input has in the run.
    """
    import control

    _refuse_odd("broken_loops(path)", "this one", len(path.inputs), len(path.outputs))
    apart = np.abs(path.u - path.y) / (1e-300 + np.maximum(np.abs(path.u), np.abs(path.y)).max())
    if apart.size and apart.max() > CUT_TOLERANCE:
        k, i = np.unravel_index(apart.argmax(), apart.shape)
        raise ValueError(
            f"`broken_loops(path)` must have a path on which the inputs are what arrives at the cut, as on a run of "
            f"the closed loop; at t = {path.t[k]:g} s {path.u[k, i]:.6g} acts for '{path.outputs[i]}', and "
            f"{path.y[k, i]:.6g} arrives. Give `along(p=...)` a row for each time with '{path.inputs[i]}' of the run."
        )
    frozen = zip(path.t, path.A, path.B, path.Cy, path.D, strict=True)
    return tuple(control.ss(A, B, -Cy, -D, name=f"frozen at t = {t:g} s") for t, A, B, Cy, D in frozen)


def _refuse_odd(call: str, name: str, inputs: int, outputs: int) -> None:
    if inputs != outputs:
        raise ValueError(
            f"`{call}` must have an output for each input, which it was before the cut; {name} has {inputs} "
            f"inputs and {outputs} outputs."
        )
