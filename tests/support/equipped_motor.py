"""A motor without inductance, and a plant whose signal has two units."""

import numpy as np

from workbench.blocks.loop import AbstractPlant
from workbench.core import block, initial, layout, parameter


@block
class Motor(AbstractPlant):
    """A motor without inductance: T omega' = K v - omega."""

    K: float = parameter(2.0, unit="rad/(V s)")
    T: float = parameter(0.5, unit="s", low=0)
    omega: float = initial(0.0, unit="rad/s")
    inputs = layout(v="V")
    outputs = layout(omega="rad/s")

    def rate(self, t, x, u):
        return {"omega": (self.K * u.v - x.omega) / self.T}


@block
class Mixed(AbstractPlant):
    """A slide and a hinge, with a force and a torque as one signal."""

    v: np.ndarray = initial([0.0, 0.0], unit="m/s, rad/s", shape=("2",))
    inputs = layout(tau=("N, N m", [0, 0]))
    outputs = layout(v=("m/s, rad/s", [0, 0]))

    def rate(self, t, x, u):
        return {"v": u.tau}
