"""The problem of a design: the response of the system, the shape of its inputs, and an input at rest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Ode
from workbench.core.validation.refusals import Array, describe, finite, known_name, multiple, seconds, whole
from workbench.identification.datasets import Dataset, Experiment
from workbench.identification.estimation.fit_system import number_source, refuse_inputs
from workbench.identification.estimation.input_record import MeasuredInput
from workbench.identification.estimation.output_model import OutputModel
from workbench.identification.estimation.unknown_numbers import UnknownNumber
from workbench.identification.experiments.driven_response import DrivenResponse
from workbench.identification.experiments.information_criterion import InformationCriterion
from workbench.identification.experiments.input_shapes import InputShape, harmonics, levels
from workbench.identification.experiments.path_limits import PathLimits

CALL = "design_experiment"
SHARES = (0.5, 0.2, 0.8, 0.05, 0.95)  # of the way from the low to the high ends, where an input may rest
HALVINGS = 8  # of the step, at most, for a run that diverges


@dataclass(frozen=True, eq=False)
class DesignProblem:
    """The problem of a design: coefficients of a shape, and an input `rest` (nu, nb) that keeps all limits."""

    response: DrivenResponse
    shape: InputShape
    criterion: InformationCriterion
    rest: Array
    until: float
    highest: float  # frequency in Hz of the shape

    def at_half_step(self) -> DesignProblem:
        """The same with steps that are half as long."""
        return replace(self, response=self.response.at_half_step())


@dataclass(frozen=True)
class InputSchedule:
    """The samples of an experiment and the shape of its inputs: harmonics, or steps if `steps` is not zero."""

    until: float
    every: float
    period: float
    orders: tuple[int, ...]
    steps: int

    @staticmethod
    def of(
        until: float, every: float, period: float | None, orders: int | Sequence[int], steps: int | None
    ) -> InputSchedule:
        """Checked: the period divides the duration, and the samples tell the highest harmonic."""
        end, sample = seconds(f"{CALL}(until=...)", until), seconds(f"{CALL}(every=...)", every)
        one = end if period is None else seconds(f"{CALL}(period=...)", period)
        multiple(f"{CALL}(until=...)", end, one, "the period")
        count = multiple(f"{CALL}(period=...)", one, sample, "the time between samples")
        if steps is not None:
            number = whole(f"{CALL}(steps=...)", steps, 2)
            multiple(f"{CALL}(steps=...): the length of a step", one / number, sample, "the time between samples")
            return InputSchedule(end, sample, one, (), number)
        every_order = range(whole(f"{CALL}(harmonics=...)", orders) + 1) if isinstance(orders, int) else orders
        numbers = tuple(sorted({whole(f"{CALL}(harmonics=...)", order, 0) for order in every_order}))
        if not any(numbers) or 2 * numbers[-1] >= count:
            raise ValueError(
                f"`{CALL}(harmonics=...)` must be at least one harmonic, and each below half of the {count} samples of "
                f"a period, as faster ones look like slower ones; got {describe(numbers)}: take fewer or sample faster."
            )
        return InputSchedule(end, sample, one, numbers, 0)

    @property
    def t(self) -> Array:
        """The times (N,) of the samples in s."""
        return np.asarray(np.arange(round(self.until / self.every) + 1) * self.every)

    @property
    def shape(self) -> InputShape:
        """The shape of the inputs."""
        return levels(self.t, self.period, self.steps) if self.steps else harmonics(self.t, self.period, self.orders)

    @property
    def highest(self) -> float:
        """The highest frequency in Hz, of steps that of an up and a down."""
        return (self.steps / 2 if self.steps else self.orders[-1]) / self.period


def dataset_of(ode: Ode, inputs: Sequence[str], t: Array, values: Array) -> Dataset:
    """The inputs (N, nu) of a system by name as a dataset."""
    units = [unit for entry in ode.parameters.entries for unit in entry.units]
    entries = []
    for name in inputs:
        places = ode.parameters.indices(name)
        whole_entry = name in ode.parameters and name not in ode.parameters.labels
        shape = ode.parameters[name].shape if whole_entry else ()
        entries.append(Entry(name, np.zeros(shape), units[places[0]]))
    return Dataset((Experiment("design", t, Layout(tuple(entries)), values),), "an experiment that was designed")


def problem_of(
    ode: Ode,
    free: Sequence[str],
    inputs: Sequence[str],
    outputs: Sequence[str],
    noise: Mapping[str, float],
    limits: Mapping[str, tuple[float, float]],
    schedule: InputSchedule,
    criterion: str,
    hold: str,
    values: Mapping[str, float],
) -> DesignProblem:
    """The problem, whose step is as long as the time between samples."""
    driven = _inputs(ode, inputs, values, hold)
    names = [name for output in outputs for name in _outputs(ode, output)]
    if not names:
        raise ValueError(f"`{CALL}(outputs=...)` must name at least one output or state that is measured; got none.")
    pairs, t, shape = tuple((name, name) for name in names), schedule.t, schedule.shape
    dataset = dataset_of(ode, inputs, t, np.zeros((t.size, len(driven))))
    if not free:
        raise ValueError(f"`{CALL}(free=...)` must name at least one number to estimate; got none.")
    source = number_source(CALL, ode, dataset, driven, pairs, values)
    numbers = source.numbers(free)
    refuse_inputs(CALL, numbers, driven)
    _refuse_delays(ode, numbers, names, hold)
    model = OutputModel(ode, dataset, driven, pairs, numbers, source.p, source.x0, (schedule.every,), (0.0,))
    path = PathLimits.of(ode, tuple(one.label for one in driven), limits)
    if not path.names:
        raise ValueError(
            f"`{CALL}(limits=...)` must limit an input, state or output, else a larger constant always tells more; got "
            f"{describe(tuple(limits))}."
        )
    z = model.starts
    response = DrivenResponse(model, path, shape.basis, _sigma(ode, noise, names))
    rest = _rest(response, shape)
    sizes = np.where(z == 0, 1.0, np.abs(z))
    return DesignProblem(
        response, shape, InformationCriterion(criterion, sizes), rest, schedule.until, schedule.highest
    )


def _refuse_delays(ode: Ode, numbers: Sequence[UnknownNumber], outputs: Sequence[str], hold: str) -> None:
    """Refuse delays of inputs that jump, by which no output has a derivative everywhere, or that an output shows."""
    delays = [number for number in numbers if number.kind == "delay"]
    if delays and hold != "linear":
        raise ValueError(
            f"`{CALL}(free=...)` designs for '{delays[0].name}' with hold='linear' alone, as inputs on straight lines "
            "have a slope by which a delay acts: say `hold='linear'`."
        )
    labels = (*ode.states.labels, *ode.outputs.labels)
    y = ca.vertcat(ode.x, ode.output)[[labels.index(name) for name in outputs]]
    for number in delays:
        if ca.depends_on(y, ode.p[ode.parameters.labels.index(number.label)]):
            raise ValueError(
                f"`{CALL}(free=...)` designs for delays of inputs that act on states; an output has '{number.label}' "
                f"itself in it: leave '{number.name}' out, or measure another output."
            )


def _inputs(ode: Ode, inputs: Sequence[str], values: Mapping[str, float], hold: str) -> tuple[MeasuredInput, ...]:
    """The inputs of the design by label; each other input of the system must have a number."""
    labels = [ode.parameters.labels[place] for name in inputs for place in ode.parameters.indices(name)]
    if not labels or len(set(labels)) < len(labels):
        raise ValueError(f"`{CALL}(inputs=...)` must name at least one input, and each once; got {describe(inputs)}.")
    driven = {label for name in ode.inputs for label in ode.parameters[name].labels()}
    if missing := sorted(driven - set(labels) - set(values)):
        raise ValueError(
            f"`{CALL}(inputs=...)` must have each input of '{ode.name}', as its motion follows from them; there is "
            f"none for '{missing[0]}': name it too, or hold it at a number by `start`."
        )
    return tuple(MeasuredInput(label, label, hold) for label in labels)


def _outputs(ode: Ode, name: str) -> list[str]:
    layout = ode.outputs if name in ode.outputs or name in ode.outputs.labels else ode.states
    known = dict.fromkeys((*layout.names, *layout.labels, *ode.outputs.names))
    known_name(name, known, f"outputs and states of '{ode.name}'")
    return [layout.labels[i] for i in layout.indices(name)]


def _sigma(ode: Ode, noise: Mapping[str, float], names: Sequence[str]) -> Array:
    """The standard deviations (ny,) of the outputs."""
    every: dict[str, float] = {}
    for name, value in noise.items():
        own = dict.fromkeys(_outputs(ode, name), finite(f"{CALL}(noise={{{name!r}: ...}})", value))
        known_name(next(iter(own)), names, "outputs of this design")
        every |= own
    if missing := [name for name in names if name not in every]:
        raise ValueError(
            f"`{CALL}(noise=...)` must have a standard deviation for each output, as errors are in its proportion; "
            f"there is none for '{missing[0]}'."
        )
    sigma = np.array([every[name] for name in names])
    if not (sigma > 0).all():
        raise ValueError(f"`{CALL}(noise=...)` must be positive standard deviations; got {sigma.min():g}.")
    return sigma


def _rest(response: DrivenResponse, shape: InputShape) -> Array:
    """Coefficients of a constant input whose run keeps all limits: the system's own, or one between the limits."""
    model, limits = response.model, response.limits
    own = np.array([model.p[model.ode.parameters.labels.index(label)] for label in limits.inputs])
    low, high = own.copy(), own.copy()
    for i, label in enumerate(limits.inputs):
        if label in limits.names:
            ends = limits.all_ends[limits.names.index(label)]
            low[i], high[i] = np.where(np.isfinite(ends), ends, ends[np.isfinite(ends)][0])
    for constant in (own, *(low + share * (high - low) for share in SHARES)):
        c = constant[:, np.newaxis] * shape.constant
        finer = response
        for _ in range(HALVINGS):  # a step that is too long makes a stable system leave its limits
            margins = finer.margins(c)
            if (margins > 0).all():
                return np.asarray(c)
            if finer is not response and (margins > -np.inf).all():
                break
            finer = finer.at_half_step()
    inner = np.clip(own, low, high)
    _refuse_rest(finer, inner[:, np.newaxis] * shape.constant)
    raise AssertionError


