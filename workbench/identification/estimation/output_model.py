"""The outputs of an equation along the experiments of a dataset, and their exact derivatives by unknown numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from workbench.core import Ode, SampledSystem
from workbench.core.validation.refusals import Array, Integers
from workbench.engine.record_runs import run_along
from workbench.identification.datasets import Dataset
from workbench.identification.estimation.driven_steps import directed_step, plain_step
from workbench.identification.estimation.input_record import InputRecord, MeasuredInput, input_record
from workbench.identification.estimation.output_map import OutputMap
from workbench.identification.estimation.unknown_numbers import UnknownNumber


@dataclass(frozen=True, eq=False)
class OutputModel:
    """Outputs y(t; z) of a system that is driven by the inputs of a log, for unknown numbers z (nz,).

    y of a sensor is scale * h(t, x, p) + offset, at the samples of each experiment, the first of which is at `begins`.
    """

    system: Ode | SampledSystem
    dataset: Dataset
    inputs: tuple[MeasuredInput, ...]
    outputs: tuple[tuple[str, str], ...]  # the label in the log, and that of a state or an output of the equation
    numbers: tuple[UnknownNumber, ...]
    p: Array  # (np,), parameters; those that are unknown are replaced
    x0: Array  # (E, nx), initial states of the experiments, likewise
    h: tuple[float, ...]  # the longest step in s of each experiment
    begins: tuple[float, ...]  # the time t of the equation in s at the first sample of each experiment

    @property
    def ode(self) -> Ode:
        """The equation in continuous time: the system, or its flow between the instants of a computer."""
        return self.system.flow if isinstance(self.system, SampledSystem) else self.system

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
        step = plain_step(self.system, drive.record)
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
            x = run_along(plain_step(self.system, drive.record), p[np.newaxis], x0[np.newaxis])[0]
            y = self._outputs(drive, x[drive.samples], p)
            return y, np.zeros((*y.shape, 0))
        step = directed_step(self.system, drive.record, parameters, tuple(drive.slopes[name] for name in delayed))
        start = np.zeros((m, step.states.size))
        start[:, :nx] = x0
        moving = len(parameters) + len(delayed)
        start[:moving, 2 * nx :] = np.eye(moving)
        for row, i in enumerate(own[moving:], moving):
            start[row, nx + self.ode.states.labels.index(self.numbers[i].label)] = 1.0
        x = run_along(step, np.broadcast_to(p, (m, p.size)), start)[:, drive.samples, : 2 * nx]
        changes = [drive.changes[name] for name in delayed]
        t = drive.record.t[drive.samples]
        return self._map.derivatives(t, x[0, :, :nx], p, drive.at_samples, x[:, :, nx:], parameters, changes)

    def drive(self, experiment: int, z: Array) -> InputRecord:
        """The inputs of an experiment in substeps, with the delays of the first row of z; the last one is kept."""
        delays = {self.numbers[i].label: float(z[0, i]) for i in self.places["delay"]}
        key = tuple(delays.values())
        if experiment not in self._drives or self._drives[experiment][0] != key:
            record = input_record(
                self.dataset.experiments[experiment],
                self.inputs,
                delays,
                self._instants,
                self.h[experiment],
                self.begins[experiment],
                self.system.period if isinstance(self.system, SampledSystem) else None,
            )
            self._drives[experiment] = key, record
        return self._drives[experiment][1]

    @cached_property
    def _drives(self) -> dict[int, tuple[tuple[float, ...], InputRecord]]:
        """The last record of each experiment, and its delays."""
        return {}

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
        return self._map.values(drive.record.t[drive.samples], x, p, drive.at_samples)

    @cached_property
    def _map(self) -> OutputMap:
        return OutputMap(self.ode, tuple(label for _, label in self.outputs), tuple(one.label for one in self.inputs))

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
