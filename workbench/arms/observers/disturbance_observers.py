"""Disturbance observers: the paper's and its repair, which filter the truth, two by a model, and all beside a state."""

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import Field, replace
from typing import TYPE_CHECKING, ClassVar

import casadi as ca
import numpy as np

from workbench.arms.arm_contracts import AbstractArmObserver, AbstractJoints, motors, torques
from workbench.arms.dynamics import AbstractArm
from workbench.arms.observers.arm_full_state import AbstractJointCounter
from workbench.blocks.loop.contracts import EULER, Inputs, Parts, Reads, euler
from workbench.blocks.loop.wiring import prefix_names, strip_prefix
from workbench.core import Entry, Layout, Signals, block, initial, parameter
from workbench.core.block import Number, Scalar, Vector, initial_states
from workbench.core.claim import Claim
from workbench.core.claim import SignalValues as Run
from workbench.core.units import ANY

ROUNDING = 1e-7  # of rates that are exact but for the last digits


def _follows(y: Run) -> ca.SX:
    """|E_i| |D_i'| - l E_i^2 - E_i E_i': >= 0, but for rounding, where E' = D' - l E."""
    E = y["d_error"]
    return ca.fabs(E) * ca.fabs(y["d'"]) - y["l"] * E**2 - E * y["d_error'"] + ROUNDING


TRUE_STATE = Claim(
    "the true state",
    "q_hat = q and qd_hat = qd at all times, to 1e-7 rad and rad/s.",
    "`ArmFullState`",
    margin=lambda y: ROUNDING - ca.fabs(ca.vertcat(y["q_error"], y["qd_error"])),
)
PRINTED_FOLLOWS = Claim(
    "D_hat follows D",
    "E = D - D_hat has E_i E_i' <= |E_i| |D_i'| - l E_i^2 + 1e-7 N^2 m^2/s, so that D_hat -> D where D settles.",
    "(24)",
    margin=_follows,
)
ORACLE_FOLLOWS = Claim(
    "D_hat = eta follows D",
    "E = D - D_hat has E_i E_i' <= |E_i| |D_i'| - l E_i^2 + 1e-7 N^2 m^2/s: |E_i| falls to |D_i'| / l.",
    "(24), repaired",
    margin=_follows,
)
MOMENTUM_FOLLOWS = Claim(
    "the momentum observer follows D",
    "With the right model, E = D - D_hat has E_i E_i' <= |E_i| |D_i'| - l E_i^2 + 1e-7 N^2 m^2/s.",
    "De Luca and Mattone (2003)",
    (TRUE_STATE,),
    _follows,
)
CHEN_DISSIPATES = Claim(
    "the nonlinear disturbance observer dissipates",
    "With the right model, E = D - D_hat has E^T E' <= E^T D' + 1e-7 N^2 m^2/s at all times.",
    "Mohammadi et al. (2013)",
    (TRUE_STATE,),
    lambda y: ca.dot(y["d_error"], y["d'"] - y["d_error'"]) + ROUNDING,  # l E^T M^-1 E, but for rounding
)


class AbstractDisturbanceObserver(AbstractJoints):
    """An observer of D in M qdd + C qd + G + D = tau, from measurements and an estimated state."""

    if TYPE_CHECKING:  # each block is a dataclass
        __dataclass_fields__: ClassVar[dict[str, Field[object]]]
    uses_truth: ClassVar[bool] = False  # True of one that needs the true disturbance, which no instrument gives

    @property
    def memory(self) -> Layout:
        return initial_states(self)

    @property
    def reads(self) -> Layout:
        """The true disturbance if it is needed, nothing else."""
        return torques("d", (ANY,) * self.dof) if self.uses_truth else Layout()

    @property
    def inputs(self) -> Layout:
        """The torques of its model's motors; none where it has no model."""
        return Layout() if (model := getattr(self, "model", None)) is None else motors(model)

    @abstractmethod
    def estimate(self, t: Number, z: Parts, y: Reads, est: Signals) -> ca.SX:
        """D_hat, (n, 1), in N m or N; of `est` the state is known so far and d is zero."""

    @abstractmethod
    def rate(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs) -> Parts:
        """The derivative of each state, when the torque `tau` is commanded; `est` holds D_hat."""


