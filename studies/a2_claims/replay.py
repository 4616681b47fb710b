"""The names in the witnesses of a2: after `from studies.a2_claims.replay import *` each of their lines runs."""

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import casadi as ca
import numpy as np

import workbench as wb
from studies.a2_claims import searches
from studies.a2_claims.checks import at, observer_rate
from studies.a2_claims.checks import both as both
from studies.a2_claims.searches import (
    CONSTANT_D,
    STEP,
    V2,
    WITHIN_4,
    I,
    free_arm,
    gain_left,
    printed_filter,
    with_weights,
)
from studies.a2_claims.searches import beside_rest as beside_rest
from studies.a2_claims.searches import rerun as rerun
from studies.paper.card import CARD
from studies.paper.comparison import comparison
from studies.paper.laws import ARM, PRINTED_ARM, proposed_as_printed

FINE = 1e-3 / 12  # s, of the law as repaired
PAIRS = [(Q, R) for Q in (0.01, 1.0, 1000.0) for R in (0.1, 1.0, 1000.0)]  # N m/(rad s), of Q I and R I in (40)
printed_dynamics, derived_dynamics = wb.arms.Dynamics.of(PRINTED_ARM, "as printed"), wb.arms.Dynamics.of(ARM, "derived")
growing_modes = wb.proofs.growing_modes


def mismatch(q_hat: Any, tau: Any) -> float:
    """|Delta| of (14) in rad/s^2 for the arm hanging at rest, qd_hat = 0: (14) less its part in q_hat alone."""
    zero = ca.SX.zeros(2)
    M, _, G = at(zero, zero)
    M_hat, _, G_hat = at(ca.SX(q_hat), zero)
    return float(ca.evalf(ca.norm_2(ca.solve(M, tau - G) - ca.solve(M_hat, tau - G_hat))))


def speed_ratio(speed: float) -> float:
    """|Delta| / |x2~| of (14) in 1/s for q = q_hat = (0, 1), qd = speed (1, 0), qd_hat = 0, without torque.

    Gravity is the same at q and q_hat, so it is not part of Delta.
    """
    q, qd = ca.SX([0.0, 1.0]), ca.SX([speed, 0.0])
    M, C, _ = at(q, qd)
    return float(ca.evalf(ca.norm_2(ca.solve(M, C @ qd)))) / abs(speed)


def v1_rate(q: Any, x2: Any) -> tuple[float, float]:
    """V1' of (17) beside the arm at rest at q, with P2 = I, x1~ = 0, and x2~ = x2 or -x2, in rad^2/s^3."""
    weight, error = at(ca.SX(q), ca.SX.zeros(2))[2], ca.SX(x2)
    there, back = (-ca.dot(e, observer_rate(ARM, ca.SX(q), -e, weight)) for e in (error, -error))
    return float(ca.evalf(there)), float(ca.evalf(back))


def skewness(arm: wb.arms.Dynamics, q: Any, qd: Any) -> wb.Array:
    """M' - 2C plus its transpose, in kg m^2/s."""
    N = arm.mass_matrix_rate - 2 * arm.C
    return np.array(ca.Function("N", [arm.q, arm.qd, arm.symbols], [N + N.T])(q, qd, arm.p.default))


def false_rest(times: float = 1) -> wb.proofs.RestPoint:
    """Where (10), with so many times the gains of section 5, rests beside the hanging arm: with errors, not at zero."""
    near = np.array([-2.65, 6.28])
    return wb.proofs.rest_point(beside_rest(times * 30 * I, times * 50 * I), np.concatenate([near, times * 30 * near]))


def kept_by_drift() -> tuple[str, ...]:
    """Assumption 4, if the run of `drift` keeps it."""
    return wb.proofs.hypotheses_kept(printed_filter(), [WITHIN_4], 10.0, 1e-2)


def drift(until: float = 10.0) -> tuple[wb.Array, wb.Array]:
    """D_hat of (24) as printed, in N m s, for D = (0.5, 0.4) N m held so long: by its closed form and by a run."""
    l, D, ode = CARD["l"], np.array(CONSTANT_D), printed_filter()
    end = wb.reference_run(ode, times=[until])
    return D * (until - (1 - np.exp(-l * until)) / l), ode.states.unpack(end.x[0])["observer.disturbance.D_hat"]