def _refuse_rest(response: DrivenResponse, c: Array) -> None:
    """Refuse a start beyond its limits, or a system that leaves them by itself."""
    limits, x = response.limits, response.states(c)
    finite_rows = np.isfinite(x).all(axis=1)
    last = len(x) if finite_rows.all() else int(np.argmin(finite_rows))
    u = response.inputs(c)[0]
    t = response.record.record.t[: min(last, len(u))]
    values = limits.values(t, x[: len(t)], response.model.p, u[: len(t)])
    beyond = (values <= limits.low) | (values >= limits.high)
    if beyond[0].any():
        i = int(np.argmax(beyond[0]))
        raise ValueError(
            f"`{CALL}(limits={{{limits.names[i]!r}: ...}})` must hold at the start with room to move; there "
            f"'{limits.names[i]}' is {values[0, i]:.6g}, and its limits are {limits.low[i]:g} and {limits.high[i]:g}: "
            "start elsewhere by `start`, or widen them."
        )
    row = int(np.argmax(beyond.any(axis=1))) if beyond.any() else len(t) - 1
    which = f"'{limits.names[int(np.argmax(beyond[row]))]}' leaves its limits" if beyond.any() else "the run diverges"
    raise ValueError(
        f"`{CALL}(system=...)` must stay within its limits while its inputs rest; {which} at t = {t[row]:.4g} s: an "
        "unstable system needs a controller, so design for its loop, or take a shorter experiment."
    )
