from collections.abc import Mapping
from dataclasses import replace

import casadi as ca
import numpy as np

from workbench.blocks.loop.contracts import AbstractController, Follows, Parts, Reads, is_recursion
from workbench.blocks.loop.wiring import prefix_names, strip_prefix
from workbench.core import Entry, Layout, Signals, block
from workbench.core.block import Number
from workbench.core.port import misfits
from workbench.core.validation.refusals import whole

Arguments = tuple[ca.SX, Signals, Signals, Signals]  # time, memory, estimates and wanted signals of a law


@block
class Cascade(AbstractController):
    """A cascade of two laws: the command of the outer law is the reference of the inner law.

    An example is a position loop around a speed loop. In a computer, the inner law runs in every period of the cascade.
    The outer law runs in the first period and then once in every `ratio` periods, and its command is held in between.
    In continuous time both laws act at every instant.

    Parameters
    ----------
    outer
        The outer law. It drives the signals that the inner law follows.
    inner
        The inner law. It drives inputs of the plant.
    ratio
        The period of the outer law in periods of the cascade, a positive whole number.

    Raises
    ------
    ValueError
        If the inner law does not follow every signal that the outer law drives, by name, size and unit; if the two laws
        read or follow one signal in different sizes or units; if one of them has a `period`; or if `ratio` is no
        positive whole number.

    References
    ----------
    Astrom and Hagglund (2006), Advanced PID Control, chapter 12.

    Examples
    --------
    >>> motor = wb.DCMotor.position()
    >>> law = wb.PID(wb.layout(theta="rad"), wb.layout(omega="rad/s"), Kp=20.0)
    >>> speed = wb.PID(wb.layout(omega="rad/s"), motor.inputs, Kp=0.5)
    >>> cascade = wb.Cascade(outer=law, inner=speed, ratio=10)
    >>> cascade.reads.names, cascade.follows.names, cascade.drives.names
    (('theta', 'omega'), ('theta',), ('v',))
    """

    outer: AbstractController
    inner: AbstractController
    ratio: int = 1

    def __post_init__(self) -> None:
        whole("Cascade(ratio=...)", self.ratio)
        outer, inner = type(self.outer).__name__, type(self.inner).__name__
        for name in ("outer", "inner"):
            if (period := getattr(self, name).period) is not None:
                raise ValueError(
                    f"`Cascade({name}=...)` must be a law without a period of its own: the cascade has one, and "
                    f"`ratio` of them make that of the outer law; got one of {period:g} s."
                )
        for clause in misfits(self.outer.drives, self.inner.follows):
            sentence = f"`Cascade(outer=...)`: `{outer}` drives {clause.format(gives=f'`{inner}` follows')}"
            raise ValueError(sentence if sentence.endswith("?") else f"{sentence}.")
        for one, other in ((self.outer.reads, self.inner.reads), (self.outer.follows, self._rest)):
            common = Layout(tuple(entry for entry in one.entries if entry.name in other))
            for clause in misfits(common, other):
                raise ValueError(
                    f"`Cascade(...)`: `{outer}` takes {clause.format(gives=f'`{inner}` takes')}; both must take one."
                )

    @property
    def reads(self) -> Layout:
        return _union(self.outer.reads, self.inner.reads)

    @property
    def follows(self) -> Layout:
        """The signals that the outer law follows, and those that the inner law follows and the outer does not drive."""
        return _union(self.outer.follows, self._rest)

    @property
    def drives(self) -> Layout:
        return self.inner.drives

    @property
    def memory(self) -> Layout:
        held = Layout(tuple(Entry(e.name, np.zeros(e.shape), e.unit) for e in self.outer.drives.entries))
        both = self.outer.memory.with_prefix("outer.") + self.inner.memory.with_prefix("inner.")
        return both + held.with_prefix("held.") if self.ratio > 1 else both

    @property
    def recursion(self) -> bool:
        """True if one of the laws is in discrete time, or if a computer holds the command of the outer law."""
        return is_recursion(self._outer) or is_recursion(self._inner) or (self.ratio > 1 and self.period is not None)

    @property
    def signal_units(self) -> Mapping[str, str]:
        return self.outer.signal_units

    @property
    def method(self) -> str:
        return f"outer law: {self.outer.method}; inner law: {self.inner.method}"

    def command(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Signals:
        _, inner = self._arguments(t, z, est, ref)
        return self._inner.command(*inner)

    def rate(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Parts:
        outer, inner = self._arguments(t, z, est, ref)
        held = {name: ca.SX.zeros(part.shape) for name, part in strip_prefix("held", z).items()}
        return prefix_names({"outer": self._outer.rate(*outer), "inner": self._inner.rate(*inner), "held": held})

    def update(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Parts:
        """The memory after one `period` of the cascade; a ValueError without a period."""
        if self.period is None:
            raise ValueError("`Cascade.update(...)` needs a period: take `run_every(period)`.")
        return self.advance(t, z, est, ref, self.period)

    def advance(self, t: Number, z: Parts, est: Reads, ref: Follows, period: float) -> Parts:
        """The memory after one `period` [s]: of the inner law, and of the outer law in the periods in which it runs."""
        outer, inner = self._arguments(t, z, est, ref)
        moved = self._outer.advance(*outer, self.ratio * period)
        parts = {"outer": moved, "inner": self._inner.advance(*inner, period)}
        if self.ratio == 1:
            return prefix_names(parts)
        old, wanted = outer[1], inner[3]
        parts["outer"] = {name: ca.if_else(self._is_turn(t, period), part, old[name]) for name, part in moved.items()}
        return prefix_names(parts | {"held": {name: wanted[name] for name in self.outer.drives.names}})

    def signals(self, z: Parts, est: Reads, ref: Follows) -> Parts:
        return self._outer.signals(
            Signals(strip_prefix("outer", z)), est.only(self.outer.reads), ref.only(self.outer.follows)
        )

    def without(self) -> Mapping[str, AbstractController]:
        outer = {f"outer {name}": replace(self, outer=law) for name, law in self.outer.without().items()}
        return outer | {f"inner {name}": replace(self, inner=law) for name, law in self.inner.without().items()}

    @property
    def _rest(self) -> Layout:
        """The signals that the inner law follows and the outer does not drive."""
        return Layout(tuple(entry for entry in self.inner.follows.entries if entry.name not in self.outer.drives))

    @property
    def _outer(self) -> AbstractController:
        return self.outer if self.period is None else self.outer.run_every(self.ratio * self.period)

    @property
    def _inner(self) -> AbstractController:
        return self.inner if self.period is None else self.inner.run_every(self.period)

    def _arguments(self, t: Number, z: Parts, est: Reads, ref: Follows) -> tuple[Arguments, Arguments]:
        """The time, memory, estimates and wanted signals of the outer law, and those of the inner one."""
        outer = (t, Signals(strip_prefix("outer", z)), est.only(self.outer.reads), ref.only(self.outer.follows))
        new = Signals(self._outer.command(*outer))
        if self.ratio > 1 and self.period is not None:
            turn = self._is_turn(t, self.period)
            new = Signals({name: ca.if_else(turn, part, z[f"held.{name}"]) for name, part in new.items()})
        return outer, (
            t,
            Signals(strip_prefix("inner", z)),
            est.only(self.inner.reads),
            (ref | new).only(self.inner.follows),
        )

    def _is_turn(self, t: Number, period: float) -> ca.SX:
        return ca.fmod(ca.floor(t / period + 0.5), self.ratio) == 0


def _union(one: Layout, other: Layout) -> Layout:
    return Layout(one.entries + tuple(entry for entry in other.entries if entry.name not in one))
