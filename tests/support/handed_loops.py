"""The loops that b4 hands over by their names, and the name of a target."""

from studies.b4_handover.loops import handed
from workbench.handover.targets import TARGETS

BY_NAME = {one.name: one for one in handed()}
M4F = TARGETS["cortex-m4f"].name
