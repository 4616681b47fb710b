"""A stirred tank reactor with three steady states."""

from __future__ import annotations

import casadi as ca

from workbench.core import block, initial, layout, parameter
from workbench.core.block import Number, Scalar, States
from workbench.loop.contracts import AbstractPlant, Inputs, Parts

MINUTE = 60.0  # s: rates of the book are per minute


@block
class StirredTank(AbstractPlant):
    """An irreversible exothermic reaction A -> B in a tank that a jacket of temperature T_c cools.

        c_A' = (q / V) (c_Af - c_A) - k_0 exp(-E_R / T) c_A
        T'   = (q / V) (T_f - T) + (dH / (rho C_p)) k_0 exp(-E_R / T) c_A + (U_A / (V rho C_p)) (T_c - T)

    with dH the heat that a mole sets free, and E_R = E / R. The numbers count minutes, as the book's do; the rates are
    in seconds. At T_c = 300 K the nominal point, c_A = 0.5 mol/l at 350 K, is the middle one of three steady states,
    a saddle.

    The numbers were read from programs that cite the book.

    References
    ----------
    Henson and Seborg (1997), Nonlinear Process Control, chapter 1; Seborg, Edgar, Mellichamp and Doyle (2011), Process
    Dynamics and Control, 3rd edition, example 2.5.

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

    def rate(self, t: Number, x: States, u: Inputs) -> Parts:
        c_A, T, heat = x["c_A"], x["T"], self.rho * self.C_p
        reacted = self.k_0 * ca.exp(-self.E_R / T) * c_A
        cooled = self.U_A / (self.V * heat) * (u["T_c"] - T)
        return {
            "c_A": (self.q / self.V * (self.c_Af - c_A) - reacted) / MINUTE,
            "T": (self.q / self.V * (self.T_f - T) + self.dH / heat * reacted + cooled) / MINUTE,
        }
