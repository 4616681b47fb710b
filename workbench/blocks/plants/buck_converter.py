from workbench.blocks.loop.contracts import AbstractPlant, Inputs, Parts
from workbench.core import block, initial, layout, parameter
from workbench.core.block import Number, Scalar, States


@block
class BuckConverter(AbstractPlant):
    """The averaged converter in continuous conduction, driven by its duty cycle d, 0 <= d <= 1.

        L i' = d V_g - v
        C v' = i - v / R

    From d to v it is G_0 / (1 + s / (Q w_0) + (s / w_0)^2) with G_0 = V_g, w_0 = 1 / sqrt(L C) and Q = R sqrt(C / L).
    The duty cycle is not limited here, and the current may turn negative: limit the command by `Instruments`.

    References
    ----------
    Erickson and Maksimovic (2001), Fundamentals of Power Electronics, 2nd edition, section 9.5.4; the numbers of its
    regulator of 15 V were quoted without the book at hand.

    Examples
    --------
    >>> linear = wb.linearize(wb.open_loop(wb.BuckConverter()), 0.0, [0.0, 0.0], u=[0.5])
    >>> linear.input_labels, linear.output_labels, np.sort(linear.poles()).round(1)
    (['d'], ['v'], array([-333.3-6315.8j, -333.3+6315.8j]))
    """

    V_g: Scalar = parameter(default=28.0, unit="V", low=0, strict=True)
    L: Scalar = parameter(default=50e-6, unit="H", low=0, strict=True)
    C: Scalar = parameter(default=500e-6, unit="F", low=0, strict=True)
    R: Scalar = parameter(default=3.0, unit="ohm", low=0, strict=True)
    i: Scalar = initial(default=0.0, unit="A")
    v: Scalar = initial(default=0.0, unit="V")

    inputs = layout(d="")
    outputs = layout(v="V")

    def rate(self, t: Number, x: States, u: Inputs) -> Parts:
        return {"i": (u["d"] * self.V_g - x["v"]) / self.L, "v": (x["i"] - x["v"] / self.R) / self.C}
