"""The linear answers of a live page at a resonance that is narrower than its frequencies lie apart."""

import numpy as np
import pytest

import workbench as wb
from tests.support.browsers import needs_node
from tests.support.compilers import needs_llvmlite
from tests.support.live_linear import LoopData, assert_same, complex_of

pytestmark = [needs_node, needs_llvmlite]


@wb.block
class Light(wb.Plant):
    """An integrator beside a mode of the frequency w and little damping."""

    w: float = wb.parameter(default=30.0, unit="rad/s")
    zeta: float = wb.parameter(default=1e-5, unit="1")
    y: float = wb.initial(default=0.0, unit="m")
    r: float = wb.initial(default=0.0, unit="m")
    rd: float = wb.initial(default=0.0, unit="m/s")
    inputs, outputs = wb.layout(u="m/s"), wb.layout(z="m")

    def rate(self, t, x, u):
        return {"y": u.u, "r": x.rd, "rd": -(self.w**2) * x.r - 2 * self.zeta * self.w * x.rd + u.u}

    def measure(self, t, x):
        return {"z": x.y + 0.05 * x.rd}


@wb.block
class Gain(wb.Controller):
    """u = -k z."""

    k: float = wb.parameter(default=1.0, unit="1/s")
    reads, drives = wb.layout(z="m"), wb.layout(u="m/s")

    def command(self, t, z, est, ref):
        return {"u": -self.k * est.z}


LIGHT = wb.ClosedLoop(Light(), controller=Gain())


@pytest.mark.heavy
def test_the_crossovers_of_a_narrow_resonance_are_found_wherever_a_knob_puts_it():
    data = LoopData.of(LIGHT)
    for w in (3.0, 41.7, 97.3):  # of a damping of 1e-5, far from the frequencies of the page
        (answer,) = data.answers(data.turn(plant__w=w))
        assert_same(answer, data.python(plant__w=w), poles_within=1e-8)
        assert len(answer["margins"][0]["gainCrossovers"]) >= 3


@pytest.mark.heavy
def test_a_sharp_peak_is_drawn_as_high_as_the_table_says_it_is_wherever_a_knob_puts_it():
    data = LoopData.of(LIGHT)
    for w in (3.0, 41.7, 97.3):
        (answer,) = data.answers(data.turn(plant__w=w, plant__zeta=1e-3))
        peak = np.abs(1 / (1 + complex_of(answer["L"]))).max()
        Ms = float(answer["margins"][0]["Ms"])
        assert 0.9 * Ms < peak <= Ms * (1 + 1e-9)  # points lie a half of a width apart
