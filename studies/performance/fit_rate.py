"""The time of a fit of ten parameters of an arm with friction, beside SciPy's least squares over LSODA."""

from __future__ import annotations

from statistics import median

import casadi as ca
import numpy as np

import workbench as wb
from studies.performance.measurements import Effort, Row, cpu_seconds
from studies.performance.scipy_fit import GRAVITY, LENGTH, Differences, ScipyEnd, run_arm, scipy_estimate

NAME = "fit of ten parameters of the arm, SciPy with LSODA"
BAR = 20.0
RATE = 1000.0  # Hz
SIGMA = 1e-3  # rad, of the noise of both angles
SAME = 1e-3  # standard errors between both estimates
START = (1.2, 0.8, 1.2, 0.8, 1.3, 0.7, 1.2, 0.8, 1.3, 0.7)  # of each parameter, over its true value
LOOSE, TIGHT = (
    1e-7,
    1e-10,
)  # tolerances of LSODA: the coarsest that converges, and the coarsest that ends as near as SAME


@wb.block
class FrictionArm(wb.Plant):
    """Two links in a vertical plane in base parameters, with viscous and smooth Coulomb friction.

    M(q) q'' + C(q, q') q' + G(q) + b q' + f tanh(q' / w) = u.  Inertias J, first moments s, and l of the first link.
    """

    J1: float = wb.parameter(default=1.2, unit="kg m^2", low=0, strict=True)
    J2: float = wb.parameter(default=0.3, unit="kg m^2", low=0, strict=True)
    s1: float = wb.parameter(default=2.4, unit="kg m", low=0)
    s2: float = wb.parameter(default=0.6, unit="kg m", low=0)
    b1: float = wb.parameter(default=0.8, unit="N m s/rad", low=0)
    b2: float = wb.parameter(default=0.4, unit="N m s/rad", low=0)
    f1: float = wb.parameter(default=1.0, unit="N m", low=0)
    f2: float = wb.parameter(default=0.5, unit="N m", low=0)
    w1: float = wb.parameter(default=0.3, unit="rad/s", low=0, strict=True)
    w2: float = wb.parameter(default=0.3, unit="rad/s", low=0, strict=True)
    q1: float = wb.initial(default=0.0, unit="rad")
    q2: float = wb.initial(default=0.0, unit="rad")
    v1: float = wb.initial(default=0.0, unit="rad/s")
    v2: float = wb.initial(default=0.0, unit="rad/s")

    inputs = wb.layout(u1="N m", u2="N m")
    outputs = wb.layout(q1="rad", q2="rad")

    def rate(self, t: ca.SX, x: wb.loop.Parts, u: wb.loop.Parts) -> wb.loop.Parts:
        q1, q2, v1, v2 = (x[name] for name in ("q1", "q2", "v1", "v2"))
        c, s = (LENGTH * self.s2 * part for part in (ca.cos(q2), ca.sin(q2)))
        M11, M12, low = self.J1 + self.J2 + 2 * c, self.J2 + c, GRAVITY * self.s2 * ca.sin(q1 + q2)
        r1 = u["u1"] + s * (2 * v1 * v2 + v2**2) - GRAVITY * self.s1 * ca.sin(q1) - low
        r1 -= self.b1 * v1 + self.f1 * ca.tanh(v1 / self.w1)
        r2 = u["u2"] - s * v1**2 - low - self.b2 * v2 - self.f2 * ca.tanh(v2 / self.w2)
        det = M11 * self.J2 - M12**2
        return {"q1": v1, "q2": v2, "v1": (self.J2 * r1 - M12 * r2) / det, "v2": (M11 * r2 - M12 * r1) / det}


def torques(t: wb.Array) -> wb.Array:
    """Three sines for each joint (N, 2) in N m, which keep the arm within 2 rad of the vertical."""
    first = 9 * np.sin(1.95 * t) + 5 * np.sin(4.84 * t + 1) + 3 * np.sin(11.9 * t)
    second = 2.2 * np.sin(2.95 * t + 0.5) + 1.2 * np.sin(8.17 * t) + np.sin(14.5 * t + 2)
    return np.column_stack([first, second])


def arm_log(t: wb.Array, truth: wb.Array) -> wb.Dataset:
    """The torques and the noisy angles of the arm, which SciPy runs."""
    u = torques(t)
    q = run_arm(truth, t, u, 1e-12) + SIGMA * np.random.default_rng(1).standard_normal((len(t), 2))
    columns = {"u1": u[:, 0], "u2": u[:, 1], "q1": q[:, 0], "q2": q[:, 1]}
    return wb.Dataset.of(t, columns, {"u1": "N m", "u2": "N m", "q1": "rad", "q2": "rad"})


def fit_rows(effort: Effort) -> tuple[Row, ...]:
    """The row of the ratio of the times of both, at the same estimates.

    SciPy first comes near the minimum at a coarse tolerance, and from there goes on at the coarsest one that ends as
    near to it as we ask. All its runs at the fine tolerance from the start would take several times as long.
    """
    arm = wb.open_loop(FrictionArm())
    truth = arm.parameters.default[: len(START)]
    log = arm_log(np.arange(round(effort.horizon * RATE) + 1) / RATE, truth)
    names, start, noise = arm.parameters.labels[: len(START)], truth * START, {"q1": SIGMA, "q2": SIGMA}
    begin = dict(zip(names, start.tolist(), strict=True))
    if not wb.identifiability(arm, log, names, ["q1", "q2"], hold="linear").is_complete:
        raise ValueError("`fit_rows(effort=...)` needs a log that tells all parameters: let it last longer.")
    fits: list[wb.identification.Fit] = []
    ends: list[ScipyEnd] = []

    def ours() -> float:
        return cpu_seconds(
            lambda: fits.append(wb.fit(arm, log, names, noise=noise, hold="linear", start=begin, hold_out=0.0))
        )

    def theirs(first: wb.Array, tolerance: float, differences: Differences) -> float:
        t, u, q = log.experiments[0].t, *(np.column_stack([log[n] for n in pair]) for pair in (("u1", "u2"), noise))
        return cpu_seconds(lambda: ends.append(scipy_estimate(t, u, q, first, tolerance, differences)))

    with wb.study.one_core():
        cold = ours()  # with the compilation of the step, if its kernel is not on the disk
        times = [ours()]
        coarse = theirs(start, LOOSE, "2-point")
        times.append(ours())
        fine = theirs(ends[0].theta, TIGHT, "3-point")
        times += [ours() for _ in range(effort.repetitions)]
    apart = [np.abs(end.theta - fits[-1].theta) / list(fits[-1].standard_errors.values()) for end in ends]
    near, mine = float(apart[1].max()), median(times)
    note = (
        f"CPU time for {len(log.experiments[0]):,} samples of two angles. Ours takes {mine:.2f} s, and {cold:.2f} s "
        f"in the first call. LSODA at {LOOSE:.0e} takes {coarse:.1f} s in {ends[0].runs} runs and ends "
        f"{apart[0].max():.2g} standard errors away; going on at {TIGHT:.0e}, it takes {fine:.0f} s more in "
        f"{ends[1].runs} runs and ends {near:.1e} away"
    )
    if near > SAME:
        return (Row(NAME, BAR, note=f"not measured, as both end apart by more than {SAME:g} standard errors. {note}"),)
    return (Row(NAME, BAR, (coarse + fine) / mine, note=note),)
