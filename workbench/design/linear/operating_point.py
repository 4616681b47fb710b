"""The point of an `Ode` that a call is about, its Jacobians there, and the point at which the equation rests."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np

from workbench.core import Layout, Ode
from workbench.core.bounded_loop import operation_codes
from workbench.core.notation.program import walk
from workbench.core.point import AT_REST, rate_terms
from workbench.core.validation.notebook_display import show
from workbench.core.validation.number_types import Numbers, Values
from workbench.core.validation.refusals import Array, as_array, describe, finite, refusal, require
from workbench.core.validation.signatures import check_arguments
from workbench.design.control_system import System
from workbench.design.matrices import LARGEST, DesignError
from workbench.proofs.interval import JUMPS, jumps

ON_IT = 1e-12  # a switching function smaller than this share of the state counts as zero
JUMP = 1e-9  # the least difference of two rates, relative to their size, that counts as a jump
GAUSS_NEWTON_STEPS, HALVINGS = 50, 30
SMALL = 1e-7  # a relative step that is taken whole, as the next one may be nothing but rounding
Mask = np.ndarray[tuple[int, ...], np.dtype[np.bool_]]
LATEST = 16  # equations whose functions are kept, as the rows of a loop take them again and again


def names_of(ode: Ode) -> dict[str, list[str]]:
    """The names of states, inputs and outputs, number by number; a column of one number goes by its own name."""
    ports = {"states": ode.states, "inputs": inputs_of(ode), "outputs": ode.outputs}
    return {
        port: [n for e in own.entries for n in (e.labels() if e.size > 1 else [e.name])] for port, own in ports.items()
    }


def inputs_of(ode: Ode) -> Layout:
    """The declared inputs, in their order."""
    return Layout(tuple(ode.parameters[name] for name in ode.inputs))


def places_of(ode: Ode) -> list[int]:
    """The places of the numbers of u in p."""
    return [place for name in ode.inputs for place in ode.parameters.indices(name)]


def row_of(ode: Ode, p: Numbers | None, u: Numbers | None = None) -> Array:
    """A copy of p (np,), the defaults if it is None, with u (nu,) in its places unless that is None."""
    require("ode", ode, Ode)
    row = ode.parameters.default.copy() if p is None else vector_of("p", p, ode.parameters)
    if u is not None:
        row[places_of(ode)] = vector_of("u", u, inputs_of(ode))
    ode.parameters.check(row[np.newaxis])
    return row


def vector_of(what: str, value: object, layout: Layout) -> Array:
    """A vector with a number for each label of the layout, every one finite and its square too."""
    labels = f": {', '.join(layout.labels)}" if layout.size < 9 else ""
    want, array = f"{layout.size} finite numbers{labels}", as_array(value)
    if array is None:
        raise ValueError(f"`{what}` must be {want}; got {describe(value)}.")
    fits = array.shape == (layout.size,)
    if not fits or not (np.abs(array) < LARGEST).all():
        size = f" below {LARGEST:g} in size" if fits and np.isfinite(array).all() else ""
        raise ValueError(f"`{what}` must be {want}{size}; got {describe(array.tolist())} of shape {array.shape}.")
    return array


def time_of(t: object) -> float:
    """A finite time in s."""
    return finite("t", t, " of seconds", low=-LARGEST, high=LARGEST)


def jacobians(call: str, ode: Ode, t: float, x: Array, p: Array) -> tuple[Array, Array, Array, Array]:
    """A, B, Cy and D at a point, or a refusal where the equations have no derivative."""
    matrices = tuple(np.array(J(t, x, p)) for J in (ode.A, ode.B, ode.Cy, ode.D))
    rates = [f"the rate of '{label}'" for label in ode.states.labels]
    rows, columns = (rates, [repr(label) for label in ode.outputs.labels]), (ode.states.labels, inputs_of(ode).labels)
    for k, (letter, matrix) in enumerate(zip(("A", "B", "Cy", "D"), matrices, strict=True)):
        for i, j in np.argwhere(~np.isfinite(matrix))[:1]:
            raise ValueError(
                f"`{call}(...)`: {letter} is not finite at t = {t:g}, x = {x.tolist()}: {rows[k // 2][i]} has no "
                f"derivative by '{columns[k % 2][j]}' there; linearise at another state."
            )
    A, B, Cy, D = matrices
    return A, B, Cy, D


def refuse_jump_at(call: str, ode: Ode, t: float, x: Array, p: Array, rates: Mask | None = None) -> None:
    """Refuse a point at which a rate or an output jumps; one at which it only bends, as |s| does, is let pass.

    With a mask `rates` (nx,) others may jump.
    """
    n, driven, functions = ode.states.size, places_of(ode), _values_beside_jumps(ode)
    if functions is None:
        return
    value, slope, acts = functions
    counts = np.ones(n + ode.outputs.size) if rates is None else np.r_[rates, np.ones(ode.outputs.size)]
    at = np.concatenate([x, p[driven]])
    reach = ON_IT * (1 + np.abs(at))
    labels = [f"'{label}' changes" for label in (*ode.states.labels, *inputs_of(ode).labels)]
    # all at once too, in no special direction: sign(x1 x2) jumps along neither axis
    across = np.vstack([np.diag(reach), reach * np.cos(np.arange(1.0, len(at) + 1))])
    for direction, label in zip(across, [*labels, "all of them change"], strict=True):
        if not acts[direction != 0].any():
            continue
        moves, points = direction != 0, []
        for side in (-1, 0, 1):
            row, moved = p.copy(), at + side * direction
            row[driven] = moved[n:]
            points.append((t, moved[:n], row))
        heights = [np.array(value(*point)).ravel() for point in points]
        change, least = np.ptp(heights, axis=0) * counts, JUMP * (1 + np.abs(heights[0]).max())
        if change.max() <= least:  # for which no slope is needed, that may cost a hundred times as much
            continue
        slopes = [np.abs(np.array(slope(*points[i]))[:, moves]) @ np.abs(direction[moves]) for i in (0, 2)]
        change = change - 4 * np.maximum(*slopes)
        if change.max() > least:
            names = (*(f"the rate of '{label}'" for label in ode.states.labels), *map(repr, ode.outputs.labels))
            raise ValueError(
                f"`{call}(...)`: {names[int(change.argmax())]} jumps by {change.max():.3g} as {label} at this state, "
                f"so it has no linear model there; take another state, another input or {smooth(ode)}."
            )


@lru_cache(maxsize=LATEST)
def _values_beside_jumps(ode: Ode) -> tuple[ca.Function, ca.Function, Array] | None:
    """Rates and outputs, their Jacobian by states and inputs, and which of these act; None if none of them can jump."""
    z, both = ca.vertcat(ode.x, ode.input_symbols), ca.densify(ca.vertcat(ode.rate, ode.output))
    symbols = [ode.t, ode.x, ode.p]
    value = ca.Function("both", symbols, [both])
    of_loops = operation_codes(value)[value.n_instructions() :]
    if not set(JUMPS).intersection(of_loops) and not jumps(walk(both), [symbol.name() for symbol in ca.vertsplit(z)]):
        return None
    acts = np.zeros(z.numel(), dtype=bool)
    acts[ca.jacobian_sparsity(both, z).get_col()] = True
    return value, ca.Function("J", symbols, [ca.densify(ca.jacobian(both, z))]), acts


def smooth(ode: Ode) -> str:
    """The advice on smooth replacements of a jump."""
    friction = any(name.endswith(".coulomb") for name in ode.parameters.names)
    return f"a continuous saturation{' (of friction from a file: `friction_speed=...`)' if friction else ''}"


def state_space(call: str, system: System) -> tuple[Array, Array, Array, Array]:
    """A, B, C and D of a `StateSpace` of python-control, all finite."""
    import control

    if not isinstance(system, control.StateSpace):
        advice = ": take `control.ss(system)`" if isinstance(system, control.TransferFunction) else ""
        raise refusal(f"{call}(system=...)", "a `StateSpace` of python-control, as `linearize` gives", system, advice)
    A, B, C, D = (np.asarray(matrix, dtype=float) for matrix in (system.A, system.B, system.C, system.D))
    if not all(np.isfinite(matrix).all() for matrix in (A, B, C, D)):
        raise ValueError(f"`{call}(system=...)` must have finite matrices; '{system.name}' has not.")
    return A, B, C, D


@dataclass(frozen=True, eq=False)
@show
class TrimPoint:
    """A state at rest x (nx,), and the inputs u (nu,) that hold it there, also in their places in p (np,).

    `residual` is the largest rate that remains, as a share of its terms. `condition` is the condition number of the
    Jacobian by the free numbers. `error` is the last step of Newton's method, relative to the size of the free numbers.
    """

    x: Array
    u: Array
    p: Array
    residual: float
    condition: float
    error: float


@check_arguments
def operating_point(
    ode: Ode, targets: Values, p: Numbers | None = None, t: float = 0.0, u: Numbers | None = None
) -> TrimPoint:
    """The inputs u and the free states at which f(t, x, p, u) = 0, with the other states as given: a trimmed state.

    It uses Gauss-Newton on all rates, from the defaults; a step is halved while the next one would be longer. If the
    rates do not fix all inputs and free states, each step takes the solution nearest to where it starts.

    Parameters
    ----------
    targets
        Names of states or inputs, or of single numbers (`q[0]`), with the values that they must have.
    p, t
        The parameters (np,), by default those of `ode`, and the time in s.
    u
        Where the inputs start, (nu,).

    Raises
    ------
    LookupError
        If a name is neither that of a state nor that of an input.
    ValueError
        If a value is not of its shape, or no input and no state is free.
    DesignError
        If no such point is found: the rate that remains is named.

    Examples
    --------
    >>> from workbench.design.linear import operating_point
    >>> operating_point(wb.open_loop(wb.DCMotor()), {"omega": 10.0}).u.round(3)
    array([100.1])
    """
    row, time = row_of(ode, p, u), time_of(t)
    x, fixed = _targets_of(ode, targets, row)
    free = [i for i in range(ode.states.size + inputs_of(ode).size) if i not in fixed]
    driven = places_of(ode)
    if not free:
        raise ValueError(f"`operating_point(...)` must have an input or a free state to find; '{ode.name}' has none.")
    step, slope = _descend(ode, time, x, row, free)
    A = np.array(ode.A(time, x, row))
    rate = ode.rate_at(time, x, row)
    share = np.abs(rate) / (rate_terms(A, x) + np.abs(np.array(ode.B(time, x, row))) @ np.abs(row[driven]))
    worst = int(np.argmax(share))
    if not share[worst] <= AT_REST:
        sought = [(*ode.states.labels, *inputs_of(ode).labels)[i] for i in free]
        raise DesignError(
            f"`operating_point(targets=...)` found no {', '.join(sought)} that hold '{ode.name}' there: "
            f"'{ode.states.labels[worst]}' still changes by {rate[worst]:.3g} a second."
        )
    ode.parameters.check(row[np.newaxis])
    return TrimPoint(x, row[driven], row, float(share[worst]), float(np.linalg.cond(slope)), step)


def _descend(ode: Ode, t: float, x: Array, p: Array, free: list[int]) -> tuple[float, Array]:
    """Gauss-Newton on the free states and inputs, in place; its last step, relative, and its last Jacobian."""
    driven, n = places_of(ode), len(x)
    step, slope = np.inf, np.zeros((n, 0))
    for _ in range(GAUSS_NEWTON_STEPS):
        A, B, _, _ = jacobians("operating_point", ode, t, x, p)
        slope, at = np.hstack([A, B])[:, free], np.concatenate([x, p[driven]])
        change = _towards_rest(slope, ode.rate_at(t, x, p))
        step = _share(change, at[free])
        if not np.isfinite(step) or np.abs(at[free] + change).max() > 1e12:
            break
        for share in 0.5 ** np.arange(HALVINGS):  # a root of a level, say, ends where the level is negative
            ahead = at.copy()
            ahead[free] += share * change
            x[:], p[driven] = ahead[:n], ahead[n:]
            rate = ode.rate_at(t, x, p)
            # the step that would be left has no units of the rates: a fast state does not hide a slow one
            left = _share(_towards_rest(slope, rate), at[free]) if np.isfinite(rate).all() else np.inf
            if step < SMALL or left < step:
                break
        if step < 1e-14:
            break
    return step, slope


def _share(change: Array, at: Array) -> float:
    return float((np.abs(change) / (1 + np.abs(at))).max())


def _towards_rest(slope: Array, rate: Array) -> Array:
    """The least change that makes the rates zero to first order, each in parts of its own steepest slope."""
    steepest = np.abs(slope).max(axis=1)
    size = np.where(steepest > 0, steepest, 1.0)
    return np.asarray(np.linalg.lstsq(slope / size[:, np.newaxis], -rate / size, rcond=1e-12)[0])


def _targets_of(ode: Ode, targets: Values, row: Array) -> tuple[Array, set[int]]:
    """The wanted state, with the wanted inputs put into the row, and the places of both."""
    require("operating_point(wanted=...)", targets, Mapping)
    x, fixed, inputs, driven = ode.states.default.copy(), set(), inputs_of(ode), places_of(ode)
    at = np.concatenate([x, row[driven]])
    for name, value in targets.items():
        is_input = isinstance(name, str) and name.partition("[")[0] in inputs
        places = [len(x) + place for place in inputs.indices(name)] if is_input else ode.states.indices(name)
        fit = as_array(value)
        if fit is None or fit.size != len(places) or not np.isfinite(fit).all():
            must = f"{len(places)} finite numbers"
            raise ValueError(f"`operating_point(targets=...)`: '{name}' must be {must}; got {describe(value)}.")
        at[places] = fit.ravel(order="F")
        fixed.update(places)
    row[driven] = at[len(x) :]
    return at[: len(x)], fixed
