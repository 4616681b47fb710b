"""What the sliding laws share: the sliding variable, the reference velocity, and sat(s / phi)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import casadi as ca

from workbench.core import AbstractArm
from workbench.core.block import Scalar, Vector
from workbench.loop.ports import Estimate, Motion

SATURATIONS: Mapping[str, str] = {
    "clip": "sat(x) = x within -1 and 1, sign(x) outside: continuous, with a corner at the layer's edge",
    "tanh": "sat(x) = tanh(x): smooth, within 1e-4 of sign(x) only from 5 phi on",
}


class Surface(NamedTuple):
    """The sliding variable and what belongs to it, each (n, 1)."""

    e: ca.SX
    ed: ca.SX
    s: ca.SX
    qd_r: ca.SX
    qdd_r: ca.SX


def sliding(est: Estimate, ref: Motion, Lambda: Vector) -> Surface:
    """The sliding variable s = ed + Lambda e of the error that the observer sees, and all that goes with it.

    Here e = q - q_ref, and the reference velocity qd_r = qd_ref - Lambda e makes s = qd - qd_r; its
    derivative is qdd_r = qdd_ref - Lambda ed where the estimates are exact. Lambda (n,) in 1/s.
    """
    e, ed = est.q - ref.q, est.qd - ref.qd
    return Surface(e, ed, ed + Lambda * e, ref.qd - Lambda * e, ref.qdd - Lambda * ed)


def saturation(s: ca.SX, phi: Scalar, kind: str) -> ca.SX:
    """sat(s / phi), elementwise: sign(s), its jump spread over a layer phi; `kind` as in `SATURATIONS`."""
    x: ca.SX = s / phi
    return ca.tanh(x) if kind == "tanh" else ca.fmax(ca.fmin(x, 1), -1)


def matrices(model: AbstractArm, est: Estimate) -> tuple[ca.SX, ca.SX, ca.SX]:
    """M (n, n), C (n, n) and G (n, 1) as the designer's model gives them at the estimated state."""
    return model.mass_matrix(est.q), model.coriolis_matrix(est.q, est.qd), model.gravity_vector(est.q)
