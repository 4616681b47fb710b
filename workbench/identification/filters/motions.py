"""The motion of a model along the samples of a log, with exact Jacobians: from sample to sample, and its readings."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import casadi as ca
import numpy as np

from workbench.core import Layout, Ode
from workbench.core.recorded_step import SignalRecord, recorded_step
from workbench.core.step import StepMap
from workbench.core.validation.refusals import Array
from workbench.identification.filters.array_steps import triangle
from workbench.identification.filters.compiled_function import CompiledFunction
from workbench.identification.filters.discrete_model import DiscreteModel
from workbench.identification.filters.filter_columns import FilterColumns

MOST_COLUMNS = 12  # of noise per state, beyond which they are joined


class AbstractMotion(ABC):
    """A model along the N samples of a log."""

    states: Layout
    log: FilterColumns

    @abstractmethod
    def advance(self, k: int, x: Array) -> tuple[Array, Array, Array]:
        """From sample k to the next: the state (n,), its Jacobian (n, n), and the root (n, l) of the noise."""

    @abstractmethod
    def advance_all(self, k: int, points: Array) -> Array:
        """The states (n, m) that points (n, m) become."""

    @abstractmethod
    def read(self, k: int, x: Array) -> tuple[Array, Array]:
        """The readings (q,) of sample k at a state, and their Jacobian (q, n)."""

    @abstractmethod
    def read_all(self, k: int, points: Array) -> Array:
        """The readings (q, m) at points (n, m)."""


@dataclass(frozen=True, eq=False)
class MapExpressions:
    """x+ = f(k, x, p, w) and y = h(k, x, p), as expressions in their symbols."""

    k: ca.SX
    x: ca.SX
    p: ca.SX
    w: ca.SX
    next: ca.SX
    output: ca.SX

    @staticmethod
    def of_model(model: DiscreteModel) -> MapExpressions:
        """Those of a discrete model, which has no random numbers of its own."""
        return MapExpressions(model.k, model.x, model.u, ca.SX(0, 1), model.next, model.output)

    @staticmethod
    def of_step(step: StepMap) -> MapExpressions:
        """Those of a step, whose random numbers are noise."""
        k, x = ca.SX.sym("k"), step.states.symbols()
        p, w = step.parameters.symbols(), ca.SX.sym("w", step.noises)
        return MapExpressions(k, x, p, w, step.F(k, x, p, w), step.y(k, x, p, w))


class MapMotion(AbstractMotion):
    """A map from sample to sample, with parameters (N, np), numbers k (N,) and the root of Q (n, l)."""

    def __init__(
        self, states: Layout, log: FilterColumns, map_: MapExpressions, rows: Array, k: Array, noise: Array
    ) -> None:
        self.states, self.log = states, log
        self._k, self._rows, self._noise = k[:, None], rows, noise
        self._map = map_
        zero = ca.DM.zeros(map_.w.numel())
        self._output = ca.substitute(map_.output[list(log.output_places)], map_.w, zero)
        self._next = ca.substitute(map_.next, map_.w, zero)
        G = ca.substitute(ca.jacobian(map_.next, map_.w), map_.w, zero)
        arguments = [map_.x, map_.k, map_.p]
        self._advance = CompiledFunction("advance", arguments, [self._next, ca.jacobian(self._next, map_.x), G])
        self._read = CompiledFunction("read", arguments, [self._output, ca.jacobian(self._output, map_.x)])
        self._many: dict[str, CompiledFunction] = {}

    def advance(self, k: int, x: Array) -> tuple[Array, Array, Array]:
        """The next state, its Jacobian and the root of the noise."""
        moved, F, G = self._advance(x, self._k[k], self._rows[k])
        noise = np.hstack([self._noise, G]) if G.shape[1] else self._noise
        return moved[:, 0].copy(), F, noise

    def advance_all(self, k: int, points: Array) -> Array:
        """The states that points become."""
        return self._all("next", self._next, k, points)

    def read(self, k: int, x: Array) -> tuple[Array, Array]:
        """The readings of a sample and their Jacobian."""
        y, H = self._read(x, self._k[k], self._rows[k])
        return y[:, 0], H

    def read_all(self, k: int, points: Array) -> Array:
        """The readings at points."""
        return self._all("output", self._output, k, points)

    def _all(self, name: str, value: ca.SX, k: int, points: Array) -> Array:
        m = points.shape[1]
        if name not in self._many:
            arguments = [self._map.x, self._map.k, self._map.p]
            self._many[name] = CompiledFunction(name, arguments, [value], m)
        return self._many[name](points, self._k[k], self._rows[k])[0]


class OdeMotion(AbstractMotion):
    """An `Ode` along the instants of a log, by Runge-Kutta steps of two halves, driven by the inputs of the log.

    White noise of intensity Q = Lq Lq' gathers over a step of h seconds, by Simpson's rule over the exact Jacobians of
    its halves, as the columns [sqrt(h / 6) F2 F1 Lq, sqrt(2 h / 3) F2 Lq, sqrt(h / 6) Lq].

    Parameters
    ----------
    ode
        The equations.
    log
        The columns of the log.
    p
        (np,), the parameters.
    noise
        (nx, l), the square root Lq of the intensity of the noise.
    hold
        "hold" if an input stays constant up to the next sample, or "linear" if it changes along a straight line.
    parts
        The number of steps in an interval of the usual length; longer ones have more.
    """

    def __init__(self, ode: Ode, log: FilterColumns, p: Array, noise: Array, hold: str, parts: int) -> None:
        self.states, self.log, self._ode = ode.states, log, ode
        self._p = p.copy()
        self._begins, self._rows = _divided(log, hold, parts)
        self._places = [label for name in log.input_labels for label in ode.parameters.indices(name)]
        self._sample_rows = np.column_stack([np.broadcast_to(p, (len(log.t), p.size)), log.t])
        self._sample_rows[:, self._places] = log.u
        record = SignalRecord(
            np.array([0.0, 1.0]), log.input_labels, *(np.zeros((1, log.u.shape[1])) for _ in range(2))
        )
        rule = recorded_step(ode, record).rule
        self._half = ca.Function("half", [rule.x, rule.p, rule.d], [rule.F(1.0, 0.0, rule.x, rule.p, [], rule.d)])
        self._step = CompiledFunction(*self._step_expressions(noise))
        self._sample = ca.vertcat(ode.p, ode.t)
        self._output = ode.output[list(log.output_places)]
        self._read = CompiledFunction("read", [ode.x, self._sample], [self._output, ca.jacobian(self._output, ode.x)])
        self._many: dict[str, CompiledFunction] = {}

    def _step_expressions(self, noise: Array) -> tuple[str, list[ca.SX], list[ca.SX]]:
        """A step of two halves: the arguments x, p and both rows d, and the results x+, F and the root of the noise."""
        n, nd = self._ode.states.size, 2 + 2 * self.log.u.shape[1]
        x, middle = ca.SX.sym("x", n), ca.SX.sym("middle", n)
        p, d = ca.SX.sym("p", self._p.size), ca.SX.sym("d", 2 * nd)
        halfway = self._half(x, p, d[:nd])
        F1 = ca.jacobian(halfway, x)
        end = self._half(middle, p, d[nd:])
        moved, F2 = (ca.substitute(part, middle, halfway) for part in (end, ca.jacobian(end, middle)))
        h, F, L = d[1] + d[nd + 1], F2 @ F1, ca.DM(noise)
        added = ca.horzcat(ca.sqrt(h / 6) * (F @ L), ca.sqrt(2 * h / 3) * (F2 @ L), ca.sqrt(h / 6) * L)
        return "step", [x, p, d], [moved, F, added]

    def advance(self, k: int, x: Array) -> tuple[Array, Array, Array]:
        """The next state, its Jacobian and the root of the noise."""
        moved, F, noise = self._step(x, self._p, self._rows[self._begins[k]])
        state, Phi, added = moved[:, 0], F.copy(), noise.copy()
        for row in range(self._begins[k] + 1, self._begins[k + 1]):
            moved, F, noise = self._step(state, self._p, self._rows[row])
            state, Phi, added = moved[:, 0], F.dot(Phi), np.hstack([F.dot(added), noise])
            if added.shape[1] > MOST_COLUMNS * len(added):
                added = triangle(np.asfortranarray(added.T)).T
        return state.copy(), Phi, added

    def advance_all(self, k: int, points: Array) -> Array:
        """The states that points become."""
        m = points.shape[1]
        if "step" not in self._many:
            _, (x, p, d), (moved, *_) = self._step_expressions(np.zeros((points.shape[0], 0)))
            self._many["step"] = CompiledFunction("steps", [x, p, d], [moved], m)
        for row in range(self._begins[k], self._begins[k + 1]):
            points = self._many["step"](points, self._p, self._rows[row])[0]
        return points

    def read(self, k: int, x: Array) -> tuple[Array, Array]:
        """The readings of a sample and their Jacobian."""
        y, H = self._read(x, self._sample_rows[k])
        return y[:, 0], H

    def read_all(self, k: int, points: Array) -> Array:
        """The readings at points."""
        if "read" not in self._many:
            arguments = [self._ode.x, self._sample]
            self._many["read"] = CompiledFunction("reads", arguments, [self._output], points.shape[1])
        return self._many["read"](points, self._sample_rows[k])[0]


def _divided(log: FilterColumns, hold: str, parts: int) -> tuple[list[int], Array]:
    """The first step of each interval (N,), and the numbers (steps, 2 (2 + 2 nd)) of the two halves of each step."""
    lengths = np.diff(log.t)
    if not len(lengths):
        return [0], np.zeros((0, 4 + 4 * log.u.shape[1]))
    counts = parts * np.maximum(1, np.ceil(lengths / np.median(lengths) - 0.01).astype(int))
    begins = np.concatenate([[0], np.cumsum(counts)])
    interval = np.repeat(np.arange(len(lengths)), 2 * counts)
    half = np.arange(len(interval)) - 2 * begins[interval]
    shares = half[:, None] / (2 * counts[interval])[:, None], (half + 1)[:, None] / (2 * counts[interval])[:, None]
    change = np.diff(log.u, axis=0)[interval] if hold == "linear" else np.zeros((len(interval), log.u.shape[1]))
    ends = [log.u[interval] + share * change for share in shares]
    instants = log.t[interval] + shares[0][:, 0] * lengths[interval]
    record = SignalRecord(np.append(instants, log.t[-1]), log.input_labels, *ends)
    return [int(begin) for begin in begins], record.rows.reshape(int(begins[-1]), -1)
