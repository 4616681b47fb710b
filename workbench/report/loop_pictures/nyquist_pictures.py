"""Nyquist plots: the curve of a loop gain about -1, its turns counted, with the circles of its margins."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.core.validation.refusals import positive, refusal
from workbench.core.validation.signatures import check_arguments
from workbench.design.frequency import StableMargins
from workbench.report.loop_pictures.bode_pictures import check_curves, numbers_of_curves
from workbench.report.loop_pictures.confidence_regions import confidence_ellipses, region_remarks
from workbench.report.loop_pictures.curve_turns import curve_turns
from workbench.study.document.figure import Arrows, Figure, Guides, Label, Mark, Panel, Points, Series, Style
from workbench.study.document.frequency_curves import (
    Complex,
    FrequencyCurve,
    add_remarks,
    breaks,
    certified_text,
    number,
    styles,
)
from workbench.study.document.gain_bounds import Disk, shaded_disks
from workbench.study.document.phrases_and_tables import Phrase
from workbench.study.document.source import Source

LEAST, MOST = 2.0, 20.0  # the reach of a picture that is cut by itself
WHOLE = 3.0  # times that reach: a curve that goes no farther is not cut
BEYOND = 4.0  # times the reach: what is drawn of a curve
HEADS = (0.35, 0.7)  # of the length of a curve: the places of its arrowheads
POINTS = 500  # of a drawn curve


@dataclass(frozen=True)
class Plane:
    """A plane of complex numbers: its critical point, with a name, and the reach of what is drawn."""

    point: float
    name: str
    reach: float


@check_arguments
def nyquist_figure(
    name: str,
    caption: Phrase,
    curves: Sequence[FrequencyCurve],
    unstable_poles: int | None = None,
    circles: bool = True,
    forbidden_disks: Sequence[Disk] = (),
    reach: float | None = None,
) -> Figure:
    """The curves of loop gains L over frequency, with their mirror images dashed, about the critical point -1.

    The caption states the number of encirclements of -1. For one curve with margins, `circles` draws the circle |S| =
    Ms and that of the disk margin, which touch the curve. `unstable_poles` is the number of unstable poles of L; with
    it the caption states how many unstable poles the closed loop has. `forbidden_disks` are shaded. A curve is cut at
    the distance `reach` from zero. For curves with a `source`, encirclements are not stated.

    Raises
    ------
    ValueError
        If there is no curve or no answer, the number of poles is negative, or the reach is not positive.
    """
    check_curves("nyquist_figure", curves)
    if unstable_poles is not None and (unstable_poles < 0 or len(curves) > 1):
        must = "the number of unstable poles of the only curve"
        raise refusal("nyquist_figure(unstable_poles=...)", must, unstable_poles)
    plane = Plane(-1.0, "−1", plane_reach("nyquist_figure", curves, reach, -1.0))
    marks: list[Mark] = list(plane_marks(curves, plane, with_mirror_image=True))
    marks += confidence_ellipses(curves, plane.reach)
    if circles and len(curves) == 1:
        marks += _margin_circles(curves[0])
    marks += [*shaded_disks(forbidden_disks), Guides(((np.cos(CIRCLE), np.sin(CIRCLE)),), ("|L| = 1",))]
    still = [one for one in curves if one.source is None]
    remarks = [said for one in still for said in turn_remarks(one, plane, unstable_poles, len(curves) > 1)]
    remarks += [*frame_remarks(still, curves, plane), *region_remarks(curves, "The ellipses have")]
    return Figure(
        name,
        add_remarks(caption, remarks),
        (plane_panel(marks, curves, plane),),
        1,
        numbers_of_curves(name, caption, curves),
    )


CIRCLE = np.linspace(-0.25 * np.pi, 1.75 * np.pi, 181)


def plane_reach(call: str, curves: Sequence[FrequencyCurve], reach: float | None, point: float) -> float:
    """The distance from zero up to which curves are drawn: all of them, or what surrounds the critical point."""
    if reach is not None:
        return positive(f"{call}(reach=...)", reach)
    sizes = [float(np.nanmax(np.abs(one.values))) for one in curves]
    least = max(
        LEAST * abs(point), *(1.3 * cut for one in curves for cut in _cuts(np.asarray(one.values, dtype=complex))), 0.0
    )
    return max(sizes) if max(sizes) <= WHOLE * least else least


def _cuts(values: Complex) -> list[float]:
    """The distances from zero, up to the most, at which a curve crosses the negative real axis."""
    here, there = values[:-1], values[1:]
    with np.errstate(invalid="ignore", divide="ignore"):
        share = here.imag / (here.imag - there.imag)
        at = here.real + share * (there.real - here.real)
        crosses = (here.imag * there.imag < 0) & (at < 0) & (at > -MOST)
    return [-float(x) for x in at[crosses]]


def plane_marks(curves: Sequence[FrequencyCurve], plane: Plane, with_mirror_image: bool) -> list[Mark]:
    """The curves within the reach with arrowheads towards higher frequencies, and the critical point."""
    marks: list[Mark] = []
    for one, style in zip(curves, styles(curves), strict=True):
        marks += _pieces(one, one.label, plane, style)
    if with_mirror_image:
        for k, one in enumerate(curves):
            marks += _pieces(one, "negative frequencies" if not k else "", plane, "aid", -1.0)
    return [*marks, Points("", np.array([plane.point]), np.array([0.0]), (plane.name,), 6, shape="critical")]


def _pieces(one: FrequencyCurve, label: Label, plane: Plane, style: Style, way: float = 1.0) -> list[Mark]:
    """The stretches of a curve, or of its mirror image, that are near enough, and the arrowheads on each of them."""
    values = np.asarray(one.values if way > 0 else one.values.conj(), dtype=complex)
    far = np.abs(values) > BEYOND * plane.reach
    if (shown := one.sources("imaginary part", "real part", way)) is not None:
        held = Series(label, np.where(far, 0.0, values.real), np.where(far, np.nan, values.imag), style, sources=shown)
        return [held, *_heads(values[~far & np.isfinite(values)], plane, style, way, shown[1].with_name("arrowheads"))]
    marks: list[Mark] = []
    stretches = [(a, b) for a, b in breaks(np.isfinite(values) & ~far) if b - a > 1]
    for a, b in stretches:
        piece = _thinned(values[a:b])
        marks.append(Series(label if not marks else "", piece.real, piece.imag, style))
        marks += _heads(piece, plane, style, way)
    return marks


def _thinned(piece: Complex) -> Complex:
    """A curve with points at even lengths of it, where it has many more."""
    if len(piece) <= POINTS:
        return piece
    length = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(piece)))])
    kept = np.searchsorted(length, np.linspace(0, length[-1], POINTS))
    return np.asarray(piece[np.unique(np.minimum(kept, len(piece) - 1))])


def _heads(piece: Complex, plane: Plane, style: Style, way: float, source: Source | None = None) -> list[Mark]:
    seen = np.flatnonzero(np.abs(piece) <= plane.reach)
    if len(seen) < 3:
        return []
    part = piece[seen[0] : seen[-1] + 1]
    length = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(part)))])
    if not length[-1] > 0.15 * plane.reach:
        return []
    places = np.array([max(1, int(np.searchsorted(length, share * length[-1]))) for share in HEADS])
    along = way * (part[places] - part[places - 1])
    return [Arrows("", part[places].real, part[places].imag, along.real, along.imag, style, source=source)]


def _margin_circles(one: FrequencyCurve) -> list[Mark]:
    """The circle |1 + L| = 1 / Ms and that of the disk margin, each of which touches the curve."""
    held = None if one.margins is None else one.margins.margins
    if one.source is not None:
        return _live_circles(one, held)
    if held is None:
        return []
    marks: list[Mark] = []
    if math.isfinite(held.Ms.gain.value):
        edge = _closed(Disk("", -1.0, 1 / held.Ms.gain.value).edge)
        marks.append(Series(f"|S| = Ms = {certified_text(held.Ms.gain)}", edge.real, edge.imag, "bound"))
    alpha = held.disk_margin.value
    if alpha < 2:
        ends = -(2 + alpha) / (2 - alpha), -(2 - alpha) / (2 + alpha)
        edge = _closed(Disk("", sum(ends) / 2, (ends[1] - ends[0]) / 2).edge)
        marks.append(Series(f"disk margin {certified_text(held.disk_margin)}", edge.real, edge.imag, 7))
    return marks


def _live_circles(one: FrequencyCurve, held: StableMargins | None) -> list[Mark]:
    """The same circles without their numbers, gaps where they do not exist."""
    Ms, alpha = (math.inf, 2.0) if held is None else (held.Ms.gain.value, held.disk_margin.value)
    sensitivity, disk = NOWHERE, NOWHERE
    if math.isfinite(Ms):
        sensitivity = _closed(Disk("", -1.0, 1 / Ms).edge)
    if alpha < 2:
        ends = -(2 + alpha) / (2 - alpha), -(2 - alpha) / (2 + alpha)
        disk = _closed(Disk("", sum(ends) / 2, (ends[1] - ends[0]) / 2).edge)
    shown = one.sources("circle of Ms", "real part"), one.sources("circle of the disk margin", "real part")
    return [
        Series("|S| = Ms", sensitivity.real, sensitivity.imag, "bound", sources=shown[0]),
        Series("disk margin", disk.real, disk.imag, 7, sources=shown[1]),
    ]


NOWHERE = np.array([complex(0.0, math.nan)])


def _closed(edge: Complex) -> Complex:
    return np.append(edge, edge[:1])


def plane_panel(marks: Sequence[Mark], curves: Sequence[FrequencyCurve], plane: Plane) -> Panel:
    """The panel of a plane: axes of one scale around the curves within the reach, zero and the critical point."""
    across, up = _frame(curves, plane)
    return Panel("imaginary part", tuple(marks), "real part", across, up, hlines=(0.0,), vlines=(0.0,), aspect="equal")


def _frame(curves: Sequence[FrequencyCurve], plane: Plane) -> tuple[tuple[float, float], tuple[float, float]]:
    """The ends of the axis of real parts, and those of the axis of imaginary parts."""
    held = np.concatenate([one.values for one in curves])
    held = held[np.isfinite(held) & (np.abs(held) <= plane.reach)]
    low, high = (float(end) for end in (held.real.min(initial=0.0), held.real.max(initial=0.0)))
    up = max(float(np.abs(held.imag).max(initial=0.0)), 0.6 * abs(plane.point))
    low, high = min(low, plane.point - 0.35 * abs(plane.point), 0.0), max(high, plane.point, 0.15 * abs(plane.point))
    room = 0.06 * max(high - low, 2 * up)
    return (low - room, high + room), (-up - room, up + room)


def turn_remarks(one: FrequencyCurve, plane: Plane, unstable: int | None, several: bool) -> list[Phrase]:
    """Sentences on the turns of a curve, and on its closure at infinity."""
    turns = curve_turns(one.frequencies, one.values, one.period, plane.point, one.integrators)
    head = f"{one.label}: the" if several else "The"
    if turns.clockwise is None:
        said = [f"{head} encirclements of {plane.name} are not counted: {turns.reason}."]
    else:
        said = [f"{head} closed curve {_times(turns.clockwise, plane.name)}."]
        if turns.closures:
            s = "" if turns.closures == 1 else "s"
            said.append(f"At infinity it is closed by {turns.closures} half turn{s} clockwise.")
        if unstable is not None:
            said.append(_verdict(turns.clockwise, unstable, None if one.margins is None else one.margins.stable))
    return list(said)


def frame_remarks(subjects: Sequence[FrequencyCurve], curves: Sequence[FrequencyCurve], plane: Plane) -> list[Phrase]:
    """A sentence on how far some of the curves of a picture go beyond its frame, if one does."""
    (left, right), (low, high) = _frame(curves, plane)
    farthest: list[tuple[float, float]] = []
    for one in subjects:
        real, imaginary = one.values.real, one.values.imag
        outside = (real < left) | (real > right) | (imaginary < low) | (imaginary > high)
        if outside.any():
            sizes = np.where(outside, np.abs(one.values), 0.0)
            farthest.append((float(sizes.max()), float(one.frequencies[sizes.argmax()])))
    if not farthest:
        return []
    size, at = max(farthest)
    head = "The curve leaves" if len(curves) == 1 else "A curve leaves" if len(farthest) == 1 else "Curves leave"
    goes = "reach" if head.startswith("Curves") else "reaches"
    subject = "they" if goes == "reach" else "it"
    return [f"{head} the frame: {subject} {goes} a distance of {number(size)} from zero, at {number(at)} rad/s."]


def _times(clockwise: int, name: str) -> str:
    if not clockwise:
        return f"does not encircle {name}"
    count = {1: "once", 2: "twice"}.get(abs(clockwise), f"{abs(clockwise)} times")
    return f"encircles {name} {count}, {'clockwise' if clockwise > 0 else 'anticlockwise'}"


def _verdict(clockwise: int, unstable: int, stable: bool | None) -> str:
    """The unstable poles of the closed loop, unless its margins, which are certified, say otherwise."""
    closed = clockwise + unstable
    if closed < 0:
        return f"This contradicts {_poles(unstable)} of L: check the range of frequencies."
    if stable is not None and stable != (closed == 0):
        truth = "stable" if stable else "not stable"
        return f"The closed loop is {truth}, but these turns do not show it: check the range of frequencies."
    return f"With {_poles(unstable)} of L, the closed loop has {_poles(closed)}."


def _poles(count: int) -> str:
    return f"{count or 'no'} unstable pole{'' if count == 1 else 's'}"
