"""`fit`: the unknown numbers of a plant or a loop from a dataset."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from workbench.core import Ode, SampledSystem
from workbench.core.equations import Loop
from workbench.core.validation.refusals import Array, finite, known_name, one_of, whole
from workbench.core.validation.refusals import seed as check_seed
from workbench.core.validation.signatures import check_arguments
from workbench.design.matrices import one_thread
from workbench.identification.datasets import DataCheck, Dataset, check_data
from workbench.identification.datasets.experiment import Marks
from workbench.identification.datasets.system_checks import check_period
from workbench.identification.estimation.computer_check import (
    refuse_random_computer,
    refuse_rough_computer,
    timing_remarks,
)
from workbench.identification.estimation.fit import Fit
from workbench.identification.estimation.fit_certificate import FitCertificate
from workbench.identification.estimation.fit_search import SearchEnd, is_poor, search, spread
from workbench.identification.estimation.identifiability import Identifiability
from workbench.identification.estimation.input_record import HOLDS, MeasuredInput
from workbench.identification.estimation.output_model import OutputModel
from workbench.identification.estimation.sign_mirrors import mirror_sentence
from workbench.identification.estimation.signal_matching import match_signals
from workbench.identification.estimation.step_refinement import coarse_enough, fastest_rate, refine
from workbench.identification.estimation.system_equations import flow_of, system_of
from workbench.identification.estimation.unknown_numbers import (
    SENSOR_OR_DELAY,
    NumberSource,
    UnknownNumber,
    with_bounds,
)
from workbench.identification.estimation.weighed_data import WeighedData

FAR = 20.0  # time constants between two samples, beyond which a log hardly shows a mode


@check_arguments
def fit(
    system: Ode | SampledSystem | Loop,
    dataset: Dataset,
    free: Sequence[str],
    *,
    noise: Mapping[str, float] | None = None,
    signals: Mapping[str, str] | None = None,
    hold: str = "hold",
    start: Mapping[str, float] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    hold_out: float = 0.2,
    starts: int = 1,
    seed: int = 0,
    answers: Mapping[str, str] | None = None,
) -> Fit:
    """Estimate numbers of a plant or a loop from a log, by output errors with exact sensitivities.

        min over z of sum_k |(y(t_k; z) - y_k) / sigma|^2,   x' = f(t, x, u, p), y = h(t, x, p)

    Parameters
    ----------
    system, dataset, signals
        A plant as `wb.open_loop(plant)` or a loop, perhaps with a computer, and the log, whose signals are its inputs,
        outputs or states by name, or as `signals` says. The first sample is at t = 0.
    free
        Names of the numbers to estimate: paths of parameters, such as `plant.J`, initial states as `omega(0)`, and
        `delay of v`, `offset of omega`, `scale of omega`.
    noise, answers
        The standard deviation of each output's noise; by default it is estimated, too. And answers to the questions of
        `wb.check_data` on the log, by point.
    hold, hold_out
        "hold" if an input keeps its value until the next sample; "linear" for straight lines between the samples. And
        the last share of each experiment that the fit does not see.
    start, bounds, starts, seed
        Values at the start, by default those of the system; they hold for numbers that are not estimated, too. Pairs
        (low, high) of numbers to estimate, within the bounds that a block declares. And the number of searches: all but
        the first begin at random numbers between half and twice the start.

    Raises
    ------
    ValueError, LookupError
        If the log's check fails, the data do not tell the numbers apart, every run diverges, or a name is unknown.

    Examples
    --------
    >>> motor = wb.open_loop(wb.DCMotor())
    >>> run = wb.simulate(motor, motor.parameters.pack({"v": 12.0}), until=2.0, every=0.02)
    >>> log = wb.Dataset.of(run.t, {"v": np.full(101, 12.0), "omega": run["omega"][0]}, {"v": "V", "omega": "rad/s"})
    >>> found = wb.fit(motor, log, ["J", "R"], start={"J": 0.02}, answers={"constant signal": "a step of the voltage"})
    >>> {name: round(value, 6) for name, value in found.values.items()}
    {'J': 0.01, 'R': 1.0}
    """
    model, remarks = _model_of(system, dataset, free, signals or {}, hold, start_values("fit", start), bounds or {})
    remarks = (*remarks, *_check(model, answers or {}))
    sigma, (weighs, held_out) = _noise(noise, model), _masks(model, finite("fit(hold_out=...)", hold_out))
    count, generator = whole("fit(starts=...)", starts), np.random.default_rng(check_seed("fit(seed=...)", seed))
    with one_thread():
        data = coarse_enough(_enough_samples(WeighedData(model, weighs)), sigma)
        return _fit_of(data, held_out, search(data, sigma, count, generator), sigma is not None, remarks)


def start_values(call: str, start: Mapping[str, float] | None) -> dict[str, float]:
    """The finite numbers of a call's `start`."""
    return {name: finite(f"{call}(start={{{name!r}: ...}})", value) for name, value in (start or {}).items()}


