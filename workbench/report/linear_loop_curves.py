"""The curves, matrices and poles of a `LinearLoop` for its pictures, with the margins of its channels."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from workbench.core import Layout
from workbench.core.validation.refusals import Array
from workbench.design.frequency import StabilityMargins
from workbench.design.linear.system_answers import SystemRoots, unstable_poles
from workbench.design.linear_loop import LinearLoop, LinearRows
from workbench.design.linear_loop.cut_margins import channel_margins
from workbench.design.linear_loop.frequency_answers import CutModels
from workbench.design.linear_loop.loop_channels import channel_models, channel_roots, loop_frequencies
from workbench.design.linear_loop.loop_equations import flow_of, labels_of
from workbench.design.matrices import DesignError
from workbench.report.loop_pictures import FrequencyMatrix, PoleZeroSet
from workbench.study.document.figure import STYLES
from workbench.study.document.frequency_curves import CornerFrequencies, FrequencyCurve


@dataclass(frozen=True)
class Curves:
    """The curves of a picture, sentences on what is not drawn, and for each curve how many poles of L are unstable."""

    curves: list[FrequencyCurve]
    remarks: list[str] = field(default_factory=list)
    unstable: list[int | None] = field(default_factory=list)

    def __add__(self, other: Curves) -> Curves:
        return Curves(self.curves + other.curves, self.remarks + other.remarks, self.unstable + other.unstable)


@dataclass(frozen=True)
class Margins:
    """The margins of each channel, None where there are none to print, and the disk margin of several at once."""

    channels: list[StabilityMargins | None]
    disk: float | None = None
    remarks: list[str] = field(default_factory=list)

    @property
    def crossovers(self) -> list[float]:
        """The frequencies in rad/s of all gain crossovers and of the first phase crossovers; a delay has many."""
        held = [one for one in self.channels if one is not None]
        return [row.frequency.value for one in held for row in (*one.gain_crossovers, *one.phase_crossovers[:1])]


def channel_curves(
    call: str, linear: LinearLoop, label: str, frequencies: Array | None, margins: bool, asymptotes: bool = False
) -> Curves:
    """The loop gain at each channel of the cut while the loop is closed at the others."""
    if call != "bode":
        refuse_rates(call, linear)
    found = loop_margins(linear) if margins or linear.models.delays.any() else Margins([None] * len(linear.channels))
    omega = frequencies_of(call, linear, frequencies, found)
    curves, unstable = [], list[int | None]()
    for k, name in enumerate(linear.channels):
        one = LinearLoop(linear.point, channel_models(linear.models, k), linear.corner_signals)
        values = one.response(omega).values[:, 0, 0]
        roots = channel_roots(call, linear.models, k)
        corners = None
        if asymptotes and roots.gain is not None:
            corners = CornerFrequencies(roots.poles, roots.zeros, roots.gain)
        told = found.channels[k] if margins else None
        words = (f"{label}, {name}" if len(linear.channels) > 1 else label) if label else f"L at {name}"
        poles = roots.integrators if not linear.models.delays.any() else None
        held = FrequencyCurve(words, omega, values, linear.period, margins=told, corners=corners, integrators=poles)
        curves.append(held if told is None else _beside_all(held, found.disk))
        unstable.append(_unstable(linear, k))
    return Curves(curves, found.remarks if margins else [], unstable)


def _beside_all(curve: FrequencyCurve, disk: float | None) -> FrequencyCurve:
    """The curve of one channel with the disk margin of all of them at once."""
    fields = (curve.label, curve.frequencies, curve.values, curve.period, curve.unit, curve.margins, curve.corners)
    return FrequencyCurve(*fields, multiloop_disk_margin=disk, integrators=curve.integrators)


def frequencies_of(call: str, linear: LinearLoop, frequencies: Array | None, margins: Margins | None = None) -> Array:
    """The frequencies that are asked for, or those that show the loop, in rad/s."""
    if frequencies is not None:
        return frequencies
    return loop_frequencies(call, linear.models, margins.crossovers if margins else ())


def loop_margins(linear: LinearLoop) -> Margins:
    """The margins of a loop at its channels, with the sentences that refuse some of them.

    Of one channel of several none are told without the disk margin of all at once, which says how much they are worth.
    """
    names = linear.channels
    disk, several = None, len(names) > 1
    if not several and (siblings := _siblings(linear, names[0])):
        said = (
            f"No margins of {names[0]}: it is one of {len(siblings)} channels, and their margins are printed beside "
            f"the disk margin of all at once: cut the loop at {', '.join(siblings)}."
        )
        return Margins([None], None, [said])
    if several:
        try:
            disk = linear.disk_margin.alpha
        except ValueError as refusal:
            said = "No margins: those of single channels are not printed without the disk margin of all at once. "
            return Margins([None] * len(names), None, [f"{said}{refusal}"])
    found, remarks = list[StabilityMargins | None](), list[str]()
    for k, name in enumerate(names):
        try:
            found += channel_margins("LinearLoop.margins()", channel_models(linear.models, k), (name,)).values()
        except ValueError as refusal:
            found.append(None)
            remarks.append(f"No margins of {name}: {refusal}")
    return Margins(found, disk, remarks)


def _siblings(linear: LinearLoop, name: str) -> tuple[str, ...]:
    """All inputs of the plant, or all outputs, of which the cut is one; empty if there is no other."""
    flow = flow_of(linear.point.equations.closed_loop)
    for names in (flow.drives, flow.measures):
        labels = labels_of(Layout(tuple(flow.outputs[each] for each in names)))
        if name in labels:
            return labels if len(labels) > 1 else ()
    return ()


def refuse_rates(call: str, linear: LinearLoop) -> None:
    """Refuse a loop whose blocks run at several periods, which has no loop gain."""
    if linear.models.closed_model.count > 1:
        raise DesignError(
            f"`{call}` needs one loop gain; here blocks run at several periods, and the gain at an instant is not that "
            'at the next. Draw "bode", "poles" or "step".'
        )


def unstable_of_all(linear: LinearLoop) -> int | None:
    """The number of unstable poles of L at all channels of the cut, None where a delay elsewhere makes it unknown."""
    if np.delete(linear.models.delays, linear.models.channels).any():
        return None
    return _unstable_of(linear.models)


def _unstable(linear: LinearLoop, k: int) -> int | None:
    """The number of unstable poles of L at channel k, None where a delay in another channel makes it unknown."""
    others = np.delete(linear.models.delays, linear.models.channels[k])
    return None if others.any() else _unstable_of(channel_models(linear.models, k))


def _unstable_of(models: CutModels) -> int:
    """The number of unstable poles of L, modes that it does not show included: the closed loop has them, too."""
    L = models.kind("LinearLoop.plot", "L")
    return unstable_poles(SystemRoots(np.linalg.eigvals(L.A[0]).astype(complex), np.zeros(0, complex), None, L.period))


def answer_curves(
    call: str,
    linear: LinearLoop,
    label: str,
    frequencies: Array | None,
    of: str,
    inputs: str | tuple[str, ...] | None,
    outputs: str | tuple[str, ...] | None,
) -> Curves:
    """The answer of each output of a kind to each of its inputs."""
    found = linear.response(frequencies_of(call, linear, frequencies), of, inputs, outputs)
    count = len(found.outputs) * len(found.inputs)
    if count > STYLES:
        raise ValueError(
            f"`{call}(of={of!r})` draws up to {STYLES} answers; there are {count}: choose some by `inputs` and "
            f"`outputs`. The inputs are {', '.join(found.inputs)}; the outputs are {', '.join(found.outputs)}."
        )
    units, curves = signal_units(linear), list[FrequencyCurve]()
    for i, output in enumerate(found.outputs):
        for j, name in enumerate(found.inputs):
            words, unit = f"{output} from {name}", unit_ratio(units[output], units[name])
            if of not in ("closed", "open"):
                words = of if count == 1 else f"{of}, {words}"
            held = (found.frequencies, found.values[:, i, j], linear.period, unit)
            curves.append(FrequencyCurve(f"{label}: {words}" if label else words, *held))
    return Curves(curves, [], [None] * count)


def signal_units(linear: LinearLoop | LinearRows) -> dict[str, str]:
    """The unit of each signal of a loop by its name, and of each that comes from outside; '' where it is unknown."""
    equations, units = linear.point.equations, dict[str, str]()
    for each in (equations.open_loop, equations.closed_loop):
        if each is not None:
            flow = flow_of(each)
            for entry in (*flow.outputs.entries, *(flow.parameters[name] for name in flow.inputs)):
                units |= zip(labels_of(Layout((entry,))), entry.units, strict=True)
    return {name: unit.replace("?", "") for name, unit in units.items()}


def unit_ratio(above: str, below: str) -> str:
    """The unit of an answer per unit of its input; '' if they are the same or one is unknown."""
    if above == below or "" in (above, below):
        return ""
    if below == "1":
        return above
    return f"{above}/({below})" if set(below) & set(" /*^") else f"{above}/{below}"


def loop_matrix(
    call: str,
    linear: LinearLoop,
    label: str,
    frequencies: Array | None,
    of: str = "L",
    inputs: str | tuple[str, ...] | None = None,
    outputs: str | tuple[str, ...] | None = None,
) -> tuple[FrequencyMatrix, list[str]]:
    """The answers of a kind as matrices, with the disk margin of all channels of a loop gain, or why it is refused."""
    found = linear.response(frequencies_of(call, linear, frequencies), of, inputs, outputs)
    disk, remarks = None, list[str]()
    if of == "L" and inputs is None and outputs is None and len(linear.channels) > 1:
        try:
            disk = linear.disk_margin.alpha
        except ValueError as refusal:
            remarks.append(f"No disk margin: {refusal}")
    names = (found.inputs, found.outputs)
    return FrequencyMatrix(label or of, found.frequencies, found.values, *names, linear.period, disk), remarks


def loop_poles(linear: LinearLoop, label: str) -> PoleZeroSet:
    """The poles of the closed loop; in a computer those of the map over the period after which all recurs."""
    period = linear.period and linear.period * linear.models.closed_model.count
    return PoleZeroSet(label, np.array([pole.value for pole in linear.poles], dtype=complex), period=period)
