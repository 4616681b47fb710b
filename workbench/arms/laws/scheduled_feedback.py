from __future__ import annotations

import casadi as ca
import numpy as np

from workbench.arms.arm_contracts import AbstractArmController
from workbench.arms.dynamics import AbstractArm
from workbench.arms.laws.arm_state_feedback import halves
from workbench.blocks.loop.contracts import Follows, Parts, Reads
from workbench.core import block, option, parameter
from workbench.core.block import Matrix, Number, Scalar
from workbench.core.validation.refusals import numbers, refusal

SERIES = {
    "chebyshev": "sum of c_k T_k(2 t / horizon - 1), k = 0, 1, ...; from the horizon on, its value there",
    "fourier": "c_0 + sum of c_2k-1 cos(2 pi k t / horizon) + c_2k sin(2 pi k t / horizon); periodic",
}


@block
class ScheduledFeedback(AbstractArmController):
    """Feedforward along the reference, and linear feedback whose gain varies in time:

        tau = tau_ref - Kp(t) e - Kd(t) ed,       e = q - q_ref,
        tau_ref = M qdd_ref + C qd_ref + G        at q_ref, qd_ref, of `model`

    With [Kp Kd](t) = R^-1 B' P(t), P the solution of the differential Riccati equation backward along the reference,
    this is the time-varying LQR. The coefficients Kp, Kd (terms, n n) are those of a `series` in time, a row for an (n,
    n) matrix row by row; `horizon` is where a Chebyshev series ends, and stays as it is, or the period of a Fourier
    series.

    References
    ----------
    Anderson and Moore (1990), Optimal Control: Linear Quadratic Methods, chapter 2.
    Trefethen (2013), Approximation Theory and Approximation Practice, chapter 3.

    Examples
    --------
    >>> from workbench.arms.laws import ScheduledFeedback
    >>> law = ScheduledFeedback.of(wb.paper_arm(), np.full((3, 2, 4), 10.0), horizon=2.0, series="chebyshev")
    >>> plant, wanted = wb.Manipulator(wb.paper_arm(), q=[0.5, 0.0]), wb.Sines("q", "rad", [1.0, 0.5], [2.0, 3.0])
    >>> wb.ClosedLoop(plant, controller=law, reference=wanted).ode().states.size
    4
    """

    model: AbstractArm
    horizon: Scalar = parameter(unit="s", low=0, strict=True, symbol="t_f")
    Kp: Matrix = parameter(unit="{force}/{position}", shape=("terms", "entries"), symbol="K_p")
    Kd: Matrix = parameter(unit="{force} s/{position}", shape=("terms", "entries"), symbol="K_d")
    series: str = option(SERIES, default="chebyshev")

    def __post_init__(self) -> None:
        if self.Kp.shape[1] != self.dof**2:
            raise ValueError(
                f"`ScheduledFeedback(Kp=...)` must have {self.dof**2} columns, a matrix ({self.dof}, {self.dof}) row "
                f"by row; got shape {self.Kp.shape}."
            )
        if self.series == "fourier" and len(self.Kp) % 2 == 0:
            raise ValueError(
                "`ScheduledFeedback(series='fourier')` needs an odd number of terms, a mean and then a cosine and a "
                f"sine of each frequency; got {len(self.Kp)}."
            )

    @staticmethod
    def of(model: AbstractArm, coefficients: object, horizon: float, series: str = "chebyshev") -> ScheduledFeedback:
        """The law u = -K(t) [e; ed], with the coefficients (terms, n, 2n) of K."""
        Kp, Kd = halves("ScheduledFeedback.of(coefficients=...)", coefficients, model.dof, model.dof)
        if Kp.ndim != 3 or not len(Kp):
            must = "an array (terms, n, 2n), one matrix for each term"
            raise refusal("ScheduledFeedback.of(coefficients=...)", must, numbers("", coefficients))
        return ScheduledFeedback(model, horizon, Kp.reshape(len(Kp), -1), Kd.reshape(len(Kd), -1), series)

    def torque(self, t: Number, z: Parts, est: Reads, ref: Follows) -> ca.SX:
        e, ed = est.q - ref.q, est.qd - ref.qd
        Kp, Kd = self.gains(t)
        tau: ca.SX = self.model.torque(ref.q, ref.qd, ref.qdd) - Kp @ e - Kd @ ed
        return tau

    def gains(self, t: Number) -> tuple[ca.SX, ca.SX]:
        """Kp(t) and Kd(t), each (n, n)."""
        terms = self.Kp.shape[0]
        kind = _chebyshev if self.series == "chebyshev" else _fourier
        basis = kind(ca.SX(t), self.horizon, terms).T
        n = self.dof
        Kp, Kd = (ca.reshape(basis @ K, n, n).T for K in (self.Kp, self.Kd))
        return Kp, Kd


def _chebyshev(t: ca.SX, horizon: Scalar, terms: int) -> ca.SX:
    """T_k(x), (terms, 1), at x = 2 t / horizon - 1 within -1 and 1."""
    x = ca.fmax(ca.fmin(2 * t / horizon - 1, 1), -1)
    T = [ca.SX(1), x]
    while len(T) < terms:
        T.append(2 * x * T[-1] - T[-2])
    basis: ca.SX = ca.vertcat(*T[:terms])
    return basis


def _fourier(t: ca.SX, period: Scalar, terms: int) -> ca.SX:
    """1, cos wt, sin wt, cos 2wt, ..., (terms, 1), with w = 2 pi / period."""
    w = 2 * np.pi / period
    waves = [wave(k * w * t) for k in range(1, terms // 2 + 1) for wave in (ca.cos, ca.sin)]
    basis: ca.SX = ca.vertcat(ca.SX(1), *waves)
    return basis
