"""Loops of transfer functions whose pictures are held against python-control."""

import control
import numpy as np

import workbench as wb
from workbench.blocks.loop import LinearLaw
from workbench.study.document.figure import Points, Series

A, B = np.array([[-1.0, 0.4], [0.2, -2.0]]), np.array([[1.0, 0.3], [0.1, 2.0]])
GAINS = np.array([[3.0, -0.5], [0.8, 2.0]])
NAMES = {"inputs": ["a", "b"], "outputs": ["y", "z"]}
TWO = control.ss(A, B, np.eye(2), np.zeros((2, 2)), states=["y", "z"], **NAMES)
LAW = control.ss(
    -20.0 * np.eye(2), 20.0 * np.eye(2), -GAINS, np.zeros((2, 2)), inputs=["y", "z"], outputs=["a", "b"]
)  # u = -K times the lagged outputs


def two_channels(gain=1.0, **options):
    law = control.ss(LAW.A, LAW.B, gain * LAW.C, LAW.D, inputs=["y", "z"], outputs=["a", "b"])
    return wb.linear_loop(wb.ClosedLoop(TWO, controller=LinearLaw(law)), **options)


def loop_gain(omega):
    """L = K (s/20 + 1)^-1 G at the inputs of the plant."""
    s = 1j * np.asarray(omega)[:, np.newaxis, np.newaxis]
    G = np.linalg.solve(s * np.eye(2) - A, B + 0j)
    return 20 / (s + 20) * (GAINS @ G)


def lines(panel):
    return [mark for mark in panel.series if isinstance(mark, Series) and mark.label != "" and mark.style != "aid"]


def named_points(panel):
    return [str(name) for mark in panel.series if isinstance(mark, Points) for name in mark.names if name]


@wb.block
class Cart(wb.Plant):
    """A cart on a spring: m p'' = F - c p' - k p + a p, which is not stable for a > k."""

    m: float = wb.parameter(default=1.0, unit="kg", low=0, strict=True)
    c: float = wb.parameter(default=0.4, unit="N s/m")
    k: float = wb.parameter(default=2.0, unit="N/m")
    p: float = wb.initial(default=0.0, unit="m")
    pd: float = wb.initial(default=0.0, unit="m/s")
    inputs, outputs = wb.layout(F="N"), wb.layout(p="m")

    def rate(self, t, x, u):
        return {"p": x.pd, "pd": (u.F - self.c * x.pd - self.k * x.p) / self.m}


@wb.block
class Lagged(wb.Controller):
    """F = g (p_ref - f), f' = (p - f) / T."""

    g: float = wb.parameter(default=1.0, unit="N/m")
    T: float = wb.parameter(default=0.2, unit="s")
    f: float = wb.initial(default=0.0, unit="m")
    reads = follows = wb.layout(p="m")
    drives = wb.layout(F="N")

    def command(self, t, z, est, ref):
        return {"F": self.g * (ref.p - z.f)}

    def rate(self, t, z, est, ref):
        return {"f": (est.p - z.f) / self.T}


CART = wb.linear_loop(wb.ClosedLoop(Cart(), controller=Lagged(), reference=wb.Step("p", "m", 1.0)))
