"""Maps of poles and zeros, with lines of constant damping and natural frequency, or the unit circle with its grid."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.core.validation.refusals import Array, refusal, seconds
from workbench.core.validation.signatures import check_arguments
from workbench.study.document.figure import STYLES, Figure, Guides, Label, Mark, Panel, Points, Series, Style
from workbench.study.document.frequency_curves import Complex, Complexes, add_remarks, complexes, number
from workbench.study.document.phrases_and_tables import Cell, Phrase, ReportTable, TableColumn
from workbench.study.document.source import Source

DAMPINGS = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95)
NICE = (1.0, 2.0, 5.0)
NAMED_AT = 90  # of 200 points of a line of constant damping in the plane of z: the end of its named part
RINGS = 5  # lines of natural frequencies, about
QUARTER = np.linspace(np.pi / 2, 3 * np.pi / 2, 91)
CIRCLE = np.linspace(0, 2 * np.pi, 361)
ROOM = 0.12  # of the largest extent, around all poles and zeros


@dataclass(frozen=True, eq=False)
@check_arguments
class PoleZeroSet:
    """The poles (n,) and zeros (m,) of one system, in 1/s, or those of a sampled one with its `period` in s.

    `names` are written beside the poles, one each, '' for none. With a `source`, the loop of which these are the poles,
    they move on a live page.
    """

    label: Label
    poles: Complexes
    zeros: Complexes = ()  # type: ignore[assignment]  # an array cannot be a default
    period: float | None = None
    names: tuple[Label, ...] = ()
    style: Style | None = None
    source: Source | None = None

    def __post_init__(self) -> None:
        for name in ("poles", "zeros"):
            object.__setattr__(self, name, complexes(f"PoleZeroSet({name}=...)", getattr(self, name), 1))
        if self.period is not None:
            seconds("PoleZeroSet(period=...)", self.period)
        if self.names and len(self.names) != len(self.poles):
            raise refusal("PoleZeroSet(names=...)", f"a name for each of {len(self.poles)} poles", self.names)


@check_arguments
def pole_zero_map(name: str, caption: Phrase, systems: Sequence[PoleZeroSet], grid: bool = True) -> Figure:
    """The poles (crosses) and zeros (rings) of systems in the plane of s, or in that of z, with axes of one scale.

    The `grid` of a continuous plane has rays of constant damping and arcs of constant natural frequency, in rad/s; that
    of a sampled one has the same lines at z = exp(s period). Stable poles are left of the axis, or inside the circle.

    Raises
    ------
    ValueError
        If there is no system, none has a pole or a zero, or their periods differ.
    """
    period = common_period("pole_zero_map", [one.period for one in systems])
    held = np.concatenate([np.concatenate([one.poles, one.zeros]) for one in systems])
    if not held.size:
        raise ValueError("`pole_zero_map(systems=...)` must have a pole or a zero; got none.")
    marks: list[Mark] = []
    for k, one in enumerate(systems):
        style = k % STYLES if one.style is None else one.style
        names = one.names or ("",) * len(one.poles)
        if len(one.poles):
            label = f"poles{_of(one, systems)}"
            sources = () if one.source is None else ((one.source, one.source),) * len(one.poles)
            marks.append(Points(label, one.poles.real, one.poles.imag, names, style, sources=sources, shape="pole"))
        if len(one.zeros):
            label = f"zeros{_of(one, systems)}"
            marks.append(Points(label, one.zeros.real, one.zeros.imag, (), style, shape="zero"))
    panel = root_panel(marks, held, period, grid)
    rows: list[tuple[Cell, ...]] = [
        (one.label, kind, float(root.real), float(root.imag), float(abs(root)))
        for one in systems
        for kind, roots in (("pole", one.poles), ("zero", one.zeros))
        for root in roots
    ]
    heads = (
        TableColumn("system"),
        TableColumn("kind"),
        TableColumn("real part"),
        TableColumn("imaginary part"),
        TableColumn("absolute value"),
    )
    remarks = grid_remarks(period) if grid else []
    return Figure(name, add_remarks(caption, remarks), (panel,), 1, ReportTable(name, caption, heads, tuple(rows)))


def _of(one: PoleZeroSet, systems: Sequence[PoleZeroSet]) -> str:
    return f" of {one.label}" if len(systems) > 1 else ""


def common_period(call: str, periods: Sequence[float | None]) -> float | None:
    """The period that all have, None in continuous time."""
    if len(set(periods)) != 1:
        raise ValueError(
            f"`{call}` needs systems of one plane: all continuous, or all sampled with one period; got the periods "
            f"{list(periods)!r}."
        )
    return periods[0]


def grid_remarks(period: float | None) -> list[Phrase]:
    """A sentence on the grid of a plane."""
    plane = "" if period is None else f", at z = exp(s {number(period)} s)"
    return [f"Grey: lines of constant damping, and of constant natural frequency in rad/s{plane}."]


def root_panel(marks: Sequence[Mark], roots: Complex, period: float | None, grid: bool) -> Panel:
    """The panel of a plane of roots: the axis or the circle of stability, and the grid, around all that is held."""
    across, up = root_limits(roots, period)
    drawn = list(marks)
    if period is None:
        lines, names = _damping_grid(across, up)
    else:
        drawn.append(Series("", np.cos(CIRCLE), np.sin(CIRCLE), 6))
        lines, names = _sampled_grid(across, up, period)
    if grid:
        drawn.append(Guides(tuple(lines), tuple(names)))
    part = "part [1/s]" if period is None else "part of z"
    label, over = f"imaginary {part}", f"real {part}"
    return Panel(label, tuple(drawn), over, across, up, hlines=(0.0,), vlines=(0.0,), aspect="equal")


def root_limits(roots: Complex, period: float | None) -> tuple[tuple[float, float], tuple[float, float]]:
    """The ends of both axes: around all roots, and zero, or the unit circle unless all are near z = 1."""
    if period is None:
        anchor = np.array([0.0])
    elif np.abs(roots - 1).max() < 0.25:
        anchor = np.array([1.0])
    else:
        anchor = np.array([-1.0, 1.0, 1j, -1j])
    both = np.concatenate([roots, roots.conj(), anchor])
    size = max(float(np.ptp(both.real)), float(np.ptp(both.imag)), 1e-9 * float(np.abs(both).max()), 1e-12)
    room = ROOM * size
    up = max(float(both.imag.max()), 0.25 * size)
    return (float(both.real.min()) - room, float(both.real.max()) + room), (-up - room, up + room)


def _rings(least: float, most: float) -> list[float]:
    """Some five round numbers between two."""
    held = [
        step * 10.0**power
        for power in range(math.floor(math.log10(most)) - 3, math.ceil(math.log10(most)) + 1)
        for step in NICE
    ]
    even = [max(most / RINGS, 1e-300)]
    step = next((one for one in held if one >= even[0]), most)
    return [step * k for k in range(1, 12) if least < step * k <= most]


def _damping_grid(across: tuple[float, float], up: tuple[float, float]) -> tuple[list[tuple[Array, Array]], list[str]]:
    """Rays and arcs of the left half-plane."""
    reach = 2.5 * max(abs(across[0]), up[1])
    lines, names = [], []
    for damping in DAMPINGS:
        angle = math.pi - math.acos(damping)
        for sign in (1.0, -1.0):
            ends = reach * np.array([0.0, 1.0])
            lines.append((ends * math.cos(angle), sign * ends * math.sin(angle)))
            names.append(f"{damping:g}" if sign > 0 else "")
    for omega in _rings(0.0, max(-across[0], 0.5 * up[1])):
        lines.append((omega * np.cos(QUARTER), omega * np.sin(QUARTER)))
        names.append(f"{number(omega)} rad/s")
    return lines, names


def _sampled_grid(
    across: tuple[float, float], up: tuple[float, float], period: float
) -> tuple[list[tuple[Array, Array]], list[str]]:
    """The same lines at z = exp(s period), up to Nyquist's frequency."""
    top = math.pi / period
    seen = min(top, max(abs(across[0] - 1), up[1]) / period)
    lines, names = [], []
    for damping in DAMPINGS:
        omega = np.linspace(0, top / math.sqrt(1 - damping**2), 200)
        z = np.exp(omega * period * (-damping + 1j * math.sqrt(1 - damping**2)))
        for sign in (1.0, -1.0):
            near, far = z[:NAMED_AT], z[NAMED_AT - 1 :]
            lines += [(near.real, sign * near.imag), (far.real, sign * far.imag)]
            names += [f"{damping:g}" if sign > 0 else "", ""]
    for natural in [*_rings(0.0, 0.99 * seen), *([top] if seen >= top else [])]:
        angle = np.linspace(np.pi / 2, np.pi, 91)
        z = np.exp(natural * period * np.exp(1j * angle))
        lines += [(z.real[::-1], z.imag[::-1]), (z.real, -z.imag)]
        names += [f"{number(natural)} rad/s", ""]
    return lines, names
