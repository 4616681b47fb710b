"""Several channels over frequency: singular values, relative gains, det(I + L) and characteristic loci."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from workbench.core.validation.refusals import Array, refusal
from workbench.core.validation.signatures import check_arguments
from workbench.design.frequency import relative_gains
from workbench.design.matrices import DesignError
from workbench.report.loop_pictures.bode_pictures import (
    DECIBELS,
    DEEPEST,
    FREQUENCY,
    check_curves,
    limits_of,
    named_lines,
    numbers_of_curves,
    nyquist_lines,
)
from workbench.report.loop_pictures.frequency_matrices import (
    FrequencyMatrix,
    characteristic_curves,
    determinant_curve,
    disk_remarks,
    square_channels,
)
from workbench.report.loop_pictures.nyquist_pictures import (
    Plane,
    frame_remarks,
    plane_marks,
    plane_panel,
    plane_reach,
    turn_remarks,
)
from workbench.study.document.figure import STYLES, Figure, Label, Mark, Panel, Series
from workbench.study.document.frequency_curves import FrequencyCurve, add_remarks, decibels
from workbench.study.document.gain_bounds import Disk, GainBound, shaded_bounds, shaded_disks
from workbench.study.document.phrases_and_tables import Cell, Phrase, ReportTable, TableColumn

LINES = 9  # elements of a relative gain array, of which each has a line


@check_arguments
def singular_value_figure(
    name: str,
    caption: Phrase,
    systems: Sequence[FrequencyMatrix],
    bounds: Sequence[GainBound] = (),
    ylabel: Label = "singular values",
) -> Figure:
    """The singular values of systems over frequency, in decibels, one line each.

    `bounds` shade regions that the largest singular value must not reach.

    Raises
    ------
    ValueError
        If there is no system, or none has a frequency above zero.
    """
    curves, marks, rows = _singular_curves(systems)
    check_curves("singular_value_figure", curves)
    return _over_frequency(
        name,
        add_remarks(caption, disk_remarks(systems)),
        curves,
        marks,
        (*ylabel, " [dB]") if isinstance(ylabel, tuple) else f"{ylabel} [dB]",
        ReportTable(
            name,
            caption,
            (
                TableColumn("system"),
                TableColumn("frequency", "rad/s"),
                TableColumn("singular value"),
                TableColumn("gain"),
            ),
            rows,
        ),
        shaded=shaded_bounds(bounds),
    )


def _singular_curves(
    systems: Sequence[FrequencyMatrix],
) -> tuple[list[FrequencyCurve], list[Mark], tuple[tuple[Cell, ...], ...]]:
    """The singular values as curves, their marks, and the rows of a table."""
    curves: list[FrequencyCurve] = []
    marks: list[Mark] = []
    rows: list[tuple[Cell, ...]] = []
    for k, one in enumerate(systems):
        values = np.full((len(one.frequencies), min(one.values.shape[1:])), np.nan)
        values[one.has_answers] = np.linalg.svd(one.values[one.has_answers], compute_uv=False)
        for j, column in enumerate(values.T):
            curve = FrequencyCurve(one.label, one.frequencies, column.astype(complex), one.period)
            omega, answers = curve.logarithmic
            curves.append(curve)
            label = one.label if not j else ""
            marks.append(Series(label, omega, decibels(answers), k % STYLES))
        rows += [
            (one.label, float(w), j + 1, None if np.isnan(x) else float(x))
            for w, row in zip(one.frequencies, values, strict=True)
            for j, x in enumerate(row)
        ]
    return curves, marks, tuple(rows)


@check_arguments
def relative_gain_figure(name: str, caption: Phrase, plant: FrequencyMatrix) -> Figure:
    """The sizes of the relative gains of a square plant over frequency, a line for each pair of output and input.

    A pairing is easy where its relative gain is near one. There is a gap where the plant is singular.

    Raises
    ------
    ValueError
        If the plant is not square, has more than three channels, or is singular at every frequency.

    References
    ----------
    Skogestad and Postlethwaite (2005), Multivariable Feedback Control, second edition, section 3.4.

    Examples
    --------
    >>> from workbench.report.loop_pictures import FrequencyMatrix, relative_gain_figure
    >>> G = FrequencyMatrix("G", [0.5, 1.0, 2.0], [[[1.0 - 1j, 0.1], [0.2, 1.0 - 2j]]] * 3)
    >>> relative_gain_figure("rga", "Two loops", G).name
    'rga'
    """
    square_channels("relative_gain_figure(plant=...)", [plant])
    size = plant.values.shape[1]
    if size**2 > LINES:
        raise refusal("relative_gain_figure(plant=...)", "a plant of up to three channels, nine lines", size)
    values = np.full(plant.values.shape, np.nan, complex)
    for k in np.flatnonzero(plant.has_answers):
        try:
            values[k] = relative_gains(plant.values[k])
        except DesignError:
            continue
    above = plant.frequencies > 0
    curves = [
        FrequencyCurve(f"{plant.outputs[i]}, {plant.inputs[j]}", plant.frequencies, values[:, i, j], plant.period)
        for i in range(size)
        for j in range(size)
    ]
    check_curves("relative_gain_figure", curves, zeros=True)
    marks: list[Mark] = [
        Series(one.label, plant.frequencies[above], np.abs(one.values[above]), k % STYLES)
        for k, one in enumerate(curves)
    ]
    heads = (
        TableColumn("output"),
        TableColumn("input"),
        TableColumn("frequency", "rad/s"),
        TableColumn("relative gain"),
    )
    rows = tuple(
        (plant.outputs[i], plant.inputs[j], float(w), None if np.isnan(x) else float(abs(x)))
        for i in range(size)
        for j in range(size)
        for w, x in zip(plant.frequencies, values[:, i, j], strict=True)
    )
    remark = "Each line is |relative gain| of an output and an input; 1 is no interaction."
    table = ReportTable(name, caption, heads, rows)
    return _over_frequency(name, add_remarks(caption, [remark]), curves, marks, "relative gain", table, level=1.0)


def _over_frequency(
    name: str,
    caption: Phrase,
    curves: Sequence[FrequencyCurve],
    marks: Sequence[Mark],
    ylabel: Label,
    table: ReportTable,
    level: float = 0.0,
    shaded: Sequence[Mark] = (),
) -> Figure:
    """One panel over frequency with a line at a level, and Nyquist's frequencies."""
    held: list[Array] = [mark.spans[1][0] for mark in marks]
    deepest = DEEPEST if level == 0 else np.inf
    limits = limits_of(held, [level] if level else [], deepest)
    omega = np.concatenate([one.logarithmic[0] for one in curves])
    tops = nyquist_lines(curves)
    panel = Panel(
        ylabel,
        (*marks, *shaded, *named_lines(curves, limits)),
        FREQUENCY,
        (float(omega.min()), max([float(omega.max()), *(1.6 * top for top in tops)])),
        limits,
        "log",
        hlines=(level,) if limits[0] < level < limits[1] else (),
        vlines=tops,
        ysteps=DECIBELS if level == 0 else (),
        aspect="tall" if len(marks) > 4 else "",
    )
    return Figure(name, caption, (panel,), 1, table)


