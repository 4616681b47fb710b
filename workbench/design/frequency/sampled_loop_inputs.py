"""The parts of a sampled loop as they are given: a continuous plant, a law with its period, and frequencies."""

from __future__ import annotations

import math

import numpy as np

from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array, numbers, refusal
from workbench.design.control_system import System
from workbench.design.linear.operating_point import state_space
from workbench.design.matrices import EPS

SAME = 4 * EPS  # relative: what differs by less is the same but for rounding
Matrices = tuple[Array, Array, Array, Array]


def continuous_plant(call: str, plant: System) -> tuple[Array, Array, Array]:
    """A, B and Cy of a plant in continuous time without feedthrough."""
    A, B, Cy, D = state_space(call.partition("(")[0], plant)
    if plant.isdtime(strict=True):
        raise ValueError(f"`{call}` must be in continuous time; '{plant.name}' has the period {plant.dt} s.")
    if D.any():
        raise ValueError(
            f"`{call}` must have no feedthrough D, or its output at an instant would depend on whether it is read "
            f"before or after the command changes; that of '{plant.name}' has. Add the lag of its sensor."
        )
    return A, B, Cy


def sampled_law(call: str, law: System) -> tuple[Matrices, float]:
    """The matrices of a law in discrete time, and its period in s."""
    matrices = state_space(call.partition("(")[0], law)
    if not law.isdtime(strict=True) or law.dt is True or not 0 < law.dt < math.inf:
        raise ValueError(
            f"`{call}` must be in discrete time with a positive period dt in s; '{law.name}' has dt = {law.dt}. Sample "
            "a continuous law by `c2d`."
        )
    return matrices, float(law.dt)


def band(call: str, frequencies: Numbers, nyquist: float = math.inf) -> Array:
    """Frequencies (m,) in rad/s that do not fall, from zero to Nyquist's frequency."""
    omega = numbers(call, frequencies, 1)
    if not omega.size or not np.isfinite(omega).all():
        raise refusal(call, "a vector of finite numbers, at least one", frequencies)
    if (np.diff(omega) < 0).any() or omega[0] < 0:
        raise ValueError(
            f"`{call}` must rise from zero on, in rad/s; got {omega[0]:g} first and {omega[-1]:g} last. Sort them."
        )
    if omega[-1] > nyquist * (1 + SAME):
        raise ValueError(
            f"`{call}` must not exceed Nyquist's frequency pi / h = {nyquist:.6g} rad/s, above which samples repeat "
            f"what they are below it; got {omega[-1]:.6g} rad/s."
        )
    return omega
