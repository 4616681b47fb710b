"""`simulate_log`: a system driven by the inputs of a log, at the times of the log."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from workbench.core import Entry, Layout, Ode, SampledSystem
from workbench.core.equations import Loop
from workbench.core.validation.refusals import Array, known_name, one_of, positive
from workbench.core.validation.signatures import check_arguments
from workbench.identification.datasets import Dataset, Experiment
from workbench.identification.estimation.computer_check import refuse_random_computer
from workbench.identification.estimation.fit_system import number_source, start_values
from workbench.identification.estimation.input_record import HOLDS
from workbench.identification.estimation.output_model import OutputModel
from workbench.identification.estimation.signal_matching import match_inputs
from workbench.identification.estimation.system_equations import flow_of, system_of

MOST_HALVINGS = 10
SMALLEST = 1e-9  # of an output, in its unit, below which it is as good as zero


@check_arguments
def simulate_log(
    system: Ode | SampledSystem | Loop,
    dataset: Dataset,
    outputs: Sequence[str],
    *,
    signals: Mapping[str, str] | None = None,
    hold: str = "hold",
    values: Mapping[str, float] | None = None,
    tolerance: float = 1e-6,
) -> Dataset:
    """The outputs of a system that the inputs of a log drive, at the log's own times, as a dataset.

    Parameters
    ----------
    system, dataset, signals, hold
        As for `wb.fit`: each input of the system is a signal of the log, by its name or as `signals` says.
    outputs
        Names of outputs and states of the system.
    values
        Values of parameters and initial states; the defaults are those of the system.
    tolerance
        The allowed change of an output at half the step, over its largest value.

    Raises
    ------
    ValueError
        If a run diverges, or no step keeps the tolerance.
    LookupError
        If a name is unknown.

    Examples
    --------
    >>> motor = wb.open_loop(wb.DCMotor())
    >>> t = np.linspace(0.0, 2.0, 201)
    >>> log = wb.Dataset.of(t, {"v": np.where(t < 1.0, 12.0, 0.0)}, {"v": "V"})
    >>> wb.identification.simulate_log(motor, log, ["omega"])["omega"][[0, 100, 200]].round(3)
    array([0.   , 0.996, 0.175])
    """
    whole_system, numbers = system_of(system, "simulate_log"), start_values("simulate_log", values)
    ode = flow_of(whole_system)
    rule = one_of("simulate_log(hold=...)", hold, HOLDS)
    inputs, _ = match_inputs("simulate_log", ode, dataset, signals or {}, rule, frozenset(numbers))
    entries = tuple(_entry(ode, name) for name in outputs)
    layout = Layout(entries)
    pairs = tuple((label, label) for label in layout.labels)
    source = number_source("simulate_log", ode, dataset, inputs, pairs, numbers)
    refuse_random_computer("simulate_log", whole_system, source.p, "values")
    steps = tuple(float(np.median(np.diff(experiment.t))) for experiment in dataset)
    model = OutputModel(whole_system, dataset, inputs, pairs, (), source.p, source.x0, steps, (0.0,) * len(steps))
    rows = _settled_outputs(model, positive("simulate_log(tolerance=...)", tolerance))
    experiments = [Experiment(e.name, e.t, layout, y) for e, y in zip(dataset, rows, strict=True)]
    return Dataset(tuple(experiments), f"'{ode.name}' driven by {dataset.source or 'a log'}")


def _entry(ode: Ode, name: str) -> Entry:
    """The output of a name, or the state."""
    known_name(name, (*ode.outputs.names, *ode.states.names), f"outputs and states of '{ode.name}'")
    return (ode.outputs if name in ode.outputs else ode.states)[name]


def _settled_outputs(model: OutputModel, tolerance: float) -> list[Array]:
    """The outputs (N, ny) of each experiment, at steps half of which change them by less than a tolerance."""
    none = np.zeros((1, 0))
    before = [model.values(none, i)[0] for i in range(len(model.dataset.names))]
    for _ in range(MOST_HALVINGS):
        model = model.at_half_step()
        now = [model.values(none, i)[0] for i in range(len(before))]
        if not all(np.isfinite(y).all() for y in now):
            raise ValueError(
                "`simulate_log(...)` needs a run that lasts; with these values and inputs it diverges: give others by "
                "`values`."
            )
        pairs = zip(before, now, strict=True)
        changes = [np.abs(a - b).max(axis=0) / np.maximum(np.abs(b).max(axis=0), SMALLEST) for a, b in pairs]
        if max(float(change.max(initial=0.0)) for change in changes) <= tolerance:
            return now
        before = now
    raise ValueError(
        f"`simulate_log(tolerance=...)` must be a change that {2**MOST_HALVINGS} steps between two samples keep; got "
        f"{tolerance:g}: take a larger one."
    )
