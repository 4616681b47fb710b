"""Regions of confidence of estimated responses: bands of gain and phase over frequency, ellipses in the plane."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.frequency.frequency_axis import phases
from workbench.study.document.figure import Band, Guides, Mark
from workbench.study.document.frequency_curves import Complex, FrequencyCurve, styles

QUANTILE = 1.959964  # of the normal distribution, for 95 %
QUANTILE_OF_TWO = math.sqrt(-2 * math.log(0.05))  # of the length of two normal numbers, for 95 %
DEEPEST = 1e-2  # of a gain, below which its band is not drawn
WIDEST = 180.0  # degrees on each side of a phase, of which an estimate this uncertain tells nothing
APART = 0.15  # of the reach of a picture: the distance from one ellipse to the next
ANGLES = np.linspace(0.0, 2 * np.pi, 49)
REGION = "95 % region"


def confidence_bands(curves: Sequence[FrequencyCurve]) -> tuple[list[Mark], list[Mark]]:
    """The bands of the gains in decibels and of the phases in degrees, at each frequency by itself."""
    gains: list[Mark] = []
    turns: list[Mark] = []
    for one, style in zip(curves, styles(curves), strict=True):
        rows = _rows(one)
        if rows is None:
            continue
        omega, values, covariance = rows
        sizes, reach = np.abs(values), QUANTILE * _spread(values / np.abs(values), covariance)
        low, high = np.maximum(sizes - reach, DEEPEST * sizes), sizes + reach
        gains.append(Band(REGION, omega, 20 * np.log10(low), 20 * np.log10(high), style))
        turned = np.degrees(QUANTILE * _spread(1j * values / sizes, covariance) / sizes)
        phase, wide = phases(omega, values), np.minimum(turned, WIDEST)
        turns.append(Band("", omega, phase - wide, phase + wide, style))
    return gains, turns


def confidence_ellipses(curves: Sequence[FrequencyCurve], reach: float) -> list[Mark]:
    """Ellipses about some values of the curves within the reach of a picture, each with 95 % of the probability."""
    lines: list[tuple[Array, Array]] = []
    for one in curves:
        rows = _rows(one)
        if rows is None:
            continue
        _, values, covariance = rows
        last = complex(np.inf)
        for value, spread in zip(values.tolist(), covariance, strict=True):
            if abs(value) <= reach and not abs(value - last) < APART * reach:
                lines.append(_ellipse(value, spread))
                last = value
    return [Guides(tuple(lines), ("",) * len(lines))] if lines else []


def region_remarks(curves: Sequence[FrequencyCurve], marks: str) -> list[str]:
    """A sentence on the bands or ellipses of a picture, if it has any."""
    return [f"{marks} 95 % of the probability at a frequency."] if any(_rows(one) is not None for one in curves) else []


def _ellipse(value: complex, covariance: Array) -> tuple[Array, Array]:
    sizes, axes = np.linalg.eigh(covariance)
    circle = np.sqrt(np.maximum(sizes, 0.0))[:, np.newaxis] * np.stack([np.cos(ANGLES), np.sin(ANGLES)])
    points = QUANTILE_OF_TWO * axes @ circle
    return value.real + points[0], value.imag + points[1]


def _rows(one: FrequencyCurve) -> tuple[Array, Complex, Array] | None:
    """Frequencies, values and covariances of a curve where all are known, or None if they are nowhere."""
    if one.covariance is None:
        return None
    seen = (one.frequencies > 0) & np.isfinite(one.values) & (np.abs(one.values) > 0)
    seen &= np.isfinite(one.covariance).all(axis=(1, 2))
    if seen.sum() < 2:
        return None
    return one.frequencies[seen], np.asarray(one.values[seen], dtype=complex), one.covariance[seen]


def _spread(directions: Complex, covariance: Array) -> Array:
    """The standard deviations (m,) along unit directions in the complex plane."""
    axes = np.stack([directions.real, directions.imag], axis=1)
    return np.asarray(np.sqrt(np.maximum(np.einsum("mi,mij,mj->m", axes, covariance, axes), 0.0)))
