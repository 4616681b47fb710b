"""A drive that takes its torque a period late, behind an observer that counts on the torque that is commanded."""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca

import workbench as wb


@wb.block
class LateDrive(wb.plants.AbstractElement):
    """The command of the instant before, held from one instant of the computer to the next:

        acts+ = waits,      waits+ = v,      y = acts.

    The delay of a `DigitalLoop` is in the computer, whose observer counts on the torque that acts. This delay is in the
    plant, so that the observer counts on the torque that is commanded.
    """

    acts: wb.core.Vector = wb.initial(default=0.0, unit="{unit}", shape=("*",))
    waits: wb.core.Vector = wb.initial(default=0.0, unit="{unit}", shape=("*",))

    @property
    def recursion(self) -> bool:
        return True

    def output(self, z: wb.plants.Memory, v: wb.core.Column) -> ca.SX:
        return z["acts"]

    def update(self, z: wb.plants.Memory, v: wb.core.Column) -> Mapping[str, ca.SX]:
        return {"acts": z["waits"], "waits": v}
