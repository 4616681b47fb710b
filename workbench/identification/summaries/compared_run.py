"""A fitted model marched along an experiment, with the squares of its errors summed beside its states."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, SampledSystem, StepMap
from workbench.core.recorded_step import SignalRecord
from workbench.core.validation.refusals import Array, Integers
from workbench.core.validation.signatures import check_arguments
from workbench.engine.metrics.value_program import MetricProgram, Written
from workbench.engine.record_runs import run_along
from workbench.identification.estimation.driven_steps import plain_step
from workbench.identification.estimation.fit import Fit
from workbench.identification.estimation.input_record import InputPieces
from workbench.identification.estimation.unknown_numbers import UnknownNumber

FIT, HELD_OUT = PARTS = ("of the fit", "held out")  # of the samples of a sensor
SENSOR = ("scale", "offset")  # the kinds of numbers that change a reading


class NumberPlace(NamedTuple):
    """The place of an unknown number among the parameters ("p") or the initial states ("x") of a step."""

    of: str
    place: int


@dataclass(frozen=True, eq=False)
@check_arguments
class ComparedRun:
    """The run of a fitted model along an experiment of its log, as every machine can make it.

    The step goes from each instant of the input to the next; behind the states of the system it sums the squares of the
    errors, of the samples that the fit saw and of those held out. One more step than there are intervals adds the last
    sample.

    Parameters
    ----------
    step
        The step, with the recorded numbers (N + 1, nd) of N intervals, and of an empty one behind them.
    readings
        (ny, 1), the readings of the sensors, in the symbols of the step.
    t
        (N + 1,), the instants in s from the first sample.
    stride
        The number of steps between two kept rows: from sample to sample if these are as many everywhere, else 1.
    p, x0
        (np,) and (nx,), the parameters and the initial states at the estimates, zero sums included.
    counts
        By part of the samples, how many there are of each sensor, (ny,).
    places
        By number, its place in `p` or `x0`; a delay has none, and an initial state of another experiment has none.
    """

    step: StepMap
    readings: ca.SX
    t: Array
    stride: int
    p: Array
    x0: Array
    counts: dict[str, Array]
    places: dict[str, NumberPlace]

    @staticmethod
    @check_arguments
    def of(fit: Fit, experiment: int, is_halved: bool = False) -> ComparedRun:
        """The run along an experiment by its number; `is_halved` for steps half as long, for the error of the sums.

        Raises
        ------
        ValueError
            If the fit is of a loop that a computer closes.
        """
        model = fit.model
        if isinstance(model.system, SampledSystem):
            raise ValueError("A fit of a loop that a computer closes has no run for a page: its steps end at instants.")
        record, samples = _record(fit, experiment, is_halved)
        masks = {FIT: fit.data.weighs[experiment], HELD_OUT: fit.held_out[experiment]}
        masks = {part: mask for part, mask in masks.items() if part == FIT or mask.any()}
        step, readings = _step(fit, record, samples, experiment, masks)
        apart = np.unique(np.diff(samples))
        own = [one for one in model.numbers if one.experiment in ("", model.dataset.names[experiment])]
        run = ComparedRun(
            step,
            readings,
            record.t[:-1] - record.t[0],
            int(apart[0]) if apart.size == 1 else 1 + is_halved,
            step.parameters.default.copy(),
            step.states.default.copy(),
            {part: mask.sum(axis=0) for part, mask in masks.items()},
            {one.name: place for one in own if (place := _place(one, step)) is not None},
        )
        run.p[: model.p.size], run.x0[: model.x0.shape[1]] = model.p, model.x0[experiment]
        return run._at({name: fit.values[name] for name in run.places})

    def _at(self, values: dict[str, float]) -> ComparedRun:
        p, x0 = self.p.copy(), self.x0.copy()
        for name, value in values.items():
            of, place = self.places[name]
            (p if of == "p" else x0)[place] = value
        return replace(self, p=p, x0=x0)

    def at(self, values: dict[str, float]) -> ComparedRun:
        """The same run with other values of its numbers, by name."""
        for name in values:
            if name not in self.places:
                raise LookupError(f"`ComparedRun.at(values=...)`: this run has no place for {name!r}.")
        return self._at(values)

    @property
    def rows(self) -> int:
        """The number of kept rows behind the first."""
        return (self.t.size - 1) // self.stride

    @property
    def kept_times(self) -> Array:
        """(rows + 1,), the instants in s of the kept rows."""
        return np.asarray(self.t[:: self.stride])

    def states(self, arithmetic: str = "portable") -> Array:
        """(N + 2, nx), the states at all instants, and behind the last one with all sums."""
        return np.asarray(run_along(self.step, self.p[np.newaxis], self.x0[np.newaxis], arithmetic)[0])

    @cached_property
    def programs(self) -> dict[str, MetricProgram]:
        """By part of the samples, the root mean square of the error of each sensor, from the states behind the last."""
        made = {}
        for part, counts in self.counts.items():
            first = self.step.states.slice(f"squares {part}").start
            inputs = tuple(("z", first + j) for j in range(len(counts)))
            n = len(counts)
            nodes: list[Written] = []
            for j, count in enumerate(counts.tolist()):
                at = n + 3 * j  # the node of the count
                nodes.extend((("const", float(count)), ("div", j, at), ("sqrt", at + 1)))
            made[part] = MetricProgram(inputs, tuple(nodes), tuple(n + 3 * j + 2 for j in range(n)))
        return made

    def root_mean_squares(self, arithmetic: str = "portable") -> dict[str, Array]:
        """By part of the samples, the root mean square of the error of each sensor, (ny,); NaN without a sample."""
        x, z = self.states(arithmetic)[-2:, np.newaxis]
        return {part: program.evaluate(x, z)[0] for part, program in self.programs.items()}


def _record(fit: Fit, experiment: int, is_halved: bool) -> tuple[SignalRecord, Integers]:
    """The inputs of an experiment at the estimates, with an empty interval behind them, and the places of samples."""
    drive = fit.model.drive(experiment, fit.theta[np.newaxis])
    record, samples, last = drive.record, drive.samples, drive.at_samples[-1:]
    assert isinstance(record, SignalRecord)  # as that of an equation without a computer is
    pieces = InputPieces(record.t, record.begins, record.ends)
    if is_halved:
        pieces, samples = pieces.divide(np.full(len(record.t) - 1, 2)), 2 * samples
    begins, ends = np.vstack([pieces.begins, last]), np.vstack([pieces.ends, last])
    return SignalRecord(np.append(pieces.t, pieces.t[-1]), record.labels, begins, ends), samples


def _step(
    fit: Fit, record: SignalRecord, samples: Integers, experiment: int, masks: dict[str, np.ndarray]
) -> tuple[StepMap, ca.SX]:
    """The step with its sums, and the readings of the sensors in its symbols."""
    model, ny = fit.model, len(fit.model.outputs)
    step = plain_step(model.ode, record)
    numbers = [one for one in model.numbers if one.kind in SENSOR]
    more = Layout(tuple(Entry(one.name, np.array(one.start)) for one in numbers))
    q = ca.SX.sym("q", len(numbers))
    both = ca.vertcat(step.rule.x, step.rule.output)
    labels = (*model.ode.states.labels, *model.ode.outputs.labels)
    readings = both[[labels.index(label) for _, label in model.outputs]]
    for j, (signal, _) in enumerate(model.outputs):
        for kind in SENSOR:
            for i, one in enumerate(numbers):
                if (one.kind, one.label) == (kind, signal):
                    readings[j] = q[i] * readings[j] if kind == "scale" else readings[j] + q[i]
    measured = ca.SX.sym("measured", ny * (1 + len(masks)))
    squares = (readings - measured[:ny]) ** 2
    sums = Layout(tuple(Entry(f"squares {part}", np.zeros(ny)) for part in masks))
    S = sums.symbols()
    weights = measured[ny:]
    update = S + weights * ca.vertcat(*[squares] * len(masks))
    rule = replace(step.rule, p=ca.vertcat(step.rule.p, q), d=ca.vertcat(step.rule.d, measured))
    columns = np.zeros((len(record.t) - 1, ny * (1 + len(masks))))
    values = fit.data.samples[experiment]
    seen = np.any([*masks.values()], axis=0)
    columns[samples] = np.column_stack([np.where(seen, values, 0.0), *(mask.astype(float) for mask in masks.values())])
    wider = replace(
        step,
        parameters=step.parameters + more,
        rule=rule,
        recorded_numbers=np.column_stack([record.rows, columns]),
    )
    return wider.with_memory(sums, S, ca.densify(update)), readings


def _place(number: UnknownNumber, step: StepMap) -> NumberPlace | None:
    if number.kind == "delay":
        return None
    if number.kind == "initial state":
        return NumberPlace("x", step.states.labels.index(number.label))
    return NumberPlace("p", step.parameters.labels.index(number.name if number.kind in SENSOR else number.label))