def _check(model: OutputModel, answers: Mapping[str, str]) -> tuple[str, ...]:
    """The remarks and answers of the check of a log; a ValueError if it is not passed."""
    known = model.dataset.signals
    inputs, outputs = ([one.signal for one in model.inputs], [signal for signal, _ in model.outputs])
    both = [[e.name for e in known.entries if {e.name, *e.labels()} & set(names)] for names in (inputs, outputs)]
    names = [number.name for number in model.numbers]
    check = check_data(model.dataset, inputs=both[0], outputs=both[1], parameters=names)
    periods = tuple(check_period(model.dataset, model.ode, model.x0[0], model.p))
    check = DataCheck((*check.findings, *periods)).answer(answers)
    check.require()
    said = [f"{point}: {text}" for point, text in check.answers.items()]
    return (*(one.text for one in check.findings if one.severity == "remark"), *said)


def _model_of(
    system: Ode | SampledSystem | Loop,
    dataset: Dataset,
    free: Sequence[str],
    signals: Mapping[str, str],
    hold: str,
    values: Mapping[str, float],
    bounds: Mapping[str, tuple[float, float]],
) -> tuple[OutputModel, tuple[str, ...]]:
    """The model of a fit, with steps as long as the intervals between samples, and remarks on log and system."""
    whole_system, rule = system_of(system, "fit"), one_of("fit(hold=...)", hold, HOLDS)
    ode = flow_of(whole_system)
    inputs, outputs, remarks = match_signals("fit", ode, dataset, signals, rule, frozenset(values))
    source = number_source("fit", ode, dataset, inputs, outputs, values)
    steps = tuple(float(np.median(np.diff(experiment.t))) for experiment in dataset)
    numbers, begins = with_bounds("fit", source.numbers(free), bounds), (0.0,) * len(steps)
    refuse_inputs("fit", numbers, inputs)
    refuse_random_computer("fit", whole_system, source.p, "start")
    refuse_rough_computer("fit", whole_system, source.p, numbers)
    model = OutputModel(whole_system, dataset, inputs, outputs, numbers, source.p, source.x0, steps, begins)
    return model, (*remarks, *timing_remarks(whole_system, dataset))


def number_source(
    call: str,
    ode: Ode,
    dataset: Dataset,
    inputs: Sequence[MeasuredInput],
    outputs: Sequence[tuple[str, str]],
    values: Mapping[str, float],
) -> NumberSource:
    """The system with `values` by name in the place of its defaults, and the signals of the log, for a call."""
    p, x0 = ode.parameters.default.copy(), ode.states.default.copy()
    first = {}
    for name, value in values.items():
        if name in ode.parameters.labels:
            p[ode.parameters.labels.index(name)] = value
        elif name in ode.states.labels:
            x0[ode.states.labels.index(name)] = value
        elif SENSOR_OR_DELAY.fullmatch(name):
            first[name] = value
        else:
            known_name(name, (*ode.parameters.labels, *ode.states.labels), f"parameters and states of '{ode.name}'")
    ode.parameters.check(p[np.newaxis])
    units = dict(zip(dataset.signals.labels, (u for e in dataset.signals.entries for u in e.units), strict=True))
    known = {signal: units.get(signal, "") for signal, _ in outputs}
    rows = np.tile(x0, (len(dataset.names), 1))
    return NumberSource(ode, p, rows, dataset.names, tuple(one.signal for one in inputs), known, first, call)


def refuse_inputs(call: str, numbers: Sequence[UnknownNumber], inputs: Sequence[MeasuredInput]) -> None:
    """Refuse an unknown number that the log gives."""
    if known := {one.label for one in inputs} & {number.name for number in numbers}:
        raise ValueError(
            f"`{call}(free=...)` cannot estimate {sorted(known)[0]!r}, which is an input and known at each instant."
        )


def _enough_samples(data: WeighedData) -> WeighedData:
    """The data; refused if fewer samples count than there are numbers, or none of a sensor."""
    needed, names = len(data.model.numbers), [signal for signal, _ in data.model.outputs]
    if not (data.counts > 0).all() or data.counts.sum() <= needed:
        counts = ", ".join(f"{count:g} of '{name}'" for count, name in zip(data.counts, names, strict=True))
        raise ValueError(
            f"`fit(dataset=...)` must have more samples than the {needed} unknown numbers, and some of each sensor; "
            f"those that count are {counts}: record for longer, or hold out less."
        )
    return data


