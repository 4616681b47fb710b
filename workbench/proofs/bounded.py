"""Verdicts on numbers that proofs lean on: |f| <= limit, Lipschitz constants, bounds of a disturbance and its slope.

All norms are 2-norms. A limit is refuted if the norm is proved to exceed it at a point, and proved if it is never
exceeded. Proofs by intervals need a little room, so one that is met exactly, as |sin x| <= 1, may stay open.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal

import casadi as ca
import numpy as np

from workbench.core import Dynamics
from workbench.notation.program import walk
from workbench.proofs.bounds import Extreme, NoBound, box_of, by_intervals, largest_norm, shown
from workbench.proofs.interval import Interval, evaluate, jumps
from workbench.proofs.spectrum import nominal, of_joints
from workbench.proofs.witness import exact
from workbench.validation.refusals import Array, refusal, seconds
from workbench.validation.signatures import door

# A limit that is nearer to what is seen, as a share, is not sought to be proved: rounding is about as large.
FINEST = 1e-12
Outcome = Literal["proved", "refuted", "not refuted", "not checkable"]


@dataclass(frozen=True, eq=False)
class BoundVerdict:
    """How it stands with a bound.

    Attributes
    ----------
    seen, at
        The largest value that was seen, in `unit`, and the point (k,) where; None and () if there is none.
    bound
        What no value in the box exceeds, proved; None where nothing was.
    replay
        A line of Python that gives `seen`, with `numpy`, `casadi` and the arguments of the call at hand.
    """

    statement: str
    kind: Outcome
    evidence: str
    unit: str
    seen: float | None
    at: Array
    bound: float | None
    replay: str


@door
def bounded(
    expression: ca.SX,
    symbols: ca.SX,
    low: float | Array,
    high: float | Array,
    limit: float | None = None,
    *,
    statement: str = "",
    unit: str = "",
    boxes: int | None = None,
) -> BoundVerdict:
    """|f(x)| <= limit for low <= x <= high; without a limit, the least one that holds is proved and named.

    Parameters
    ----------
    expression
        A number, a vector, or a matrix, of which the largest singular value counts.
    symbols, low, high
        (k, 1), all that the expression holds, and the box: numbers or (k,).

    Raises
    ------
    ValueError
        If the box is not one of finite numbers, the limit is not positive, or the expression holds other symbols.
    """
    line = 'casadi.Function("f", [symbols], [expression])({x})'
    asked = _Question("|f|", (low, high), limit, unit, line, boxes, statement)
    return _judge(asked, expression, symbols)


@door
def lipschitz(
    expression: ca.SX,
    symbols: ca.SX,
    low: float | Array,
    high: float | Array,
    limit: float | None = None,
    *,
    statement: str = "",
    unit: str = "",
    boxes: int | None = None,
) -> BoundVerdict:
    """|f(x) - f(y)| <= L |x - y| for all x, y in a box: the norm of the Jacobian is at most L.

    Where f may jump, it is `not checkable`: its slope says nothing then.

    Raises
    ------
    ValueError
        As `bounded`.
    """
    line = 'casadi.Function("J", [symbols], [casadi.jacobian(expression, symbols)])({x})'
    asked = _Question("|df/dx|", (low, high), limit, unit, line, boxes, statement)
    return _slope(asked, expression, symbols)


@door
def disturbance(
    D: ca.SX, t: ca.SX, until: float, D_max: float | None = None, L_D: float | None = None, *, boxes: int | None = None
) -> tuple[BoundVerdict, BoundVerdict]:
    """|D(t)| <= D_max and |D'(t)| <= L_D for 0 <= t <= until: a disturbance (n, 1) in N m, and its slope in N m/s.

    Raises
    ------
    ValueError
        If `until` is not a positive number, or D holds other symbols than t.
    """
    span = 0.0, seconds("disturbance(until=...)", until)
    size = 'casadi.Function("D", [t], [D])({x})'
    slope = 'casadi.Function("D", [t], [casadi.jacobian(D, t)])({x})'
    horizon = f"for t in [0, {until:g}] s"
    first = _Question("|D|", span, D_max, "N m", size, boxes, _said("|D(t)|", D_max, horizon))
    second = _Question("|D'|", span, L_D, "N m/s", slope, boxes, _said("|D'(t)|", L_D, horizon))
    return _judge(first, D, t), _slope(second, D, t)


@door
def lipschitz_gravity(
    dynamics: Dynamics,
    low: float | Array = -np.pi,
    high: float | Array = np.pi,
    limit: float | None = None,
    *,
    boxes: int | None = None,
) -> BoundVerdict:
    """|G(x) - G(y)| <= L |x - y| for positions in a box (rad), at nominal parameters; L in N m/rad."""
    line = _of_dynamics("casadi.jacobian(dynamics.G, dynamics.q)", "dynamics.q")
    box = box_of("lipschitz_gravity", low, high, dynamics.dof)
    said = _said("|dG/dq|", limit, NOMINAL)
    asked = _Question("|dG/dq|", box, limit, of_joints("N m/rad", dynamics), line, boxes, said, nominal(dynamics))
    return _slope(asked, dynamics.G, dynamics.q)


@door
def lipschitz_coriolis(
    dynamics: Dynamics,
    speed: float | Array,
    low: float | Array = -np.pi,
    high: float | Array = np.pi,
    limit: float | None = None,
    *,
    boxes: int | None = None,
) -> BoundVerdict:
    """|C qd at x - C qd at y| <= L |x - y| for states x = (q, qd) in a box, at nominal parameters.

    Parameters
    ----------
    speed
        The most that |qd_i| can be, in rad/s: a number or (n,).
    low, high
        The box of positions, in rad.
    """
    slow, fast = box_of("lipschitz_coriolis", -1.0 * np.asarray(speed), speed, dynamics.dof)
    first, last = box_of("lipschitz_coriolis", low, high, dynamics.dof)
    state, bias = ca.vertcat(dynamics.q, dynamics.qd), dynamics.C @ dynamics.qd
    box = np.concatenate([first, slow]), np.concatenate([last, fast])
    x = "casadi.vertcat(dynamics.q, dynamics.qd)"
    line = _of_dynamics(f"casadi.jacobian(dynamics.C @ dynamics.qd, {x})", x)
    said, unit = _said("|d(C qd)/d(q, qd)|", limit, NOMINAL), of_joints("N m/rad, N m s/rad", dynamics)
    return _slope(_Question("|d(C qd)/dx|", box, limit, unit, line, boxes, said, nominal(dynamics)), bias, state)


@door
def lipschitz_inverse_mass(
    dynamics: Dynamics,
    low: float | Array = -np.pi,
    high: float | Array = np.pi,
    limit: float | None = None,
    *,
    boxes: int | None = None,
) -> BoundVerdict:
    """|M^-1(x) - M^-1(y)| <= L |x - y| in the Frobenius norm, for positions in a box (rad), at nominal parameters."""
    inverse = ca.vec(ca.inv(ca.densify(dynamics.M)))
    line = _of_dynamics("casadi.jacobian(casadi.vec(casadi.inv(dynamics.M)), dynamics.q)", "dynamics.q")
    box = box_of("lipschitz_inverse_mass", low, high, dynamics.dof)
    said = _said("|dM^-1/dq|", limit, NOMINAL)
    asked = _Question(
        "|dM^-1/dq|", box, limit, of_joints("1/(kg m^2 rad)", dynamics), line, boxes, said, nominal(dynamics)
    )
    return _slope(asked, inverse, dynamics.q)


NOMINAL = "at nominal parameters"


def _said(what: str, limit: float | None, where: str) -> str:
    return f"{what} is bounded {where}" if limit is None else f"{what} <= {limit:g} {where}"


def _of_dynamics(expression: str, symbols: str) -> str:
    return f'casadi.Function("J", [{symbols}, dynamics.symbols], [{expression}])({{x}}, dynamics.p.default)'


@dataclass(frozen=True, eq=False)
class _Question:
    """What is to be bounded, over which box, by how much, the line that shows it at {x}, and the numbers of symbols."""

    what: str
    box: tuple[float | Array, float | Array]
    limit: float | None
    unit: str
    line: str
    boxes: int | None
    statement: str
    numbers: Mapping[str, float] | None = None

    def open(self, why: str) -> BoundVerdict:
        """The verdict where nothing can be said."""
        return BoundVerdict(self.said, "not checkable", why, self.unit, None, np.zeros(0), None, "")

    @property
    def said(self) -> str:
        """The statement."""
        return self.statement or _said(self.what, self.limit, "over the box")


def _slope(asked: _Question, f: ca.SX, symbols: ca.SX) -> BoundVerdict:
    if not symbols.is_valid_input():
        raise refusal("symbols=...", "a column of symbols, each of them alone", symbols)
    names = [symbols[i].name() for i in range(symbols.numel())]
    if found := jumps(walk(f), names):
        return asked.open(f"it holds {found[0]}, where it may jump or has no slope")
    return _judge(asked, ca.jacobian(f, symbols), symbols)


def _judge(asked: _Question, matrix: ca.SX, symbols: ca.SX) -> BoundVerdict:
    """The norm of a matrix over a box against its limit."""
    if asked.limit is not None and not 0 < asked.limit < np.inf:
        raise ValueError(f"A limit of {asked.what} must be a positive number, as norms are; got {asked.limit}.")
    try:
        found = _found(asked, matrix, symbols)
    except NoBound as none:
        return asked.open(str(none))
    kind, evidence = _compared(asked, found)
    point = exact(found.x).strip("(),")
    replay = f"numpy.linalg.norm(numpy.array({asked.line.format(x=f'[{point}]')}), 2)"
    return BoundVerdict(asked.said, kind, evidence, asked.unit, found.value, found.x, found.beyond, replay)


def _found(asked: _Question, matrix: ca.SX, symbols: ca.SX) -> Extreme:
    """The norm to all its digits if that can be had, else as sharp as the limit asks."""
    limit, numbers = asked.limit, asked.numbers
    found = largest_norm(matrix, symbols, *asked.box, boxes=asked.boxes, numbers=numbers)
    if limit is None or limit < found.value or (found.beyond is not None and found.beyond <= limit):
        return found
    if (own := _own(asked, matrix, symbols)) <= limit:
        return replace(found, beyond=own, boxes=found.boxes + 1, why="")
    share = (limit / found.value - 1) * (1 - 1e-6) if found.value else 0.0
    if share > FINEST:
        coarse = largest_norm(matrix, symbols, *asked.box, tolerance=share, boxes=asked.boxes, numbers=numbers)
        return found if coarse.why else coarse
    return found


def _own(asked: _Question, matrix: ca.SX, symbols: ca.SX) -> float:
    """What the interval of one number over the whole box says of its size: of a sine, 1 and not a little more."""
    if matrix.numel() != 1:
        return np.inf
    names = [symbols[i].name() for i in range(symbols.numel())]
    low, high = (np.broadcast_to(np.asarray(side, dtype=float), len(names)) for side in asked.box)
    ends = {name: (low[i], high[i]) for i, name in enumerate(names)}
    ends |= {name: (number, number) for name, number in (asked.numbers or {}).items()}
    (range_,) = evaluate(walk(matrix), {name: Interval(*map(np.atleast_1d, pair)) for name, pair in ends.items()})
    return float(np.abs([range_.low, range_.high]).max())


def _compared(asked: _Question, found: Extreme) -> tuple[Outcome, str]:
    limit, where = np.inf if asked.limit is None else asked.limit, (np.round(found.x, 6) + 0.0).tolist()
    place = f"{asked.what} reaches {found.value + 0.0:.9g} {asked.unit}".rstrip() + f" at {where}"
    if found.reached > limit:
        return "refuted", f"{place}, which is proved to exceed the limit by {found.reached / limit - 1:.2g} of itself"
    most = shown(found.beyond or 0.0, -1)
    proof = f"no more than {most} anywhere{by_intervals(found.boxes)}"
    if found.beyond is not None and found.beyond <= limit:
        return "proved", f"{place}, and {proof}"
    reason, rest = found.why, ""
    if found.beyond is not None:
        reach = "what is seen reaches the limit, and " if found.value >= limit * (1 - FINEST) else ""
        over = f"{reach}what is proved exceeds the limit by {found.beyond / limit - 1:.1g} of itself"
        reason = f"{reason}, and {over}" if reason else over
        rest = f"; proved is {proof}"
    return "not refuted", f"not refuted in {found.samples} samples: {place}; not proved: {reason}{rest}"
