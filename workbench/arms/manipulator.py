"""A robot arm with drives, from the torque that is commanded to the one that acts, friction and a disturbance."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from copy import copy
from typing import Self

import casadi as ca

from workbench.arms.arm_contracts import motion, motors, torques
from workbench.arms.dynamics import MOST_JOINTS, AbstractArm
from workbench.blocks.loop.contracts import AbstractPlant, Inputs, Parts
from workbench.blocks.loop.environment import AbstractDisturbance
from workbench.core import Entry, Layout, Signals, block, initial, parameter
from workbench.core.block import Column, Number, Scalar, States, Vector, quantities
from workbench.core.shapes import Shape
from workbench.core.validation.refusals import whole
from workbench.core.validation.signatures import check_arguments


class AbstractAtJoints:
    """The base class of parts with one number for each joint; `units` are those of the positions, by default rad."""

    units: tuple[str, ...] = ()

    @check_arguments
    def at(self, units: tuple[str, ...]) -> Self:
        """A copy of the part for joints whose positions have these `units`."""
        part = copy(self)
        object.__setattr__(part, "units", units)
        return part

    @property
    def force(self) -> str:
        """The unit of the force: N m for a joint that turns, N for a joint that slides; one for each if they differ."""
        return torques("tau", self.units or ("rad",))["tau"].unit


class AbstractActuator(AbstractAtJoints, ABC):
    """The base class of drives, with one drive at each joint that has a motor."""

    @check_arguments
    def memory(self, motors: int) -> Layout:
        """The states of the drives for a number of `motors`; none by default."""
        return Layout()

    @abstractmethod
    def applied_torque(self, z: Parts, tau: Column) -> ca.SX:
        """The torque that acts on the arm, (motors, 1), in N m or N, for the command tau and the states z."""

    @check_arguments
    def rate(self, z: Parts, tau: Column) -> Parts:
        """The time derivative of each state z of the drives, for the command tau."""
        return {}


@block
class DirectDrive(AbstractActuator):
    """A drive without dynamics: the commanded torque acts at once, limited to -limit <= tau <= limit.

    Parameters
    ----------
    limit
        The largest torque of each motor, or None for no limit.
    """

    limit: Vector | None = parameter(default=None, unit="{force}", low=0, strict=True, shape=("n",), symbol="tau_max")

    def applied_torque(self, z: Parts, tau: Column) -> ca.SX:
        return _limit(tau, self.limit)


@block
class FirstOrderLag(AbstractActuator):
    """A drive with a first-order lag behind the limit:  tau_m' = (tau - tau_m) / T,  tau_m(0) = 0.

    Parameters
    ----------
    time_constant
        The time constant T.
    limit
        The largest torque of each motor, or None for no limit.
    """

    time_constant: Scalar = parameter(unit="s", low=0, strict=True, symbol="T_m")
    limit: Vector | None = parameter(default=None, unit="{force}", low=0, strict=True, shape=("n",), symbol="tau_max")

    def memory(self, motors: int) -> Layout:
        count = whole("memory(motors=...)", motors, most=MOST_JOINTS)
        return torques("tau_m", self.units or ("rad",) * count)

    def applied_torque(self, z: Parts, tau: Column) -> ca.SX:
        return z["tau_m"]

    def rate(self, z: Parts, tau: Column) -> Parts:
        return {"tau_m": (_limit(tau, self.limit) - z["tau_m"]) / self.time_constant}


def _limit(tau: ca.SX, limit: Vector | None) -> ca.SX:
    return tau if limit is None else ca.fmin(ca.fmax(tau, -limit), limit)


@block
class Friction(AbstractAtJoints):
    """Viscous and Coulomb friction at each joint:  F(qd) = viscous qd + coulomb tanh(qd / speed).

    Parameters
    ----------
    viscous
        Coefficient of viscous friction of each joint.
    coulomb
        Coulomb friction of each joint.
    speed
        The speed over which the jump of the Coulomb friction is smoothed.
    """

    viscous: Vector = parameter(unit="{force_by_speed}", low=0, shape=("n",), symbol="b")
    coulomb: Vector = parameter(unit="{force}", low=0, shape=("n",), symbol="f_c")
    speed: Scalar = parameter(default=0.01, unit="{speed_unit}", low=0, strict=True, symbol="v_s")

    @property
    def force_by_speed(self) -> str:
        """The unit of viscous friction; one for each joint if they differ."""
        return ", ".join(f"{force} s/{'m' if force == 'N' else 'rad'}" for force in self.force.split(", "))

    @property
    def speed_unit(self) -> str:
        """The unit of a speed; both units if some joints turn and others slide."""
        return " or ".join(dict.fromkeys(f"{unit}/s" for unit in self.units or ("rad",)))

    def torque(self, qd: Column) -> ca.SX:
        """The friction F(qd), (n, 1), in N m or N."""
        friction: ca.SX = self.viscous * qd + self.coulomb * ca.tanh(qd / self.speed)
        return friction


@block
class Manipulator(AbstractPlant):
    """A robot arm with drives as a plant, with friction F and a disturbance D:

        M(q) qdd + C(q, qd) qd + G(q) + F(qd) + D(t) = tau,        tau = 0 at a joint without a motor.

    The input is tau, one number for each motor; the outputs are q and qd. The disturbance D is available as the signal
    d, which no instrument measures (one of the `truths`). Torques are in N m for joints that turn; for joints that
    slide they are forces in N.

    Parameters
    ----------
    arm
        The arm, as of `wb.robot` or `wb.read_urdf`, with n joints.
    q
        Positions of the joints.
    qd
        Velocities of the joints.
    disturbance
        The disturbance torques D, such as `SineTorque`, or None.
    friction
        The friction F, a `wb.arms.Friction`, or None.
    actuator
        The drives: `wb.arms.DirectDrive` (the default) or `wb.arms.FirstOrderLag`.

    References
    ----------
    Siciliano, Sciavicco, Villani and Oriolo (2009), Robotics: Modelling, Planning and Control, chapter 7.

    Examples
    --------
    >>> plant = wb.Manipulator(wb.paper_arm(), q=[0.5, 0.0])
    >>> plant.inputs["tau"].units, plant.outputs.names, plant.states["q"].default
    (('N m', 'N m'), ('q', 'qd'), array([0.5, 0. ]))
    """

    counts = "joint"
    power = ("tau", "qd")

    arm: AbstractArm
    q: Vector = initial(unit="{q_unit}", shape=("n",))
    qd: Vector = initial(default=0.0, unit="{qd_unit}", shape=("n",))
    disturbance: AbstractDisturbance | None = None
    friction: Friction | None = None
    actuator: AbstractActuator = DirectDrive()

    def __post_init__(self) -> None:
        if self.disturbance is not None and self.disturbance.dof != self.dof:
            raise ValueError(
                f"`Manipulator(disturbance=...)` acts on {self.disturbance.dof} joints, the arm has {self.dof}."
            )
        motors = tuple(self.arm.units[joint] for joint in self.arm.motors)
        for name, units, of in (("friction", self.arm.units, "joint"), ("actuator", motors, "motor")):
            if (part := getattr(self, name)) is not None:
                self._check_sizes(name, len(units), of)
                object.__setattr__(self, name, part.at(units))

    def _check_sizes(self, name: str, count: int, of: str) -> None:
        """Refuse a part with a number for each joint or motor of some other arm."""
        part = getattr(self, name)
        for f, quantity in quantities(part):
            value = getattr(part, f.name)
            if quantity.shape == ("n",) and value is not None and len(value) != count:
                raise ValueError(
                    f"`Manipulator({name}=...)` needs one number a {of}: its '{f.name}' has {len(value)}, "
                    f"the arm has {count} {of}{'s' if count > 1 else ''}."
                )

    @property
    def dof(self) -> int:
        """The number of joints n."""
        return self.arm.dof

    @property
    def q_unit(self) -> str:
        """The unit of q; one for each joint if they differ."""
        return self.outputs["q"].unit

    @property
    def qd_unit(self) -> str:
        """The unit of qd; one for each joint if they differ."""
        return self.outputs["qd"].unit

    @property
    def states(self) -> Layout:
        """The positions q, the velocities qd, and the states of the drives."""
        moving = Layout((Entry("q", self.q, self.q_unit), Entry("qd", self.qd, self.qd_unit)))
        return moving + self.actuator.memory(len(self.arm.motors))

    @property
    def inputs(self) -> Layout:
        """The commanded torques tau, one for each motor."""
        return motors(self.arm)

    @property
    def outputs(self) -> Layout:
        """The positions q and the velocities qd, (n,) each."""
        return motion(self.arm.units, ("q", "qd"))

    @property
    def truths(self) -> Layout:
        """The disturbance d, (n,)."""
        return torques("d", self.arm.units)

    @property
    def labels(self) -> Mapping[str, str]:
        return {"e_q": "e", "e_qd": "ed", "e_hat_q": "e_hat"}

    def measure(self, t: Number, x: States) -> Signals:
        """The outputs q and qd, and the disturbance d."""
        return Signals(q=x["q"], qd=x["qd"], d=self._disturbance(t))

    def applied_inputs(self, t: Number, x: States, u: Inputs) -> Signals:
        """The torques behind the drives."""
        return Signals(tau=self.actuator.applied_torque(x, u["tau"]))

    def drawing(self, t: Number, x: States) -> tuple[Shape, ...] | None:
        """The picture of the arm, or None if the arm has none."""
        return self.arm.drawing(x["q"])

    def rate(self, t: Number, x: States, u: Inputs) -> Parts:
        q, qd = x["q"], x["qd"]
        friction = self.friction.torque(qd) if self.friction is not None else 0
        torque = self.arm.joint_torques(self.actuator.applied_torque(x, u["tau"])) - friction - self._disturbance(t)
        qdd = self.arm.acceleration(q, qd, torque)
        return {"q": qd, "qd": qdd, **self.actuator.rate(x, u["tau"])}

    def _disturbance(self, t: ca.SX) -> ca.SX:
        return self.disturbance.at(t) if self.disturbance is not None else ca.SX.zeros(self.dof)
