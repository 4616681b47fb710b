"""Sampled: a continuous equation with a jump at each sampling instant, as of a plant under a digital law."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from importlib import import_module
from typing import Literal

import casadi as ca

from workbench.core.crossing import Crossing, refuse_strangers, without_crossings
from workbench.core.expressions import refuse_misfit
from workbench.core.fingerprints import fingerprint_of
from workbench.core.layout import Layout, layouts_to_html
from workbench.core.methods import METHODS, runge_kutta
from workbench.core.ode import Ode
from workbench.core.sampled_law import SampledLaw
from workbench.core.segments import Segments
from workbench.core.shapes import Drawing
from workbench.core.state_corners import corners_of
from workbench.core.step import StepMap, StepRule, held_at
from workbench.core.switches import Switches
from workbench.core.timing_faults import add_timing_faults
from workbench.core.validation.refusals import MOST, one_of, seconds, whole
from workbench.core.validation.signatures import check_arguments

MOST_SUBSTEPS = 10_000  # each is written out, so that more take minutes to be derived
PERIODS = 100  # over which the substeps of a step without a number are chosen


@dataclass(frozen=True, eq=False)
@check_arguments
class SampledSystem:
    """A system that jumps at sampling instants, such as a plant with the computer of its law:

        x+ = g(k, x, p, w) at t_k = k period, k = 0, 1, ...,     x' = f(t, x, p) between two instants.

    `ClosedLoop.digital` makes one. w are standard normal random numbers, new ones at every instant.

    Parameters
    ----------
    flow
        The `Ode` of f, over all states, with the outputs. The outputs at t_k are taken after the jump.
    period
        The sampling period in s.
    k
        The symbol of the number of the instant, (1, 1).
    w
        The symbols of the random numbers, (nw, 1).
    jump
        The expression of g for the first m states, (m, 1), in k, `flow.x`, `flow.p` and w. Other states do not jump.
    methods
        The integration method of the states of each block in the computer, as text.
    law_of
        The function that `law()` calls to build its result, or None.
    crossings
        The readings and references of the computer, such as 'y.q' and 'r.q', as symbols with their values.
    crossing_jump
        The expression of g in the symbols of the crossings. The default is `jump`.
    noise_states
        Names of the states of coloured noise, which are not in the computer.

    Raises
    ------
    ValueError
        If the period is not a positive finite number; or if the jump has more entries than there are states, or a
        symbol other than k, x, p and w.

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

    flow: Ode
    period: float
    k: ca.SX
    w: ca.SX
    jump: ca.SX
    methods: tuple[str, ...] = ()
    law_of: Callable[[str, tuple[str, ...]], SampledLaw] | None = None
    crossings: tuple[Crossing, ...] = ()
    crossing_jump: ca.SX | None = None
    noise_states: tuple[str, ...] = ()

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
        """The part of the computer alone (observer and controller), which another machine can run.

        Parameters
        ----------
        reference
            "input" if the references are inputs of the law, or "built in" for the reference of the loop.
        truths
            Names of signals that no instrument measures and that are inputs of the law nevertheless.

        Raises
        ------
        ValueError
            If the law uses a truth that is not named, or the system was not made by `ClosedLoop.digital`.
        LookupError
            If a name is not that of a truth.
        """
        if self.law_of is None:
            raise ValueError(
                f"`SampledSystem.law()` needs a loop that `ClosedLoop.digital` has made; '{self.name}' was made of "
                "equations alone, in which plant and law are not told apart."
            )
        return self.law_of(reference, truths)

    @property
    def after(self) -> ca.SX:
        """The first m states after the jump, (m, 1), in k, x, p, w and the symbols of the crossings."""
        return self.jump if self.crossing_jump is None else self.crossing_jump

    @property
    def computer_inputs(self) -> dict[str, ca.SX]:
        """The symbols of the inputs of the computer by name: readings as 'y.q', references as 'r.q'."""
        parts = [part for crossing in self.crossings for part in crossing.parts.items()]
        return {name: part for name, part in parts if name.startswith(("y.", "r."))}

    @cached_property
    def computer_input_values(self) -> Mapping[str, ca.SX]:
        """The expressions of the inputs of the computer, by name, in k, x, p and w."""
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
        """The number of steps of h [s] in one period; a ValueError if h does not divide the period."""
        count = self.period / seconds("substeps(h=...)", h)
        if not round(min(count, MOST)) >= 1 or abs(count - round(min(count, MOST))) > 1e-6:
            raise ValueError(
                f"`substeps(h=...)` must divide the sampling period {self.period:g} s, which belongs to the "
                f"controller; got {h:g} s."
            )
        return round(count)

    def step(self, substeps: int | Literal["chosen"] = "chosen", method: str = "rk4") -> StepMap:
        """One period as a `StepMap`: the jump at t_k, and then Runge-Kutta steps of the flow.

        Parameters
        ----------
        substeps
            The number of Runge-Kutta steps, or "chosen" for the number that `simulate` chooses for 100 periods from the
            initial state.
        method
            The method of these steps, as of `runge_kutta_step`.
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
        """The same loop with a computer that may start a period late, and may miss a period.

        The loop has two more parameters, both 0 by default. With `computer.jitter` in s, at most half of the period,
        the instant k is at k * period + d_k with d_k uniform in [0, `computer.jitter`] and d_0 = 0; law and reference
        still use the time k * period. With `computer.missed`, the probability that a period is missed, the commands and
        the memory of the computer stay unchanged in a missed period. If both are 0, the results are bit for bit those
        of the loop without faults, in the portable arithmetic.

        A row of a run has the nominal time k * period, and the state at k * period + d_k. Integrals and coloured noise
        take each period as one period long. Disturbances and references among the outputs, as `q_ref`, are those of the
        true time.

        Raises
        ------
        ValueError
            If the system was not made by `ClosedLoop.digital`, or its plant is in discrete time.
        """
        self._refuse_one_clock()
        jumps = {"w": self.w, "jump": self.jump, "crossing_jump": self.after}
        flow, faulty = add_timing_faults(self.flow, self.period, self.k, jumps, self.noise_states)
        return replace(self, flow=flow, w=faulty["w"], jump=faulty["jump"], crossing_jump=faulty["crossing_jump"])

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
        """The digest of flow, jump and period (64 hexadecimal digits), the same in every process; see `Ode`."""
        handed = [crossing.symbols for crossing in self.crossings]
        values = [*(crossing.values for crossing in self.crossings), self.after]
        jump = ca.Function("g", [self.k, self.flow.x, self.flow.p, self.w, *handed], values)
        return fingerprint_of(f"{self.flow.fingerprint} {self.period.hex()}".encode(), jump)

    def __repr__(self) -> str:
        return f"<Sampled '{self.name}': every {self.period:g} s, {self.flow.sizes}>"

    def _repr_html_(self) -> str:
        name = f"{self.name}, sampled every {self.period:g} s"
        return layouts_to_html(name, {"state": self.states, "parameter": self.parameters})
