"""Sampled: a continuous equation with a jump at each sampling instant, as of a plant under a digital law."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from importlib import import_module
from typing import Literal

import casadi as ca
import numpy as np

from workbench.core.crossing import Crossing, refuse_strangers, without_crossings
from workbench.core.expressions import refuse_misfit
from workbench.core.fingerprints import fingerprint_of
from workbench.core.layout import Entry, Layout, layouts_to_html
from workbench.core.methods import METHODS, runge_kutta
from workbench.core.numbers import Bounds
from workbench.core.ode import Ode
from workbench.core.sampled_law import SampledLaw
from workbench.core.segments import Segments
from workbench.core.shapes import Drawing
from workbench.core.state_corners import corners_of
from workbench.core.step import StepMap, StepRule, held_at
from workbench.core.switches import Switches
from workbench.core.validation.refusals import MOST, one_of, seconds, whole
from workbench.core.validation.signatures import check_arguments

MOST_SUBSTEPS = 10_000  # each is written out, so that more take minutes to be derived
PERIODS = 100  # over which the substeps of a step without a number are chosen


@dataclass(frozen=True, eq=False)
@check_arguments
class SampledSystem:
    """x+ = g(k, x, p, w) at the instants t_k = k period, k = 0, 1, ..., and x' = f(t, x, p) from each to the next.

    Raises
    ------
    ValueError
        If the period is no positive finite number, or the jump is none of at most all states, or has a symbol that is
        none of k, x, p and w.

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0)
    >>> loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    >>> digital = loop.digital(0.01, delay=True)
    >>> digital.states.names[-3:]
    ('hold.next', 'hold.v', 'hold.omega_hat')
    >>> wb.simulate(digital, until=2.0)["omega"][0, -1].round(2)
    array([1.])
    """

    flow: Ode  # f, over all states, and the outputs; at t_k they are taken after the jump
    period: float  # s
    k: ca.SX  # symbol of the number of the jump, (1, 1)
    w: ca.SX  # of standard normal numbers, (nw, 1), fresh ones at every jump
    jump: ca.SX  # g, (m, 1), for the first m states, in k, `flow.x`, `flow.p` and w; the others do not jump
    methods: tuple[str, ...] = ()  # by which the memory of each block is stepped, in words
    law_of: Callable[[str, tuple[str, ...]], SampledLaw] | None = None  # the computer's part of it, see `law`
    crossings: tuple[Crossing, ...] = ()  # what goes into the computer and out of it: 'y.q', 'r.q'
    crossing_jump: ca.SX | None = None  # g with the symbols of the crossings; `jump`, which has none, unless given
    noise_states: tuple[str, ...] = ()  # the states of coloured noise, which belong to no computer

    def __post_init__(self) -> None:
        seconds("SampledSystem(period=...)", self.period)
        rows, columns = self.jump.shape
        if columns != 1 or rows > self.flow.states.size:
            raise ValueError(
                f"`SampledSystem(jump=...)` must have shape (m, 1), for the first m of {self.flow.states.size} states; "
                f"got {self.jump.shape}."
            )
        refuse_misfit("SampledSystem", "k", self.k, 1, 1, "the number of the jump")
        refuse_misfit("SampledSystem", "w", self.w, self.w.numel(), 1)
        symbols = {"k": self.k, "x": self.flow.x, "p": self.flow.p, "w": self.w}
        refuse_strangers("SampledSystem", symbols, (), jump=self.jump)
        refuse_strangers("SampledSystem", symbols, self.crossings, crossing_jump=self.after)
        refuse_misfit("SampledSystem", "crossing_jump", self.after, rows, 1, "one for each entry of the jump")

    @check_arguments
    def law(self, reference: str = "input", truths: tuple[str, ...] = ()) -> SampledLaw:
        """The part of the computer alone, which another machine can run.

        Parameters
        ----------
        reference
            "input" if what is wanted is handed in at each instant, or "built in" for the reference of the loop.
        truths
            Signals that no instrument gives, which the machine is handed all the same.

        Raises
        ------
        ValueError
            If the law uses a truth that is not named, or this is no loop of blocks, as `ClosedLoop.digital` makes one.
        LookupError
            If a name is none of a truth.
        """
        if self.law_of is None:
            raise ValueError(
                f"`SampledSystem.law()` needs a loop that `ClosedLoop.digital` has made; '{self.name}' was made of "
                "equations alone, in which plant and law are not told apart."
            )
        return self.law_of(reference, truths)

    @property
    def after(self) -> ca.SX:
        """The state after the jump, (m, 1), in k, x, p, w and the symbols of the crossings, as machines compute it."""
        return self.jump if self.crossing_jump is None else self.crossing_jump

    @property
    def computer_inputs(self) -> dict[str, ca.SX]:
        """The symbols of what the computer is handed: readings 'y.q' and references 'r.q'."""
        parts = [part for crossing in self.crossings for part in crossing.parts.items()]
        return {name: part for name, part in parts if name.startswith(("y.", "r."))}

    @cached_property
    def computer_input_values(self) -> Mapping[str, ca.SX]:
        """The same in k, x, p and w."""
        return {name: without_crossings(self.crossings, part) for name, part in self.computer_inputs.items()}

    @property
    def name(self) -> str:
        """The name of the flow."""
        return self.flow.name

    @property
    def notes(self) -> tuple[str, ...]:
        """The notes of the flow."""
        return self.flow.notes

    @property
    def switches(self) -> Switches:
        """The switches of the flow."""
        return self.flow.switches

    @property
    def states(self) -> Layout:
        """The states of the flow."""
        return self.flow.states

    @property
    def parameters(self) -> Layout:
        """The parameters of the flow."""
        return self.flow.parameters

    @property
    def outputs(self) -> Layout:
        """The outputs of the flow."""
        return self.flow.outputs

    @property
    def drawing(self) -> Drawing | None:
        """The drawing of the flow."""
        return self.flow.drawing

    def substeps(self, h: float) -> int:
        """The number of steps of h [s] in the period; refused if they do not fill it."""
        count = self.period / seconds("substeps(h=...)", h)
        if not round(min(count, MOST)) >= 1 or abs(count - round(min(count, MOST))) > 1e-6:
            raise ValueError(
                f"`substeps(h=...)` must divide the sampling period {self.period:g} s, which belongs to the "
                f"controller; got {h:g} s."
            )
        return round(count)

    def step(self, substeps: int | Literal["chosen"] = "chosen", method: str = "rk4") -> StepMap:
        """One period as a `StepMap`: the jump at t_k, then `substeps` Runge-Kutta steps of the flow.

        Without a number it is the step that `simulate` chooses for a hundred periods from the initial state. The
        method of the substeps goes by its name, as in `runge_kutta_step`.
        """
        if isinstance(substeps, str) and substeps == "chosen":
            periods = max(1, int(min(PERIODS, self.flow.horizon / self.period)))
            chosen: StepMap = import_module("workbench").simulate(self, until=periods * self.period).step
            return chosen
        substeps = whole("SampledSystem.step(substeps=...)", substeps, most=MOST_SUBSTEPS)
        by = METHODS[one_of("SampledSystem.step(method=...)", method, METHODS)]
        flow, h = self.flow, self.period / substeps
        t, p, switches = self.k * self.period, flow.p, flow.switches
        after = x = ca.vertcat(self.after, flow.x[self.jump.numel() :, 0])
        for i in range(substeps):
            f = held_at(t + i * h + h / 2, switches.m, flow.t, flow.x, p, switches.rate)
            x = runge_kutta(f, t + i * h, x, p, h, by)
        output = ca.substitute(flow.output, ca.vertcat(flow.t, flow.x), ca.vertcat(t, after))
        rule = StepRule(
            *(ca.SX.sym("h"), self.k, flow.t, flow.x, p, self.w),
            *(ca.SX(0, 1), x, output, self.crossings),
            method=by,
        )
        corners = corners_of(flow) if by.corners else None
        if switches.has_instants or corners is not None:
            segments = Segments.of(switches, t, ca.SX(self.period), flow.x, after, substeps, corners)
            rule = replace(rule, m=switches.m, segments=segments)
        layouts = (flow.states, flow.parameters, flow.outputs)
        finer = partial(self.step, 2 * substeps, method) if 2 * substeps <= MOST_SUBSTEPS else None
        return StepMap(self.period, *layouts, rule, flow, by.amplification, substeps, finer)

    @check_arguments
    def with_timing_faults(self) -> SampledSystem:
        """The same loop with a computer that is late, and that misses periods, by two more parameters.

        The instant k comes d_k late, at k period + d_k, with d_k uniform in [0, `computer.jitter`], at most half of the
        period, and d_0 = 0; law and reference still count on k period. With the probability `computer.missed` nothing
        is done in a period: the commands that act stay, and so does all that the computer keeps. Both are 0 unless set,
        and the loop then has the bits of the one without in the portable arithmetic.

        Times, integrals and samples of a run are nominal: its row k is the state at k period + d_k, and an integral and
        a coloured noise count each period as one period long. Disturbance and reference of the outputs are those of the
        true time.

        Raises
        ------
        ValueError
            If this is no loop of blocks, as `ClosedLoop.digital` makes one, or its plant moves in discrete time.
        """
        self._refuse_one_clock()
        flow, T, t = self.flow, self.period, self.flow.t
        kinds = (("jitter", "s", T / 2), ("missed", "1", 1.0))
        settings = Layout(tuple(Entry(f"computer.{n}", np.zeros(()), unit, Bounds(0.0, b)) for n, unit, b in kinds))
        clock = Layout(tuple(Entry(f"computer.{name}", np.zeros(()), "s") for name in ("late", "later", "instant")))
        p, z, w = settings.symbols(), clock.symbols(), ca.SX.sym("w", 4)
        jitter, missed = ca.vertsplit(p)
        late, later, instant = ca.vertsplit(z)
        # of two normal numbers the sum of squares is exponential with mean 2, so that this is uniform in (0, 1]
        lateness, luck = (ca.exp(-(w[i] * w[i] + w[i + 1] * w[i + 1]) / 2) for i in (0, 2))
        # nominal time runs through each period as if it were `period` long: x' = pace f(true time, x, p)
        pace = 1 + (later - late) / T
        true = t + late + (later - late) / T * (t - instant)
        rate, output = ca.substitute([flow.rate, flow.output], [t], [true])
        kept = [name for name in self.states.names if not name.startswith("plant.") and name not in self.noise_states]
        own = [i for name in kept for i in self.states.indices(name)]
        clocks = ca.vertcat(later, jitter * lateness, self.k * T)
        jump, crossed = (ca.vertcat(_unless(luck < missed, flow.x, g, own), clocks) for g in (self.jump, self.after))
        return replace(
            self,
            flow=replace(
                flow,
                states=flow.states + clock,
                parameters=flow.parameters + settings,
                x=ca.vertcat(flow.x, z),
                p=ca.vertcat(flow.p, p),
                rate=ca.vertcat(pace * rate, ca.SX.zeros(clock.size, 1)),
                output=output,
            ),
            w=ca.vertcat(self.w, w),
            jump=jump,
            crossing_jump=crossed,
        )

    def _refuse_one_clock(self) -> None:
        """Refuse a loop whose computer is not told apart, or whose plant moves by the clock of the computer."""
        if self.law_of is None:
            raise ValueError(
                f"`SampledSystem.with_timing_faults()` needs a loop that `ClosedLoop.digital` has made; '{self.name}' "
                "was made of equations alone, in which plant and computer are not told apart."
            )
        for name in self.states.names:
            rows = self.states.slice(name)
            moves = name.startswith("plant.") and name not in self.noise_states
            if moves and not ca.is_equal(self.jump[rows], self.flow.x[rows]):
                raise ValueError(
                    f"`SampledSystem.with_timing_faults()` needs a plant in continuous time; '{name}' of "
                    f"'{self.name}' moves at the instants themselves, which cannot come late for it."
                )

    @cached_property
    def fingerprint(self) -> str:
        """A name of flow, jump and period (64 hexadecimal digits), the same in every process; see `Ode`."""
        handed = [crossing.symbols for crossing in self.crossings]
        values = [*(crossing.values for crossing in self.crossings), self.after]
        jump = ca.Function("g", [self.k, self.flow.x, self.flow.p, self.w, *handed], values)
        return fingerprint_of(f"{self.flow.fingerprint} {self.period.hex()}".encode(), jump)

    def __repr__(self) -> str:
        return f"<Sampled '{self.name}': every {self.period:g} s, {self.flow.sizes}>"

    def _repr_html_(self) -> str:
        name = f"{self.name}, sampled every {self.period:g} s"
        return layouts_to_html(name, {"state": self.states, "parameter": self.parameters})


def _unless(is_missed: ca.SX, x: ca.SX, jump: ca.SX, own: list[int]) -> ca.SX:
    """The state after the jump, where the entries `own` stay as they are in a period that is missed."""
    after = ca.vertcat(jump, x[jump.numel() :, 0])
    for i in own:
        after[i] = ca.if_else(is_missed, x[i], after[i])
    return after
