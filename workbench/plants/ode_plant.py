"""A plant whose equations are there already: an open `Ode`, CasADi functions, or plain Python functions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import casadi as ca

from workbench.core import Layout, Ode, Signals, block
from workbench.core.block import Number, States, parameters
from workbench.loop.contracts import AbstractPlant, Inputs, Parts
from workbench.plants.functions import Arguments, port, read, with_defaults
from workbench.validation.refusals import Array, text

Port = Layout | tuple[str, ...]


def _read_outputs(h: Callable[..., Any] | None, outputs: Port | None, given: Arguments) -> tuple[Layout, ca.SX]:
    """What is read, and its expression (ny, 1): what h gives or, without it, states."""
    if h is None:
        known = given.states
        names = known.names if outputs is None else port("outputs", outputs).names
        return Layout(tuple(known[n] for n in names)), ca.vertcat(*(given.x[known.slice(n)] for n in names))
    if outputs is None:
        raise ValueError("`OdePlant.of(outputs=...)` must name what h gives, as in ('y:V',); got None.")
    watched = port("outputs", outputs)
    return watched, read("h", h, given.of_output(), watched)


@block
class OdePlant(AbstractPlant):
    """An open `Ode` as a plant: its declared inputs drive it, its outputs are read, its other parameters are its own.

    A parameter 'R' of the equation is `plant.R` of the loop, to be varied as any other number.

    Raises
    ------
    ValueError
        If the equation declares no inputs, or one of its outputs depends on an input: a law that reads it would meet
        its own command of the same instant, an algebraic loop.

    Examples
    --------
    >>> tank = wb.OdePlant.of(lambda t, x, u, m: [u[0] - m.sqrt(x[0])], states=("h:m",), inputs=("w:m/s",), x0=[1.0])
    >>> tank.inputs.names, tank.outputs.names
    (('w',), ('h',))
    """

    ode: Ode
    own: Layout = parameters()

    def __post_init__(self) -> None:
        ode = self.ode
        if not ode.inputs:
            raise ValueError(
                f"`OdePlant(ode=...)` must declare in `inputs` which of its parameters drive it; '{ode.name}' declares "
                "none."
            )
        for entry in ode.outputs.entries:
            if ca.depends_on(ode.output[ode.outputs.slice(entry.name)], ode.input_symbols):
                raise ValueError(
                    f"`OdePlant(ode=...)` must have outputs that depend on no input, as a law that reads one would "
                    f"meet its own command of the same instant, an algebraic loop; '{entry.name}' of '{ode.name}' "
                    "does: leave it out, or put the lag between the two into the states."
                )
        own = tuple(entry for entry in ode.parameters.entries if entry.name not in ode.inputs)
        object.__setattr__(self, "own", Layout(own))

    def __repr__(self) -> str:
        """One line: a notebook should not print the equations by accident."""
        return f"<OdePlant '{self.ode.name}': {', '.join(self.inputs.names)} to {', '.join(self.outputs.names)}>"

    @staticmethod
    def of(
        f: Callable[..., Any],
        states: Port,
        inputs: Port,
        outputs: Port | None = None,
        h: Callable[..., Any] | None = None,
        *,
        p: Layout | None = None,
        x0: Array | None = None,
        u0: Array | None = None,
        name: str = "plant",
    ) -> OdePlant:
        """x' = f(t, x, u, p), y = h(t, x, p), from functions as they stand.

        Parameters
        ----------
        f, h
            Each a `casadi.Function` of columns, made of SX or MX, without the argument p where there are no parameters;
            or a Python function that returns a number for each state or output. That one is called with t, with x and u
            as vectors of symbols, with `p.R` for the parameter R, if there are parameters, and, if it takes one more
            argument, with a namespace m of functions: `m.sin`, `m.sqrt`, `m.where(c, a, b)`. It is read once.
        states, inputs, outputs
            Layouts, or a "name:unit" for each number; a name alone has an unknown unit, which fits any. Without h the
            outputs are states, all of them unless they are named.
        p
            The parameters, each with its number: `layout(R=("ohm", 1.0))`.
        x0, u0
            The start (nx,) and the inputs (nu,) of an open loop; zero, or those of the layouts, if not given.

        Raises
        ------
        ValueError
            If a function takes other arguments or sizes, gives another number of values, or cannot be computed with
            symbols in place of numbers.
        LookupError
            If an output without h is no state.
        """
        known = with_defaults("x0", port("states", states), x0)
        driven = with_defaults("u0", port("inputs", inputs), u0)
        given = Arguments(ca.SX.sym("t"), known, driven, p or Layout())
        rate = read("f", f, given.of_rate(), known)
        watched, output = _read_outputs(h, outputs, given)
        own, symbols = given.parameters + driven, (given.t, given.x, ca.vertcat(given.p, given.u))
        called = text("OdePlant.of(name=...)", name)
        return OdePlant(Ode(called, known, own, watched, *symbols, rate, output, inputs=driven.names))

    @property
    def ends(self) -> float:
        """The horizon of the equation, in s."""
        return self.ode.horizon

    @property
    def states(self) -> Layout:
        """Those of the equation, each with its start."""
        return self.ode.states

    @property
    def inputs(self) -> Layout:
        """The declared inputs of the equation."""
        return Layout(tuple(self.ode.parameters[name] for name in self.ode.inputs))

    @property
    def outputs(self) -> Layout:
        """Those of the equation."""
        return self.ode.outputs

    def measure(self, t: Number, x: States) -> Signals:
        """y = h(t, x, p)."""
        ode = self.ode
        unused = {e.name: ca.SX.zeros(*e.shape) for e in self.inputs.entries}
        return Signals(ode.outputs.view(ode.h(t, ode.states.flatten(x), self._p(unused))))

    def rate(self, t: Number, x: States, u: Inputs) -> Parts:
        """x' = f(t, x, p) with u in its places."""
        ode = self.ode
        return ode.states.view(ode.f(t, ode.states.flatten(x), self._p(u)))

    def _p(self, u: Parts) -> ca.SX:
        """All parameters of the equation as one column."""
        own: Any = self.own  # of the lifted twin the symbols
        held = {e.name: ca.SX(e.default) for e in own.entries} if isinstance(own, Layout) else own
        return self.ode.parameters.flatten({**held, **u})