def _fit_of(
    data: WeighedData,
    held_out: tuple[Marks, ...],
    end: SearchEnd | None,
    is_known: bool,
    remarks: tuple[str, ...],
) -> Fit:
    """The answer at the end of a search, or a refusal if the data do not tell the numbers apart."""
    if end is None:
        raise ValueError(
            "`fit(...)` needs a start from which a run lasts; all runs from the start, and from segments of the log, "
            f"diverge: {_time_advice(data.model)}give other values by `start`."
        )
    at_end = refine(data, end, is_known)
    data, end, last = at_end.data, at_end.end, at_end.last
    names = tuple(number.name for number in data.model.numbers)
    identifiability = Identifiability.of(names, end.z, last.derivatives, data.model.starts)
    if not identifiability.is_complete:
        raise ValueError(
            f"{_poor_fit(data, end, is_known)}From these data `fit(...)` cannot tell "
            f"{', '.join(identifiability.ambiguous_names)} apart. "
            f"{' '.join(identifiability.sentences)} Leave out of `free` one number for each such direction."
        )
    covariance = np.linalg.inv(last.derivatives.T @ last.derivatives)
    total = data.counts.sum()
    factor = 1.0 if is_known else total / (total - len(names))  # residuals of n numbers are too small
    norms = np.linalg.norm(last.derivatives, axis=0)
    condition = float(np.linalg.cond(last.derivatives / norms))
    sentence = mirror_sentence(data, end.z, np.sqrt(np.diag(covariance)))
    remarks = (sentence, *remarks) if sentence else remarks
    certificate = FitCertificate(at_end.to_minimum, at_end.by_half_step, at_end.limit, condition, end.minimum.reason)
    return Fit(data, held_out, end, is_known, np.asarray(factor * covariance), certificate, identifiability, remarks)


def _time_advice(model: OutputModel) -> str:
    """The advice to look at the unit of time if samples are far apart for the modes of the system; else nothing."""
    fastest = fastest_rate(model)
    apart = float(np.median(np.diff(model.dataset.experiments[0].t)))
    if apart * fastest < FAR:
        return ""
    return (
        f"the samples are {apart:.3g} s apart, and the fastest mode of the system has a time constant of "
        f"{1 / fastest:.3g} s; look at the unit of the log's times, or "
    )


def _poor_fit(data: WeighedData, end: SearchEnd, is_noise_known: bool) -> str:
    """A sentence if the best numbers explain the data badly, which then is the first thing to know; else nothing."""
    if not is_poor(data, end.z, end.sigma if is_noise_known else None):
        return ""
    left = np.sqrt(data.sum_of_squares(end.z) / data.counts) / (end.sigma if is_noise_known else spread(data))
    worst = int(np.argmax(left))
    unit = "the noise that was given" if is_noise_known else "the signal's spread"
    return f"The model does not explain '{data.model.outputs[worst][0]}': {left[worst]:.3g} times {unit} is left. "


def _masks(model: OutputModel, share: float) -> tuple[tuple[Marks, ...], tuple[Marks, ...]]:
    """The samples (N, ny) of each experiment that count, and those that are held out."""
    if not 0 <= share < 1:
        raise ValueError(f"`fit(hold_out=...)` must be a share from 0 to below 1; got {share:g}.")
    weighs, held_out = [], []
    labels = model.dataset.signals.labels
    columns = [labels.index(signal) for signal, _ in model.outputs]
    for experiment in model.dataset:
        fine = experiment.is_weighed[:, columns]
        late = np.arange(len(experiment)) >= round((1 - share) * len(experiment))
        weighs.append(fine & ~late[:, np.newaxis])
        held_out.append(fine & late[:, np.newaxis])
    return tuple(weighs), tuple(held_out)


def _noise(noise: Mapping[str, float] | None, model: OutputModel) -> Array | None:
    """The standard deviations (ny,) of the outputs, or None if they are to be estimated."""
    if noise is None:
        return None
    names = [signal for signal, _ in model.outputs]
    for name in noise:
        known_name(name, names, "outputs of this fit")
    if missing := [name for name in names if name not in noise]:
        raise ValueError(
            f"`fit(noise=...)` must have a standard deviation for each output of the log; there is none for "
            f"'{missing[0]}': name it too, or leave `noise` out to have each estimated."
        )
    sigma = np.array([finite(f"fit(noise={{{name!r}: ...}})", noise[name]) for name in names])
    if not (sigma > 0).all():
        raise ValueError(f"`fit(noise=...)` must be positive standard deviations; got {sigma.min():g}.")
    return sigma
