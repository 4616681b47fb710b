"""Loops of second order whose figures have closed forms."""

import math

import workbench as wb

OMEGA = 2.0


@wb.block
class Slide(wb.Plant):
    """A mass with friction: m x'' = F - c x'."""

    m: float = wb.parameter(default=1.0, unit="kg", low=0, strict=True)
    c: float = wb.parameter(default=1.0, unit="N s/m", low=0)
    x: float = wb.initial(default=0.0, unit="m")
    v: float = wb.initial(default=0.0, unit="m/s")
    inputs, outputs = wb.layout(F="N"), wb.layout(x="m", v="m/s")

    def rate(self, t, x, u):
        return {"x": x.v, "v": (u.F - self.c * x.v) / self.m}


@wb.block
class Proportional(wb.Controller):
    """F = k (x_ref - x)."""

    k: float = wb.parameter(default=4.0, unit="N/m")
    reads = follows = wb.layout(x="m")
    drives = wb.layout(F="N")

    def command(self, t, z, est, ref):
        return {"F": self.k * (ref.x - est.x)}


def loop_of(plant, **gains):
    law = wb.PID(wb.layout(x="m"), plant.inputs, **gains) if gains else Proportional()
    return wb.ClosedLoop(plant, controller=law, reference=wb.Step("x", "m", 0.5))


SLIDE = loop_of(Slide())


def peak_of_S(zeta):
    """Åström and Hägglund (2006), Advanced PID Control, section 4.6."""
    root = math.sqrt(8 * zeta**2 + 1)
    return math.sqrt((root**2 + (4 * zeta**2 + 1) * root) / (root**2 + (4 * zeta**2 - 1) * root))


def closed_forms(zeta):
    shrink, drop = 1 - 2 * zeta**2, 10**-0.3
    return {
        "Ms": peak_of_S(zeta),
        "Mt": 1 / (2 * zeta * math.sqrt(1 - zeta**2)),
        "bandwidth": OMEGA * math.sqrt(shrink + math.sqrt(shrink**2 - 1 + 1 / drop)),
        "damping": zeta,
        "decay": zeta * OMEGA,
        "phase_margin": math.degrees(math.atan2(2 * zeta, math.sqrt(math.sqrt(1 + 4 * zeta**4) - 2 * zeta**2))),
        "overshoot": 100 * math.exp(-math.pi * zeta / math.sqrt(1 - zeta**2)),
    }
