"""The state of any plant as it is, for a law that is designed before its observer."""

from __future__ import annotations

from workbench.blocks.loop.contracts import AbstractObserver, AbstractPlant, Parts, Reads
from workbench.core import Layout, Signals, block
from workbench.core.block import Number
from workbench.core.port import misfits
from workbench.core.validation.refusals import known_name


@block
class FullState(AbstractObserver):
    """Every state of a plant: as its instrument reads it, or, where none does, as it truly is: x_hat = x.

    Noise, rounding and delay of the instruments reach the law as they are. A state that no instrument reads makes this
    an observer that uses the truth: a report says so, and no machine can run it. Put one with a model in its place, as
    `LinearObserver` or `ExtendedKalmanFilter` is, before the law is handed over.

    Examples
    --------
    >>> cart = wb.CartPole(phi=0.1)
    >>> observer = wb.FullState.of(cart)
    >>> observer.gives.names, observer.uses_truth, observer.hidden_states
    (('x', 'xd', 'phi', 'phid'), True, ('xd', 'phid'))
    """

    states: Layout
    hidden_states: tuple[str, ...] = ()
    noun = ""  # no observer at all

    def __post_init__(self) -> None:
        for name in self.hidden_states:
            known_name(name, self.states.names, "states")

    @staticmethod
    def of(plant: AbstractPlant) -> FullState:
        """The full state of a plant; `hidden_states` are those that no instrument reads."""
        each = {entry.name: Layout((entry,)) for entry in plant.states.entries}
        return FullState(plant.states, tuple(name for name, port in each.items() if misfits(port, plant.outputs)))

    @property
    def uses_truth(self) -> bool:
        return bool(self.hidden_states)

    @property
    def reads(self) -> Layout:
        return self.states

    @property
    def gives(self) -> Layout:
        return self.states

    def estimate(self, t: Number, z: Parts, y: Reads) -> Signals:
        return y
