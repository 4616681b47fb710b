"""A generalized plant with the scalings D before its disturbances and after its errors, and D from the loop's gain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import linalg

from workbench.core.validation.refusals import Array
from workbench.design.structured_uncertainty.frequency_bands import PerturbedSystem
from workbench.design.structured_uncertainty.magnitude_fit import MagnitudeFit, Matrices, fit_magnitude
from workbench.design.structured_uncertainty.scaling_search import best_scalings
from workbench.design.structured_uncertainty.uncertainty_blocks import (
    ComplexScalar,
    FullBlock,
    UncertaintyBlock,
    pad,
    places_of,
)
from workbench.design.synthesis.generalized_plant import PlantParts

ROUGH = 1e-3  # of the square of a bound at a frequency; its D is the centre of those that prove this much
LEAST_WEIGHT = 0.05  # of a frequency far below the peak, in a fit


def single_blocks(blocks: Sequence[UncertaintyBlock]) -> list[UncertaintyBlock]:
    """The blocks with each repeated scalar, real or complex, as complex numbers apart: their D is diagonal."""
    return [
        part
        for block in blocks
        for part in ([block] if isinstance(block, FullBlock) else [ComplexScalar(1)] * block.count)
    ]


@dataclass(frozen=True, eq=False)
class SampledScalings:
    """Upper bounds of mu at frequencies, and for each block but the last the magnitude of d, relative to the last."""

    omega: Array
    bounds: Array
    d: Array

    @property
    def peak(self) -> float:
        """The largest bound."""
        return float(self.bounds.max())

    def fits(self, order: int, start: Array, step: float) -> list[MagnitudeFit]:
        """A function of an order for each block but the last, nearest where the bound is near to its peak.

        With a step above one, the logarithm goes on beyond the new d, away from the one at the start, which the plant had.
        """
        weights = np.maximum((self.bounds / self.peak) ** 4, LEAST_WEIGHT)
        return [fit_magnitude(self.omega, d, weights, order) for d in start * (self.d / start) ** step]


def sampled_scalings(matrices: Matrices, blocks: Sequence[UncertaintyBlock], omega: Array) -> SampledScalings:
    """The bounds of a loop at frequencies with the scalings that prove them."""
    loop, places = PerturbedSystem(*matrices), places_of(blocks)
    starts = [place.start for place in places]
    bounds, d = np.zeros(len(omega)), np.zeros((len(starts) - 1, len(omega)))
    for k, w in enumerate(omega):
        M = pad(loop.at(float(w)), blocks)
        scalings = best_scalings(M, places, ROUGH)
        bounds[k] = np.sqrt(max(scalings.square(M), 0.0))
        D = np.diag(scalings.D).real[starts]
        d[:, k] = np.sqrt(D[:-1] / D[-1])
    return SampledScalings(omega, bounds, d)


def scaled_plant(p: PlantParts, blocks: Sequence[UncertaintyBlock], fits: Sequence[MagnitudeFit]) -> PlantParts:
    """The plant with d on each error of a block and 1 / d on each disturbance; the last block stays as it is."""
    if not fits:
        return p
    errors = [fit.state_space() for fit, block in zip(fits, blocks, strict=False) for _ in range(block.shape[1])]
    inputs = [fit.state_space(True) for fit, block in zip(fits, blocks, strict=False) for _ in range(block.shape[0])]
    Al, Bl, Cl, Dl = _diagonal(errors, blocks[-1].shape[1])
    Ar, Br, Cr, Dr = _diagonal(inputs, blocks[-1].shape[0])
    n, nl, nr = len(p.A), len(Al), len(Ar)
    A = np.zeros((n + nl + nr, n + nl + nr))
    A[:n, :n], A[:n, n + nl :] = p.A, p.B1 @ Cr
    A[n : n + nl, :n], A[n : n + nl, n : n + nl], A[n : n + nl, n + nl :] = Bl @ p.C1, Al, Bl @ p.D11 @ Cr
    A[n + nl :, n + nl :] = Ar
    return PlantParts(
        A=A,
        B1=np.vstack([p.B1 @ Dr, Bl @ p.D11 @ Dr, Br]),
        B2=np.vstack([p.B2, Bl @ p.D12, np.zeros((nr, p.B2.shape[1]))]),
        C1=np.hstack([Dl @ p.C1, Cl, Dl @ p.D11 @ Cr]),
        C2=np.hstack([p.C2, np.zeros((len(p.C2), nl)), p.D21 @ Cr]),
        D11=Dl @ p.D11 @ Dr,
        D12=Dl @ p.D12,
        D21=p.D21 @ Dr,
        D22=p.D22,
    )


def _diagonal(systems: Sequence[Matrices], ones: int) -> Matrices:
    """The systems side by side, with a unit matrix of a size after them."""
    empty: Array = np.zeros((0, 0))
    A = linalg.block_diag(empty, *(s[0] for s in systems))
    B = linalg.block_diag(*(s[1] for s in systems), np.zeros((0, ones)))
    C = linalg.block_diag(*(s[2] for s in systems), np.zeros((ones, 0)))
    D = linalg.block_diag(*(s[3] for s in systems), np.eye(ones))
    n, m = len(systems) + ones, sum(len(s[0]) for s in systems)
    return A.reshape(m, m), B.reshape(m, n), C.reshape(n, m), D
