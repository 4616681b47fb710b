from collections.abc import Mapping
from dataclasses import replace

import casadi as ca
import numpy as np

from workbench.blocks.loop.contracts import AbstractController, Follows, Parts, Reads
from workbench.core import Entry, Layout, Signals, block, option, parameter
from workbench.core.block import Number, Scalar, Vector
from workbench.core.port import one_entry
from workbench.core.units import gain
from workbench.core.validation.refusals import refusal


@block
class PID(AbstractController):
    """A PID law with two degrees of freedom, from outputs y and their references r to inputs u of the plant:

        v  = u0 + Kp (b r - y) + I + Kd N (w - f),      u = min(max(v, low), high)
        w  = c (r - y0) - (y - y0)
        I' = Ki (r - y) + anti-windup,             I(0) = 0
        f' = N (w - f),                            f(0) = 0

    Without limits it is u = u0 + Kp (b r - y) + Ki / s (r - y) + Kd s / (1 + s / N) (c r - y), as of MATLAB's `pid2`.

    The law works component by component: the first component of y drives the first component of u, and so on. With
    several components it is a decentralised law. A single number as a gain holds for all components.

    In a computer with the period h, the derivative is a backward difference and the integral a forward difference:

        f_k = (f_(k-1) + N h w_k) / (1 + N h),     I_(k+1) = I_k + h (Ki (r_k - y_k) + anti-windup)

    With `Kd=None` it is a PI law: it has no filter, and so no state f and no hidden pole at -N. With `Ki=None` the law
    has no integral, and so no state I and no hidden pole at 0.

    Parameters
    ----------
    reads
        Layout of the outputs y that the law reads, as `motor.outputs` or `wb.layout(omega="rad/s")`.
    drives
        Layout of the inputs u that the law commands, with as many components as `reads`.
    Kp
        Proportional gain, in the unit of u over that of y.
    Ki
        Integral gain, in the unit of u over that of y, per second; None for a law without an integral. With 0 the law
        has the state I all the same.
    Kd
        Derivative gain, in the unit of u over that of y, times second; None for a law without a derivative. With 0 the
        law has the state of its filter all the same.
    N
        Bandwidth of the filter of the derivative. Only a law without a derivative may have None.
    b
        Weight of the reference in the proportional action.
    c
        Weight of the reference in the derivative action.
    low, high
        The lowest and the highest command, or None for no limit. Limits of `Instruments` must be repeated here: the law
        does not know them.
    anti_windup
        The rule for the integral while the command is limited.
    Tt
        Time constant of the back-calculation.
    u0
        Command at the operating point.
    y0
        Output at the operating point.

    Raises
    ------
    ValueError
        If `reads` or `drives` has no signal, or they have different numbers of components; a lower limit is not below
        the upper; back-calculation is asked for without limits, without Tt or without an integral; or a derivative has
        no filter.

    References
    ----------
    Astrom and Hagglund (2006), Advanced PID Control, chapters 3 (weights, windup) and 13 (the form in a computer).

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0, Kd=10.0, low=-24.0, high=24.0)
    >>> law.unit_of_Kp, law.unit_of_Ki, law.memory.names
    ('V s/rad', 'V/rad', ('integral', 'filter'))

    Two loops of a tank system in one law, with a pump for each level:

    >>> levels, pumps = wb.layout(h1="cm", h2="cm"), wb.layout(v1="V", v2="V")
    >>> wb.PID(levels, pumps, Kp=[3.0, 2.7], Ki=[0.1, 0.07]).drives.names
    ('v1', 'v2')
    """

    reads: Layout = Layout()
    drives: Layout = Layout()
    Kp: Vector = parameter(default=0.0, unit="{unit_of_Kp}", shape=("n",), symbol="K_p")
    Ki: Vector | None = parameter(default=0.0, unit="{unit_of_Ki}", shape=("n",), symbol="K_i")
    Kd: Vector | None = parameter(default=0.0, unit="{unit_of_Kd}", shape=("n",), symbol="K_d")
    N: Vector | None = parameter(default=100.0, unit="1/s", low=0, strict=True, shape=("n",), symbol="N")
    b: Vector = parameter(default=1.0, unit="", shape=("n",), symbol="b")
    c: Vector = parameter(default=1.0, unit="", shape=("n",), symbol="c")
    low: Vector | None = parameter(default=None, unit="{unit_of_u}", shape=("n",), symbol="u_min")
    high: Vector | None = parameter(default=None, unit="{unit_of_u}", shape=("n",), symbol="u_max")
    anti_windup: str = option(
        {
            "none": "limits do not change the integral",
            "clamping": "the integral stops while v is beyond a limit and Ki (r - y) would drive it farther",
            "back-calculation": "(u - v) / Tt is added to I'",
        },
        default="clamping",
    )
    Tt: Scalar = parameter(default=None, unit="s", low=0, strict=True, symbol="T_t")
    u0: Vector = parameter(default=0.0, unit="{unit_of_u}", shape=("n",), symbol="u_0")
    y0: Vector = parameter(default=0.0, unit="{unit_of_y}", shape=("n",), symbol="y_0")

    def __post_init__(self) -> None:
        for name, port in (("reads", self.reads), ("drives", self.drives)):
            if not port.size:
                raise ValueError(f"`PID({name}=...)` must be a layout of signals, as `layout(v='V')` is; it has none.")
        if self.reads.size != self.drives.size:
            raise ValueError(
                "`PID(reads=..., drives=...)` must drive as many numbers as it reads, each the one of its place; it "
                f"reads {self.reads.size} ({', '.join(map(repr, self.reads.names))}) and drives {self.drives.size} "
                f"({', '.join(map(repr, self.drives.names))})."
            )
        if self.Kd is not None and self.N is None:
            raise ValueError("`PID(N=...)` must be a number, as no law differentiates without a filter; got None.")
        if self.low is not None and self.high is not None and np.any(self.low >= self.high):
            raise ValueError(f"`PID(low=..., high=...)` must leave room between them; got {self.low} and {self.high}.")
        if self.anti_windup == "back-calculation" and (self.Tt is None or (self.low is None and self.high is None)):
            raise ValueError(
                "`PID(anti_windup='back-calculation')` needs limits and the time Tt in which the integral follows "
                f"them; got low = {self.low}, high = {self.high} and Tt = {self.Tt}."
            )
        if self.anti_windup == "back-calculation" and self.Ki is None:
            raise ValueError("`PID(anti_windup='back-calculation')` needs an integral; got Ki = None.")

    @staticmethod
    def of(
        design: object,
        reads: Layout | None = None,
        drives: Layout | None = None,
        low: object = None,
        high: object = None,
        anti_windup: str = "clamping",
        Tt: float | None = None,
    ) -> "PID":
        """The law of a `PidDesign`, about the operating point of its plant.

        Parameters
        ----------
        design
            The result of `tune_pid` or of a function of `pid_design`.
        reads, drives
            The layouts of y and u. The default is those of the linearised plant.
        low, high, anti_windup, Tt
            As for `PID`.

        Raises
        ------
        ValueError
            If `design` is no such result, or its plant has no operating point and a layout is left out.
        """
        gains = getattr(design, "law_arguments", None)
        if not isinstance(gains, dict):
            raise refusal("PID.of(design)", "the result of `tune_pid` or of a function of `pid_design`", design)
        layouts = {"reads": reads or gains.get("reads"), "drives": drives or gains.get("drives")}
        if None in layouts.values():
            raise ValueError(
                "`PID.of(design)` needs `reads` and `drives`, as a plant that was not linearised has no layouts: give "
                "them as `layout(y='m')`, or design for the result of `linearize`."
            )
        limits = {"low": low, "high": high, "anti_windup": anti_windup, "Tt": Tt}
        return PID(**(gains | layouts | limits))

    @property
    def dof(self) -> int:
        """The number n of components of y and of u."""
        return max(self.reads.size, 1)

    @property
    def unit_of_u(self) -> str:
        """The unit of the command u, one for each component if they differ."""
        return one_entry(self.drives, "u").unit

    @property
    def unit_of_y(self) -> str:
        """The unit of the output y, one for each component if they differ."""
        return one_entry(self.reads, "y").unit

    @property
    def unit_of_Kp(self) -> str:
        """The unit of Kp, one for each component if they differ."""
        return gain(self.unit_of_u, self.unit_of_y)

    @property
    def unit_of_Ki(self) -> str:
        """The unit of Ki, one for each component if they differ."""
        return gain(self.unit_of_u, self.unit_of_y, -1)

    @property
    def unit_of_Kd(self) -> str:
        """The unit of Kd, one for each component if they differ."""
        return gain(self.unit_of_u, self.unit_of_y, 1)

    @property
    def follows(self) -> Layout:
        return self.reads

    @property
    def memory(self) -> Layout:
        zero = np.zeros(self.dof)
        integral = (Entry("integral", zero, self.unit_of_u, symbol="I"),) if self.Ki is not None else ()
        derivative = (Entry("filter", zero, self.unit_of_y, symbol="f"),) if self.Kd is not None else ()
        return Layout((*integral, *derivative))

    @property
    def recursion(self) -> bool:
        """True if the law has a period, and so is in discrete time."""
        return self.period is not None

    def command(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Signals:
        return Signals(self.drives.view(self._limit(self._unlimited_command(z, est, ref))))

    def rate(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Parts:
        integral = {} if self.Ki is None else {"integral": self._growth(z, est, ref)}
        if self.Kd is None or self.N is None:
            return integral
        return {**integral, "filter": self.N * (self._weighted_error(est, ref) - z["filter"])}

    def update(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Parts:
        """The memory after one `period` of the computer."""
        return self.advance(t, z, est, ref, self._period)

    def advance(self, t: Number, z: Parts, est: Reads, ref: Follows, period: float) -> Parts:
        integral = {} if self.Ki is None else {"integral": z["integral"] + period * self._growth(z, est, ref)}
        if self.Kd is None or self.N is None:
            return integral
        share = self.N * period / (1 + self.N * period)
        return {**integral, "filter": z["filter"] + share * (self._weighted_error(est, ref) - z["filter"])}

    @property
    def method(self) -> str:
        return "forward difference of the integral, backward difference of the derivative"

    def without(self) -> Mapping[str, AbstractController]:
        integral = {"integral action": replace(self, Ki=0 * self.Ki)} if self.Ki is not None and self.Ki.any() else {}
        derivative = (
            {"derivative action": replace(self, Kd=0 * self.Kd)} if self.Kd is not None and self.Kd.any() else {}
        )
        return integral | derivative

    @property
    def _period(self) -> float:
        """The period of its computer in s; 0 in continuous time."""
        return 0.0 if self.period is None else self.period

    def _signals(self, est: Reads, ref: Follows) -> tuple[ca.SX, ca.SX]:
        return self.reads.flatten(est), self.reads.flatten(ref)

    def _weighted_error(self, est: Reads, ref: Follows) -> ca.SX:
        """The weighted error w, of which the derivative is taken."""
        y, r = self._signals(est, ref)
        w: ca.SX = self.c * (r - self.y0) - (y - self.y0)
        return w

    def _unlimited_command(self, z: Parts, est: Reads, ref: Follows) -> ca.SX:
        """The command v before its limits."""
        y, r = self._signals(est, ref)
        v: ca.SX = self.u0 + self.Kp * (self.b * r - y)
        if self.Ki is not None:
            v += z["integral"]
        if self.Kd is None or self.N is None:
            return v
        behind = (self._weighted_error(est, ref) - z["filter"]) / (
            1 + self.N * self._period
        )  # w - f, the f of this instant
        v += self.Kd * self.N * behind
        return v

    def _limit(self, v: ca.SX) -> ca.SX:
        v = v if self.low is None else ca.fmax(v, self.low)
        return v if self.high is None else ca.fmin(v, self.high)

    def _growth(self, z: Parts, est: Reads, ref: Follows) -> ca.SX:
        """The derivative of the integral, with the anti-windup."""
        y, r = self._signals(est, ref)
        v = self._unlimited_command(z, est, ref)
        growth: ca.SX = (0.0 if self.Ki is None else self.Ki) * (r - y)
        if self.anti_windup == "back-calculation":
            growth += (self._limit(v) - v) / self.Tt
        if self.anti_windup == "clamping" and self.low is not None:
            growth = ca.if_else(v < self.low, ca.fmax(growth, 0), growth)
        if self.anti_windup == "clamping" and self.high is not None:
            growth = ca.if_else(v > self.high, ca.fmin(growth, 0), growth)
        return growth
