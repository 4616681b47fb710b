"""The certified norm of the loop of a plant and a controller as both are written, without rounding between them.

The matrices of a closed loop are sums of products. Rounded to doubles they are another loop, whose norm may differ in
the sixth digit where a controller has large gains. Here they are enclosed in twice the precision.
"""

from __future__ import annotations

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.control_system import System
from workbench.design.frequency.certified_values import CertifiedPeak
from workbench.design.frequency.hinf_norm import MOST_STATES, hinf_norm, peak_of
from workbench.design.frequency.limit_pencils import wide_inverse
from workbench.design.frequency.proved_norm import proved_norm
from workbench.design.frequency.wide_matrices import Wide, bounds_of_solution, stack
from workbench.design.matrices import one_thread
from workbench.design.synthesis.generalized_plant import GeneralizedPlant, PlantParts
from workbench.design.synthesis.normal_plant import Controller

WideMatrices = tuple[Wide, Wide, Wide, Wide]


@one_thread()
def closed_loop_norm(plant: GeneralizedPlant, controller: System) -> CertifiedPeak:
    """The H-infinity norm from w to z; that of `plant.close(controller)`, as rounded, where this is not proved."""
    loop = plant.close(controller)
    K = controller.A, controller.B, controller.C, controller.D
    wide = enclosed_loop(plant.parts, K) if loop.nstates <= MOST_STATES else None
    bounds = None if wide is None else proved_norm(*wide, plant.dt is not None)
    return hinf_norm(loop) if bounds is None else peak_of(bounds, loop.A, plant.dt)


def enclosed_loop(plant: PlantParts, controller: Controller) -> WideMatrices | None:
    """A, B, C and D of the loop that u = K y closes; None where no enclosure is found."""
    Ak, Bk, Ck, Dk = (_exact(part) for part in controller)
    gain = _gain(plant, Ck, Dk)
    if gain is None:
        return None
    A, B1, B2 = _exact(plant.A), _exact(plant.B1), _exact(plant.B2)
    C1, C2, D11 = _exact(plant.C1), _exact(plant.C2), _exact(plant.D11)
    D12, D21, D22 = _exact(plant.D12), _exact(plant.D21), _exact(plant.D22)
    n, both = len(plant.A), len(plant.A) + len(Ak.high)
    x, k, w = gain[:, :n], gain[:, n:both], gain[:, both:]  # u by the plant's state, the controller's, and w
    return (
        stack([[A + B2 @ x, B2 @ k], [Bk @ (C2 + D22 @ x), Ak + Bk @ (D22 @ k)]]),
        stack([[B1 + B2 @ w], [Bk @ (D21 + D22 @ w)]]),
        stack([[C1 + D12 @ x, D12 @ k]]),
        D11 + D12 @ w,
    )


def _gain(plant: PlantParts, Ck: Wide, Dk: Wide) -> Wide | None:
    """u by the states of the plant, those of the controller, and w: (I - Dk D22)^-1 [Dk C2, Ck, Dk D21]."""
    sides = stack([[Dk @ _exact(plant.C2), Ck, Dk @ _exact(plant.D21)]])
    if not plant.D22.any() or not Dk.high.any():
        return sides
    W = Wide.of(np.eye(len(Dk.high))) - Dk @ _exact(plant.D22)
    try:
        inverse = wide_inverse(W)
    except np.linalg.LinAlgError:
        return None
    near = (inverse @ sides).middle
    bound = bounds_of_solution(inverse.high, W, sides - W @ near)
    return None if bound is None else Wide(near.high, near.low, bound)


def _exact(M: Array) -> Wide:
    return Wide.of(np.asarray(M, dtype=float))
