"""`fit`: the unknown numbers of a plant or a loop from a dataset."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from workbench.core import Ode, SampledSystem
from workbench.core.equations import LOOP, Loop, equations_of, is_loop
from workbench.core.validation.refusals import Array, finite, known_name, one_of, refusal, whole
from workbench.core.validation.refusals import seed as check_seed
from workbench.core.validation.signatures import check_arguments
from workbench.identification.datasets import Dataset
from workbench.identification.datasets.dataset import Marks
from workbench.identification.estimation.fit import Fit, FitCertificate
from workbench.identification.estimation.identifiability import Identifiability
from workbench.identification.estimation.input_record import HOLDS, MeasuredInput
from workbench.identification.estimation.output_model import OutputModel
from workbench.identification.estimation.search import SearchEnd, is_poor, search, spread
from workbench.identification.estimation.signal_matching import match_signals
from workbench.identification.estimation.step_refinement import coarse_enough, refine
from workbench.identification.estimation.unknown_numbers import (
    UnknownNumber,
    delay_numbers,
    initial_numbers,
    parameter_numbers,
    sensor_numbers,
)
from workbench.identification.estimation.weighed_data import WeighedData


@check_arguments
def fit(
    system: Ode | SampledSystem | Loop,
    dataset: Dataset,
    free: Sequence[str],
    *,
    initial_states: Sequence[str] = (),
    delays: Sequence[str] = (),
    offsets: Sequence[str] = (),
    scales: Sequence[str] = (),
    noise: Mapping[str, float] | None = None,
    signals: Mapping[str, str] | None = None,
    hold: str = "hold",
    start: Mapping[str, float] | None = None,
    hold_out: float = 0.2,
    starts: int = 1,
    seed: int = 0,
) -> Fit:
    """Estimate parameters of a plant or a loop from measured signals, by output errors with exact sensitivities.

        min over z of sum_k |(y(t_k; z) - y_k) / sigma|^2,   x' = f(t, x, u, p), y = h(t, x, p)

    The inputs u are those of the log. The states and their derivatives by z are marched together along the samples'
    own times. The first sample of an experiment is at t = 0.

    Parameters
    ----------
    system
        A plant as `wb.open_loop(plant)`, a loop in continuous time, or an `Ode`.
    dataset
        The log. Its signals are matched by name with the inputs, outputs and states of the system.
    free
        Paths of the parameters to be estimated.
    initial_states
        States whose initial values are estimated, in each experiment by itself. All others begin at their defaults.
    delays
        Inputs whose delay in s is estimated.
    offsets, scales
        Outputs whose sensor has an unknown offset, or scale.
    noise
        The standard deviation of the noise of each sensor. Without it, each is estimated from the residuals.
    signals
        For a signal of the log with another name, the parameter, state or output of the system.
    hold
        "hold" if an input keeps its value until the next sample; "linear" for straight lines.
    start
        Values of parameters and initial states at which the search starts; the defaults are those of the system.
    hold_out
        The share of each experiment, at its end, that the fit does not see; 0 for none.
    starts, seed
        The number of searches: the first from the start, others from random numbers between half and twice of it.

    Raises
    ------
    ValueError
        If the data do not tell the numbers apart, a run from every start diverges, or an argument is out of bounds.
    LookupError
        If a name is unknown.

    References
    ----------
    Ljung (1999), System Identification, chapter 7; Bock (1983) for multiple shooting.

    Examples
    --------
    >>> motor = wb.open_loop(wb.DCMotor())
    >>> run = wb.simulate(motor, motor.parameters.pack({"v": 12.0}), until=2.0, every=0.02)
    >>> signals = {"v": np.full(101, 12.0), "omega": run["omega"][0]}
    >>> log = wb.Dataset.of(run.t, signals, {"v": "V", "omega": "rad/s"})
    >>> found = wb.fit(motor, log, ["J", "R"], start={"J": 0.02, "R": 2.0})
    >>> {name: round(value, 6) for name, value in found.values.items()}
    {'J': 0.01, 'R': 1.0}
    """
    ode = equation_of(system, "fit")
    values = {name: finite(f"fit(start={{{name!r}: ...}})", value) for name, value in (start or {}).items()}
    one_of("fit(hold=...)", hold, HOLDS)
    inputs, outputs, unused = match_signals(ode, dataset, dict(signals or {}), hold, frozenset(values))
    p, x0 = start_values(ode, values)
    first = np.tile(x0, (len(dataset.names), 1))
    names = tuple(signal for signal, _ in outputs)
    units = dict(zip(dataset.signals.labels, (u for e in dataset.signals.entries for u in e.units), strict=True))
    numbers = (
        *parameter_numbers(ode, tuple(free), p),
        *delay_numbers(tuple(delays), tuple(one.signal for one in inputs)),
        *sensor_numbers("scale", tuple(scales), names, tuple(units[name] for name in names)),
        *sensor_numbers("offset", tuple(offsets), names, tuple(units[name] for name in names)),
        *initial_numbers(ode, tuple(initial_states), dataset, first),
    )
    refuse_numbers(numbers, inputs)
    steps = tuple(float(np.median(np.diff(experiment.t))) for experiment in dataset)
    model = OutputModel(ode, dataset, inputs, outputs, numbers, p, first, steps, (0.0,) * len(steps))
    weighs, held_out = _masks(model, finite("fit(hold_out=...)", hold_out))
    sigma = None if noise is None else _noise(dict(noise), names)
    data = coarse_enough(WeighedData(model, weighs), sigma)
    if not (data.counts > 0).all() or data.counts.sum() <= len(numbers):
        raise ValueError(
            f"`fit(dataset=...)` must have more samples than the {len(numbers)} unknown numbers, and some of each "
            f"sensor; {', '.join(f'{n:g} of {name}' for n, name in zip(data.counts, names, strict=True))} count."
        )
    generator = np.random.default_rng(check_seed("fit(seed=...)", seed))
    end = search(data, sigma, whole("fit(starts=...)", starts), generator)
    if end is None:
        raise ValueError(
            "`fit(...)` needs a start from which a run lasts; all runs from the start, and from segments of the log, "
            "diverge: give other values by `start`."
        )
    return _fit_of(data, held_out, end, sigma is not None, unused)


def _fit_of(
    data: WeighedData, held_out: tuple[Marks, ...], end: SearchEnd, is_noise_known: bool, unused: tuple[str, ...]
) -> Fit:
    """The answer at the end of a search, or a refusal if the data do not tell the numbers apart."""
    at_end = refine(data, end, is_noise_known)
    data, end, last = at_end.data, at_end.end, at_end.last
    names = tuple(number.name for number in data.model.numbers)
    identifiability = Identifiability.of(names, end.z, last.derivatives)
    if not identifiability.is_complete:
        raise ValueError(
            f"{_poor_fit(data, end, is_noise_known)}`fit(...)` cannot tell {', '.join(identifiability.ambiguous_names)} apart from these data. "
            f"{' '.join(identifiability.sentences)} Leave out of `free` one number for each such direction."
        )
    covariance = np.linalg.inv(last.derivatives.T @ last.derivatives)
    total = data.counts.sum()
    factor = 1.0 if is_noise_known else total / (total - len(names))  # residuals of n numbers are too small
    norms = np.linalg.norm(last.derivatives, axis=0)
    condition = float(np.linalg.cond(last.derivatives / norms))
    certificate = FitCertificate(at_end.to_minimum, at_end.by_half_step, at_end.limit, condition, end.minimum.reason)
    remarks = (f"The log's signals {', '.join(unused)} were not used.",) if unused else ()
    return Fit(
        data, held_out, end, is_noise_known, np.asarray(factor * covariance), certificate, identifiability, remarks
    )


def _poor_fit(data: WeighedData, end: SearchEnd, is_noise_known: bool) -> str:
    """A sentence if the best numbers explain the data badly, which then is the first thing to know; else nothing."""
    if not is_poor(data, end.z, end.sigma if is_noise_known else None):
        return ""
    left = np.sqrt(data.sum_of_squares(end.z) / data.counts) / (end.sigma if is_noise_known else spread(data))
    worst = int(np.argmax(left))
    unit = "the noise that was given" if is_noise_known else "the signal's spread"
    return f"The model does not explain '{data.model.outputs[worst][0]}': {left[worst]:.3g} times {unit} is left. "


def equation_of(system: Ode | SampledSystem | Loop, call: str) -> Ode:
    """The equations of a system in continuous time; any other is refused in the name of a call."""
    if not is_loop(system):
        raise refusal(f"{call}(system=...)", LOOP, system)
    equation = equations_of(system, "loop")
    if isinstance(equation, SampledSystem):
        raise ValueError(
            f"`{call}(system=...)` must be in continuous time; a computer closes this loop: fit the plant alone, "
            "`wb.open_loop(plant)`, to the commands and measurements of the log."
        )
    return equation


def start_values(ode: Ode, values: Mapping[str, float]) -> tuple[Array, Array]:
    """All parameters (np,) and states (nx,) at the start, with some of them by name."""
    p, x0 = ode.parameters.default.copy(), ode.states.default.copy()
    for name, value in values.items():
        if name in ode.parameters.labels:
            p[ode.parameters.labels.index(name)] = value
        elif name in ode.states.labels:
            x0[ode.states.labels.index(name)] = value
        else:
            known_name(name, (*ode.parameters.labels, *ode.states.labels), f"parameters and states of '{ode.name}'")
    ode.parameters.check(p[np.newaxis])
    return p, x0


def refuse_numbers(numbers: Sequence[UnknownNumber], inputs: Sequence[MeasuredInput]) -> None:
    """Refuse a fit of nothing, a number that is named twice, and one that the log gives."""
    names = [number.name for number in numbers]
    if not names:
        raise ValueError("`fit(free=...)` must name at least one unknown number; got none.")
    if twice := {name for name in names if names.count(name) > 1}:
        raise ValueError(f"`fit(free=...)` must name each number once; {sorted(twice)[0]!r} came more than once.")
    if known := {one.label for one in inputs} & set(names):
        raise ValueError(f"`fit(free=...)` cannot estimate {sorted(known)[0]!r}, which the log gives at each instant.")


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


def _noise(noise: Mapping[str, float], names: Sequence[str]) -> Array:
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
