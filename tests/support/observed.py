"""Small plants that tests of observers watch, and laws beside them, written as a user writes them."""

import casadi as ca

from workbench.blocks.loop import AbstractController, AbstractPlant
from workbench.core import block, initial, layout, parameter
from workbench.core.block import Matrix, Scalar


@block
class Oscillator(AbstractPlant):
    """p'' = -w^2 p - c v + a, linear."""

    w: Scalar = parameter(2.0, unit="rad/s")
    c: Scalar = parameter(0.3, unit="1/s")
    p: Scalar = initial(1.0, unit="m")
    v: Scalar = initial(0.0, unit="m/s")
    inputs = layout(a="m/s^2")
    outputs = layout(p="m", v="m/s")

    def rate(self, t, x, u):
        return {"p": x.v, "v": -(self.w**2) * x.p - self.c * x.v + u.a}


@block
class Pendulum(AbstractPlant):
    """phi'' = -k sin phi - c omega + a, of which the height is an output too."""

    k: Scalar = parameter(9.0, unit="1/s^2")
    c: Scalar = parameter(0.2, unit="1/s")
    d: Scalar = parameter(0.0, unit="rad/s^2")
    phi: Scalar = initial(0.5, unit="rad")
    omega: Scalar = initial(0.0, unit="rad/s")
    inputs = layout(a="rad/s^2")
    outputs = layout(phi="rad", omega="rad/s", height="1")

    def measure(self, t, x):
        return {"phi": x.phi, "omega": x.omega, "height": 1 - ca.cos(x.phi)}

    def rate(self, t, x, u):
        return {"phi": x.omega, "omega": -self.k * ca.sin(x.phi) - self.c * x.omega + self.d + u.a}


@block
class CartPole(AbstractPlant):
    """The cart with an inverted pendulum of the control tutorials for MATLAB: phi is 0 upright."""

    M: Scalar = parameter(0.5, unit="kg")
    m: Scalar = parameter(0.2, unit="kg")
    b: Scalar = parameter(0.1, unit="N s/m")
    I: Scalar = parameter(0.006, unit="kg m^2")
    l: Scalar = parameter(0.3, unit="m")
    g: Scalar = parameter(9.8, unit="m/s^2")
    p: Scalar = initial(0.0, unit="m")
    v: Scalar = initial(0.0, unit="m/s")
    phi: Scalar = initial(0.0, unit="rad")
    omega: Scalar = initial(0.0, unit="rad/s")
    inputs = layout(F="N")
    outputs = layout(p="m", phi="rad")

    def rate(self, t, x, u):
        s, c, ml = ca.sin(x.phi), ca.cos(x.phi), self.m * self.l
        push = u.F - self.b * x.v - ml * x.omega**2 * s
        J, total = self.I + self.m * self.l**2, self.M + self.m
        det = total * J - (ml * c) ** 2
        dv = (J * push + ml**2 * self.g * s * c) / det
        return {"p": x.v, "v": dv, "phi": x.omega, "omega": ml * (self.g * s + c * dv) / J}


@block
class Swaying(AbstractController):
    """a = sin(3 t), which needs no estimate."""

    reads = layout()
    drives = layout(a="?")

    def command(self, t, z, est, ref):
        return {"a": ca.sin(3 * t)}


@block
class Constant(AbstractController):
    """a, always the same."""

    a: Scalar = parameter(unit="?")
    reads = layout()
    drives = layout(a="?")

    def command(self, t, z, est, ref):
        return {"a": self.a}


@block
class Balance(AbstractController):
    """F = -K x of the estimated states of `CartPole`."""

    K: Matrix = parameter(unit="?", shape=("1", "4"))
    reads = layout(p="m", v="m/s", phi="rad", omega="rad/s")
    drives = layout(F="N")

    def command(self, t, z, est, ref):
        return {"F": -self.K @ ca.vertcat(est.p, est.v, est.phi, est.omega)}
