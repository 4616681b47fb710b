r"""A loop at its rest for all parameters of a box: the states at which it rests, and its matrices, both enclosed.

Near the middle of a box the rest is x = x_c + G (theta - theta_c) + e, where G is the derivative of the rest by the
parameters, as computed. With Y near the inverse of df/dx, the map e -> e - Y f(x, theta) carries |e| <= E into its
interior for all theta of the box: then for each theta there is one rest with such an e, and no other (Krawczyk). The
matrices follow from their exact derivatives along theta and e, by the mean value theorem.

References
----------
Moore, Kearfott and Cloud (2009), Introduction to Interval Analysis, chapter 8.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import casadi as ca
import numpy as np

from workbench.core import Ode
from workbench.core.notation.program import walk
from workbench.core.validation.refusals import Array
from workbench.design.linear_loop import LinearLoop
from workbench.design.linear_loop.loop_equations import labels_of
from workbench.design.linear_loop.point_model import input_labels
from workbench.design.linear_loop.rest_state import resting_states
from workbench.design.loop_boxes.interval_functions import (
    IntervalFunction,
    MatrixBall,
    add_balls,
    product,
    product_right,
    reach,
)
from workbench.design.loop_boxes.rest_tubes import RestTube
from workbench.proofs.enclosures import UNIT
from workbench.proofs.interval import Interval, NoBound, jumps

ROUNDS, INFLATIONS, GROWTH = 30, 12, 1.2  # of Newton's method, and of the size of e that is tried
LEAST, ROOM = 1e-12, 1e-6  # of the size of a rest: the least E of a part of a box, and of the whole of it
MOST_OPERATIONS = 40_000  # on intervals, for one enclosure


class Matrices(NamedTuple):
    """M(theta) = [A, B; C, D] (b, q, w) at middles, its slopes (b, d, q, w), and a bound of all else (b, q, w).

    At the middles the loop rests within `doubt` (b, n) of x (b, n).
    """

    middle: Array
    slopes: Array
    rest: Array
    x: Array
    doubt: Array


@dataclass(frozen=True, eq=False)
class LoopFamily:
    """A loop whose d numbers `labels` vary, with some of its inputs and outputs, by their names.

    `moving_states` are the places of the states that must rest, and start the search for a rest at `x` (nx,).
    """

    labels: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    order: int
    x: Array
    moving_states: tuple[int, ...]
    still: dict[str, float]
    names: tuple[tuple[str, ...], tuple[str, ...]]
    values: ca.Function
    rate: IntervalFunction
    rate_slopes: IntervalFunction
    matrix: IntervalFunction
    matrix_slopes: IntervalFunction

    @staticmethod
    def of(linear: LinearLoop, labels: Sequence[str], inputs: Sequence[str], outputs: Sequence[str]) -> LoopFamily:
        """The family of a linear loop in continuous time.

        Raises
        ------
        NoBound
            If the loop is none of these, or its equations may jump, are too long, or have an operation without bound.
        """
        ode = linear.point.equations.closed_loop
        if not isinstance(ode, Ode) or linear.models.delays.any():
            raise NoBound("a proof is known of loops in continuous time without delays alone")
        us, ys = input_labels(ode), labels_of(ode.outputs)
        u = ca.vertcat(*(ode.input_symbols[us.index(name)] for name in inputs))
        y = ca.vertcat(*(ode.output[ys.index(name)] for name in outputs))
        M = ca.densify(ca.jacobian(ca.vertcat(ode.rate, y), ca.vertcat(ode.x, u)))
        theta = ca.vertcat(*(ode.p[ode.parameters.labels.index(label)] for label in labels))
        must = resting_states(ode, linear.point.equations.ports) if linear.point.at_rest else np.zeros(0, dtype=bool)
        moving = np.flatnonzero(must).tolist()
        xm, f = (part[moving] if moving else ca.SX(0, 1) for part in (ode.x, ca.densify(ode.rate)))
        varying = [s.name() for part in (xm, theta) for s in ca.vertsplit(part) if part.numel()]
        _refuse_jumps(ca.veccat(f, M), varying)
        flat = ca.vec(M)
        parts = (f, ca.horzcat(ca.jacobian(f, xm), ca.jacobian(f, theta)), M)
        curved = ca.horzcat(ca.jacobian(flat, xm), ca.jacobian(flat, theta))
        functions = [IntervalFunction.of(part) for part in (*parts, curved)]
        if (cost := sum(function.cost for function in functions)) > MOST_OPERATIONS:
            raise NoBound(f"one enclosure of its matrices would take {cost} operations, more than {MOST_OPERATIONS}")
        rows = np.concatenate([linear.point.x, linear.point.p, [linear.point.instant.t]]).tolist()
        symbols = [s.name() for part in (ode.x, ode.p) for s in ca.vertsplit(part) if part.numel()] + [ode.t.name()]
        still = {name: value for name, value in zip(symbols, rows, strict=True) if name not in varying}
        fixed = [s for part in (ode.x, ode.p, ode.t) for s in ca.symvar(part) if s.name() in still]
        numbers = ca.DM([still[s.name()] for s in fixed])
        at = [ca.substitute(ca.densify(part), ca.vertcat(*fixed), numbers) for part in parts]
        return LoopFamily(
            tuple(labels),
            tuple(inputs),
            tuple(outputs),
            ode.states.size,
            linear.point.x[moving],
            tuple(moving),
            still,
            (tuple(varying[: len(moving)]), tuple(varying[len(moving) :])),
            ca.Function("values", [xm, theta], at, {"cse": True}),
            *functions,
        )

    def rests(self, theta: Array) -> Array:
        """The states (b, n) that must rest, at draws (b, d), by Newton's method; NaN where it finds none."""
        x, n = np.tile(self.x, (len(theta), 1)), len(self.moving_states)
        for _ in range(ROUNDS if n else 0):
            f, slopes, _ = self._at(x, theta)
            step = _solve_each(slopes[:, :, :n], f)[:, :, 0]
            x = x - step
            if not (np.abs(step) > 1e-14 * (1 + np.abs(x))).any():
                break
        return np.asarray(x)

    def matrices(self, x: Array, theta: Array) -> Array:
        """M (b, q, w) at states and draws, as computed."""
        return self._at(x, theta)[2]

    def enclose(self, theta: Array, r: Array) -> Matrices:
        """The matrices over the boxes |theta - theta_c| <= r, (b, d) each; no bound where a rest was not enclosed."""
        x, n, b = self.rests(theta), len(self.moving_states), len(theta)
        x = np.where(np.isfinite(x), x, 0.0)
        _, slopes, _ = self._at(x, theta)
        Y = _inverses(slopes[:, :, :n])
        G = -Y @ slopes[:, :, n:]
        E, wide = self._rest_radii(x, theta, r, Y, G, LEAST)
        thin = self.matrix(self._boxes(x, theta, np.zeros_like(x), np.zeros_like(r)), b)
        curved = self.matrix_slopes(wide, b)
        by_x, by_theta = (
            MatrixBall(*(part[:, :, :n] for part in curved)),
            MatrixBall(*(part[:, :, n:] for part in curved)),
        )
        along = add_balls(by_theta, product_right(by_x, G)) if n else by_theta
        q, w = self.matrix.shape
        rest = _flat(thin.radius) + reach(along.radius, r) + (reach(by_x.size, E) if n else 0.0)
        total = np.asarray(rest * (1 + 16 * UNIT))
        slopes_k = along.middle.swapaxes(1, 2).reshape(b, -1, w, q).swapaxes(2, 3)
        return Matrices(thin.middle, slopes_k, total.reshape(b, w, q).swapaxes(1, 2), x, E)

    def tube(self, theta: Array, r: Array, least: float = ROOM) -> RestTube | None:
        """The rests of all draws of one box |theta - theta_c| <= r, (d,) each; None if that is not proved."""
        middle, radius, n = theta[np.newaxis], r[np.newaxis], len(self.moving_states)
        x = self.rests(middle)
        if not np.isfinite(x).all():
            return None
        _, slopes, _ = self._at(x, middle)
        Y = _inverses(slopes[:, :, :n])
        G = -Y @ slopes[:, :, n:]
        E, _ = self._rest_radii(x, middle, radius, Y, G, least)
        return RestTube(theta, r, x[0], G[0], E[0]) if np.isfinite(E).all() else None

    def _rest_radii(
        self, x: Array, theta: Array, r: Array, Y: Array, G: Array, least: float
    ) -> tuple[Array, dict[str, Interval]]:
        """E (b, n), infinite where none is mapped into itself, and the boxes of all symbols."""
        n, b = len(self.moving_states), len(theta)
        if not n:
            return np.zeros((b, 0)), self._boxes(x, theta, x, r)
        thin = self.rate(self._boxes(x, theta, np.zeros_like(x), np.zeros_like(r)), b)
        start = reach(np.abs(Y), thin.size[:, :, 0])
        E = 2 * start + least * (1 + np.abs(x))
        inside = np.zeros(b, dtype=bool)
        for _ in range(INFLATIONS):
            slopes = self.rate_slopes(self._boxes(x, theta, _reach_of_rest(G, r, E), r), b)
            image = _image(thin, slopes, r, Y, G, E)
            good = np.asarray((image < E).all(axis=1))
            inside |= good
            if inside.all():
                break
            E = np.where(inside[:, np.newaxis], E, np.maximum(E, GROWTH * image))
        E = np.where(inside[:, np.newaxis] & np.isfinite(E), E, np.inf)
        finite = np.where(np.isfinite(E), E, 0.0)
        return E, self._boxes(x, theta, _reach_of_rest(G, r, finite), r)

    def _boxes(self, x: Array, theta: Array, dx: Array, r: Array) -> dict[str, Interval]:
        """The intervals of all symbols: states and parameters within a distance, and the numbers that stay."""
        held = {name: Interval(*(np.full(len(theta), value),) * 2) for name, value in self.still.items()}
        for names, middle, radius in zip(self.names, (x, theta), (dx, r), strict=True):
            wide = radius > 0
            low = np.where(wide, np.nextafter(middle - radius, -np.inf), middle)
            high = np.where(wide, np.nextafter(middle + radius, np.inf), middle)
            held |= {name: Interval(low[:, k], high[:, k]) for k, name in enumerate(names)}
        return held

    def _at(self, x: Array, theta: Array) -> tuple[Array, Array, Array]:
        """The rate (b, n, 1), its slopes (b, n, n + d) and M (b, q, w), as computed."""
        b = len(theta)
        shapes = (self.rate.shape, self.rate_slopes.shape, self.matrix.shape)
        found = self.values(x.T, theta.T) if len(self.moving_states) else self.values(np.zeros((0, b)), theta.T)
        f, slopes, M = (
            np.array(part).reshape(rows, b, columns).swapaxes(0, 1)
            for part, (rows, columns) in zip(found, shapes, strict=True)
        )
        return f, slopes, M


