"""Pictures over frequency are smooth curves at a sharp resonance, whose circle is drawn from close points."""

import casadi as ca
import control
import numpy as np
import pytest

import workbench as wb
from workbench.study.document.figure import Series

s = control.tf("s")
SHARP = 1 / (s**2 + 2e-4 * s + 1) * 0.5 / (s + 0.5) + 0.3 / s


@wb.block
class Sharp(wb.Plant):
    """An integrator beside two lightly damped modes."""

    y: float = wb.initial(default=0.0, unit="m")
    r: np.ndarray = wb.initial(default=[0, 0, 0, 0], unit="m", shape=("4",))
    inputs, outputs = wb.layout(u="m/s"), wb.layout(z="m")

    def rate(self, t, x, u):
        r = x.r
        return {"y": u.u, "r": ca.vertcat(r[1], -r[0] - 2e-4 * r[1] + u.u, r[3], -400 * r[2] - 4e-3 * r[3] + u.u)}

    def measure(self, t, x):
        return {"z": x.y + 0.2 * x.r[1] + 0.1 * x.r[3]}


@wb.block
class Slow(wb.Controller):
    """u = -0.3 z."""

    reads, drives = wb.layout(z="m"), wb.layout(u="m/s")

    def command(self, t, z, est, ref):
        return {"u": -0.3 * est.z}


LOOP = wb.linear_loop(wb.ClosedLoop(Sharp(), controller=Slow()))


@pytest.mark.parametrize("draw", [lambda: wb.nichols(SHARP), lambda: LOOP.plot("nichols")])
def test_a_nichols_curve_turns_by_small_steps(draw):
    (curve,) = (mark for mark in draw().figure.panels[0].series if isinstance(mark, Series))
    across, up = np.diff(curve.x), np.diff(curve.y)
    (left, right), (low, high) = (draw().figure.panels[0].xlim, draw().figure.panels[0].ylim)
    seen = (curve.y[:-1] > low) & (curve.y[:-1] < high)
    assert np.hypot(across / (right - left), up / (high - low))[seen].max() < 0.04  # of the picture


@pytest.mark.heavy
def test_characteristic_loci_and_singular_values_have_points_on_the_flanks_of_a_resonance():
    for kind in ("characteristic_loci", "singular_values"):
        figure = LOOP.plot(kind).figure
        if kind == "singular_values":
            (curve,) = (mark for mark in figure.panels[0].series if isinstance(mark, Series))
            near = (curve.x > 0.5) & (curve.x < 2)
            assert np.abs(np.diff(curve.y[near])).max() < 1.0  # dB
        else:
            omega = np.unique([row[1] for row in figure.numbers.rows])
            values = LOOP.response(omega).values[:, 0, 0]
            turns = np.angle(np.diff(values)[1:] / np.diff(values)[:-1])
            assert np.abs(turns).max() < 0.3  # radians, by which a drawn curve bends at a point
