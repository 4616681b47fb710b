"""The margins of claims as outputs of an equation, so that a simulation can tell whether a run breaks one."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Ode
from workbench.core.claim import Claim, Declared
from workbench.metrics.contract import AbstractMetric, Parts
from workbench.validation.refusals import Array, known, require
from workbench.validation.signatures import door

PRIME = "'"
# Below and above any violation, in the loop's arithmetic, where an infinity would become NaN; the second stands for a
# margin that is not a number.
NEVER, UNDEFINED = -1e300, 1e300


class SignalsOf(Mapping[str, ca.SX]):
    """The signals of an equation by name, seen from a block at `path`: its own names, outputs, states, parameters, t.

    A prime behind a name is the derivative along a solution, d/dt + (d/dx) f.
    """

    @door
    def __init__(self, ode: Ode, path: str = "") -> None:
        states, parameters = ode.states.view(ode.x), ode.parameters.view(ode.p)
        everything = {**parameters, **states, **ode.outputs.view(ode.output)}
        own = {k.removeprefix(path): v for k, v in {**parameters, **states}.items() if path and k.startswith(path)}
        self._ode, self._held = ode, {"t": ode.t, **everything, **own}

    def __getitem__(self, name: str) -> ca.SX:
        if isinstance(name, str) and name.endswith(PRIME):
            return derivative(self._ode, self[name.removesuffix(PRIME)])
        return self._held[known(name, self._held, f"signals of '{self._ode.name}'")]

    def __iter__(self) -> Iterator[str]:
        return iter(self._held)

    def __len__(self) -> int:
        return len(self._held)


@door
def derivative(ode: Ode, value: ca.SX) -> ca.SX:
    """The derivative of an expression (any shape) in t, x, p along the solutions of x' = f(t, x, p)."""
    flat = ca.vec(ca.densify(value))
    along = ca.jtimes(flat, ca.vertcat(ode.t, ode.x), ca.vertcat(1, ode.rate))
    return ca.reshape(along, *value.shape)


@dataclass(frozen=True)
@door
class Largest(AbstractMetric):
    """The largest value of an output over all steps, with its sign, (k, 1); `UNDEFINED` if it ever is no number."""

    signal: str

    @property
    def watches(self) -> tuple[str, ...]:
        """The signal of the metric."""
        return (self.signal,)

    def memory(self, size: int) -> Layout:
        """The largest so far."""
        return Layout((Entry("largest", np.full(size, NEVER)),))

    def update(self, k: ca.SX, h: ca.SX, z: Parts, y: Parts) -> Parts:
        """The larger of the memory and the present value."""
        signal = y[self.signal]
        return {"largest": ca.fmax(z["largest"], ca.if_else(ca.fabs(signal) < UNDEFINED, signal, UNDEFINED))}

    def value(self, integral: Array, z: Mapping[str, Array], horizon: float) -> Array:
        """The largest value of the run."""
        return z["largest"]


@door
def violation(claim: Claim) -> Largest:
    """The largest violation of a claim over all instants of a run: positive where it is broken."""
    name = f"violation of {claim.name}"
    return Largest(name, "", f"largest negative margin of {claim.name}", name)


@door
def watching(ode: Ode, claims: Sequence[Declared]) -> Ode:
    """The same equation with one more output for each claim: minus its margin, `violation of ...`."""
    entries, columns = [], [ode.output]
    for said in {said.claim.name: said for said in claims}.values():
        if said.claim.margin is None:
            name = said.claim.name
            raise ValueError(
                f"`watching(claims=...)` needs margins, which a run can break; the claim '{name}' has none."
            )
        margin = said.claim.margin(SignalsOf(ode, said.path))
        require(f"The margin of '{said.claim.name}'", margin, ca.SX)
        value = -ca.vec(ca.densify(margin))
        entries.append(Entry(violation(said.claim).signal, np.zeros(value.numel())))
        columns.append(value)
    return replace(ode, outputs=ode.outputs + Layout(tuple(entries)), output=ca.vertcat(*columns))
