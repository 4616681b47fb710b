"""The response of a system to an input that is linear in coefficients, and its exact derivatives by them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from workbench.core.expressions import rows
from workbench.core.recorded_step import record_rows
from workbench.core.validation.refusals import Array, Integers
from workbench.identification.estimation.input_record import InputRecord, input_record
from workbench.identification.estimation.output_model import OutputModel
from workbench.identification.experiments.path_limits import PathLimits
from workbench.identification.experiments.step_functions import StepFunctions, backward, march, step_functions

Weigh = Callable[[Array], tuple[float, Array | None]]  # a value and its derivatives, or None where it has none


@dataclass(frozen=True, eq=False)
class DrivenResponse:
    """Information and limits of an experiment, as functions of the coefficients c (nu, nb) of its inputs.

    The steps are those of `OutputModel`, whose dataset gives the samples.
    """

    model: OutputModel
    limits: PathLimits
    basis: Array  # (N, nb), of the inputs at the samples
    sigma: Array  # (ny,)

    def at_half_step(self) -> DrivenResponse:
        """The same with steps that are half as long."""
        return replace(self, model=self.model.at_half_step())

    def with_basis(self, basis: Array) -> DrivenResponse:
        """The same for inputs of another shape."""
        return replace(self, basis=basis)

    @cached_property
    def functions(self) -> StepFunctions:
        """The functions of its equation."""
        model = self.model
        labels = tuple(one.label for one in model.inputs)
        kinds = tuple((number.kind, number.label) for number in model.numbers)
        return step_functions(model.ode, labels, kinds, model.outputs)

    @cached_property
    def record(self) -> InputRecord:
        """The instants of the steps."""
        model, end = self.model, float(self.model.dataset.experiments[0].t[-1])
        instants = model.ode.switches.until(model.p[np.newaxis], end)[0]
        delays = {one.signal: delay for one, delay in zip(model.inputs, self.delays, strict=True) if delay}
        return input_record(model.dataset.experiments[0], model.inputs, delays, instants, model.h[0])

    @cached_property
    def delays(self) -> Array:
        """(nu,), the delays of the inputs in s."""
        delays = {number.label: number.start for number in self.model.numbers if number.kind == "delay"}
        return np.array([delays.get(one.label, 0.0) for one in self.model.inputs])

    @cached_property
    def bases(self) -> tuple[Array, Array]:
        """The bases (K, nu, nb) of the inputs that act at the begin and at the end of each step."""
        pairs = [self._prompt_bases if not delay else self._delayed_bases(delay) for delay in self.delays]
        begins, ends = zip(*pairs, strict=True)
        return np.stack(begins, axis=1), np.stack(ends, axis=1)

    def _delayed_bases(self, delay: float) -> tuple[Array, Array]:
        """The bases (K, nb) at the begin and at the end of each step of an input on straight lines that acts later."""
        t, begin = self.record.record.t, self.record.record.t[self.record.samples]
        at = np.maximum(t - delay, begin[0])
        row = np.clip(np.searchsorted(begin, at, side="right") - 1, 0, len(begin) - 2)
        share = ((at - begin[row]) / (begin[row + 1] - begin[row]))[:, np.newaxis]
        values = self.basis[row] + share * (self.basis[row + 1] - self.basis[row])
        return values[:-1], values[1:]

    @cached_property
    def _prompt_bases(self) -> tuple[Array, Array]:
        """The bases (K, nb) at the begin and at the end of each step of an input without delay."""
        t, samples = self.record.record.t, self.record.samples
        row = np.searchsorted(samples, np.arange(len(t) - 1), side="right") - 1
        if self.model.inputs[0].hold == "hold":
            return self.basis[row], self.basis[row]
        first, span = t[samples[row]], t[samples[row + 1]] - t[samples[row]]
        change = self.basis[row + 1] - self.basis[row]
        begins, ends = (((at - first) / span)[:, np.newaxis] for at in (t[:-1], t[1:]))
        return self.basis[row] + begins * change, self.basis[row] + ends * change

    def numbers(self, c: Array) -> Array:
        """The recorded numbers (K, 2 + 2 nu) of the steps."""
        return record_rows(self.record.record.t, *self.inputs(c))

    def inputs(self, c: Array) -> tuple[Array, Array]:
        """The inputs (K, nu) that act at the begin and at the end of each step."""
        begins, ends = (np.einsum("kub,ub->ku", basis, c) for basis in self.bases)
        return begins, ends

    # the motion and its limits

    def states(self, c: Array) -> Array:
        """The states (K + 1, nx); not finite from where a run diverges."""
        run, x0 = march(self.functions.plain, len(self.bases[0])), self.model.x0[0]
        return np.vstack([x0, np.array(run(x0, self.numbers(c).T, self.model.p)).T])

    def _instants(self, x: Array, c: Array) -> tuple[Array, Array, Array]:
        """Instants (2 K,), states and inputs at the begins of all steps, and then at their ends."""
        t = self.record.record.t
        return np.concatenate([t[:-1], t[1:]]), np.vstack([x[:-1], x[1:]]), np.vstack(self.inputs(c))

    @cached_property
    def _limits_of_inputs(self) -> list[tuple[int, int]]:
        """The places of limits of inputs with a delay, and of their inputs: they hold for what is commanded."""
        own = [
            (i, self.limits.inputs.index(name))
            for i, name in enumerate(self.limits.names)
            if name in self.limits.inputs
        ]
        return [(i, u) for i, u in own if self.delays[u]]

    def margins(self, c: Array) -> Array:
        """The distances (rows, all limits, 2) to the lower and upper ends, as shares of each range; NaN is none."""
        x = self.states(c)
        if not np.isfinite(x).all():
            return np.full((1, len(self.limits.all_names), 2), -np.inf)
        t, at, u = self._instants(x, c)
        values = self.limits.values(t, at, self.model.p, u)
        for i, place in self._limits_of_inputs:
            values[:, i] = np.vstack(self._prompt_bases) @ c[place]
        return self._ordered(values, self.input_slopes @ c.T)

    @cached_property
    def input_slopes(self) -> Array:
        """(N - 1, nb), the slopes of the basis between samples."""
        return np.asarray(np.diff(self.basis, axis=0) / np.diff(self.model.dataset.experiments[0].t)[:, np.newaxis])

    def _ordered(self, values: Array, slopes: Array) -> Array:
        """Distances of values (2 K, nl) and slopes of inputs (N - 1, nu) to the ends of the limits."""
        ends, count = self.limits.all_ends, max(len(values), len(slopes))
        every = np.full((count, len(ends)), np.nan)
        every[: len(values), : values.shape[1]] = values
        for column, (i, _, _) in enumerate(self.limits.slopes, values.shape[1]):
            every[: len(slopes), column] = slopes[:, i]
        distances = np.stack([every - ends[:, 0], ends[:, 1] - every], axis=2)
        return np.where(np.isnan(distances), np.inf, distances) / self.limits.scales[:, np.newaxis]

    def margin_slopes(self, c: Array, places: Integers) -> Array:
        """The derivatives (M, nu nb) of margins at `places` (M, 3): row, limit and end."""
        x, (nu, nb) = self.states(c), c.shape
        out, nx = np.zeros((len(places), nu * nb)), x.shape[1]
        dx = self._state_slopes(x, c)
        t, at, u = self._instants(x, c)
        is_path, sign = places[:, 1] < len(self.limits.names), np.where(places[:, 2] == 0, 1.0, -1.0)
        row, limit = places[is_path, 0], places[is_path, 1]
        if row.size:
            local = self.limits.derivatives(t[row], at[row], self.model.p, u[row])[np.arange(row.size), limit]
            steps = len(self.bases[0])
            k = np.where(row < steps, row, row - steps + 1)
            bases = np.vstack(self.bases)[row]
            for i, place in self._limits_of_inputs:
                bases[limit == i, place] = np.vstack(self._prompt_bases)[row[limit == i]]
            direct = local[:, nx:, np.newaxis] * bases
            out[is_path] = np.einsum("mi,mij->mj", local[:, :nx], dx[k]) + direct.reshape(row.size, -1)
        for m in np.flatnonzero(~is_path):
            i = self.limits.slopes[places[m, 1] - len(self.limits.names)][0]
            out[m, i * nb : (i + 1) * nb] = self.input_slopes[places[m, 0]]
        return np.asarray(out * (sign / self.limits.scales[places[:, 1]])[:, np.newaxis])

    def _state_slopes(self, x: Array, c: Array) -> Array:
        """The derivatives (K + 1, nx, nu nb) of the states by the coefficients."""
        (nu, nb), nx, d = c.shape, x.shape[1], self.numbers(c)
        flat = rows(self.functions.slopes, x[:-1], d, self.model.p[np.newaxis])
        slopes = flat.reshape(len(d), nx, nx + d.shape[1])
        begins, ends = self.bases
        A, middle, change = slopes[:, :, :nx], slopes[:, :, nx + 2 : nx + 2 + nu], slopes[:, :, nx + 2 + nu :]
        drive = np.einsum("kiu,kub->kiub", middle, (begins + ends) / 2)
        drive = drive + np.einsum("kiu,kub->kiub", change, ends - begins)
        drive = drive.reshape(len(d), nx, nu * nb)
        out = np.zeros((len(d) + 1, nx, nu * nb))
        for k in range(len(d)):
            out[k + 1] = A[k] @ out[k] + drive[k]
        return out

    # the information

    @cached_property
    def _start(self) -> Array:
        """X at the start: the states, and 1 for the derivative of each by its own unknown initial value."""
        model = self.model
        S = np.zeros((model.ode.states.size, len(model.numbers)))
        for i, number in enumerate(model.numbers):
            if number.kind == "initial state":
                S[model.ode.states.labels.index(number.label), i] = 1.0
        return np.concatenate([model.x0[0], S.T.ravel()])

    def _wide_states(self, c: Array) -> Array:
        run = march(self.functions.wide, len(self.bases[0]))
        return np.vstack([self._start, np.array(run(self._start, self.numbers(c).T, self.model.p)).T])

    def derivatives(self, c: Array) -> Array:
        """The derivatives (N, ny, nz) of the outputs at the samples by the numbers, in standard deviations."""
        X, u = self._wide_states(c), self.basis @ c.T
        return self._derivatives(X, u)

    def _derivatives(self, X: Array, u: Array) -> Array:
        t = self.record.record.t[self.record.samples, np.newaxis]
        flat = rows(self.functions.outputs, X[self.record.samples], t, u, self.model.p[np.newaxis])
        J = flat.reshape(len(u), len(self.model.numbers), -1).transpose(0, 2, 1)
        return np.asarray(J / self.sigma[:, np.newaxis])

    def pull_back(self, c: Array, weigh: Weigh) -> tuple[float, Array]:
        """A function of the derivatives (N, ny, nz) and its gradient (nu, nb) by the coefficients.

        `weigh` gives the value, and its derivatives by those derivatives.
        """
        X, u = self._wide_states(c), self.basis @ c.T
        value, G = weigh(self._derivatives(X, u)) if np.isfinite(X).all() else (np.inf, None)
        if G is None:
            return np.inf, np.zeros_like(c)
        G = (G / self.sigma[:, np.newaxis]).transpose(0, 2, 1).reshape(len(u), -1)
        samples, t = self.record.samples, self.record.record.t
        pulls = rows(self.functions.pulls, X[samples], t[samples, np.newaxis], u, self.model.p[np.newaxis], G)
        seeds = np.zeros_like(X)
        seeds[samples] = pulls[:, : X.shape[1]]
        direct = pulls[:, X.shape[1] :].T @ self.basis
        back = backward(march(self.functions.wide, len(X) - 1))
        nu, (begins, ends) = len(c), self.bases
        d = np.array(back(self._start, self.numbers(c).T, self.model.p, X[1:].T, seeds[1:].T)).T
        through = np.einsum("ku,kub->ub", d[:, 2 : 2 + nu], (begins + ends) / 2)
        return value, direct + through + np.einsum("ku,kub->ub", d[:, 2 + nu :], ends - begins)
