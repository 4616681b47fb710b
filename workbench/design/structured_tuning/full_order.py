"""The H-infinity norm that a controller of full order reaches, beside which that of a structured one is held."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from workbench.design.matrices import DesignError
from workbench.design.structured_tuning.design_goals import DesignGoal
from workbench.design.synthesis import GeneralizedPlant, hinf_controller
from workbench.design.synthesis.plant_conditions import full_columns

SHARES = (1e-4, 1e-3, 1e-2)  # of what a measurement reads, or a control moves: of the noise and weight that are added


def full_order_norm(plants: Sequence[GeneralizedPlant], goals: Sequence[DesignGoal]) -> tuple[float | None, str]:
    """The largest norm over all plants that a controller of full order for each reaches, and a note.

    The norm is that of the one H-infinity goal; None where there is none, for the reason in the note. Where a
    measurement has no noise, or a control no weight, a little of it is added. This raises the norm of every controller,
    so what is reached with it is reached without.
    """
    norms = [goal for goal in goals if goal.figure == "hinf"]
    if len(norms) != 1:
        return None, f"a full-order controller is held against one H-infinity goal; there are {len(norms)}"
    reached, notes = list[float](), list[str]()
    for plant in plants:
        norm, note = _reached(_part(plant, norms[0]))
        if norm is None:
            return None, note
        reached.append(norm)
        notes.append(note)
    return max(reached), max(notes, key=len)


def _reached(plant: GeneralizedPlant) -> tuple[float | None, str]:
    """The norm of one plant that a controller of full order reaches, or None, and a note."""
    lacks = [] if full_columns(plant.parts.D21.T) else ["noise on each measurement"]
    lacks += [] if full_columns(plant.parts.D12) else ["a weight on each control"]
    reason = ""
    for share in SHARES if lacks else (0.0,):
        try:
            norm = hinf_controller(_regular(plant, share)).norm.gain.high
        except DesignError as refused:
            reason = str(refused)
            continue
        return norm, f"reached after adding {' and '.join(lacks)} of {share:g} of its size" if lacks else ""
    return None, reason


def _regular(plant: GeneralizedPlant, share: float) -> GeneralizedPlant:
    """The plant with a little noise on each measurement, and a little weight on each control, where these lack."""
    p = plant.parts
    n, _, nu, _, ny = plant.sizes
    if not full_columns(p.D21.T):
        noise = np.diag(share * np.linalg.norm(np.hstack([p.C2, p.D21]), axis=1))
        B1, D11 = np.hstack([p.B1, np.zeros((n, ny))]), np.hstack([p.D11, np.zeros((len(p.D11), ny))])
        p = replace(p, B1=B1, D11=D11, D21=np.hstack([p.D21, noise]))
    if not full_columns(p.D12):
        weight = np.diag(share * np.linalg.norm(np.vstack([p.B2, p.D12]), axis=0))
        C1, D11 = np.vstack([p.C1, np.zeros((nu, n))]), np.vstack([p.D11, np.zeros((nu, p.D11.shape[1]))])
        p = replace(p, C1=C1, D11=D11, D12=np.vstack([p.D12, weight]))
    return replace(plant, B1=p.B1, C1=p.C1, D11=p.D11, D12=p.D12, D21=p.D21)


def _part(plant: GeneralizedPlant, goal: DesignGoal) -> GeneralizedPlant:
    """The plant from the disturbances to the errors of a goal."""
    p = plant.parts
    rows = slice(None) if goal.outputs is None else list(goal.outputs)
    columns = slice(None) if goal.inputs is None else list(goal.inputs)
    return replace(
        plant,
        B1=p.B1[:, columns],
        C1=p.C1[rows],
        D11=p.D11[rows][:, columns],
        D12=p.D12[rows],
        D21=p.D21[:, columns],
    )
