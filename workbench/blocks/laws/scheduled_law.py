from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import casadi as ca
import numpy as np

from workbench.blocks.laws.block_interpolation import differences, interpolated_block, interpolation_weights
from workbench.blocks.loop.contracts import AbstractController, Follows, Parts, Reads, is_recursion
from workbench.core import Layout, Signals, block, option, parameter
from workbench.core.block import Number, Vector
from workbench.core.port import misfits
from workbench.core.validation.refusals import Array, finite, one_of, vector


@block
class ScheduledLaw(AbstractController):
    """A gain-scheduled law: every number of a law is interpolated between laws for m points of one signal.

    The laws differ in their numbers alone, such as gains and operating points. They share one memory. The scheduling
    signal s is an estimate that the law reads or a reference that it follows; beyond the first and the last point the
    numbers are those of the end.

    The linear model of a loop includes the slopes of the numbers over s, as they are a part of its equations. Its poles
    are not those of the interpolated law with s held. `wb.scheduling.check_schedule` compares both.

    Parameters
    ----------
    laws
        The laws at the points, two or more, of one class, with the same signals and options. Their initial
        memory is that of the first.
    signal
        Layout of the scheduling signal, one number with its unit, as `wb.layout(T="K")`.
    points
        The m values of the signal for which the laws are designed, in increasing order.
    source
        Where the signal comes from.
    interpolation
        The rule between two points.

    Raises
    ------
    ValueError
        If there are fewer than two laws, or another number of points; the points do not increase; the laws differ in
        more than their numbers, or have a period; or the signal is not one number.

    References
    ----------
    Rugh and Shamma (2000), Research on gain scheduling, Automatica 36. Astrom and Hagglund (2006), Advanced PID
    Control, chapter 9.

    Examples
    --------
    >>> temperature, coolant = wb.layout(T="K"), wb.layout(T_c="K")
    >>> laws = [wb.PID(temperature, coolant, Kp=k, Ki=k / 60, u0=300.0) for k in (4.0, 8.0)]
    >>> law = wb.ScheduledLaw(laws, temperature, points=[320.0, 350.0], source="estimate")
    >>> law.at(335.0).Kp, law.memory.names
    (array([6.]), ('integral', 'filter'))
    """

    laws: tuple[AbstractController, ...]
    signal: Layout
    points: Vector = parameter(unit="{unit_of_signal}", shape=("m",))
    source: str = option(
        {
            "estimate": "the law reads the signal",
            "reference": "the law follows the signal, and its reference is used",
        },
        default="estimate",
    )
    interpolation: str = option(
        {
            "cubic": "cubic polynomials with a continuous slope; a number may leave the range of its two neighbours",
            "linear": "straight lines; the slope of the law jumps at the points, where it has no linear model",
        },
        default="cubic",
    )

    def __post_init__(self) -> None:
        vector("ScheduledLaw(points=...)", self.points, len(self.laws), "laws")
        if len(self.laws) < 2:
            raise ValueError(
                f"`ScheduledLaw(laws=...)` must have a law for each of two or more points; got {len(self.laws)}."
            )
        if not (np.diff(self.points) > 0).all():
            raise ValueError(f"`ScheduledLaw(points=...)` must increase; got {self.points}.")
        if self.signal.size != 1:
            raise ValueError(
                f"`ScheduledLaw(signal=...)` must be a layout of one number, as `layout(T='K')`; it has "
                f"{self.signal.size}."
            )
        first = self.laws[0]
        for i, law in enumerate(self.laws):
            if law.period is not None:
                raise ValueError(
                    f"`ScheduledLaw(laws=...)` must be laws without a period of their own: take `run_every(period)` of "
                    f"the scheduled law; laws[{i}] has one of {law.period:g} s."
                )
            if different := next(differences(first, law), None):
                raise ValueError(
                    f"`ScheduledLaw(laws=...)` must be laws of one class that differ in their numbers alone; laws[0] "
                    f"and laws[{i}] differ in `{different}`."
                )
        one_of("ScheduledLaw(source=...)", self.source, ("estimate", "reference"))
        port = first.reads if self.source == "estimate" else first.follows
        common = Layout(tuple(entry for entry in self.signal.entries if entry.name in port))
        for clause in misfits(common, port):
            raise ValueError(f"`ScheduledLaw(signal=...)` takes {clause.format(gives='its laws take')}.")

    @property
    def unit_of_signal(self) -> str:
        """The unit of the scheduling signal."""
        return self.signal.entries[0].unit if self.signal.size else ""

    @property
    def reads(self) -> Layout:
        return self._with_signal(self.laws[0].reads, "estimate")

    @property
    def follows(self) -> Layout:
        return self._with_signal(self.laws[0].follows, "reference")

    @property
    def drives(self) -> Layout:
        return self.laws[0].drives

    @property
    def memory(self) -> Layout:
        return self.laws[0].memory

    @property
    def recursion(self) -> bool:
        """True if the laws are in discrete time."""
        return is_recursion(self._timed(self.laws[0]))

    @property
    def signal_units(self) -> Mapping[str, str]:
        return self.laws[0].signal_units

    @property
    def method(self) -> str:
        return self._timed(self.laws[0]).method

    @property
    def corners(self) -> Array:
        """The values of the signal at which the slope of the numbers jumps: both ends, or all points if linear."""
        return np.array(self.points[[0, -1]] if self._cubic else self.points)

    def at(self, value: float) -> AbstractController:
        """The law with the numbers that hold while the scheduling signal has a value, as a law of its own."""
        weights = interpolation_weights(
            ca.SX(self.points), ca.SX(finite("ScheduledLaw.at(value=...)", value)), self._cubic
        )
        return self._timed(interpolated_block(self.laws, [float(weight) for weight in weights]))

    def command(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Signals:
        law, est, ref = self._now(est, ref)
        return law.command(t, z, est, ref)

    def rate(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Parts:
        law, est, ref = self._now(est, ref)
        return law.rate(t, z, est, ref)

    def update(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Parts:
        """The memory after one `period` of the computer."""
        law, est, ref = self._now(est, ref)
        return law.update(t, z, est, ref)

    def advance(self, t: Number, z: Parts, est: Reads, ref: Follows, period: float) -> Parts:
        """The memory after one `period` [s], with the numbers at its beginning."""
        law, est, ref = self._now(est, ref)
        return law.advance(t, z, est, ref, period)

    def signals(self, z: Parts, est: Reads, ref: Follows) -> Parts:
        law, est, ref = self._now(est, ref)
        return law.signals(z, est, ref)

    def without(self) -> Mapping[str, AbstractController]:
        parts = [law.without() for law in self.laws]
        names = [name for name in parts[0] if all(name in others for others in parts)]
        return {name: replace(self, laws=tuple(others[name] for others in parts)) for name in names}

    @property
    def _cubic(self) -> bool:
        return self.interpolation == "cubic"

    def _with_signal(self, port: Layout, source: str) -> Layout:
        """A port of the laws, with the scheduling signal where it comes from there and no law takes it."""
        if source != self.source or self.signal.names[0] in port:
            return port
        return port + self.signal

    def _timed(self, law: AbstractController) -> AbstractController:
        return law if self.period is None else law.run_every(self.period)

    def _now(self, est: Reads, ref: Follows) -> tuple[AbstractController, Signals, Signals]:
        """The law with the numbers of this instant, and the signals that it reads and follows."""
        value = (est if self.source == "estimate" else ref)[self.signal.names[0]]
        law = interpolated_block(self.laws, interpolation_weights(ca.SX(self.points), value, self._cubic))
        return self._timed(law), est.only(law.reads), ref.only(law.follows)
