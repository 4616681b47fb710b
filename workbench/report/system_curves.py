"""The curves, matrices and roots of systems of python-control and of linear loops, by their names, for pictures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, TypeAlias

from workbench.core.validation.refusals import Array, refusal
from workbench.design.control_system import System
from workbench.design.frequency import StabilityMargins, stability_margins
from workbench.design.linear.system_answers import lti, system_answers, system_roots, unstable_poles
from workbench.design.linear_loop import LinearLoop
from workbench.design.matrices import DesignError
from workbench.identification.linear_models import FrequencyEstimate
from workbench.report.linear_loop_curves import Curves, channel_curves, loop_matrix, loop_poles
from workbench.report.loop_pictures import FrequencyMatrix, PoleZeroSet
from workbench.study.document.frequency_curves import CornerFrequencies, FrequencyCurve

if TYPE_CHECKING:
    Drawable: TypeAlias = System | LinearLoop | FrequencyCurve | FrequencyEstimate
    Systems: TypeAlias = Drawable | Mapping[str, Drawable]
else:
    Systems = object  # each picture refuses what it cannot draw, in its own words


def systems_by_name(systems: Systems) -> list[tuple[str, System]]:
    """The systems by their names; a single one has no name."""
    if isinstance(systems, Mapping):
        if not systems:
            raise refusal("bode(systems) and its like", "a system, or a mapping from names to systems", systems)
        return [(str(name), one) for name, one in systems.items()]
    return [("", systems)]


def one_channel(call: str, system: System) -> System:
    """A system with one input and one output; any other is refused."""
    if not system.issiso():
        raise ValueError(
            f"`{call}(systems)` draws one input and one output; this one has {system.ninputs} and {system.noutputs}: "
            "take one channel, as `system[0, 0]`, or `singular_values_plot`."
        )
    return system


def curves_of(
    call: str, systems: Systems, frequencies: Array | None, margins: bool | None, asymptotes: bool = False
) -> Curves:
    """The curves of systems with what is to be drawn beside them; by default loops alone have margins."""
    found = Curves([])
    for label, one in systems_by_name(systems):
        if isinstance(one, LinearLoop):
            found += channel_curves(call, one, label, frequencies, margins is not False, asymptotes)
        elif isinstance(one, FrequencyCurve):
            found += Curves([one], [], [None])
        elif isinstance(one, FrequencyEstimate):
            found += Curves([_estimate_curve(label, one)], list(one.remarks), [None])
        else:
            found += _system_curves(call, label, one, frequencies, bool(margins), asymptotes)
    return found


def _estimate_curve(label: str, one: FrequencyEstimate) -> FrequencyCurve:
    """The curve of an estimate, up to Nyquist's frequency, with its covariance."""
    return FrequencyCurve(label or one.method, one.frequencies, one.values, one.period, covariance=one.covariance)


def _system_curves(
    call: str, label: str, system: System, frequencies: Array | None, margins: bool, asymptotes: bool
) -> Curves:
    """The curve of a system, and the sentence that refuses its margins if it has none."""
    held = one_channel(call, lti(call, system))
    found, roots = system_answers(held, frequencies, call), system_roots(held)
    corners = CornerFrequencies(roots.poles, roots.zeros, roots.gain) if asymptotes and roots.gain is not None else None
    known, refused = _margins(held) if margins else (None, "")
    name = label or "L" * margins
    answers = found.frequencies, found.values[:, 0, 0], found.period
    curve = FrequencyCurve(name, *answers, margins=known, corners=corners, integrators=roots.integrators)
    return Curves([curve], [f"No margins of {name}: {refused}"] if refused else [], [unstable_poles(roots)])


def _margins(system: System) -> tuple[StabilityMargins | None, str]:
    """The certified margins of a loop gain, or none and the sentence that refuses them."""
    try:
        return stability_margins(system), ""
    except DesignError as refusal:
        return None, str(refusal)


def matrices_of(call: str, systems: Systems, frequencies: Array | None) -> tuple[list[FrequencyMatrix], list[str]]:
    """The answers of systems with several channels, the loop gains of loops, and sentences on what is refused."""
    held, remarks = [], list[str]()
    for label, one in systems_by_name(systems):
        if isinstance(one, LinearLoop):
            matrix, said = loop_matrix(call, one, label, frequencies)
            held.append(matrix)
            remarks += said
            continue
        found = system_answers(lti(call, one), frequencies, call)
        held.append(FrequencyMatrix(label, found.frequencies, found.values, found.inputs, found.outputs, found.period))
    return held, remarks


def roots_of(call: str, systems: Systems) -> list[PoleZeroSet]:
    """The poles and zeros of systems, and the poles of closed loops."""
    held = []
    for label, one in systems_by_name(systems):
        if isinstance(one, LinearLoop):
            held.append(loop_poles(one, label))
            continue
        roots = system_roots(lti(call, one))
        held.append(PoleZeroSet(label, roots.poles, roots.zeros, roots.period))
    return held
