"""What stands in a socket that is left empty: the readings themselves, and no wanted signal."""

from __future__ import annotations

from workbench.core import Layout, Signals, block
from workbench.core.block import Number
from workbench.loop.contracts import AbstractObserver, Parts, Reads
from workbench.loop.surroundings import AbstractReference


@block
class Readings(AbstractObserver):
    """What the instruments read, as it is.

    Parameters
    ----------
    outputs
        Of the plant, those that are read: `plant.outputs`.
    """

    noun = ""  # no observer at all

    outputs: Layout

    @property
    def reads(self) -> Layout:
        """The outputs."""
        return self.outputs

    @property
    def gives(self) -> Layout:
        """The outputs."""
        return self.outputs

    def estimate(self, t: Number, z: Parts, y: Reads) -> Signals:
        """The readings."""
        del t, z
        return y


@block
class Rest(AbstractReference):
    """No wanted signal: for a law that follows none."""

    @property
    def says(self) -> Layout:
        """Nothing."""
        return Layout()

    def at(self, t: Number) -> Signals:
        """Nothing."""
        del t
        return Signals()