def gain_lost(reading: str, until: float = 4.0, Q: float = 1.0, R: float = 1.0) -> tuple[float, float, int]:
    """The least leading minor of K, (33) as printed, in the second scenario; its error of the step; its order.

    The weights are Q I and R I. The unit is (N m)^order.
    """
    loop = with_weights(proposed_as_printed("SS", reading), Q, R)
    ode, gain = loop.ode(), wb.core.BlockClaim(wb.arms.laws.K_STAYS_DEFINITE, "controller.")
    found = wb.measure(
        wb.proofs.with_violations(ode, [gain]), (wb.proofs.violation(gain.claim),), until=until, h=STEP / 2
    )
    pairs = [score.pair for score in found.scores]
    worst = int(np.argmax([value for value, _ in pairs]))
    return -pairs[worst][0], pairs[worst][1], worst + 1


def cost(Q: float, R: float, until: float = 5.0) -> tuple[float, float]:
    """J of (32) for (31) with u = -R^-1 B^T P s by P(t) of (34), and the least J, both over an infinite horizon.

    A and B are those of section 5 at the start, held: M(0), K(0), Lambda; so are P(0) and s(0). The weights are Q I
    and R I. At `until` P is the algebraic solution, with which the rest of the cost is s^T P s.
    """
    M, _, _ = at(ca.SX.zeros(2), ca.SX.zeros(2))
    A, B = -np.linalg.solve(np.array(ca.evalf(M)), CARD["K(0)"]), np.diag(CARD["Lambda"])
    start = np.array([-2.0, -1.5])  # rad/s: s(0) = -qd_d(0) of the first scenario
    least = wb.riccati.care(A, B, Q * I, R * I).X
    states = wb.Layout((wb.core.Entry("P", CARD["P(0)"]), wb.core.Entry("s", start), wb.core.Entry("J", np.zeros(1))))
    t, x = ca.SX.sym("t"), states.symbols()
    z = states.view(x)
    P, s = z["P"], z["s"]
    u = -B.T @ P @ s / R
    rates: dict[str, ca.SX] = {
        "P": ca.SX(A.T @ P + P @ A - P @ B @ B.T @ P / R + Q * I),
        "s": ca.SX(A @ s + B @ u),
        "J": Q * ca.sumsqr(s) + R * ca.sumsqr(u),
    }
    ode = wb.Ode.of("(31) and (34)", states, wb.Layout(), (t, x, ca.SX(0, 1)), rates, {"J": z["J"]})
    end = ode.states.unpack(wb.reference_run(ode, times=[until], rtol=1e-9).x[0])
    return float(end["J"][0] + end["s"] @ least @ end["s"]), float(start @ least @ start)


def v2_rate(Q: float, R: float) -> tuple[float, float, float]:
    """V2' [W], |s| [rad/s] and lambda_min(K) - |D - D_hat| [N m] at the start of the printed law, C derived, in FS.

    The arm and its estimate start on the desired path; the weights are Q I and R I.
    """
    ode = with_weights(searches.printed_but_for_c(), Q, R).ode()
    y, path = wb.proofs.SignalsOf(ode), np.array([2.0, 1.5])  # rad/s, qd_d(0)
    x = ode.states.pack({"plant.q": np.zeros(2), "plant.qd": path, "observer.state.qd_hat": path})[0]
    wanted = [wb.proofs.derivative(ode, V2(y)), ca.norm_2(y["s"]), gain_left(y)]
    rate, speed, left = ca.Function("rate", [ode.t, ode.x, ode.p], wanted)(0, x, ode.parameters.default)
    return float(rate), float(speed), float(left)


