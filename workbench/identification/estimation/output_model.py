"""The outputs of an equation along the experiments of a dataset, and their exact derivatives by unknown numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import casadi as ca
import numpy as np

from workbench.core import Ode
from workbench.core.expressions import rows
from workbench.core.validation.refusals import Array, Integers
from workbench.engine.record_runs import run_along
from workbench.identification.datasets import Dataset
from workbench.identification.estimation.driven_steps import directed_step, plain_step
from workbench.identification.estimation.input_record import InputRecord, MeasuredInput, input_record
from workbench.identification.estimation.unknown_numbers import UnknownNumber


@dataclass(frozen=True, eq=False)
class OutputModel:
    """Outputs y(t; z) of an equation that is driven by the inputs of a log, for unknown numbers z (nz,).

    y of a sensor is scale * h(t, x, p) + offset, at the samples of each experiment, the first of which is at `begins`.
    """

    ode: Ode
    dataset: Dataset
    inputs: tuple[MeasuredInput, ...]
    outputs: tuple[tuple[str, str], ...]  # the label in the log, and that of a state or an output of the equation
    numbers: tuple[UnknownNumber, ...]
    p: Array  # (np,), parameters; those that are unknown are replaced
    x0: Array  # (E, nx), initial states of the experiments, likewise
    h: tuple[float, ...]  # the longest step in s of each experiment
    begins: tuple[float, ...]  # the time t of the equation in s at the first sample of each experiment

    @cached_property
    def places(self) -> Mapping[str, Integers]:
        """The places in z of the numbers of each kind."""
        kinds = np.array([number.kind for number in self.numbers])
        return {
            kind: np.flatnonzero(kinds == kind) for kind in ("parameter", "initial state", "delay", "offset", "scale")
        }

    @cached_property
    def starts(self) -> Array:
        """The values z (nz,) at which a search begins."""
        return np.array([number.start for number in self.numbers])

    def at_half_step(self) -> OutputModel:
        """The same model with steps that are half as long."""
        return replace(self, h=tuple(h / 2 for h in self.h))

    def values(self, z: Array, experiment: int) -> Array:
        """The outputs (B, N, ny) at the samples of an experiment, for numbers z (B, nz)."""
        drive = self.drive(experiment, z)
        step = plain_step(self.ode, drive.record)
        x = run_along(step, self._parameters(z), self._initial(z, experiment))[:, drive.samples]
        y = np.stack([self._outputs(drive, one, p) for one, p in zip(x, self._parameters(z), strict=True)])
        return self._sensed(y, z)

    def derivatives(self, z: Array, experiment: int) -> tuple[Array, Array]:
        """The outputs (N, ny) at the samples of an experiment, and their derivatives (N, ny, nz), for z (nz,)."""
        own = self._directions(experiment)
        drive = self.drive(experiment, z[np.newaxis])
        p, x0 = self._parameters(z[np.newaxis])[0], self._initial(z[np.newaxis], experiment)[0]
        inner, dy = self._inner(drive, experiment, own, p, x0)
        y = self._sensed(inner[np.newaxis], z[np.newaxis])[0]
        J = np.zeros((*y.shape, len(z)))
        J[:, :, own] = self._scales(z[np.newaxis])[0][:, np.newaxis] * dy
        names = [signal for signal, _ in self.outputs]
        for i in self.places["offset"]:
            J[:, names.index(self.numbers[i].label), i] = 1.0
        for i in self.places["scale"]:
            column = names.index(self.numbers[i].label)
            J[:, column, i] = inner[:, column]
        return y, J

    # of the equation

    def _directions(self, experiment: int) -> Integers:
        """The places in z of what moves the states of an experiment: parameters, delays and its own initial states."""
        name = self.dataset.names[experiment]
        initial = [i for i in self.places["initial state"] if self.numbers[i].experiment == name]
        return np.concatenate([self.places["parameter"], self.places["delay"], initial]).astype(int)

    def _inner(self, drive: InputRecord, experiment: int, own: Integers, p: Array, x0: Array) -> tuple[Array, Array]:
        """The outputs of the equation (N, ny), and their derivatives (N, ny, m) in the directions `own`."""
        m, nx = len(own), self.ode.states.size
        parameters = tuple(self.ode.parameters.labels.index(self.numbers[i].label) for i in self.places["parameter"])
        delayed = tuple(self.numbers[i].label for i in self.places["delay"])
        if not m:
            x = run_along(plain_step(self.ode, drive.record), p[np.newaxis], x0[np.newaxis])[0]
            y = self._outputs(drive, x[drive.samples], p)
            return y, np.zeros((*y.shape, 0))
        step = directed_step(self.ode, drive.record, parameters, tuple(drive.slopes[name] for name in delayed))
        start = np.zeros((m, step.states.size))
        start[:, :nx] = x0
        moving = len(parameters) + len(delayed)
        start[:moving, 2 * nx :] = np.eye(moving)
        for row, i in enumerate(own[moving:], moving):
            start[row, nx + self.ode.states.labels.index(self.numbers[i].label)] = 1.0
        x = run_along(step, np.broadcast_to(p, (m, p.size)), start)[:, drive.samples]
        dp, du = np.zeros((m, p.size)), np.zeros((m, *drive.at_samples.shape))
        dp[np.arange(len(parameters)), parameters] = 1.0
        for row, name in enumerate(delayed, len(parameters)):
            du[row] = drive.changes[name]
        y = self._outputs(drive, x[0, :, :nx], p)
        each = zip(x, dp, du, strict=True)
        slopes = [self._changes(drive, states[:, : 2 * nx], p, dq, dv) for states, dq, dv in each]
        return y, np.stack(slopes, axis=2)

    def drive(self, experiment: int, z: Array) -> InputRecord:
        """The inputs of an experiment in substeps, with the delays of the first row of z."""
        delays = {self.numbers[i].label: float(z[0, i]) for i in self.places["delay"]}
        return input_record(
            self.dataset.experiments[experiment],
            self.inputs,
            delays,
            self._instants,
            self.h[experiment],
            self.begins[experiment],
        )

    @cached_property
    def _instants(self) -> Array:
        """The instants in s at which the rate jumps, as known before a run."""
        end = max(begin + float(np.ptp(one.t)) for begin, one in zip(self.begins, self.dataset, strict=True))
        return self.ode.switches.until(self.p[np.newaxis], end)[0]

    def _parameters(self, z: Array) -> Array:
        p = np.tile(self.p, (len(z), 1))
        for i in self.places["parameter"]:
            p[:, self.ode.parameters.labels.index(self.numbers[i].label)] = z[:, i]
        return p

    def _initial(self, z: Array, experiment: int) -> Array:
        x0, name = np.tile(self.x0[experiment], (len(z), 1)), self.dataset.names[experiment]
        for i in self.places["initial state"]:
            if self.numbers[i].experiment == name:
                x0[:, self.ode.states.labels.index(self.numbers[i].label)] = z[:, i]
        return x0

    # of the sensors

    def _outputs(self, drive: InputRecord, x: Array, p: Array) -> Array:
        """The outputs of the equation (N, ny) in states x (N, nx)."""
        return rows(
            self._output_functions[0], drive.record.t[drive.samples, np.newaxis], x, p[np.newaxis], drive.at_samples
        )

    def _changes(self, drive: InputRecord, x: Array, p: Array, dp: Array, du: Array) -> Array:
        """The derivatives of the outputs (N, ny) along a direction; x (N, 2 nx) are states and their derivatives."""
        t = drive.record.t[drive.samples, np.newaxis]
        u = np.hstack([drive.at_samples, du])
        return rows(self._output_functions[1], t, x, np.concatenate([p, dp])[np.newaxis], u)

    @cached_property
    def _output_functions(self) -> tuple[ca.Function, ca.Function]:
        """The outputs of (t, x, p, u), and their derivatives along directions, of (t, [x; S], [p; dp], [u; du])."""
        ode, u = self.ode, ca.SX.sym("u", len(self.inputs))
        both = ca.vertcat(ode.x, ode.output)
        labels = (*ode.states.labels, *ode.outputs.labels)
        y = both[[labels.index(label) for _, label in self.outputs]]
        places = [ode.parameters.labels.index(one.label) for one in self.inputs]
        S, dp, du = (
            ca.SX.sym(name, size) for name, size in (("S", ode.x.numel()), ("dp", ode.p.numel()), ("du", u.numel()))
        )
        directions = ca.SX(dp)
        directions[places] += du
        dy = ca.jtimes(y, ca.vertcat(ode.x, ode.p), ca.vertcat(S, directions))
        y, dy = (ca.substitute(part, ode.p[places], u) if places else part for part in (y, dy))
        return (
            ca.Function("outputs", [ode.t, ode.x, ode.p, u], [ca.densify(y)]),
            ca.Function(
                "changes",
                [ode.t, ca.vertcat(ode.x, S), ca.vertcat(ode.p, dp), ca.vertcat(u, du)],
                [ca.densify(dy)],
            ),
        )

    def _scales(self, z: Array) -> Array:
        """The scales (B, ny) of the sensors."""
        return self._of_sensors("scale", 1.0, z)

    def _of_sensors(self, kind: str, default: float, z: Array) -> Array:
        values, names = np.full((len(z), len(self.outputs)), default), [signal for signal, _ in self.outputs]
        for i in self.places[kind]:
            values[:, names.index(self.numbers[i].label)] = z[:, i]
        return values

    def _sensed(self, y: Array, z: Array) -> Array:
        """The readings of the sensors for outputs y (B, N, ny)."""
        return self._scales(z)[:, np.newaxis] * y + self._of_sensors("offset", 0.0, z)[:, np.newaxis]
