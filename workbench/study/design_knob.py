"""DesignKnob: a number from which a law is designed, which a reader of a page turns among designs made before."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from workbench.core import Layout, StepMap
from workbench.core.equations import Loop, equations_of
from workbench.core.validation.refusals import Array, finite, name, vector
from workbench.core.validation.signatures import check_arguments
from workbench.engine.factors import Mark

MOST = 200  # values, as a page holds the numbers of each design
SAME = 1e-9  # relative difference of two values that are one


@dataclass(frozen=True, eq=False)
class DesignKnob:
    """A number from which a law is designed, as a weight, that a reader of the page turns among some values.

    A page cannot solve a design again, for instance a Riccati equation. So all designs are made before, one for each
    value, and the page takes all numbers of the loop that differ between them. `DesignKnob.of` makes the knob.

    Attributes
    ----------
    values
        (D,), ascending.
    numbers
        The parameters of the loop that follow from the value, by label: (D,) each.
    unit
        The unit of the values; "1" for none.
    origin
        Where the number of the loop comes from.

    Examples
    --------
    >>> motor = wb.open_loop(wb.DCMotor())
    >>> def loop(weight):
    ...     K = wb.lqr(wb.linearize(motor, t=0.0, x=[0.0, 0.0], at_rest=True), np.eye(2), [[weight]]).K
    ...     law = wb.StateFeedback(wb.DCMotor().states, wb.DCMotor().inputs, K, np.zeros(2), np.zeros(1))
    ...     return wb.ClosedLoop(wb.DCMotor(), observer=wb.FullState.of(wb.DCMotor()), controller=law)
    >>> knob = wb.DesignKnob.of("weight of the voltage", np.geomspace(0.01, 1.0, 5), loop)
    >>> sorted(knob.numbers), knob.values.shape
    (['controller.K[0,0]', 'controller.K[0,1]'], (5,))
    """

    name: str
    values: Array
    numbers: Mapping[str, Array]
    unit: str = "1"
    origin: Mark = "derived"
    share = False

    @staticmethod
    @check_arguments
    def of(name: str, values: Sequence[float] | Array, loop: Callable[[float], Loop], unit: str = "1") -> DesignKnob:
        """The knob of a number, by the loop that is designed from it.

        Parameters
        ----------
        values
            The values at which the loop is designed, ascending, 2 to 200 of them.
        loop
            The function from a value to its loop. All loops must have parameters of the same names and shapes.

        Raises
        ------
        ValueError
            If the values are no such list, a loop has other parameters than the first one, or no parameter differs.
        """
        return _knob_of(name, values, loop, unit)

    def __repr__(self) -> str:
        numbers, unit = len(self.numbers), "" if self.unit == "1" else f" {self.unit}"
        ends = f"{self.low:.4g} to {self.high:.4g}{unit}"
        return f"<DesignKnob '{self.name[:40]}': {len(self.values)} designs from {ends}, {numbers} numbers each>"

    @property
    def paths(self) -> tuple[str, ...]:
        """The labels of the parameters that follow from the value."""
        return tuple(self.numbers)

    @property
    def low(self) -> float:
        """The least value."""
        return float(self.values[0])

    @property
    def high(self) -> float:
        """The largest value."""
        return float(self.values[-1])

    @property
    def log(self) -> bool:
        """False: the values themselves are the scale."""
        return False

    @cached_property
    def table(self) -> Array:
        """The parameters of each design, (D, number of parameters)."""
        return np.column_stack(list(self.numbers.values()))

    @check_arguments
    def places(self, step: StepMap) -> tuple[int, ...]:
        """The places that the knob moves in a row of parameters; none for a loop that has not all of them."""
        labels = {label: place for place, label in enumerate(step.parameters.labels)}
        return tuple(labels[path] for path in self.paths) if labels.keys() >= self.numbers.keys() else ()

    @check_arguments
    def value(self, step: StepMap, p: Array, x0: Array) -> float:
        """The value from which a loop with parameters p was designed.

        Raises
        ------
        ValueError
            If the loop is none of the designs.
        """
        del x0
        own = vector("DesignKnob.value(p=...)", p, step.parameters.size, "parameters")[[*self.places(step)]]
        size = np.maximum(np.abs(self.table).max(axis=0), 1e-300)
        off = np.abs((self.table - own) / size).max(axis=1)
        if not off.min() <= SAME:
            raise ValueError(
                f"`DesignKnob({self.name!r}, ...)` must be designed at the number of the loop itself, too; none of its "
                f"{len(self.values)} values gives the parameters of this loop."
            )
        return float(self.values[off.argmin()])

    @check_arguments
    def numbers_at(self, value: float, own: Array) -> Array:
        """The numbers at the places of the knob for a value, the nearest of its own."""
        del own
        return np.asarray(self.table[np.abs(self.values - value).argmin()])


def _knob_of(title: str, values: Sequence[float] | Array, loop: Callable[[float], Loop], unit: str) -> DesignKnob:
    call = f"DesignKnob.of({name('DesignKnob.of(name=...)', title)!r}, values=...)"
    own = np.asarray([finite(call, value) for value in values], dtype=float)
    if not (2 <= len(own) <= MOST and (np.diff(own) > 0).all()):
        raise ValueError(f"`{call}` must be 2 to {MOST} ascending numbers; got {len(own)}: {own.tolist()}.")
    layouts: list[Layout] = [equations_of(loop(float(value)), call).parameters for value in own]
    for value, layout in zip(own, layouts, strict=True):
        if layout.labels != layouts[0].labels:
            other = sorted({*layout.labels} ^ {*layouts[0].labels})
            raise ValueError(
                f"`{call}` must have loops with the same parameters; that of {value:g} differs from that of {own[0]:g} "
                f"in '{other[0]}'. Give the sizes of the design, such as the number of sweeps."
            )
    rows = np.array([layout.default for layout in layouts])
    differs = np.flatnonzero((rows != rows[0]).any(axis=0) & ~np.isnan(rows).any(axis=0))
    if not differs.size:
        raise ValueError(f"`{call}` must change a parameter of the loop; all {len(own)} loops have the same ones.")
    return DesignKnob(title, own, {layouts[0].labels[k]: rows[:, k] for k in differs}, unit)
