import casadi as ca

from workbench.core import block, initial, layout, parameter
from workbench.core.block import Number, Scalar, States
from workbench.loop.contracts import AbstractPlant, Inputs, Parts


@block
class SingleTrackVehicle(AbstractPlant):
    """The bicycle model at a constant speed V_x, steered at the front wheels by delta.

        m (v_y' + V_x r) = F_f + F_r,     F_f = 2 C_f (delta - (v_y + l_f r) / V_x)
        I_z r' = l_f F_f - l_r F_r,       F_r = -2 C_r (v_y - l_r r) / V_x
        psi' = r,                         Y' = V_x sin(psi) + v_y cos(psi)

    v_y is the velocity to the left and r the yaw rate of the body, Y and psi its place and heading on the ground; C_f
    and C_r are the cornering stiffness of one tyre. Slip angles are small, and tyres do not saturate.

    References
    ----------
    Rajamani (2012), Vehicle Dynamics and Control, 2nd edition, sections 2.3 and 3.3; the numbers of a passenger car
    were read from programs that implement it, and the speed is an assumption.

    Examples
    --------
    >>> car = wb.SingleTrackVehicle()
    >>> car.states.names, car.inputs.names, car.outputs.names
    (('Y', 'psi', 'v_y', 'r'), ('delta',), ('Y', 'psi', 'r'))
    """

    m: Scalar = parameter(default=1573.0, unit="kg", low=0, strict=True)
    I_z: Scalar = parameter(default=2873.0, unit="kg m^2", low=0, strict=True)
    l_f: Scalar = parameter(default=1.1, unit="m", low=0, strict=True)
    l_r: Scalar = parameter(default=1.58, unit="m", low=0, strict=True)
    C_f: Scalar = parameter(default=80_000.0, unit="N/rad", low=0, strict=True)
    C_r: Scalar = parameter(default=80_000.0, unit="N/rad", low=0, strict=True)
    V_x: Scalar = parameter(default=30.0, unit="m/s", low=0, strict=True)
    Y: Scalar = initial(default=0.0, unit="m")
    psi: Scalar = initial(default=0.0, unit="rad")
    v_y: Scalar = initial(default=0.0, unit="m/s")
    r: Scalar = initial(default=0.0, unit="rad/s")

    inputs = layout(delta="rad")
    outputs = layout(Y="m", psi="rad", r="rad/s")

    def rate(self, t: Number, x: States, u: Inputs) -> Parts:
        v_y, r = x["v_y"], x["r"]
        F_f = 2 * self.C_f * (u["delta"] - (v_y + self.l_f * r) / self.V_x)
        F_r = -2 * self.C_r * (v_y - self.l_r * r) / self.V_x
        return {
            "Y": self.V_x * ca.sin(x["psi"]) + v_y * ca.cos(x["psi"]),
            "psi": r,
            "v_y": (F_f + F_r) / self.m - self.V_x * r,
            "r": (self.l_f * F_f - self.l_r * F_r) / self.I_z,
        }
