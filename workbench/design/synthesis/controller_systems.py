"""Controllers as systems of python-control, with the names and the point of the plant, and their closed loops."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from workbench.core import Entry, Layout
from workbench.design.control_system import System
from workbench.design.matrices import Complex
from workbench.design.riccati.algebraic_equation import distances
from workbench.design.synthesis.normal_plant import Controller

if TYPE_CHECKING:
    from workbench.design.synthesis.generalized_plant import GeneralizedPlant

POINTS = 60  # of the unit circle


def controller_system(plant: GeneralizedPlant, matrices: Controller, name: str) -> System:
    """The controller from y to u of a plant; with a point it is relative to it, and its states are zero there."""
    import control  # takes seconds

    from workbench.design.linear.pointed_systems import PointedSpace

    states = [f"k[{k}]" for k in range(len(matrices[0]))]
    system = control.ss(
        *matrices,
        plant.dt or 0,
        name=name,
        states=states,
        inputs=list(plant.measurements),
        outputs=list(plant.controls),
        remove_useless_states=False,
    )
    if plant.point is None:
        return system
    layout = Layout(tuple(Entry(label, np.zeros(()), "1") for label in states))
    return PointedSpace(system, plant.point.of_controller(layout))


def loop_poles(loop: System) -> Complex:
    """The poles of a closed loop."""
    return np.asarray(np.linalg.eigvals(loop.A), dtype=complex)


def is_stable(loop: System) -> bool:
    """True if every pole of a closed loop, as computed, is stable."""
    return bool(distances(loop_poles(loop), bool(loop.dt)).min(initial=1.0) > 0)


def likely_gain(loop: System) -> float:
    """The largest gain at the frequencies of the poles and between them: a lower bound of the H-infinity norm."""
    sizes = np.abs(loop_poles(loop))
    if loop.dt:
        points = np.exp(1j * np.linspace(0, np.pi, POINTS))
    else:
        sizes = np.unique(sizes[sizes > 0])
        between = np.sqrt(sizes[1:] * sizes[:-1])
        points = 1j * np.concatenate([[0.0], sizes, between])
    one = np.eye(loop.nstates)
    gains = [np.linalg.norm(loop.C @ np.linalg.solve(s * one - loop.A, loop.B) + loop.D, 2) for s in points]
    return float(max([*gains, np.linalg.norm(loop.D, 2)]))
