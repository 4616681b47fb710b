"""`identifiability`: what an experiment can tell of a system, before or without any measurement."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from workbench.core import Ode, SampledSystem
from workbench.core.equations import Loop
from workbench.core.validation.refusals import Array, finite, known_name, one_of
from workbench.core.validation.signatures import check_arguments
from workbench.identification.datasets import Dataset
from workbench.identification.estimation.computer_check import refuse_random_computer, refuse_rough_computer
from workbench.identification.estimation.fit_system import number_source, refuse_inputs, start_values
from workbench.identification.estimation.identifiability import RANK, Identifiability
from workbench.identification.estimation.input_record import HOLDS
from workbench.identification.estimation.output_model import OutputModel
from workbench.identification.estimation.signal_matching import match_inputs
from workbench.identification.estimation.system_equations import flow_of, system_of

SETTLED = 0.5  # least ratio of two singular values, at a step and at half of it, that are not errors of the step
MOST_HALVINGS = 11
MOST_NUMBERS = 2**26  # of the runs of one experiment, half a GiB, at which halving ends


@check_arguments
def identifiability(
    system: Ode | SampledSystem | Loop,
    dataset: Dataset,
    free: Sequence[str],
    outputs: Sequence[str],
    *,
    noise: Mapping[str, float] | None = None,
    signals: Mapping[str, str] | None = None,
    hold: str = "hold",
    start: Mapping[str, float] | None = None,
) -> Identifiability:
    """Which parameters the outputs of an experiment can tell apart, near their values in the system.

    The answer is local: it rests on the derivatives of the outputs along the run with these values and these inputs.

    Parameters
    ----------
    system, free, signals, hold, start
        As for `wb.fit`.
    dataset
        The times and the inputs of the experiment. Its other signals are not used.
    outputs
        Names of the outputs and states that are measured at each time.
    noise
        The standard deviation of each output's noise, by which its derivatives are divided; by default 1.

    Raises
    ------
    ValueError
        If the run diverges, or an argument is out of its bounds.
    LookupError
        If a name is unknown.

    Examples
    --------
    >>> motor = wb.open_loop(wb.DCMotor())
    >>> t = np.linspace(0.0, 2.0, 201)
    >>> step = wb.Dataset.of(t, {"v": np.where(t < 1.0, 12.0, 0.0)}, {"v": "V"})
    >>> wb.identifiability(motor, step, ["J", "b", "K", "R", "L"], ["omega"]).is_complete
    False
    """
    whole_system = system_of(system, "identifiability")
    ode = flow_of(whole_system)
    values = start_values("identifiability", start)
    one_of("identifiability(hold=...)", hold, HOLDS)
    inputs, _ = match_inputs("identifiability", ode, dataset, dict(signals or {}), hold, frozenset(values))
    labels = [label for name in outputs for label in _labels(ode, name)]
    pairs = tuple((label, label) for label in labels)
    source = number_source("identifiability", ode, dataset, inputs, pairs, values)
    numbers = source.numbers(free)
    refuse_inputs("identifiability", numbers, inputs)
    refuse_random_computer("identifiability", whole_system, source.p, "start")
    refuse_rough_computer("identifiability", whole_system, source.p, numbers)
    steps = tuple(float(np.median(np.diff(experiment.t))) / 2 for experiment in dataset)
    model = OutputModel(whole_system, dataset, inputs, pairs, numbers, source.p, source.x0, steps, (0.0,) * len(steps))
    sigma = np.array([finite(f"identifiability(noise={{{n!r}: ...}})", (noise or {}).get(n, 1.0)) for n in labels])
    return _settled(model, sigma)


def _labels(ode: Ode, name: str) -> list[str]:
    """The labels of an output or a state."""
    layout = ode.outputs if name in ode.outputs or name in ode.outputs.labels else ode.states
    known_name(name, (*layout.names, *layout.labels, *ode.outputs.names), f"outputs and states of '{ode.name}'")
    return [layout.labels[i] for i in layout.indices(name)]


def _settled(model: OutputModel, sigma: Array) -> Identifiability:
    """The answer at a step that is so short that no small singular value is one of its errors."""
    before = None
    for _ in range(MOST_HALVINGS):
        now = _at_step(model, sigma)
        if before is not None and now is not None and _is_settled(before, now):
            return now
        before = now or before
        model = model.at_half_step()
        if _size(model) > MOST_NUMBERS:
            break
    if before is None:
        raise ValueError(
            "`identifiability(...)` needs a run that lasts; with these values and inputs it diverges at each step: "
            "give other values by `start`, or a shorter experiment."
        )
    return before


def _is_settled(before: Identifiability, now: Identifiability) -> bool:
    """True if no singular value above the limit of the rank is small because the step is."""
    values, largest = now.singular_values, now.singular_values[0]
    small = (values > RANK * largest) & (values < 1e-3 * largest)
    return not (small & (values < SETTLED * before.singular_values)).any()


def _size(model: OutputModel) -> float:
    """The numbers of the runs with directions of the longest experiment."""
    steps = max(float(np.ptp(one.t)) / h for one, h in zip(model.dataset, model.h, strict=True))
    return steps * len(model.numbers) * 3 * model.ode.states.size


def _at_step(model: OutputModel, sigma: Array) -> Identifiability | None:
    """The answer at the step of a model, or None if a run diverges."""
    parts = []
    for i in range(len(model.dataset.names)):
        with np.errstate(all="ignore"):
            _, J = model.derivatives(model.starts, i)
        parts.append((J / sigma[:, np.newaxis]).reshape(-1, len(model.numbers)))
    derivatives = np.concatenate(parts)
    if not np.isfinite(derivatives).all():
        return None
    return Identifiability.of(tuple(number.name for number in model.numbers), model.starts, derivatives)
