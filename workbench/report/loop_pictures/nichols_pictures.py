"""Nichols plots: gains in decibels over phases, with the lines of constant closed-loop gain and phase."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.design.frequency.frequency_axis import phases
from workbench.report.loop_pictures.bode_pictures import DECIBELS, DEGREES, check_curves, limits_of, numbers_of_curves
from workbench.report.loop_pictures.margin_words import margin_remarks
from workbench.study.document.figure import Figure, Guides, Mark, Panel, Points, Series
from workbench.study.document.frequency_curves import (
    Complex,
    FrequencyCurve,
    add_remarks,
    decibels,
    doubts,
    styles,
)
from workbench.study.document.phrases_and_tables import Phrase

M_LINES = (6.0, 3.0, 2.0, 1.0, 0.5, 0.25, 0.0, -0.5, -1.0, -3.0, -6.0, -12.0, -20.0, -40.0)  # dB
N_LINES = (-10.0, -20.0, -30.0, -60.0, -90.0, -120.0, -150.0, -180.0)  # degrees, and as far above -360
NEAR = 0.003  # radians from T = 1, where L is infinite: the angles along M-lines are closest there
HALF = NEAR * np.sinh(np.linspace(0, 1, 201) * np.arcsinh(np.pi / NEAR))
ALONG = np.concatenate([HALF, 2 * np.pi - HALF[-2::-1]])
GAINS = np.concatenate([np.geomspace(1e-4, 0.9, 80), np.linspace(0.91, 1.09, 41), np.geomspace(1.1, 1e4, 80)])
LEAST, MOST = -40.0, 80.0  # decibels: the ends of a picture about -1, which is at 0 dB


@check_arguments
def nichols_figure(name: str, caption: Phrase, curves: Sequence[FrequencyCurve]) -> Figure:
    """The curves of loop gains L, in decibels over degrees, with M- and N-lines: those of T = L / (1 + L).

    M-lines have the gain of T in decibels, and N-lines its phase in degrees. A plus marks L = -1. Gains are drawn from
    -40 to 80 dB.

    Raises
    ------
    ValueError
        If there is no curve, or no answer in one.
    """
    check_curves("nichols_figure", curves)
    marks: list[Mark] = []
    for one, style in zip(curves, styles(curves), strict=True):
        omega, values = one.logarithmic
        turned, gains = phases(omega, values), decibels(values)
        held = np.isfinite(turned)
        marks.append(Series(one.label, turned[held], gains[held], style))
    across = limits_of([mark.spans[0][0] for mark in marks], (-90.0, -200.0), np.inf, 0.03)
    up = limits_of([np.clip(mark.spans[1][0], LEAST, MOST) for mark in marks], (10.0, -10.0), np.inf, 0.03)
    ends = math.floor((across[0] + 180) / 360), math.ceil((across[1] + 180) / 360)
    points = np.array([360.0 * k - 180 for k in range(ends[0], ends[1] + 1) if across[0] < 360 * k - 180 < across[1]])
    marks.append(Points("", points, np.zeros(len(points)), ("−1",) * len(points), 6, shape="critical"))
    marks.append(_chart(ends))
    panel = Panel(
        "magnitude [dB]", tuple(marks), "phase [degrees]", across, up, xsteps=DEGREES, ysteps=DECIBELS, aspect="tall"
    )
    remarks: list[Phrase] = margin_remarks(curves, len(curves) > 1)
    remarks += [said for one in curves for said in doubts(one, len(curves) > 1)]
    remarks.append("Grey: lines of constant gain (dB) and phase (degrees) of T = L / (1 + L).")
    return Figure(name, add_remarks(caption, remarks), (panel,), 1, numbers_of_curves(name, caption, curves))


def _chart(ends: tuple[int, int]) -> Guides:
    """The M- and N-lines between 360 k - 360 and 360 k degrees, for each k of a range."""
    lines: list[tuple[Array, Array]] = []
    names: list[str] = []
    for k in range(ends[0], ends[1] + 1):
        for level in M_LINES:
            lines.append(_turned(np.asarray(10 ** (level / 20) * np.exp(1j * ALONG), dtype=complex), k))
            names.append(f"{level:g} dB".replace("-", "−"))
        for angle in N_LINES:
            for degrees in {angle, -360.0 - angle}:
                lines.append(_turned(GAINS[::-1] * np.exp(1j * math.radians(degrees)), k))
                names.append(f"{degrees:g}°".replace("-", "−"))
    return Guides(tuple(lines), tuple(names))


def _turned(T: Complex, k: int) -> tuple[Array, Array]:
    """The points of L = T / (1 - T) by phase, between 360 k - 360 and 360 k degrees, and gain, with gaps at jumps."""
    away = 1 - T
    with np.errstate(divide="ignore", invalid="ignore"):
        L = np.where(np.abs(away) > 1e-9, T / away, np.nan)
    across = np.degrees(np.angle(L)) % 360 - 360 + 360 * k
    up = decibels(L)
    jumps = np.flatnonzero(np.abs(np.diff(across)) > 180)
    return np.insert(across, jumps + 1, np.nan), np.insert(up, jumps + 1, np.nan)
