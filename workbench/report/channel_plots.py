"""Pictures of the channels of a `LinearLoop`: gang of six, singular values, det(I + L), its loci, relative gains."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from workbench.core import Layout
from workbench.core.validation.refusals import Array, refusal
from workbench.core.validation.signatures import check_arguments
from workbench.design.linear_loop import LinearLoop
from workbench.design.linear_loop.loop_equations import flow_of, labels_of
from workbench.report.linear_loop_curves import (
    frequencies_of,
    loop_matrix,
    refuse_rates,
    signal_units,
    unit_ratio,
    unstable_of_all,
)
from workbench.report.linear_loop_responses import Names
from workbench.report.loop_pictures import (
    FrequencyMatrix,
    bode_figure,
    characteristic_loci_figure,
    determinant_figure,
    relative_gain_figure,
    singular_value_figure,
)
from workbench.report.picture import Picture
from workbench.report.system_curves import Systems, systems_by_name
from workbench.study.document.figure import STYLES, Figure, Panel
from workbench.study.document.frequency_curves import FrequencyCurve
from workbench.study.document.gain_bounds import Disk, GainBound

CALL = "LinearLoop.plot"
GANG = ("TF", "T", "PS", "CSF", "CS", "S")  # in the order of the panels, row by row


def one_loop(kind: str, loops: Systems) -> LinearLoop:
    """A single loop; several by their names are refused."""
    if not isinstance(loops, LinearLoop):
        raise refusal(f"plot(..., {kind!r})", "of one `LinearLoop`", loops)
    return loops


@check_arguments
def gang_of_six(loops: Systems, frequencies: Array | None = None) -> Picture:
    """The gains of the gang of six over frequency, a panel each; of a loop that follows nothing those of four.

    References
    ----------
    Åström and Murray (2021), Feedback Systems, 2nd edition, section 12.1.
    """
    loop = one_loop("gang_of_six", loops)
    omega = frequencies_of(CALL, loop, frequencies)
    found, units, zero = loop.gang_of_six(omega), signal_units(loop), list[str]()
    places: dict[str, int] = {}
    panels = []
    for name in (one for one in GANG if one in found):
        curves = []
        for i, out in enumerate(found[name].outputs):
            for j, into in enumerate(found[name].inputs):
                values, words = found[name].values[:, i, j], f"{out} from {into}"
                if (np.abs(values[omega > 0]) > 0).any():
                    style = places.setdefault(words, len(places)) % STYLES
                    unit = unit_ratio(units[out], units[into])
                    curves.append(FrequencyCurve(words, omega, values, loop.period, unit, style=style))
        if curves:
            panels.append(_gain_panel(name, curves))
        else:
            zero.append(name)
    remarks = ["Gains of the gang of six." if "TF" in found else "Gains of the gang of four: the loop follows nothing."]
    remarks += [f"{name} is zero." for name in zero]
    return Picture(Figure("gang_of_six", " ".join(remarks), tuple(panels), 3 if len(panels) > 4 else 2))


def _gain_panel(name: str, curves: list[FrequencyCurve]) -> Panel:
    """The gains of one of the six; a single curve needs no line in the legend."""
    if len(curves) > STYLES:
        raise ValueError(
            f"`{CALL}('gang_of_six')` draws up to {STYLES} answers in a panel; {name} has {len(curves)}: take "
            '"bode" with `of="closed"`, `inputs` and `outputs`.'
        )
    title = name
    if len(curves) == 1:
        title, curves = f"{name}: {curves[0].label}", [replace(curves[0], label="", style=0)]
    panel = bode_figure("gang", "", curves, ylabel="gain").panels[0]
    return replace(panel, title=title, aspect="")


@check_arguments
def singular_values(
    loops: Systems,
    frequencies: Array | None = None,
    of: str = "L",
    inputs: Names = None,
    outputs: Names = None,
    bounds: tuple[GainBound, ...] = (),
) -> Picture:
    """The singular values of a kind over frequency, of the loop gain with the disk margin of all channels."""
    held, remarks = [], list[str]()
    for label, one in systems_by_name(loops):
        matrix, said = loop_matrix(CALL, one, label, frequencies, of, inputs, outputs)
        held.append(matrix)
        remarks += said
    return Picture(singular_value_figure("singular_values", " ".join(remarks), held, bounds))


@check_arguments
def determinant(loops: Systems, frequencies: Array | None = None, reach: float | None = None) -> Picture:
    """The Nyquist plot of det(I + L), whose turns about zero are counted."""
    return Picture(determinant_plot(loops, frequencies, reach))


def determinant_plot(loops: Systems, frequencies: Array | None, reach: float | None = None) -> Figure:
    """The figure of det(I + L) of a loop, or of several by their names."""
    held, remarks, unstable = [], list[str](), list[int | None]()
    for label, one in systems_by_name(loops):
        refuse_rates(CALL, one)
        matrix, said = loop_matrix(CALL, one, label or "det(I + L)", frequencies)
        held.append(matrix)
        remarks += said
        unstable.append(unstable_of_all(one))
    return determinant_figure(
        "determinant", " ".join(remarks), held, unstable[0] if len(held) == 1 else None, reach=reach
    )


@check_arguments
def characteristic_loci(
    loops: Systems, frequencies: Array | None = None, forbidden_disks: tuple[Disk, ...] = (), reach: float | None = None
) -> Picture:
    """The eigenvalues of L over frequency, with the disk margin of all channels."""
    loop = one_loop("characteristic_loci", loops)
    refuse_rates(CALL, loop)
    matrix, remarks = loop_matrix(CALL, loop, "L", frequencies)
    return Picture(characteristic_loci_figure("characteristic_loci", " ".join(remarks), matrix, forbidden_disks, reach))


@check_arguments
def relative_gains(loops: Systems, frequencies: Array | None = None, outputs: Names = None) -> Picture:
    """The relative gains of the plant, from the inputs at which the loop is cut to as many of its outputs."""
    loop = one_loop("relative_gains", loops)
    flow = flow_of(loop.point.equations.closed_loop)
    drives, measures = (
        labels_of(Layout(tuple(flow.outputs[name] for name in names))) for names in (flow.drives, flow.measures)
    )
    if not set(loop.channels) <= set(drives):
        raise ValueError(
            f"`{CALL}('relative_gains')` needs a loop that is cut at inputs of its plant, {', '.join(drives)}; it is "
            f"cut at {', '.join(loop.channels)}."
        )
    found = loop.response(frequencies_of(CALL, loop, frequencies), "open", "drive", outputs or measures)
    if len(found.outputs) != len(found.inputs):
        raise ValueError(
            f"`{CALL}('relative_gains', outputs=...)` must name an output for each of {len(found.inputs)} inputs; got "
            f"{len(found.outputs)}. The plant has {', '.join(measures)}."
        )
    plant = FrequencyMatrix("plant", found.frequencies, found.values, loop.channels, found.outputs, loop.period)
    return Picture(relative_gain_figure("relative_gains", "", plant))
