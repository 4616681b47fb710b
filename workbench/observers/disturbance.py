"""Observers of the disturbance, and how one of them joins an observer of the state."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import replace
from typing import ClassVar

import casadi as ca

from workbench.core import Layout, Signals, block
from workbench.core.block import Number, initial_states
from workbench.core.port import ANY
from workbench.loop.arm_ports import AbstractArmObserver, known, motors, torques, unit, units_of
from workbench.loop.contracts import EULER, Inputs, Parts, Reads, euler

STATE, DISTURBANCE = "state.", "disturbance."


class AbstractDisturbanceObserver(ABC):
    """From measurements and an estimated state to an estimate of D in M qdd + C qd + G + D = tau."""

    @property
    @abstractmethod
    def dof(self) -> int:
        """The number of joints n."""

    @property
    @abstractmethod
    def uses_truth(self) -> bool:
        """Whether it needs the true disturbance, which no instrument gives."""

    @property
    def memory(self) -> Layout:
        """Its own states: the fields that are declared by `initial`."""
        return initial_states(self)

    @property
    def force(self) -> str:
        """The unit of the disturbance, for the units of numbers: N m where there is no model to tell."""
        return unit(torques("d", known(units_of(self))))

    @property
    def reads(self) -> Layout:
        """The true disturbance where it needs it, nothing else."""
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
    """An observer of the state and one of the disturbance as one: first the state, then D_hat from it.

    Both rates see the whole estimate. The true disturbance is handed only to the part that declares
    to use it.

    Raises
    ------
    ValueError
        If the two are for different numbers of joints.
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
        """The number of joints."""
        return self.state.dof

    @property
    def uses_truth(self) -> bool:
        """Whether either of them does."""
        return self.state.uses_truth or self.disturbance.uses_truth

    @property
    def memory(self) -> Layout:
        """The states of both, below `state.` and `disturbance.`."""
        return self.state.memory.prefixed(STATE) + self.disturbance.memory.prefixed(DISTURBANCE)

    @property
    def units(self) -> tuple[str, ...]:
        """Those of the observer of the state."""
        return self.state.units

    @property
    def reads(self) -> Layout:
        """What either of them reads."""
        return _both(self.state.reads, self.disturbance.reads)

    @property
    def inputs(self) -> Layout:
        """The torques that either of them counts on."""
        return _both(self.state.inputs, self.disturbance.inputs)

    def estimate(self, t: Number, z: Parts, y: Reads) -> Signals:
        """The estimated state, with D_hat."""
        est = self.state.estimate(t, _below(STATE, z), y.only(self.state.reads))
        seen = y.only(self.disturbance.reads)
        return est | {"d": self.disturbance.estimate(t, _below(DISTURBANCE, z), seen, est)}

    def rate(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs) -> Parts:
        """The rates of both."""
        one, other = self.state, self.disturbance
        state = one.rate(t, _below(STATE, z), y.only(one.reads), est, u.only(one.inputs))
        disturbance = other.rate(t, _below(DISTURBANCE, z), y.only(other.reads), est, u.only(other.inputs))
        return _above(STATE, state) | _above(DISTURBANCE, disturbance)

    @property
    def method(self) -> str:
        """That of the observer of the state, with the other one's."""
        return f"{self.state.method}, D_hat by {EULER}" if self.disturbance.memory.size else self.state.method

    def advance(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs, period: float) -> Parts:
        """The state by its own method, the disturbance by explicit Euler."""
        moved, one = euler(z, self.rate(t, z, y, est, u), period), self.state
        state = one.advance(t, _below(STATE, z), y.only(one.reads), est, u.only(one.inputs), period)
        return moved | _above(STATE, state)

    def without(self) -> Mapping[str, AbstractArmObserver]:
        """The observer of the state alone, and both with each part of that one left out."""
        less = {
            name: replace(self, state=state)
            for name, state in self.state.without().items()
            if isinstance(state, AbstractArmObserver)
        }
        return {"disturbance estimate": self.state} | less


def _above(prefix: str, parts: Parts) -> dict[str, ca.SX]:
    return {f"{prefix}{name}": part for name, part in parts.items()}


def _below(prefix: str, z: Parts) -> Parts:
    return {name.removeprefix(prefix): part for name, part in z.items() if name.startswith(prefix)}


def _both(a: Layout, b: Layout) -> Layout:
    """The signals of two ports, each once."""
    return a + Layout(tuple(entry for entry in b.entries if entry.name not in a))
