"""Ode: x' = f(t, x, p), y = h(t, x, p), with exact Jacobians and a fingerprint."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar

import casadi as ca
import numpy as np

from workbench.core.expressions import refuse_misfit, refuse_unknown
from workbench.core.fingerprints import fingerprint_of
from workbench.core.layout import Entry, Layout, layouts_to_html
from workbench.core.publications import Origin
from workbench.core.shapes import Drawing
from workbench.core.switches import Switches, find_switches
from workbench.core.validation.refusals import Array, finite, vector
from workbench.core.validation.signatures import check_arguments


@dataclass(frozen=True, eq=False)
@check_arguments
class Ode:
    """An ordinary differential equation x' = f(t, x, p), y = h(t, x, p) with named states, parameters and outputs.

    `wb.open_loop(plant)`, `ClosedLoop.ode()` and `Ode.of` make one. The fields from `follows` on are set for loops.

    Parameters
    ----------
    name
        The name of the equations.
    states, parameters, outputs
        Layouts of x, p and y, with units and default values. The defaults of the states are the initial state.
    t, x, p
        The symbols of time in s, (1, 1), of the state, (nx, 1), and of the parameters, (np, 1).
    rate
        The expression of f, (nx, 1).
    output
        The expression of h, (ny, 1).
    inputs
        Names of the parameters that are declared as inputs u, such as the voltage of a motor.
    notes
        Warnings for a reader of reports, for example that an estimate uses the truth.
    follows
        Names of the outputs that follow a reference. The reference of x is the output `x_ref`.
    drives
        Names of the commands.
    measures
        Names of the outputs of the plant.
    differences
        For each output that is an error, the two outputs of which it is the difference.
    power
        Names of two outputs whose product is the power that enters through the inputs, or ().
    horizon
        The last time in s for which the equations hold, such as that of the last row of a table.
    counts
        The thing to which each entry of a vector belongs, as "tank".
    drawing
        The picture of the plant, in the symbols t, x and p.
    origins
        The blocks from which the equations were made, with their references.

    Raises
    ------
    ValueError
        If a symbol, the rate or the output does not have the size of its layout; if rate or output has a symbol other
        than t, x and p; or if a state and a parameter have the same name.
    LookupError
        If an input is not a parameter.

    Examples
    --------
    >>> ode = wb.open_loop(wb.DCMotor())
    >>> ode.states.names, ode.inputs, ode.parameters.names
    (('omega', 'i'), ('v',), ('J', 'b', 'K', 'R', 'L', 'v'))
    >>> ode.rate_at(0.0, [0.2, 1.0]).round(3)
    array([-1.   , -2.004])
    """

    name: str
    states: Layout
    parameters: Layout
    outputs: Layout
    t: ca.SX
    x: ca.SX
    p: ca.SX
    rate: ca.SX
    output: ca.SX
    inputs: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    follows: tuple[str, ...] = ()
    drives: tuple[str, ...] = ()
    measures: tuple[str, ...] = ()
    differences: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    power: tuple[str, ...] = ()
    horizon: float = math.inf
    counts: str = ""
    drawing: Drawing | None = None
    origins: tuple[Origin, ...] = ()

    WAYS: ClassVar = {
        "ClosedLoop": "a loop becomes one by its method `ode()`",
        "SampledSystem": "a loop that a computer closes jumps at its instants: `measure(...)`, a `Run` and "
        "`simulate(sampled, until=...)` take it as it stands",
    }

    def __post_init__(self) -> None:
        of = {"x": "states", "p": "parameters", "rate": "states", "output": "outputs"}
        refuse_misfit("Ode", "t", self.t, 1, 1, "the time")
        for part, layout in of.items():
            size = getattr(self, layout).size
            refuse_misfit("Ode", part, getattr(self, part), size, 1, f"one number for each of its {layout}")
        symbols = {"t": self.t, "x": self.x, "p": self.p}
        refuse_unknown("Ode", symbols, rate=self.rate, output=self.output)
        if self.drawing is not None:
            refuse_unknown("Ode", symbols, drawing=self.drawing.coordinates)
        for name in self.inputs:
            self.parameters.slice(name)
        if twice := sorted(set(self.states.labels) & set(self.parameters.labels)):
            kind = "an input" if twice[0] in self.inputs else "a parameter"
            raise ValueError(
                "`Ode(states=..., parameters=...)` must have different names, by which symbols are told apart; "
                f"'{twice[0]}' of '{self.name}' is a state and {kind}: rename one of them."
            )

    @staticmethod
    @check_arguments
    def of(
        name: str,
        states: Layout,
        parameters: Layout,
        symbols: tuple[ca.SX, ca.SX, ca.SX],
        rates: Mapping[str, ca.SX],
        outputs: Mapping[str, ca.SX],
        units: Mapping[str, str] | None = None,
    ) -> Ode:
        """An `Ode` from rates and outputs by name.

        Parameters
        ----------
        name
            The name of the equations.
        states, parameters
            Layouts of the state x and of the parameters p.
        symbols
            The symbols (t, x, p) in which rates and outputs are written.
        rates
            The time derivative of each state.
        outputs
            The expression of each output.
        units
            Units of outputs, by name. An output without one is dimensionless.
        """
        columns = {key: ca.vec(ca.SX(value)) for key, value in outputs.items()}
        entries = tuple(Entry(key, np.zeros(y.numel()), (units or {}).get(key, "")) for key, y in columns.items())
        output = ca.vertcat(*columns.values()) if columns else ca.SX(0, 1)
        return Ode(name, states, parameters, Layout(entries), *symbols, states.flatten(rates), output)

    @cached_property
    def switches(self) -> Switches:
        """The instants, known before a run, at which the rate jumps or bends: ends of pulses, rows of tables."""
        return find_switches(self.rate, self.t, self.x, self.p)

    @cached_property
    def f(self) -> ca.Function:
        """The rate as a CasADi function (t, x, p) -> (nx, 1)."""
        return self._function("f", self.rate)

    @cached_property
    def h(self) -> ca.Function:
        """The outputs as a CasADi function (t, x, p) -> (ny, 1)."""
        return self._function("h", self.output)

    @cached_property
    def A(self) -> ca.Function:
        """The exact Jacobian df/dx as a function (t, x, p) -> (nx, nx)."""
        # a search for shared operations takes as long as five thousand values, and saves a fifth of them
        return self._function("A", ca.densify(ca.jacobian(self.rate, self.x)), cse=False)

    @cached_property
    def B(self) -> ca.Function:
        """The exact Jacobian df/du for the declared inputs u as a function (t, x, p) -> (nx, nu)."""
        return self._function("B", ca.densify(ca.jacobian(self.rate, self.input_symbols)))

    @cached_property
    def Cy(self) -> ca.Function:
        """The exact Jacobian dh/dx as a function (t, x, p) -> (ny, nx)."""
        return self._function("Cy", ca.densify(ca.jacobian(self.output, self.x)))

    @cached_property
    def D(self) -> ca.Function:
        """The exact Jacobian dh/du for the declared inputs u as a function (t, x, p) -> (ny, nu)."""
        return self._function("D", ca.densify(ca.jacobian(self.output, self.input_symbols)))

    def _function(self, name: str, value: ca.SX, cse: bool = True) -> ca.Function:
        return ca.Function(f"workbench_{name}", [self.t, self.x, self.p], [value], {"cse": cse})

    @property
    def input_symbols(self) -> ca.SX:
        """The symbols of the declared inputs, (nu, 1)."""
        return ca.vertcat(*[self.p[self.parameters.slice(name)] for name in self.inputs])

    def rate_at(self, t: float, x: Array, p: Array | None = None) -> Array:
        """The rate f(t, x, p) as numbers (nx,), for a state x (nx,) and parameters p (np,), else their defaults."""
        return np.array(self.f(*self._point("rate_at", t, x, p))).ravel()

    def outputs_at(self, t: float, x: Array, p: Array | None = None) -> dict[str, Array]:
        """The outputs by name as numbers, for a state x (nx,) and parameters p (np,), else their defaults."""
        return self.outputs.unpack(np.array(self.h(*self._point("outputs_at", t, x, p))).ravel())

    def _point(self, call: str, t: float, x: Array, p: Array | None) -> tuple[float, Array, Array]:
        """The arguments as vectors of the right length, which CasADi would fill by repetition."""
        return (
            finite(f"{call}(t=...)", t, " of seconds"),
            vector(f"{call}(x=...)", x, self.states.size, "states"),
            self.parameters.default if p is None else vector(f"{call}(p=...)", p, self.parameters.size, "parameters"),
        )

    @property
    def default_signals(self) -> tuple[str, ...]:
        """The signals of a picture if none are named: for a loop, the outputs that follow a reference and the commands.

        A loop without a reference shows all outputs of its plant instead. Other equations show all outputs, or all
        states if there are no outputs.
        """
        applied = (f"{name}_applied" for name in self.drives)
        commands = tuple(name for name in applied if name in self.outputs) or self.drives
        about = tuple(name for name in (*(self.follows or self.measures), *commands) if name in self.outputs)
        return about or self.outputs.names or self.states.names

    @cached_property
    def fingerprint(self) -> str:
        """The digest of the equations (64 hexadecimal digits), the same in every process and for all default values.

        It includes every function that the equations call, such as a table. A function whose content cannot be read is
        refused by a `ValueError`.
        """
        layouts = (self.states, self.parameters, self.outputs)
        entries = (repr((entry.name, entry.shape, entry.unit)) for layout in layouts for entry in layout.entries)
        function = ca.Function("f", [self.t, self.x, self.p], [self.rate, self.output])
        return fingerprint_of("".join(entries).encode(), function)

    @check_arguments
    def refuse_beyond(self, call: str, until: float) -> None:
        """Raise a ValueError, which names `call`, if the time `until` [s] is beyond the horizon."""
        # 1e-9: what the rounding of a count of steps may add to a time
        if until > self.horizon + 1e-9 * abs(self.horizon):
            raise ValueError(
                f"`{call}` must be at most {self.horizon:g} s, the time at which a table of '{self.name}' ends; got "
                f"{until:g} s: run it for less, or add rows."
            )

    def __repr__(self) -> str:
        return f"<Ode '{self.name}': {self.sizes}>"

    @property
    def sizes(self) -> str:
        """The numbers of states, parameters and outputs, as text."""
        counts = {"state": self.states, "parameter": self.parameters, "output": self.outputs}
        return ", ".join(f"{port.size} {word}{'' if port.size == 1 else 's'}" for word, port in counts.items())

    def _repr_html_(self) -> str:
        return layouts_to_html(self.name, {"state": self.states, "parameter": self.parameters})


def time_beside(*layouts: Layout) -> ca.SX:
    """A symbol of time that no label of the layouts has as its name: t, else t with underscores behind it."""
    name, taken = "t", {label for layout in layouts for label in layout.labels}
    while name in taken:
        name += "_"
    return ca.SX.sym(name)