@block
class PrintedFilter(AbstractJointCounter, AbstractDisturbanceObserver):
    """The paper's disturbance observer as printed, equation (24):

        eta' = -l (eta - D),    eta(0) = 0
        D_hat = integral of eta from 0 to t

    It needs the unknown D itself; and as eta follows D, D_hat follows the integral of D, not D.

    References
    ----------
    Adaptive observer-based sliding mode control with time-varying learning using Riccati gain synthesis for robotic
    manipulators, section 3.2.
    """

    claims: ClassVar[tuple[Claim, ...]] = (PRINTED_FOLLOWS,)
    uses_truth: ClassVar[bool] = True

    joints: int
    l: Scalar = parameter(unit="1/s", low=0, strict=True, symbol="l")

    def __post_init__(self) -> None:
        self.check_joints()

    @property
    def memory(self) -> Layout:
        """The filter's eta and its integral, in the units that (24) would have them."""
        zero = np.zeros(self.joints)
        return Layout((Entry("eta", zero, "N m", symbol="eta"), Entry("D_hat", zero, "N m s")))

    def estimate(self, t: Number, z: Parts, y: Reads, est: Signals) -> ca.SX:
        return z["D_hat"]

    def rate(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs) -> Parts:
        return {"eta": -self.l * (z["eta"] - y.d), "D_hat": z["eta"]}


@block
class OracleFilter(AbstractJointCounter, AbstractDisturbanceObserver):
    """The smallest repair of equation (24): the filter's state is the estimate,

        D_hat' = -l (D_hat - D),    D_hat(0) = 0.

    It is told the true D, and shows what a perfect instrument would be worth.
    """

    claims: ClassVar[tuple[Claim, ...]] = (ORACLE_FOLLOWS,)
    noun: ClassVar[str] = "oracle"
    uses_truth: ClassVar[bool] = True

    joints: int
    l: Scalar = parameter(unit="1/s", low=0, strict=True, symbol="l")

    def __post_init__(self) -> None:
        self.check_joints()

    @property
    def memory(self) -> Layout:
        return Layout((Entry("D_hat", np.zeros(self.joints), "N m"),))

    def estimate(self, t: Number, z: Parts, y: Reads, est: Signals) -> ca.SX:
        return z["D_hat"]

    def rate(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs) -> Parts:
        return {"D_hat": -self.l * (z["D_hat"] - y.d)}


@block
class NonlinearDisturbanceObserver(AbstractDisturbanceObserver):
    """The nonlinear disturbance observer with gain L(q) = l M^-1(q), for M qdd + C qd + G + D = tau:

        D_hat = z - l qd,                               z(0) = l qd(0) makes D_hat(0) = 0
        z'    = l M^-1 (tau - C qd - G - D_hat)

    with M, C, G of `model` at the estimated state. With the right model and a true velocity the error E = D - D_hat
    obeys E' = D' - l M^-1(q) E: a constant D is found at the rate l / max eig M at least, and otherwise |E| comes
    within (max eig M / l) times the bound of |D'|. Terms that the model lacks count as D.

    Beside a `Luenberger` that compensates, D_hat' = -l L2 (q - q_hat) is one more integrator in its loop, which a large
    l makes unstable.

    References
    ----------
    Chen et al. (2000), A nonlinear disturbance observer for robotic manipulators, IEEE TIE 47(4).
    Mohammadi et al. (2013), Nonlinear disturbance observer design for robotic manipulators, Control Eng. Pract. 21(3).
    """

    claims: ClassVar[tuple[Claim, ...]] = (CHEN_DISSIPATES,)

    model: AbstractArm
    l: Scalar = parameter(unit="kg m^2/s", low=0, strict=True, symbol="l")
    z: Vector = initial(default=0.0, unit="{force}", shape=("n",), symbol="z")

    def estimate(self, t: Number, z: Parts, y: Reads, est: Signals) -> ca.SX:
        d: ca.SX = z["z"] - self.l * est.qd
        return d

    def rate(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs) -> Parts:
        return {"z": self.l * self.model.acceleration(est.q, est.qd, self.model.joint_torques(u.tau) - est.d)}


