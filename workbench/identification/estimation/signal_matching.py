"""Signals of a log and the inputs, outputs and states of a system that they are."""

from __future__ import annotations

from collections.abc import Mapping

from workbench.core import Layout, Ode
from workbench.core.units import ANY, read
from workbench.core.validation.refusals import describe, nearest
from workbench.identification.datasets import Dataset
from workbench.identification.estimation.input_record import MeasuredInput


def match_signals(
    call: str, ode: Ode, dataset: Dataset, signals: Mapping[str, str], hold: str, constants: frozenset[str]
) -> tuple[tuple[MeasuredInput, ...], tuple[tuple[str, str], ...], tuple[str, ...]]:
    """The inputs and outputs of a fit, label by label, and remarks on signals of the log or the loop that are neither.

    `signals` are other names than those of the log, and `constants` inputs that the user holds at a number.

    Raises
    ------
    LookupError
        If a name is unknown.
    ValueError
        If an input has no signal, no signal is an output or a state, or units differ.
    """
    inputs, others = match_inputs(call, ode, dataset, signals, hold, constants)
    outputs, unused = [], []
    for label, target in others.items():
        if target in ode.outputs.labels or target in ode.states.labels:
            _refuse_unit(
                call, dataset.signals, label, ode.outputs if target in ode.outputs.labels else ode.states, target
            )
            outputs.append((label, target))
        elif target != _only_number(ode, label):
            known = (*ode.parameters.labels, *ode.outputs.labels, *ode.states.labels)
            raise LookupError(
                f"There is no {describe(target)} among the parameters, outputs and states of '{ode.name}'."
                f"{nearest(target, known)}"
            )
        else:
            unused.append(label)
    if not outputs:
        raise ValueError(
            f"`{call}(dataset=...)` must have a signal that is an output or a state of '{ode.name}' "
            f"({', '.join((*ode.outputs.labels, *ode.states.labels)[:8])}); it has "
            f"{', '.join(dataset.signals.labels)}: name one by `signals`."
        )
    remarks = [f"The log's signals {', '.join(unused)} were not used."] if unused else []
    absent = {label for name in ode.inputs for label in ode.parameters[name].labels()} & _additions(ode)
    if left := sorted(absent - {one.label for one in inputs} - constants):
        remarks.append(f"The log has no {', '.join(left)}: nothing is added to the loop there.")
    return inputs, tuple(outputs), tuple(remarks)


def match_inputs(
    call: str, ode: Ode, dataset: Dataset, signals: Mapping[str, str], hold: str, constants: frozenset[str]
) -> tuple[tuple[MeasuredInput, ...], dict[str, str]]:
    """The signals that drive parameters of the equation, and the other signals with their names in the system."""
    for name in signals:
        dataset.signals.indices(name)
    inputs, others = [], {}
    driven = {label for name in ode.inputs for label in ode.parameters[name].labels()}
    for label, name in _targets(dataset.signals, signals).items():
        target = _only_number(ode, name)
        if target in ode.parameters.labels and (target in driven or name != label):
            _refuse_unit(call, dataset.signals, label, ode.parameters, target)
            inputs.append(MeasuredInput(label, target, hold))
        else:
            others[label] = target
    if missing := sorted(driven - {one.label for one in inputs} - constants - _additions(ode)):
        argument = "values" if call == "simulate_log" else "start"
        raise ValueError(
            f"`{call}(dataset=...)` must have a signal for each input of '{ode.name}', as its motion follows from "
            f"them; there is none for '{missing[0]}': name it by `signals`, or hold it at a number by `{argument}`."
        )
    return tuple(inputs), others


def _additions(ode: Ode) -> set[str]:
    """The inputs of a loop that are added to signals of its own, and are 0 where a log does not have them."""
    names = {f"{name}_ref" for name in ode.follows} | {f"{name}_load" for name in ode.drives}
    names |= {f"{name}_noise" for name in ode.outputs.names}
    return {label for name in ode.inputs if name in names for label in ode.parameters[name].labels()}


def _only_number(ode: Ode, name: str) -> str:
    """The label of the only number of a quantity, as `omega[0]` of `omega`; any other name as it is."""
    for layout in (ode.parameters, ode.outputs, ode.states):
        if name in layout and name not in layout.labels and layout[name].size == 1:
            return layout[name].labels()[0]
    return name


def _targets(layout: Layout, signals: Mapping[str, str]) -> dict[str, str]:
    """For each label of the log the label in the system."""
    targets = {}
    for entry in layout.entries:
        for label in entry.labels():
            base = signals.get(entry.name, entry.name)
            targets[label] = signals.get(label, base + label[len(entry.name) :])
    return targets


def _refuse_unit(call: str, log: Layout, label: str, layout: Layout, target: str) -> None:
    """Refuse a signal whose unit is not that of the system."""
    measured, wanted = (_unit(of, name) for of, name in ((log, label), (layout, target)))
    if ANY not in (measured, wanted) and read(measured) != read(wanted):
        raise ValueError(
            f"`{call}(dataset=...)` must have '{label}' in the unit of '{target}', [{wanted}], as nothing is "
            f"converted; got [{measured}]: scale the signal and state its unit."
        )


def _unit(layout: Layout, label: str) -> str:
    units = [unit for entry in layout.entries for unit in entry.units]
    return units[layout.labels.index(label)]
