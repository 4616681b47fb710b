"""A motor, a level and a PI law, as a user writes them."""

from workbench.blocks.loop import (
    AbstractController,
    AbstractPlant,
    AbstractReference,
    ClosedLoop,
)
from workbench.core import block, initial, layout, parameter


@block
class Motor(AbstractPlant):
    """L i' = v - R i - K omega, J omega' = K i - b omega."""

    R: float = parameter(1.0, unit="ohm", low=0)
    L: float = parameter(0.5, unit="H", low=0, strict=True)
    K: float = parameter(0.01, unit="N m/A")
    J: float = parameter(0.01, unit="kg m^2", low=0, strict=True)
    b: float = parameter(0.1, unit="N m s/rad", low=0)
    i: float = initial(0.0, unit="A")
    omega: float = initial(0.0, unit="rad/s")

    inputs = layout(v="V")
    outputs = layout(omega="rad/s")

    def rate(self, t, x, u):
        return {
            "i": (u.v - self.R * x.i - self.K * x.omega) / self.L,
            "omega": (self.K * x.i - self.b * x.omega) / self.J,
        }


@block
class Level(AbstractReference):
    """omega_ref = level."""

    level: float = parameter(1.0, unit="rad/s")
    gives = layout(omega="rad/s")

    def at(self, t):
        return {"omega": self.level}


@block
class PI(AbstractController):
    """v = kp e + ki z, z' = e, with e = omega_ref - omega."""

    kp: float = parameter(50.0, unit="V s/rad")
    ki: float = parameter(100.0, unit="V/rad")
    z: float = initial(0.0, unit="rad")

    reads = layout(omega="rad/s")
    follows = layout(omega="rad/s")
    drives = layout(v="V")

    def command(self, t, z, est, ref):
        return {"v": self.kp * (ref.omega - est.omega) + self.ki * z.z}

    def rate(self, t, z, est, ref):
        return {"z": ref.omega - est.omega}


def motor(**changes):
    return ClosedLoop(**{"plant": Motor(), "controller": PI(), "reference": Level(), **changes})


def law(**own):
    """A law of one's own with other ports or methods."""
    plain = {"reads": layout(), "drives": layout(v="V"), "command": lambda self, t, z, est, ref: {"v": 0}}
    return block(type("Own", (AbstractController,), {**plain, **own}))()


def plant(**own):
    plain = {
        "states": layout(x="m"),
        "inputs": layout(v="V"),
        "outputs": layout(x="m"),
        "rate": lambda self, t, x, u: {"x": u.v - x.x},
    }
    return block(type("Tank", (AbstractPlant,), {**plain, **own}))()
