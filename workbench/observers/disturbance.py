"""Observers of the disturbance, and how one of them joins an observer of the state."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import replace
from typing import ClassVar

import casadi as ca

from workbench.core import Layout, block
from workbench.loop.contracts import EULER, AbstractObserver, euler
from workbench.loop.ports import Estimate, Measurement, Parts
from workbench.validation.shapes import Column, Number

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
    @abstractmethod
    def memory(self) -> Layout:
        """The observer's own states."""

    @abstractmethod
    def estimate(self, t: Number, z: Parts, y: Measurement, est: Estimate) -> ca.SX:
        """D_hat, (n, 1), in N m; of `est` the state is known so far and d is zero."""

    @abstractmethod
    def rate(self, t: Number, z: Parts, y: Measurement, est: Estimate, tau: Column) -> Parts:
        """The derivative of each state, when the torque `tau` is commanded; `est` holds D_hat."""


@block
class WithDisturbance(AbstractObserver):
    """An observer of the state and one of the disturbance as one: first the state, then D_hat from it.

    Both rates see the whole estimate. The true disturbance is handed only to the part that declares
    to use it.

    Raises
    ------
    ValueError
        If the two are for different numbers of joints.
    """

    noun: ClassVar[str] = ""  # it is called what its parts are called

    state: AbstractObserver
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

    def estimate(self, t: Number, z: Parts, y: Measurement) -> Estimate:
        """The estimated state, with D_hat."""
        est = self.state.estimate(t, _below(STATE, z), _seen(y, self.state.uses_truth))
        y_d = _seen(y, self.disturbance.uses_truth)
        return est._replace(d=self.disturbance.estimate(t, _below(DISTURBANCE, z), y_d, est))

    def rate(self, t: Number, z: Parts, y: Measurement, est: Estimate, tau: Column) -> Parts:
        """The rates of both."""
        state = self.state.rate(t, _below(STATE, z), _seen(y, self.state.uses_truth), est, tau)
        y_d = _seen(y, self.disturbance.uses_truth)
        disturbance = self.disturbance.rate(t, _below(DISTURBANCE, z), y_d, est, tau)
        return _above(STATE, state) | _above(DISTURBANCE, disturbance)

    @property
    def method(self) -> str:
        """That of the observer of the state, with the other one's."""
        return f"{self.state.method}, D_hat by {EULER}" if self.disturbance.memory.size else self.state.method

    def advance(self, t: Number, z: Parts, y: Measurement, est: Estimate, tau: Column, period: float) -> Parts:
        """The state by its own method, the disturbance by explicit Euler."""
        moved = euler(z, self.rate(t, z, y, est, tau), period)
        y_state = _seen(y, self.state.uses_truth)
        state = self.state.advance(t, _below(STATE, z), y_state, est, tau, period)
        return moved | _above(STATE, state)

    def without(self) -> Mapping[str, AbstractObserver]:
        """The observer of the state alone, and both with each part of that one left out."""
        less = {name: replace(self, state=state) for name, state in self.state.without().items()}
        return {"disturbance estimate": self.state} | less


def _above(prefix: str, parts: Parts) -> dict[str, ca.SX]:
    return {f"{prefix}{name}": part for name, part in parts.items()}


def _below(prefix: str, z: Parts) -> Parts:
    return {name.removeprefix(prefix): part for name, part in z.items() if name.startswith(prefix)}


def _seen(y: Measurement, uses_truth: bool) -> Measurement:
    return y if uses_truth else y._replace(d=None)
