"""Loop gains of python-control, and the curves of their pictures."""

import math

import control
import numpy as np

from workbench.design.frequency import stability_margins
from workbench.report.table_text import plain
from workbench.study.document.figure import Series
from workbench.study.document.frequency_curves import FrequencyCurve

s = control.tf("s")
THIRD = 4 / (s + 1) ** 3
RESONANT = 10 * (s + 1) / (s * (s + 5) * (s**2 + 0.4 * s + 4))
UNSTABLE = 2 * (s + 3) / (s**2 - 1)
DOUBLE = (s + 1) / s**2
CONDITIONAL = 40 * (s + 1) ** 2 / (s**3 * (s / 20 + 1))
SAMPLED = control.sample_system(8 / (s * (s + 2)), 0.1)
LOOPS = {
    "third order": THIRD,
    "third order, unstable": 4 * THIRD,
    "resonant": RESONANT,
    "unstable plant": UNSTABLE,
    "unstable plant, too weak": 0.1 * UNSTABLE,
    "double integrator": DOUBLE,
    "conditionally stable": CONDITIONAL,
    "conditionally stable, too weak": 0.01 * CONDITIONAL,
    "negative": -0.5 * THIRD,
    "sampled": SAMPLED,
    "sampled, unstable": 8 * SAMPLED,
}


def curve(system, label="L", margins=True, frequencies=None, **more):
    h = system.dt or None
    omega = np.geomspace(1e-3, 1e3, 1501) if frequencies is None else frequencies
    if h:
        omega = np.append(omega[omega < 0.999 * math.pi / h], math.pi / h)
    values = system(np.exp(1j * omega * h)) if h else system(1j * omega)
    found = stability_margins(system) if margins else None
    return FrequencyCurve(label, omega, values, h, margins=found, **more)


def series(panel, label=None):
    return [mark for mark in panel.series if isinstance(mark, Series) and (label is None or mark.label == label)]


def caption(figure):
    return plain(figure.caption)
