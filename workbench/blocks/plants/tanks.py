"""Tanks: four with two pumps, whose zero a valve moves, and a stirred reactor with three steady states."""

from __future__ import annotations

import math

import casadi as ca

from workbench.blocks.loop.contracts import AbstractPlant, Inputs, Parts
from workbench.core import block, initial, layout, parameter
from workbench.core.block import Number, Scalar, States
from workbench.core.shapes import Line, Shape, Word

MINUTE = 60.0  # s: rates of the reactor's book are per minute
COLD, HOT = 280.0, 440.0  # K, the ends of the drawn thermometer
HEIGHT = 0.20  # m, of the walls that are drawn of the four tanks


@block
class QuadrupleTank(AbstractPlant):
    """Four tanks with two pumps: each pump feeds one lower tank (1 or 2) and, crosswise, one upper tank (4 or 3).

        A_1 h_1' = -a_1 sqrt(2 g h_1) + a_3 sqrt(2 g h_3) + gamma_1 k_1 v_1
        A_2 h_2' = -a_2 sqrt(2 g h_2) + a_4 sqrt(2 g h_4) + gamma_2 k_2 v_2
        A_3 h_3' = -a_3 sqrt(2 g h_3) + (1 - gamma_2) k_2 v_2
        A_4 h_4' = -a_4 sqrt(2 g h_4) + (1 - gamma_1) k_1 v_1

    with A_3 = A_1, A_4 = A_2, a_3 = a_1 and a_4 = a_2. The upper tank 3 drains into tank 1, and 4 into 2. The
    multivariable zero that the valves move is in the left half-plane if gamma_1 + gamma_2 > 1. The default numbers are
    those of the setting P-, for which this holds; its published equilibrium is rounded. The outputs are levels in cm.
    The paper has the voltages of their sensors instead, 0.50 V/cm.

    Parameters
    ----------
    A_1, A_2
        Cross-section of tanks 1 and 3 (A_1), and of tanks 2 and 4 (A_2).
    a_1, a_2
        Cross-section of the outlets of tanks 1 and 3 (a_1), and of tanks 2 and 4 (a_2).
    k_1, k_2
        Flow of each pump per volt.
    gamma_1, gamma_2
        Fraction of the flow of each pump that the valve sends to the lower tank.
    g
        Gravitational acceleration.
    h_1, h_2, h_3, h_4
        Levels of the tanks.

    References
    ----------
    Johansson (2000), The quadruple-tank process: a multivariable laboratory process with an adjustable zero, IEEE TCST
    8, 456-465, equation (1); the numbers of both settings were read from programs that cite it.

    Examples
    --------
    >>> tanks = wb.QuadrupleTank()
    >>> linear = wb.linearize(wb.open_loop(tanks), 0.0, tanks.states.default)
    >>> np.sort(linear.zeros().real).round(4)
    array([-0.058 , -0.0172])
    """

    A_1: Scalar = parameter(default=28.0, unit="cm^2", low=0, strict=True)
    A_2: Scalar = parameter(default=32.0, unit="cm^2", low=0, strict=True)
    a_1: Scalar = parameter(default=0.071, unit="cm^2", low=0, strict=True)
    a_2: Scalar = parameter(default=0.057, unit="cm^2", low=0, strict=True)
    k_1: Scalar = parameter(default=3.33, unit="cm^3/(V s)", low=0, strict=True)
    k_2: Scalar = parameter(default=3.35, unit="cm^3/(V s)", low=0, strict=True)
    gamma_1: Scalar = parameter(default=0.70, unit="", low=0, high=1)
    gamma_2: Scalar = parameter(default=0.60, unit="", low=0, high=1)
    g: Scalar = parameter(default=981.0, unit="cm/s^2", low=0, strict=True)
    h_1: Scalar = initial(default=12.4, unit="cm")
    h_2: Scalar = initial(default=12.7, unit="cm")
    h_3: Scalar = initial(default=1.8, unit="cm")
    h_4: Scalar = initial(default=1.4, unit="cm")

    inputs = layout(v_1=("V", 3.0), v_2=("V", 3.0))
    outputs = layout(h_1="cm", h_2="cm")

    @staticmethod
    def nonminimum_phase() -> QuadrupleTank:
        """The setting P+, with a zero in the right half-plane. Its equilibrium is at 3.15 V for each pump."""
        return QuadrupleTank(k_1=3.14, k_2=3.29, gamma_1=0.43, gamma_2=0.34, h_1=12.6, h_2=13.0, h_3=4.8, h_4=4.9)

    def drawing(self, t: Number, x: States) -> tuple[Shape, ...]:
        """The four tanks with their levels. Each upper tank is drawn above the tank into which it drains."""
        shapes: list[Shape] = []
        for digit, left, floor in ((1, 0.0, 0.0), (2, 0.16, 0.0), (3, 0.0, 0.27), (4, 0.16, 0.27)):
            right = left + 0.02 * ca.sqrt((self.A_1 if digit in (1, 3) else self.A_2) / math.pi)  # 2 r, of cm in m
            level = floor + x[f"h_{digit}"] / 100.0
            middle = (left + right) / 2
            water = [(left, floor), (right, floor), (right, level), (left, level)]
            glass = [(left, floor + HEIGHT), (left, floor), (right, floor), (right, floor + HEIGHT)]
            shapes += [
                Line(water, "liquid", is_closed=True),
                Line(glass, "body", 0.003),
                Line([(middle, floor), (middle, floor - 0.03)], "liquid", 0.004),
                Word((middle, floor + 0.9 * HEIGHT), str(digit)),
            ]
        return tuple(shapes)

    def rate(self, t: Number, x: States, u: Inputs) -> Parts:
        feed_1, feed_2 = self.k_1 * u["v_1"], self.k_2 * u["v_2"]
        out_1, out_3 = (self.a_1 * ca.sqrt(2 * self.g * x[h]) for h in ("h_1", "h_3"))
        out_2, out_4 = (self.a_2 * ca.sqrt(2 * self.g * x[h]) for h in ("h_2", "h_4"))
        return {
            "h_1": (-out_1 + out_3 + self.gamma_1 * feed_1) / self.A_1,
            "h_2": (-out_2 + out_4 + self.gamma_2 * feed_2) / self.A_2,
            "h_3": (-out_3 + (1 - self.gamma_2) * feed_2) / self.A_1,
            "h_4": (-out_4 + (1 - self.gamma_1) * feed_1) / self.A_2,
        }