def _image(thin: MatrixBall, slopes: MatrixBall, r: Array, Y: Array, G: Array, E: Array) -> Array:
    """A bound (b, n) of |e - Y f(x_c + G d + e, theta_c + d)| over |d| <= r, |e| <= E."""
    n = E.shape[1]
    by_x, by_theta = MatrixBall(*(part[:, :, :n] for part in slopes)), MatrixBall(*(part[:, :, n:] for part in slopes))
    along = product(Y, add_balls(by_theta, product_right(by_x, G)))
    kept = product(Y, by_x)
    left = MatrixBall(np.eye(n) - kept.middle, kept.radius + 2 * UNIT * (1 + np.abs(kept.middle)))
    there = product(Y, thin).size[:, :, 0]
    return np.asarray((there + reach(along.size, r) + reach(left.size, E)) * (1 + 8 * UNIT))


def _reach_of_rest(G: Array, r: Array, E: Array) -> Array:
    """A bound (b, n) of |G d + e|."""
    return np.asarray((reach(np.abs(G), r) + E) * (1 + 4 * UNIT))


def _refuse_jumps(expressions: ca.SX, varying_names: list[str]) -> None:
    """Refuse equations that may jump, or have a corner, as the rest or the box moves."""
    if ca.symvar(expressions) and (found := jumps(walk(expressions, cse=True), varying_names)):
        raise NoBound(f"its equations have a corner or a jump ({found[0].lower()}), near which no derivative holds")


def _flat(matrices: Array) -> Array:
    """The entries (b, q w) of matrices (b, q, w), column by column."""
    return matrices.swapaxes(1, 2).reshape(len(matrices), -1)


def _solve_each(matrices: Array, right: Array) -> Array:
    return np.asarray(_inverses(matrices) @ right)


def _inverses(matrices: Array) -> Array:
    """The inverses (b, n, n); NaN turned to zero where there is none, so that nothing is proved."""
    found = np.zeros_like(matrices)
    for own, M in zip(found, matrices, strict=True):
        if M.size and np.isfinite(M).all():
            try:
                own[:] = np.linalg.inv(M)
            except np.linalg.LinAlgError:
                own[:] = 0.0
    return found
