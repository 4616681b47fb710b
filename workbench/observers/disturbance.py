"""The contract of a disturbance observer, and its combination with an observer of the state."""

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar

import casadi as ca

from workbench.core import Layout, Signals, block
from workbench.core.block import Number, initial_states
from workbench.core.port import ANY
from workbench.loop.arm_ports import AbstractArmObserver, AbstractJoints, motors, torques
from workbench.loop.contracts import EULER, Inputs, Parts, Reads, euler
from workbench.loop.wiring import above, below


class AbstractDisturbanceObserver(AbstractJoints):
    """An observer of D in M qdd + C qd + G + D = tau, from measurements and an estimated state."""

    uses_truth: ClassVar[bool] = False  # True of one that needs the true disturbance, which no instrument gives

    @property
    def memory(self) -> Layout:
        """The states of the observer: the fields that are declared by `initial`."""
        return initial_states(self)

    @property
    def reads(self) -> Layout:
        """The true disturbance if it is needed, nothing else."""
        return torques("d", (ANY,) * self.dof) if self.uses_truth else Layout()

    @property
    def inputs(self) -> Layout:
        """The torques of its model's motors; none where it has no model."""
        model = getattr(self, "model", None)
        return Layout() if model is None else motors(model)

    @abstractmethod
    def estimate(self, t: Number, z: Parts, y: Reads, est: Signals) -> ca.SX:
        """D_hat, (n, 1), in N m or N; of `est` the state is known so far and d is zero."""

    @abstractmethod
    def rate(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs) -> Parts:
        """The derivative of each state, when the torque `tau` is commanded; `est` holds D_hat."""


@block
class WithDisturbance(AbstractArmObserver):
    """Observers of the state and of the disturbance of the same joints as one: first the state, then D_hat from it.

    Both rates see the whole estimate. The true disturbance is handed only to the part that declares to use it.
    """

    noun: ClassVar[str] = ""  # it is called what its parts are called

    state: AbstractArmObserver
    disturbance: AbstractDisturbanceObserver

    def __post_init__(self) -> None:
        if self.state.dof != self.disturbance.dof:
            raise ValueError(
                "`WithDisturbance(...)` needs two observers of the same joints; got a state of "
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
        return self.state.memory.prefixed("state.") + self.disturbance.memory.prefixed("disturbance.")

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
        est = self.state.estimate(t, below("state", z), y.only(self.state.reads))
        seen = y.only(self.disturbance.reads)
        return est | {"d": self.disturbance.estimate(t, below("disturbance", z), seen, est)}

    def rate(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs) -> Parts:
        parts: dict[str, Any] = {"state": self.state, "disturbance": self.disturbance}
        return above(
            {name: o.rate(t, below(name, z), y.only(o.reads), est, u.only(o.inputs)) for name, o in parts.items()}
        )

    @property
    def method(self) -> str:
        return f"{self.state.method}, D_hat by {EULER}" if self.disturbance.memory.size else self.state.method

    def advance(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs, period: float) -> Parts:
        """The state by its own method, the disturbance by explicit Euler."""
        moved, one = euler(z, self.rate(t, z, y, est, u), period), self.state
        state = one.advance(t, below("state", z), y.only(one.reads), est, u.only(one.inputs), period)
        return moved | above({"state": state})

    def without(self) -> Mapping[str, AbstractArmObserver]:
        less: Mapping[str, Any] = self.state.without()
        return {"disturbance estimate": self.state} | {name: replace(self, state=one) for name, one in less.items()}


def _union(a: Layout, b: Layout) -> Layout:
    """The signals of two ports, each once."""
    return a + Layout(tuple(entry for entry in b.entries if entry.name not in a))
