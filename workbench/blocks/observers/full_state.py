"""The state of any plant as it is, for a law that is designed before its observer."""

from __future__ import annotations

from workbench.blocks.loop.contracts import AbstractObserver, AbstractPlant, Parts, Reads
from workbench.core import Layout, Signals, block
from workbench.core.block import Number
from workbench.core.port import misfits
from workbench.core.validation.refusals import known_name


@block
class FullState(AbstractObserver):
    """The full state of a plant as the estimate, without an observer: x_hat = x.

    A measured state is the reading of its instrument, with noise and quantisation. A state that is not measured is its
    true value. The observer then uses the truth: a report warns of it, and the law cannot be exported. Use an observer
    with a model instead, such as `LinearObserver` or `ExtendedKalmanFilter`, before you export the law.

    Parameters
    ----------
    states
        Layout of the states of the plant.
    hidden_states
        Names of the states that no instrument measures.

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
        """The full state of a plant. `hidden_states` are the states that are not outputs of the plant."""
        each = {entry.name: Layout((entry,)) for entry in plant.states.entries}
        return FullState(plant.states, tuple(name for name, port in each.items() if misfits(port, plant.outputs)))

    @property
    def uses_truth(self) -> bool:
        """True if there are hidden states."""
        return bool(self.hidden_states)

    @property
    def reads(self) -> Layout:
        return self.states

    @property
    def gives(self) -> Layout:
        return self.states

    def estimate(self, t: Number, z: Parts, y: Reads) -> Signals:
        return y
