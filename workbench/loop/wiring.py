"""What a loop in continuous time and a sampled one have in common: its sockets, its outputs and their units."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import casadi as ca

from workbench.core import Layout
from workbench.loop.contracts import AbstractController, AbstractObserver, AbstractPlant, AbstractReference
from workbench.loop.ports import Estimate, Measurement, Motion, Parts

SOCKETS = ("plant", "observer", "controller")  # those with a memory
UNITS = {
    "q": "rad",
    "qd": "rad/s",
    "q_ref": "rad",
    "qd_ref": "rad/s",
    "e": "rad",
    "e_hat": "rad",
    "ed": "rad/s",
    "tau": "N m",
    "tau_applied": "N m",
    "d": "N m",
    "q_error": "rad",
    "qd_error": "rad/s",
    "d_error": "N m",
    "s": "rad/s",
}
OWN = {*UNITS, "q_hat", "qd_hat", "d_hat", "next"} - {"s"}  # what a loop watches and holds by itself


class Blocks(Protocol):
    """A loop, as far as its blocks go."""

    @property
    def plant(self) -> AbstractPlant:
        """What is controlled."""

    @property
    def observer(self) -> AbstractObserver:
        """What estimates."""

    @property
    def controller(self) -> AbstractController:
        """What commands the torque."""

    @property
    def reference(self) -> AbstractReference:
        """What is wanted."""


def memory(loop: Blocks) -> Layout:
    """The states of all blocks, each below the name of its socket."""
    return sum((getattr(loop, socket).memory.prefixed(f"{socket}.") for socket in SOCKETS), Layout())


def visible(loop: Blocks, y: Measurement) -> Measurement:
    """What the observer may see: the true disturbance only where it declares to use it."""
    return y if loop.observer.uses_truth else y._replace(d=None)


def outputs(y: Measurement, ref: Motion, est: Estimate, tau: ca.SX, applied: ca.SX) -> dict[str, ca.SX]:
    """What is worth watching in any loop: the motion, the wanted one, the torques, and all errors."""
    d = y.d if y.d is not None else ca.SX.zeros(tau.shape)
    return {
        "q": y.q,
        "qd": y.qd,
        "q_ref": ref.q,
        "qd_ref": ref.qd,
        "e": y.q - ref.q,
        "e_hat": est.q - ref.q,
        "ed": y.qd - ref.qd,
        "tau": tau,
        "tau_applied": applied,
        "d": d,
        "q_error": y.q - est.q,
        "qd_error": y.qd - est.qd,
        "d_error": d - est.d,
    }


def signals(law: AbstractController, z: Parts, est: Estimate, ref: Motion) -> Parts:
    """What a law adds to these.

    Raises
    ------
    ValueError
        If it uses a name that is the loop's own, whose quantity it would take the place of.
    """
    parts = law.signals(z, est, ref)
    for name in parts:
        if name in OWN:
            raise ValueError(
                f"`{type(law).__name__}.signals(...)` must not use the name '{name}', which is the loop's own; "
                "rename it."
            )
    return parts


def below(socket: str, parts: Parts) -> dict[str, ca.SX]:
    """The parts of one socket by their own names."""
    prefix = f"{socket}."
    return {name.removeprefix(prefix): part for name, part in parts.items() if name.startswith(prefix)}


def above(parts: Mapping[str, Parts]) -> dict[str, ca.SX]:
    """The parts of several sockets, each below the name of its own."""
    return {f"{socket}.{name}": part for socket, own in parts.items() for name, part in own.items()}


def dense(parts: Mapping[str, ca.SX | None]) -> dict[str, ca.SX]:
    """The parts that there are, with every zero written out."""
    return {name: ca.densify(ca.SX(part)) for name, part in parts.items() if part is not None}


def methods(loop: Blocks, fine: int) -> tuple[str, ...]:
    """How a computer steps each memory: as its block declares, or by so many Runge-Kutta steps a period."""
    by = f"{fine} Runge-Kutta steps a period" if fine else ""
    blocks = {socket: getattr(loop, socket) for socket in ("observer", "controller")}
    return tuple(f"memory of the {socket}: {by or own.method}" for socket, own in blocks.items() if own.memory.size)


def notes(loop: Blocks) -> tuple[str, ...]:
    """What a reader must know of the loop's equations."""
    return ("the observer uses the true disturbance, which no instrument gives",) if loop.observer.uses_truth else ()
