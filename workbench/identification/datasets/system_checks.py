"""The check of a log against a system: names, units, and the length beside the slowest mode."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from workbench.core import Layout, Ode
from workbench.core.units import ANY
from workbench.core.validation.refusals import Array, nearest
from workbench.identification.datasets.data_finding import DataFinding
from workbench.identification.datasets.dataset import Dataset
from workbench.identification.datasets.unit_scales import scale

TINY = 1e-6  # of the largest eigenvalue: below it a mode is an integrator, whatever rounding makes of it
COARSE = 10.0  # time constants of the slowest mode in one period that make its unit doubtful


def check_names(dataset: Dataset, names: Sequence[str], kind: str) -> Iterator[DataFinding]:
    """Signals that are wanted and that the log does not have."""
    known = (*dataset.signals.names, *dataset.signals.labels)
    for name in names:
        if name not in known:
            text = (
                f"The {kind} {name} must be a column of the log, and it is missing: there is no {name} among "
                f"{', '.join(dataset.signals.names)}.{nearest(name, known)} Rename one by `names` where it is read."
            )
            yield DataFinding("signal missing", "refused", text, name)


def check_system_names(system: Ode, inputs: Sequence[str], outputs: Sequence[str]) -> Iterator[DataFinding]:
    """Inputs and outputs that the system does not have."""
    ports = (
        ("input", inputs, (system.parameters,), "inputs or parameters"),
        ("output", outputs, (system.outputs, system.states), "outputs or states"),
    )
    for kind, names, layouts, of in ports:
        known = [name for layout in layouts for name in (*layout.names, *layout.labels)]
        for name in names:
            if name not in known:
                text = (
                    f"The {kind} {name} must be one of the {of} of '{system.name}'; it is none.{nearest(name, known)}"
                )
                yield DataFinding("signal unknown", "refused", text, name)


def expected_units(system: Ode | None, names: Sequence[str], units: Mapping[str, str] | None) -> dict[str, str]:
    """The units that signals must have by the system, and by `units`, which goes first."""
    result: dict[str, str] = {}
    layouts: tuple[Layout, ...] = () if system is None else (system.states, system.outputs, system.parameters)
    for layout in layouts:
        labels = zip(layout.labels, (unit for entry in layout.entries for unit in entry.units), strict=True)
        result |= dict(labels) | {entry.name: entry.unit for entry in layout.entries}
    result |= units or {}
    return {name: unit for name, unit in result.items() if name in names}


def check_units(dataset: Dataset, names: Sequence[str], required_units: Mapping[str, str]) -> Iterator[DataFinding]:
    """Signals without a unit, in a scaled unit, or in one of another kind."""
    layout = dataset.signals
    own = dict(zip(layout.labels, (unit for entry in layout.entries for unit in entry.units), strict=True))
    own |= {entry.name: entry.unit for entry in layout.entries}
    for name in names:
        if name not in own:
            continue
        unit, wanted = own[name], required_units.get(name, ANY)
        if unit == ANY:
            known = f" The system has it in [{wanted}]." if wanted not in (ANY, "") else ""
            text = (
                f"The signal {name} should have a unit; the log has none: give it by `units` where it is read.{known}"
            )
            yield DataFinding("unit missing", "question", text, name)
            continue
        pairs = zip(unit.split(", "), wanted.split(", "), strict=False)
        factors = [1.0 if wanted == ANY else scale(one, other) for one, other in pairs]
        if None in factors:
            text = (
                f"The signal {name} must have the unit [{wanted}] or one of its kind, and the log has it in [{unit}], "
                "a unit of another kind: look at the column and its head."
            )
            yield DataFinding("unit of another kind", "refused", text, name)
        elif any(factor is not None and abs(factor - 1) > 1e-12 for factor in factors):
            text = (
                f"The signal {name} must be in [{wanted}], and the log has it in [{unit}], {factors[0]:.6g} of it: "
                f'write `log.convert({{"{name}": "{wanted}"}})`.'
            )
            yield DataFinding("unit scaled", "refused", text, name)


def slowest_time(system: Ode, t: float, x: Array | None, p: Array | None) -> float | None:
    """The time 1/|lambda| in s of the slowest mode at a point that is no integrator; None if there is no such mode."""
    state = system.states.default if x is None else x
    numbers = system.parameters.default if p is None else p
    A = np.array(system.A(t, state, numbers))
    if not A.size or not np.isfinite(A).all():
        return None
    sizes = np.abs(np.linalg.eigvals(A))
    modes = sizes[sizes > TINY * sizes.max()]
    return float(1 / modes.min()) if modes.size else None


def check_length(dataset: Dataset, system: Ode, x: Array | None, p: Array | None) -> Iterator[DataFinding]:
    """A log that is shorter than the slowest mode, or so coarse beside it that its unit of time is in doubt."""
    slowest = slowest_time(system, 0.0, x, p)
    spans = {experiment.name: float(np.ptp(experiment.t)) for experiment in dataset if len(experiment)}
    longest = max(spans, key=lambda name: spans[name], default="")
    if slowest is not None and longest and spans[longest] < slowest:
        text = (
            f"The log should be longer than the slowest mode of '{system.name}', {slowest:.4g} s at this point, and "
            f"'{longest}' is too short with {spans[longest]:.4g} s: record a longer one, or say why it will do."
        )
        yield DataFinding("too short", "question", text)
    yield from check_period(dataset, system, x, p)


def check_period(dataset: Dataset, system: Ode, x: Array | None, p: Array | None) -> Iterator[DataFinding]:
    """A log whose samples are so far apart beside the slowest mode that its unit of time is in doubt."""
    slowest = slowest_time(system, 0.0, x, p)
    periods = [experiment.period for experiment in dataset if len(experiment) > 1]
    if slowest is not None and periods and min(periods) > COARSE * slowest:
        text = (
            f"The log should have samples within the slowest mode of '{system.name}', {slowest:.4g} s, and its period "
            f"is {min(periods):.4g} s: say whether its unit of time is s, and not ms."
        )
        yield DataFinding("time unit", "question", text)
