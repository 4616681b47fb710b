"""The loops that b4 hands over by their names, and the name of a target."""

from studies.b4_handover.loops import handover_loops
from workbench.handover.targets import TARGETS

BY_NAME = {one.name: one for one in handover_loops()}
M4F = TARGETS["cortex-m4f"].name
