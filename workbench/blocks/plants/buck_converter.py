from workbench.blocks.loop.contracts import AbstractPlant, Inputs, Parts
from workbench.core import block, initial, layout, parameter
from workbench.core.block import Number, Scalar, States


@block
class BuckConverter(AbstractPlant):
    """The averaged model of a buck converter in continuous conduction, with the duty cycle d as its input.

        L i' = d V_g - v
        C v' = i - v / R

    The transfer function from d to v is G_0 / (1 + s / (Q w_0) + (s / w_0)^2) with G_0 = V_g, w_0 = 1 / sqrt(L C) and
    Q = R sqrt(C / L). The model does not limit d to 0 <= d <= 1, and the current may become negative. Limit the command
    by `Instruments`.

    Parameters
    ----------
    V_g
        Input voltage.
    L
        Inductance of the filter.
    C
        Capacitance of the filter.
    R
        Resistance of the load.
    i
        Current of the inductor.
    v
        Output voltage.

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