@block
class MomentumObserver(AbstractDisturbanceObserver):
    """The observer of the generalized momentum p = M(q) qd, for M qdd + C qd + G + D = tau:

        p_hat' = tau + C^T qd - G - D_hat,              p_hat(0) = M(q(0)) qd(0) makes D_hat(0) = 0
        D_hat  = l (p_hat - p)

    with M, C, G of `model` at the estimated state. With the C of the Christoffel symbols M' = C + C^T, and with the
    right model and a true velocity D_hat' = l (D - D_hat), joint by joint, wherever the arm is.

    References
    ----------
    De Luca and Mattone (2003), Actuator failure detection and isolation using generalized momenta, ICRA.
    """

    claims: ClassVar[tuple[Claim, ...]] = (MOMENTUM_FOLLOWS,)
    noun: ClassVar[str] = "momentum"

    model: AbstractArm
    l: Scalar = parameter(unit="1/s", low=0, strict=True, symbol="l")
    p_hat: Vector = initial(default=0.0, unit="{force} s", shape=("n",))

    def estimate(self, t: Number, z: Parts, y: Reads, est: Signals) -> ca.SX:
        d: ca.SX = self.l * (z["p_hat"] - self.model.mass_matrix(est.q) @ est.qd)
        return d

    def rate(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs) -> Parts:
        C, G = self.model.coriolis_matrix(est.q, est.qd), self.model.gravity_vector(est.q)
        return {"p_hat": self.model.joint_torques(u.tau) + C.T @ est.qd - G - est.d}


@block
class StateAndDisturbanceObserver(AbstractArmObserver):
    """Observers of the state and of the disturbance of the same joints as one: first the state, then D_hat from it.

    Both rates see the whole estimate. The true disturbance is handed only to the part that declares to use it.
    """

    noun: ClassVar[str] = ""  # it is called what its parts are called

    state: AbstractArmObserver
    disturbance: AbstractDisturbanceObserver

    def __post_init__(self) -> None:
        if self.state.dof != self.disturbance.dof:
            raise ValueError(
                "`StateAndDisturbanceObserver(...)` needs two observers of the same joints; got a state of "
                f"{self.state.dof} joints and a disturbance of {self.disturbance.dof}."
            )

    @property
    def dof(self) -> int:
        return self.state.dof

    @property
    def uses_truth(self) -> bool:
        return self.state.uses_truth or self.disturbance.uses_truth

    @property
    def memory(self) -> Layout:
        return self.state.memory.with_prefix("state.") + self.disturbance.memory.with_prefix("disturbance.")

    @property
    def units(self) -> tuple[str, ...]:
        return self.state.units

    @property
    def reads(self) -> Layout:
        return _union(self.state.reads, self.disturbance.reads)

    @property
    def inputs(self) -> Layout:
        return _union(self.state.inputs, self.disturbance.inputs)

    def estimate(self, t: Number, z: Parts, y: Reads) -> Signals:
        est = self.state.estimate(t, strip_prefix("state", z), y.only(self.state.reads))
        seen = y.only(self.disturbance.reads)
        return est | {"d": self.disturbance.estimate(t, strip_prefix("disturbance", z), seen, est)}

    def rate(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs) -> Parts:
        parts: dict[str, AbstractArmObserver | AbstractDisturbanceObserver]
        parts = {"state": self.state, "disturbance": self.disturbance}
        rates = {
            name: o.rate(t, strip_prefix(name, z), y.only(o.reads), est, u.only(o.inputs)) for name, o in parts.items()
        }
        return prefix_names(rates)

    @property
    def method(self) -> str:
        return f"{self.state.method}, D_hat by {EULER}" if self.disturbance.memory.size else self.state.method

    def advance(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs, period: float) -> Parts:
        """The state by its own method, the disturbance by explicit Euler."""
        moved, one = euler(z, self.rate(t, z, y, est, u), period), self.state
        state = one.advance(t, strip_prefix("state", z), y.only(one.reads), est, u.only(one.inputs), period)
        return moved | prefix_names({"state": state})

    def without(self) -> Mapping[str, AbstractArmObserver]:
        parts = {name: replace(self, state=one) for name, one in self.state.without().items()}
        return {"disturbance estimate": self.state} | parts


def _union(a: Layout, b: Layout) -> Layout:
    """The signals of two ports, each once."""
    return a + Layout(tuple(entry for entry in b.entries if entry.name not in a))