@block
class StirredTank(AbstractPlant):
    """A stirred-tank reactor with the exothermic reaction A -> B, cooled by a jacket of temperature T_c.

        c_A' = (q / V) (c_Af - c_A) - k_0 exp(-E_R / T) c_A
        T'   = (q / V) (T_f - T) + (dH / (rho C_p)) k_0 exp(-E_R / T) c_A + (U_A / (V rho C_p)) (T_c - T)

    These are the book's equations, per minute. The plant divides their rates by 60, as its time is in s. At T_c = 300 K
    there are three steady states. The nominal point, 0.5 mol/l at 350 K, is the middle one of them and a saddle.

    Parameters
    ----------
    q
        Flow through the tank.
    V
        Volume of the tank.
    rho
        Density of the content.
    C_p
        Specific heat of the content.
    dH
        Heat that the reaction of one mole releases.
    E_R
        Activation energy divided by the gas constant, E / R.
    k_0
        Pre-exponential factor of the reaction rate.
    U_A
        Heat transfer coefficient of the jacket times its area.
    T_f
        Temperature of the feed.
    c_Af
        Concentration of A in the feed.
    c_A
        Concentration of A in the tank.
    T
        Temperature in the tank.

    References
    ----------
    Henson and Seborg (1997), Nonlinear Process Control, chapter 1; Seborg et al. (2011), Process Dynamics and Control,
    3rd edition, example 2.5. The numbers were read from programs that cite the book.

    Examples
    --------
    >>> linear = wb.linearize(wb.open_loop(wb.StirredTank()), 0.0, [0.5, 350.0])
    >>> linear.input_labels, linear.output_labels, linear.poles().real.max().round(2)
    (['T_c'], ['T'], np.float64(0.05))
    """

    q: Scalar = parameter(default=100.0, unit="l/min", low=0, strict=True)
    V: Scalar = parameter(default=100.0, unit="l", low=0, strict=True)
    rho: Scalar = parameter(default=1000.0, unit="g/l", low=0, strict=True)
    C_p: Scalar = parameter(default=0.239, unit="J/(g K)", low=0, strict=True)
    dH: Scalar = parameter(default=5e4, unit="J/mol")
    E_R: Scalar = parameter(default=8750.0, unit="K", low=0)
    k_0: Scalar = parameter(default=7.2e10, unit="1/min", low=0)
    U_A: Scalar = parameter(default=5e4, unit="J/(min K)", low=0)
    T_f: Scalar = parameter(default=350.0, unit="K", low=0, strict=True)
    c_Af: Scalar = parameter(default=1.0, unit="mol/l", low=0)
    c_A: Scalar = initial(default=0.5, unit="mol/l")
    T: Scalar = initial(default=350.0, unit="K")

    inputs = layout(T_c=("K", 300.0))
    outputs = layout(T="K")

    def drawing(self, t: Number, x: States) -> tuple[Shape, ...]:
        """The tank, a gauge of the fraction c_A / c_Af that has not reacted, and a thermometer from 280 K to 440 K."""
        warm, share = (x["T"] - COLD) / (HOT - COLD), x["c_A"] / self.c_Af
        gauges: list[Shape] = []
        for left, height, letters in ((0.72, share, "A"), (0.92, warm, "T")):
            right = left + 0.08
            column = [(left, 0.0), (right, 0.0), (right, 0.6 * height), (left, 0.6 * height)]
            frame = [(left, 0.0), (right, 0.0), (right, 0.6), (left, 0.6)]
            gauges += [Line(column, "liquid", is_closed=True), Line([*frame, frame[0]], "body", 0.006)]
            gauges.append(Word((left + 0.04, -0.07), letters))
        return (
            Line([(0.0, 0.0), (0.5, 0.0), (0.5, 0.5), (0.0, 0.5)], "liquid", is_closed=True),
            Line([(0.0, 0.62), (0.0, 0.0), (0.5, 0.0), (0.5, 0.62)], "body", 0.012),
            Line([(0.25, 0.7), (0.25, 0.15)], "link", 0.012),
            Line([(0.15, 0.15), (0.35, 0.15)], "link", 0.03),
            *gauges,
        )

    def rate(self, t: Number, x: States, u: Inputs) -> Parts:
        c_A, T, heat = x["c_A"], x["T"], self.rho * self.C_p
        reacted = self.k_0 * ca.exp(-self.E_R / T) * c_A
        cooled = self.U_A / (self.V * heat) * (u["T_c"] - T)
        return {
            "c_A": (self.q / self.V * (self.c_Af - c_A) - reacted) / MINUTE,
            "T": (self.q / self.V * (self.T_f - T) + self.dH / heat * reacted + cooled) / MINUTE,
        }
