"""The columns of a regression beside those of the bodies: frictions, offsets and the inertia of drives, by joint."""

from __future__ import annotations

from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from workbench.arms.mechanics.inertial_regressor import Regressor, regressor
from workbench.arms.mechanics.planar_arm import PlanarArm
from workbench.arms.mechanics.spatial import SpatialArm
from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import finite, positive
from workbench.core.validation.signatures import check_arguments


@dataclass(frozen=True)
@show
@check_arguments
class JointTerms:
    """The torques of each joint beside those of the bodies, all linear in their numbers:

        J qdd + b qd + (f_c + f_s exp(-(qd / v_s)^2)) s(qd) + c

    Parameters
    ----------
    drive, viscous, coulomb, offset
        True for a column of J [kg m^2], b [N m s/rad], f_c [N m] and c [N m]; kg, N s/m and N of a slide.
    smoothing
        The speed v in s(qd) = tanh(qd / v), in rad/s or m/s; 0 for s = sign(qd).
    least_speed
        Samples of a joint that is slower have no weight in its equation, as the friction at rest has no known sign.
    stribeck_speed
        The speed v_s of the column of f_s [N m]; None for no such column.

    References
    ----------
    Armstrong-Helouvry, Dupont and Canudas-de-Wit (1994), Automatica 30(7), 1083-1138, section 2.
    """

    drive: bool = True
    viscous: bool = True
    coulomb: bool = True
    offset: bool = False
    smoothing: float = 0.0
    least_speed: float = 0.0
    stribeck_speed: float | None = None

    def __post_init__(self) -> None:
        for word in ("smoothing", "least_speed"):
            finite(f"JointTerms({word}=...)", getattr(self, word), low=0.0)
        if self.stribeck_speed is not None:
            positive("JointTerms(stribeck_speed=...)", self.stribeck_speed)

    @check_arguments
    def direction(self, qd: ca.SX) -> ca.SX:
        """The sign s(qd), (1, 1), smoothed if `smoothing` is given."""
        return ca.tanh(qd / self.smoothing) if self.smoothing else ca.sign(qd)

    def columns(self, qd: ca.SX, qdd: ca.SX, length: str, force: str) -> dict[str, tuple[str, ca.SX]]:
        """The unit and the torque per unit of each number of a joint."""
        s, every = self.direction(qd), {}
        if self.drive:
            every["drive"] = ("kg" if length == "m" else "kg m^2", qdd)
        if self.viscous:
            every["viscous"] = (f"{force} s/{length}", qd)
        if self.coulomb:
            every["coulomb"] = (force, s)
        if self.stribeck_speed is not None:
            every["stribeck"] = (force, s * ca.exp(-((qd / self.stribeck_speed) ** 2)))
        if self.offset:
            every["offset"] = (force, ca.SX(1))
        return every


def regressor_with_joints(arm: PlanarArm | SpatialArm, terms: JointTerms) -> Regressor:
    """The regressor of the bodies with the columns of the joints behind them; a column that the arm has stays its own.

    The values of new numbers are zero.
    """
    Y = regressor(arm)
    names, units, columns = list(Y.names), list(Y.units), [Y.matrix]
    for i, name in enumerate(link_names(arm)):
        slides = isinstance(arm, SpatialArm) and arm.links[i].slides
        length, force = ("m", "N") if slides else ("rad", "N m")
        for word, (unit, torque) in terms.columns(Y.qd[i], Y.qdd[i], length, force).items():
            if f"{name}.{word}" not in Y.names:
                column = ca.SX(Y.dof, 1)
                column[i] = torque
                names, units, columns = [*names, f"{name}.{word}"], [*units, unit], [*columns, column]
    theta = np.concatenate([Y.theta, np.zeros(len(names) - len(Y.names))])
    return replace(Y, names=tuple(names), units=tuple(units), theta=theta, matrix=ca.densify(ca.horzcat(*columns)))


def link_names(arm: PlanarArm | SpatialArm) -> tuple[str, ...]:
    """The names of the links as the regressor has them."""
    if isinstance(arm, SpatialArm):
        return tuple(link.name for link in arm.links)
    return tuple(f"link{i + 1}" for i in range(arm.dof))
