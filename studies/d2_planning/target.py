"""The parts that all laws of this study share: the model of their observer, and the rest that a law holds."""

from __future__ import annotations

import casadi as ca
import numpy as np

import workbench as wb

ANY = "?"  # the unit of numbers whose units are those of the ports


@wb.block
class LoadedPlant(wb.Plant):
    """A plant whose inputs lose a constant d, as the model of the observer that all laws share:

        x' = f(t, x, u - d),      d' = 0.

    A law that adds the estimate of d to its command has no offset at rest.
    """

    plant: wb.Plant
    unit: str = ""

    @property
    def inputs(self) -> wb.Layout:
        """The inputs of the plant."""
        return self.plant.inputs

    @property
    def outputs(self) -> wb.Layout:
        """The outputs of the plant."""
        return self.plant.outputs

    @property
    def states(self) -> wb.Layout:
        """The states of the plant, and d."""
        return self.plant.states + wb.Layout((wb.core.Entry("d", np.zeros(self.inputs.size), self.unit),))

    def measure(self, t, x):  # type: ignore[no-untyped-def]
        """The outputs of the plant."""
        return wb.Signals(self.plant.measure(t, wb.Signals(x).only(self.plant.states))).only(self.outputs)

    def rate(self, t, x, u):  # type: ignore[no-untyped-def]
        """The rates of the plant; d stays.

        They are taken at symbols first: an arm differentiates its energies, and a command may be the end of a loop,
        through which no kernel differentiates.
        """
        own, u_own = self.plant.states.symbols(), self.inputs.symbols()
        parts = self.plant.rate(t, wb.Signals(self.plant.states.view(own)), wb.Signals(self.inputs.view(u_own)))
        here = self.plant.states.flatten({name: x[name] for name in self.plant.states.names})
        names = self.plant.states.names
        flat = ca.vertcat(*(ca.SX(parts[name]) for name in names))
        (at,) = ca.substitute([flat], [own, u_own], [here, self.inputs.flatten(u) - x["d"]])
        return {**self.plant.states.view(at), "d": ca.SX.zeros(self.inputs.size)}


@wb.block
class Target:
    """The rest for a reference r and a disturbance d, and the limits of the inputs:

    x_s = x0 + X (r - r0),      u_s = u0 + G (r - r0) + d,      low <= u <= high.
    """

    states: wb.Layout
    inputs: wb.Layout
    outputs: wb.Layout
    unit: str
    x0: wb.Array = wb.parameter(unit=ANY, shape=("nx",))
    u0: wb.Array = wb.parameter(unit=ANY, shape=("nu",))
    r0: wb.Array = wb.parameter(unit=ANY, shape=("nr",))
    X: wb.Array = wb.parameter(unit=ANY, shape=("nx", "nr"))
    G: wb.Array = wb.parameter(unit=ANY, shape=("nu", "nr"))
    low: wb.Array = wb.parameter(unit=ANY, shape=("nu",))
    high: wb.Array = wb.parameter(unit=ANY, shape=("nu",))

    @property
    def reads(self) -> wb.Layout:
        """The estimates of the states and of d."""
        return self.states + wb.Layout((wb.core.Entry("d", np.zeros(self.inputs.size), self.unit),))

    def error(self, est: wb.Signals, r: ca.SX) -> ca.SX:
        """The distance of the state from the rest of a reference, (nx, 1)."""
        x = self.states.flatten({name: est[name] for name in self.states.names})
        e: ca.SX = x - self.x0 - self.X @ (r - self.r0)
        return e

    def input(self, est: wb.Signals, r: ca.SX) -> ca.SX:
        """The input at the rest of a reference, (nu, 1)."""
        u: ca.SX = self.disturbance_free_input(r) + est["d"]
        return u

    def disturbance_free_input(self, r: ca.SX) -> ca.SX:
        """The same without a disturbance."""
        u: ca.SX = self.u0 + self.G @ (r - self.r0)  # type: ignore[assignment]  # numbers are symbols here
        return u

    def limit(self, u: ca.SX) -> ca.SX:
        """The command within its limits."""
        return ca.fmin(ca.fmax(u, self.low), self.high)
