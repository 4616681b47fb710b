"""Ode: x' = f(t, x, p), y = h(t, x, p), with exact Jacobians, a fingerprint, quadratures and sensitivities."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
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

    Raises
    ------
    ValueError
        If symbols, rate or output do not have the sizes of their layouts, if rate or output has a symbol that is none
        of t, x and p, or if a state and a parameter have one name.
    LookupError
        If an input is no parameter.

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
    t: ca.SX  # symbol of time in s, (1, 1)
    x: ca.SX  # of the state, (nx, 1)
    p: ca.SX  # of the parameters, (np, 1)
    rate: ca.SX  # f, (nx, 1)
    output: ca.SX  # h, (ny, 1)
    inputs: tuple[str, ...] = ()  # the parameters that an outside signal may drive (the torque of an open loop, say)
    notes: tuple[str, ...] = ()  # warnings for a reader of reports: an estimate that uses the truth, say
    follows: tuple[str, ...] = ()  # of a loop, the outputs that follow a reference, each beside it (`x_ref`)
    drives: tuple[str, ...] = ()  # of a loop, the commands
    measures: tuple[str, ...] = ()  # of a loop, the outputs of its plant
    differences: Mapping[str, tuple[str, str]] = field(default_factory=dict)  # of a loop, `e_x` by its x and `x_ref`
    power: tuple[str, ...] = ()  # of a loop, the two outputs whose product is the power that its inputs bring
    horizon: float = math.inf  # s, the last time at which the equations hold: that of the last row of a table, say
    counts: str = ""  # the thing that each number of a vector belongs to, as 'tank'; empty where indices do
    drawing: Drawing | None = None  # of the plant, in t, x and p
    origins: tuple[Origin, ...] = ()  # of a loop, the blocks whose equations these are, with their references

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
        """An `Ode` from named rates and outputs over symbols (t, x, p)."""
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
        """f(t, x, p) as numbers (nx,), at default parameters unless p is given."""
        return np.array(self.f(*self._point("rate_at", t, x, p))).ravel()

    def outputs_at(self, t: float, x: Array, p: Array | None = None) -> dict[str, Array]:
        """The outputs by name at one state, at default parameters unless p is given."""
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
        """The signals of a picture for which none are named: what a loop is about, or all outputs, or all states.

        A loop is about what follows a reference, or, where nothing does, the outputs of its plant; and its commands.
        """
        applied = (f"{name}_applied" for name in self.drives)
        commands = tuple(name for name in applied if name in self.outputs) or self.drives
        about = tuple(name for name in (*(self.follows or self.measures), *commands) if name in self.outputs)
        return about or self.outputs.names or self.states.names

    @cached_property
    def fingerprint(self) -> str:
        """The digest of the equations (64 hexadecimal digits), the same in every process and for all default values.

        It holds all that the equations call, such as the values of a table; a `ValueError` names what it cannot see.
        """
        layouts = (self.states, self.parameters, self.outputs)
        entries = (repr((entry.name, entry.shape, entry.unit)) for layout in layouts for entry in layout.entries)
        function = ca.Function("f", [self.t, self.x, self.p], [self.rate, self.output])
        return fingerprint_of("".join(entries).encode(), function)

    @check_arguments
    def refuse_beyond(self, call: str, until: float) -> None:
        """Refuse a time in s beyond the horizon."""
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
        """The numbers of its states, parameters and outputs, in words."""
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


@check_arguments
def with_quadrature(ode: Ode, integrands: Mapping[str, ca.SX], units: Mapping[str, str] | None = None) -> Ode:
    """The same equation with a state z for each integrand g(t, x, p), (k, 1), by its name: z' = g, z(0) = 0."""
    entries = tuple(Entry(name, np.zeros(g.numel()), (units or {}).get(name, "")) for name, g in integrands.items())
    extra = Layout(entries)
    z = extra.symbols()
    return replace(
        ode,
        states=ode.states + extra,
        x=ca.vertcat(ode.x, z),
        rate=ca.vertcat(ode.rate, *[ca.vec(g) for g in integrands.values()]),
    )


@check_arguments
def with_sensitivity(ode: Ode, names: Sequence[str]) -> Ode:
    """The same equation with S = dx/dtheta carried along: S' = (df/dx) S + df/dtheta.

    Each name is a parameter, a state (its initial value) or one number of either (`plant.q[0]`). S is a state 'S' of
    shape (nx, k), the columns in the order of the names; where f has a corner (saturation, |s|), it is that of the
    smooth pieces.

    Raises
    ------
    ValueError
        If no name is given.
    LookupError
        If a name is neither a parameter's nor a state's; the message names the nearest.

    Examples
    --------
    >>> from workbench.core import with_sensitivity
    >>> with_sensitivity(wb.open_loop(wb.DCMotor()), ["J"]).states.labels
    ('omega', 'i', 'S[0,0]', 'S[1,0]')
    """
    if not names:
        raise ValueError("`with_sensitivity(names=...)` needs at least one parameter or state; got none.")
    nx, columns, starts = ode.states.size, [], []
    known = {entry.name: entry for entry in ode.parameters.entries + ode.states.entries}
    for name in names:
        Layout(tuple(known.values())).indices(name)  # refuses a name of neither
        of_parameter = name in ode.parameters or name in ode.parameters.labels
        for i in (ode.parameters if of_parameter else ode.states).indices(name):
            columns.append(ca.jacobian(ode.rate, ode.p[i]) if of_parameter else ca.SX(nx, 1))
            starts.append(np.zeros(nx) if of_parameter else np.eye(nx)[i])
    extra = Layout((Entry("S", np.stack(starts, axis=1)),))
    s = extra.symbols()
    S = ca.reshape(s, nx, len(columns))
    rate = ca.jacobian(ode.rate, ode.x) @ S + ca.horzcat(*columns)
    return replace(
        ode,
        states=ode.states + extra,
        x=ca.vertcat(ode.x, s),
        rate=ca.vertcat(ode.rate, ca.vec(ca.densify(rate))),
    )