@check_arguments
def determinant_figure(
    name: str,
    caption: Phrase,
    loops: Sequence[FrequencyMatrix],
    unstable_poles: int | None = None,
    reach: float | None = None,
) -> Figure:
    """The curves of det(I + L) over frequency, with the number of their encirclements of zero.

    The closed loop is stable if the curve encircles zero anticlockwise as often as L has `unstable_poles`. Curves are
    cut at the distance `reach` from zero.

    Raises
    ------
    ValueError
        If there is no loop, one is not square, or an argument is out of range.

    References
    ----------
    Skogestad and Postlethwaite (2005), Multivariable Feedback Control, second edition, theorem 4.9.

    Examples
    --------
    >>> import control
    >>> from workbench.report.loop_pictures import FrequencyMatrix, determinant_figure
    >>> G = control.ss([[-1.0, 0.0], [0.0, -2.0]], np.eye(2), [[1.0, 1.0], [0.0, 1.0]], np.zeros((2, 2)))
    >>> omega = np.array([0.5, 1.0, 2.0, 4.0])
    >>> L = FrequencyMatrix("L", omega, np.moveaxis(G(1j * omega), -1, 0))
    >>> determinant_figure("determinant", "Two loops", [L], 0, 2.0).name
    'determinant'
    """
    square_channels("determinant_figure(loops=...)", loops)
    curves = [determinant_curve(one) for one in loops]
    return _plane_figure("determinant_figure", name, caption, curves, loops, (0.0, unstable_poles, reach))


@check_arguments
def characteristic_loci_figure(
    name: str,
    caption: Phrase,
    loop: FrequencyMatrix,
    forbidden_disks: Sequence[Disk] = (),
    reach: float | None = None,
) -> Figure:
    """The eigenvalues of L(j w) over frequency: together they encircle -1 as often as det(I + L) encircles zero.

    They do not measure robustness; for this the caption has the disk margin, if the loop has one. `forbidden_disks` are
    shaded, and curves are cut at the distance `reach` from zero.

    Raises
    ------
    ValueError
        If the loop is not square, or the reach is not positive.

    Examples
    --------
    >>> from workbench.report.loop_pictures import FrequencyMatrix, characteristic_loci_figure
    >>> L = FrequencyMatrix("L", [0.5, 1.0, 2.0], [[[1.0 - 1j, 0.1], [0.2, 1.0 - 2j]]] * 3)
    >>> characteristic_loci_figure("loci", "Two loops", L).name
    'loci'
    """
    square_channels("characteristic_loci_figure(loop=...)", [loop])
    curves = characteristic_curves(loop)
    return _plane_figure(
        "characteristic_loci_figure", name, caption, curves, [loop], (-1.0, None, reach), forbidden_disks
    )


def _plane_figure(
    call: str,
    name: str,
    caption: Phrase,
    curves: Sequence[FrequencyCurve],
    loops: Sequence[FrequencyMatrix],
    about: tuple[float, int | None, float | None],
    forbidden: Sequence[Disk] = (),
) -> Figure:
    """Curves in the plane of complex numbers, their turns about a point counted if it is zero."""
    point, unstable, reach = about
    check_curves(call, curves)
    if unstable is not None and (unstable < 0 or len(curves) > 1):
        raise refusal(f"{call}(unstable_poles=...)", "the number of unstable poles of the only loop", unstable)
    plane = Plane(point, "0" if point == 0 else "−1", plane_reach(call, curves, reach, point or 1.0))
    marks = [*plane_marks(curves, plane, with_mirror_image=True), *shaded_disks(forbidden)]
    remarks: list[Phrase] = []
    if not point:  # single loci may be closed through each other, and only all of them count
        remarks = [said for one in curves for said in turn_remarks(one, plane, unstable, len(curves) > 1)]
    remarks += frame_remarks(curves, curves, plane)
    remarks += disk_remarks(loops)
    table = numbers_of_curves(name, caption, curves)
    return Figure(name, add_remarks(caption, remarks), (plane_panel(marks, curves, plane),), 1, table)
