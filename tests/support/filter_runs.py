"""A run of a plant behind a filter, in a computer of the period h."""

from tests.support.observed import Swaying
from workbench.blocks.loop import ClosedLoop
from workbench.engine import simulate

h = 0.05


def run(plant, observer, until=2.0, law=None, instruments=None, **keys):
    sampled = ClosedLoop(plant, observer, law or Swaying()).digital(h, instruments)
    return simulate(sampled.step(2), until=until, arithmetic="casadi", **keys)  # which compiles nothing
