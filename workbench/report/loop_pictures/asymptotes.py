"""Bode's asymptotes: gains of straight lines between corners, and phases of straight lines a decade around each."""

from __future__ import annotations

import math

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.study.document.figure import Series
from workbench.study.document.frequency_curves import Complexes, CornerFrequencies, FrequencyCurve

ORIGIN = 1e-9  # of the size of the largest root: one that is nearer to zero lies there
DENSE = 400  # frequencies of a line of phases


def gain_asymptote(curve: FrequencyCurve) -> Series:
    """The asymptote of the gain in decibels, straight over the logarithm of frequency between corners."""
    corners = _checked(curve)
    omega = curve.logarithmic[0]
    sizes = np.abs(np.concatenate([corners.poles, corners.zeros]))
    inner = sizes[(sizes > omega[0]) & (sizes < omega[-1])]
    at = np.unique(np.concatenate([omega[[0, -1]], inner]))
    return Series("asymptotes", at, asymptotic_gain(corners, at), "aid")


def phase_asymptote(curve: FrequencyCurve) -> Series:
    """The asymptote of the phase in degrees."""
    corners, omega = _checked(curve), curve.logarithmic[0]
    at = np.geomspace(omega[0], omega[-1], DENSE)
    return Series("asymptotes", at, asymptotic_phase(corners, at), "aid")


def asymptotic_gain(corners: CornerFrequencies, omega: Array) -> Array:
    """20 log10 of |gain| times max(w, |z|) of each zero over max(w, |p|) of each pole, at frequencies w in rad/s."""
    poles, zeros = (_rooted(roots, corners) for roots in (corners.poles, corners.zeros))
    above = np.log10(np.maximum(omega[:, np.newaxis], np.abs(zeros))).sum(axis=1)
    below = np.log10(np.maximum(omega[:, np.newaxis], np.abs(poles))).sum(axis=1)
    return np.asarray(20 * (math.log10(abs(corners.gain)) + above - below))


def asymptotic_phase(corners: CornerFrequencies, omega: Array) -> Array:
    """The phase in degrees at frequencies in rad/s: each root turns it by 90 degrees, over a decade to both sides.

    Roots with the damping zeta turn it over zeta decades; at the least, it jumps. Where the gain between is negative,
    it begins at -180 degrees.
    """
    poles, zeros = (_rooted(roots, corners) for roots in (corners.poles, corners.zeros))
    still = corners.gain * np.prod(-zeros[zeros != 0]) / np.prod(-poles[poles != 0])
    found = np.full(len(omega), -180.0 if complex(still).real < 0 else 0.0)
    for roots, sign in ((zeros, 1.0), (poles, -1.0)):
        found += sign * 90.0 * int((roots == 0).sum())
        for root in roots[roots != 0]:
            found += sign * _turn(complex(root), omega)
    return found


def _turn(root: complex, omega: Array) -> Array:
    """The turn of 1 - s / root in degrees: upwards for a root in the left half-plane, else downwards."""
    reach = max(abs(root.real) / abs(root), 1e-3)  # in decades
    share = np.clip((np.log10(omega / abs(root)) / reach + 1) / 2, 0, 1)
    return np.asarray(90.0 * share * (-1.0 if root.real > 0 else 1.0))


def _rooted(roots: Complexes, corners: CornerFrequencies) -> Array:
    """The roots, with those that are zero as far as rounding can tell at zero."""
    largest = float(np.abs(np.concatenate([corners.poles, corners.zeros])).max(initial=0.0))
    return np.where(np.abs(roots) > ORIGIN * largest, roots, 0)


def _checked(curve: FrequencyCurve) -> CornerFrequencies:
    if curve.period is not None or curve.corners is None:
        raise ValueError(
            "`bode_figure(asymptotes=True)` draws straight lines between the corners of a continuous system; the curve "
            f"'{curve.label}' is sampled. Leave them out."
        )
    return curve.corners