def v2_over(weights: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """The answers of `v2_along` for several pairs (Q, R), from one batch of runs."""
    ode = searches.on_path().ode()

    def margin(y: Mapping[str, ca.SX]) -> ca.SX:
        s, M = y["s"], ARM.mass_matrix(y["plant.q"])
        V2_rate = wb.proofs.derivative(ode, ca.dot(s, M @ s) / 2 + ca.trace(y["controller.P"]) / 2)
        return -V2_rate - gain_left(y) * ca.norm_2(s)

    claim = wb.core.BlockClaim(wb.core.Claim("(40)", "V2' <= -c |s|.", "(40)", margin=margin))
    Q, R = (np.multiply.outer([pair[i] for pair in weights], I) for i in (0, 1))
    rows = ode.parameters.pack({"controller.Q": Q, "controller.R": R})
    found = wb.measure(
        wb.proofs.with_violations(ode, [claim]), (wb.proofs.violation(claim.claim),), rows, until=8.0, h=STEP
    )
    score = found.scores[0]
    return [(float(value), float(error)) for value, error in zip(score.value, score.error, strict=True)]


def v2_along(Q: float, R: float) -> tuple[float, float]:
    """The largest V2' + c |s| [W] within 8 s of the printed law, C derived, and its change by half of the step.

    The estimates obey (35) and start on the desired path of the first scenario; c is lambda_min(K) - |D - D_hat| at
    each instant, and the weights are Q I and R I.
    """
    (found,) = v2_over([(Q, R)])
    return found


@cache
def comparison_results() -> wb.Results:
    """The laws of a1 in both scenarios, each with all its metrics."""
    return wb.study.run(
        wb.Study("compared", "T", "Q?", "M.", lambda results: (), cases=(*comparison("FS"), *comparison("SS")))
    )


def beside(metric: str) -> dict[str, list[float]]:
    """A metric of the laws in both scenarios, joint by joint, as a1 measures it."""
    found = {one.case.name: one.measurement for one in comparison_results().outcomes if metric in one.measurement.names}
    return {name: [score.pair[0] for score in one.scores_of(metric)] for name, one in found.items()}


def astray(q: Any, qd: Any, until: float = 2.0) -> tuple[float, float]:
    """|q - q_hat| in rad at `until` for the arm without torque from (q, qd)(0), by variable steps; its error."""
    ode = free_arm()
    x0 = ode.states.pack({"plant.q": q, "plant.qd": qd})[0]
    y, error = wb.proofs.in_reference_mode(ode, "q_error", ode.parameters.default, x0, [until])
    return float(np.linalg.norm(y[0])), float(np.linalg.norm(error))


def share_astray(starts: wb.Array, bound: float = 5.0, until: float = 2.0) -> float:
    """The share of starts (q, qd)(0), rows (B, 4), with |q - q_hat| > bound [rad] at `until`."""
    ode = free_arm()
    x0 = ode.states.pack({"plant.q": starts[:, :2], "plant.qd": starts[:, 2:]})
    p = np.tile(ode.parameters.default, (len(x0), 1))
    runs = wb.simulate(wb.rk4(ode, 1e-3), p, x0, until=until, every=until)
    return float((~(np.linalg.norm(runs["q_error"][:, -1], axis=1) <= bound)).mean())


def offset(until: float = 20.0) -> tuple[wb.Array, wb.Array]:
    """q - q_d at the end of a long rest under D = (0.5, 0.4) N m, by the repaired law, and its change by h / 2."""
    ode = searches.regulation().ode()
    runs = (wb.measure(ode, (), until=until, h=h, every=until).trajectories for h in (FINE, FINE / 2))
    coarse, fine = (one["e"][0, -1] for one in runs)
    return fine, np.abs(fine - coarse)


def along_35(until: float = 20.0) -> dict[str, tuple[float, float]]:
    """The largest |e1| [rad] and |s| [rad/s] from 15 s on, where the estimates obey (35); their errors of the step."""
    late = (wb.metrics.late_error(15.0), wb.metrics.Peak("late s", "rad/s", "largest |s| from 15 s on", "s", 15.0))
    found = wb.measure(searches.on_path().ode(), late, until=until, h=STEP / 2)
    pairs = {name: [score.pair for score in found.scores_of(name)] for name in found.names}
    return {name: (max(v for v, _ in mine), max(e for _, e in mine)) for name, mine in pairs.items()}
