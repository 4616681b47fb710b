"""The largest gain from the noise of a measurement to the command of a law, over frequency."""

from __future__ import annotations

import numpy as np

from workbench.design.control_system import System
from workbench.design.pid_design.process import Process

POINTS = 4.0  # times the frequencies of a search


def noise_gain(plant: System, delay: float, law: System) -> float:
    """sup |C / (1 + P C)| of a plant P, with its delay, and a law C of the error that is proper."""
    process = Process.of("noise_gain", plant, delay)
    return largest_noise_gain(process, law.num[0][0], law.den[0][0])


def largest_noise_gain(process: Process, num: np.ndarray, den: np.ndarray) -> float:
    """The same for the polynomials of the law."""
    corners = np.abs(np.roots(den))
    reach = max(1.0, 30 * float(corners.max()) / float(process.frequencies()[-1]))
    omega = process.frequencies(POINTS)[1:]
    if reach > 1:
        omega = np.concatenate([omega, np.geomspace(omega[-1], reach * omega[-1], 400)[1:]])
    law = np.polyval(num, 1j * omega) / np.polyval(den, 1j * omega)
    g = process.inverse(omega)
    gain = np.abs(law * g / (g + law))
    last = abs(num[0] / den[0]) if len(num) == len(den) else 0.0
    return max(
        float(gain.max()), float(last) / (1 + last * abs(process.gain_limit)) if process.delay == 0 else float(last)
    )
