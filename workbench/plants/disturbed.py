"""A disturbance on an input or an output of any plant."""

from __future__ import annotations

from collections.abc import Mapping

from workbench.core import Entry, Layout, Signals, block
from workbench.core.block import Number, States
from workbench.core.port import misfits
from workbench.loop.contracts import AbstractPlant, Inputs, Parts, is_recursion
from workbench.loop.surroundings import AbstractReference

TRUTH = "d_"


@block
class Disturbed(AbstractPlant):
    """A plant whose inputs, behind the command, and whose outputs have a signal in time added to them:

        x' = f(t, x, u + d_u(t)),      y = h(t, x) + d_y(t).

    The signals are truths of the plant, `d_v` that on the input v, which no instrument gives.

    Parameters
    ----------
    by
        A reference, or several `Together`, each named as an input or an output of the plant. Derivatives do not count.

    Raises
    ------
    ValueError
        If a signal is neither an input nor an output of the plant, or of another size or unit; or if the plant has a
        signal of the name of the disturbance, as one that is disturbed already has.

    Examples
    --------
    >>> motor = wb.Disturbed(wb.DCMotor(), by=wb.Step("v", "V", 1.0, time=2.0))
    >>> motor.inputs.names, motor.truths.names
    (('v',), ('d_v',))
    """

    plant: AbstractPlant
    by: AbstractReference

    def __post_init__(self) -> None:
        for clause in misfits(self._added, self.plant.inputs + self.plant.outputs):
            held = clause.format(gives=f"`{type(self.plant).__name__}` has")
            raise ValueError(f"`Disturbed(by=...)` adds {held if held.endswith('?') else f'{held}.'}")
        for name in self._added.prefixed(TRUTH).names:
            if name in self.plant.outputs + self.plant.truths:
                raise ValueError(
                    f"`Disturbed(by=...)` must leave the name '{name}' to `{type(self.plant).__name__}`, which has it "
                    "already: where that is a disturbance too, add the two up in one signal."
                )

    @property
    def period(self) -> float | None:  # type: ignore[override]
        """That of the plant, where it moves in discrete time."""
        return self.plant.period

    @property
    def recursion(self) -> bool:
        """Whether the plant moves in discrete time."""
        return is_recursion(self.plant)

    @property
    def labels(self) -> Mapping[str, str]:
        """Those of the plant."""
        return self.plant.labels

    @property
    def states(self) -> Layout:
        """Those of the plant."""
        return self.plant.states

    @property
    def inputs(self) -> Layout:
        """Those of the plant."""
        return self.plant.inputs

    @property
    def outputs(self) -> Layout:
        """Those of the plant."""
        return self.plant.outputs

    @property
    def truths(self) -> Layout:
        """Those of the plant, and the disturbances."""
        return self.plant.truths + self._added.prefixed(TRUTH)

    def measure(self, t: Number, x: States) -> Signals:
        """The disturbed outputs, and the truths."""
        d, y = self._at(t), Signals(self.plant.measure(t, x))
        truths = {f"{TRUTH}{name}": part for name, part in d.items()}
        return y | {name: y[name] + part for name, part in d.items() if name in self.outputs} | truths

    def applied(self, t: Number, x: States, u: Inputs) -> Signals:
        """What acts in the plant under the disturbed command."""
        return self.plant.applied(t, x, self._driven(t, u))

    def rate(self, t: Number, x: States, u: Inputs) -> Parts:
        """That of the plant under the disturbed command."""
        return self.plant.rate(t, x, self._driven(t, u))

    def update(self, t: Number, x: States, u: Inputs) -> Parts:
        """That of the plant under the disturbed command."""
        return self.plant.update(t, x, self._driven(t, u))

    @property
    def _added(self) -> Layout:
        return Layout(
            tuple(Entry(e.name, e.default, e.unit) for e in self.by.says.entries if e.name in self.by.primary)
        )

    def _at(self, t: Number) -> Signals:
        return Signals(self.by.at(t)).only(self._added)

    def _driven(self, t: Number, u: Inputs) -> Signals:
        return u | {name: u[name] + part for name, part in self._at(t).items() if name in self.inputs}
