"""What the sliding laws share: the sliding variable, the reference velocity, and what they switch."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import casadi as ca

from workbench.controllers.relay import relay
from workbench.core import AbstractArm
from workbench.core.block import Scalar, Vector
from workbench.loop.contracts import Follows, Reads

SATURATIONS = {
    "clip": "sat(x) = x within -1 and 1, sign(x) outside: continuous, with a corner at the layer's edge",
    "tanh": "sat(x) = tanh(x): smooth, within 1e-4 of sign(x) only from 5 phi on",
    "sign": "sign(s), whatever phi: a relay, which chatters at the steps of its computer, or else of the solver",
}
SWITCHINGS = SATURATIONS | {
    "implicit": "a relay by backward Euler over a sampling period, whatever phi: in a sampled loop only",
}


class Switching(Protocol):
    """A law that switches, as far as that goes."""

    @property
    def phi(self) -> Scalar:
        """The width of the boundary layer."""

    @property
    def saturation(self) -> str:
        """Which of `SWITCHINGS`."""

    @property
    def period(self) -> float | None:
        """The sampling period in s, or None in continuous time."""


class Surface(NamedTuple):
    """The sliding variable and what belongs to it, each (n, 1)."""

    e: ca.SX
    ed: ca.SX
    s: ca.SX
    qd_r: ca.SX
    qdd_r: ca.SX


def sliding(est: Reads, ref: Follows, Lambda: Vector) -> Surface:
    """The sliding variable s = ed + Lambda e of the error that the observer sees, and all that goes with it.

    Here e = q - q_ref, and the reference velocity qd_r = qd_ref - Lambda e makes s = qd - qd_r; its
    derivative is qdd_r = qdd_ref - Lambda ed where the estimates are exact. Lambda (n,) in 1/s.
    """
    e, ed = est.q - ref.q, est.qd - ref.qd
    return Surface(e, ed, ed + Lambda * e, ref.qd - Lambda * e, ref.qdd - Lambda * ed)


def saturation(s: ca.SX, phi: Scalar, kind: str) -> ca.SX:
    """sat(s / phi), elementwise: sign(s), its jump spread over a layer phi; `kind` as in `SATURATIONS`."""
    if kind == "sign":
        return ca.sign(s)
    x: ca.SX = s / phi
    return ca.tanh(x) if kind == "tanh" else ca.fmax(ca.fmin(x, 1), -1)


def layered(law: Switching) -> bool:
    """Whether the law has a boundary layer to be left out."""
    return law.saturation in ("clip", "tanh")


def switched(law: Switching, K: Vector, s: ca.SX, M: ca.SX) -> ca.SX:
    """K o sat(s / phi) as the law has it, (n, 1) in N m; "implicit" the torque of `relay` for M s' = -K o sign(s).

    Raises
    ------
    ValueError
        If the law is "implicit" and runs in continuous time.
    """
    if law.saturation == "implicit":
        return relay(s, M, K, sampling_period(law))
    torque: ca.SX = K * saturation(s, law.phi, law.saturation)
    return torque


def sampling_period(law: Switching) -> float:
    """The period in s of a law that needs one, or a refusal."""
    if law.period is None:
        raise ValueError(
            f"`{type(law).__name__}(saturation='implicit')` solves its relay over a sampling period, which continuous "
            "time has none of: take `ClosedLoop.digital(period)`, or another saturation."
        )
    return law.period


def matrices(model: AbstractArm, est: Reads) -> tuple[ca.SX, ca.SX, ca.SX]:
    """M (n, n), C (n, n) and G (n, 1) as the designer's model gives them at the estimated state."""
    return model.mass_matrix(est.q), model.coriolis_matrix(est.q, est.qd), model.gravity_vector(est.q)
