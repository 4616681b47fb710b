"""Claims that a run can break, with the margin that each leaves along it."""

import casadi as ca

from studies.a2_claims.loops import printed_but_for_c
from studies.paper.laws import ARM
from workbench.claims.claim_margins import SignalsOf
from workbench.core import Claim
from workbench.core.claim import Declared, Signals

D_MAX, L_D = 0.65, 2.2  # N m, N m/s: Assumption 4 in numbers, just above the needs of both scenarios
FLOOR = 2.0  # N m, a c that lambda_min(K) - delta keeps in the runs that count
ODE = printed_but_for_c().ode("as printed but for C")


def gain_left(y: Signals) -> ca.SX:
    """lambda_min(K) - |D - D_hat|, in N m: the c of (40) at an instant."""
    K = (y["controller.K"] + y["controller.K"].T) / 2
    least = (K[0, 0] + K[1, 1]) / 2 - ca.sqrt(((K[0, 0] - K[1, 1]) / 2) ** 2 + K[0, 1] ** 2)
    return least - ca.norm_2(y["d_error"])


def V2(y: Signals) -> ca.SX:
    """(36)."""
    s, M = y["s"], ARM.mass_matrix(y["observer.state.q_hat"])
    return ca.dot(s, M @ s) / 2 + ca.trace(y["controller.P"]) / 2


# In J: the estimates start at zero wherever the arm does, so it is the same in all runs.
V2_AT_START = float(
    ca.Function("V2", [ODE.t, ODE.x, ODE.p], [V2(SignalsOf(ODE))])(0, ODE.states.default, ODE.parameters.default)
)


def late(after: float, bound: float) -> Declared:
    """A part of Theorem 1 that a run of finite length can break: |q - q_hat| <= bound [rad] from `after` s on."""

    def margin(y: Signals) -> ca.SX:
        return ca.if_else(y["t"] < after, 1e3, bound**2 - ca.sumsqr(y["q_error"]))

    return Declared(Claim("late", f"|q - q_hat| <= {bound:g} rad from {after:g} s on.", "(23)", (), margin))


ASSUMPTION_4 = Claim(
    "Assumption 4",
    "|D(t)| <= D_max and |D'(t)| <= L_D in both scenarios.",
    "(8)",
    margin=lambda y: ca.vertcat(D_MAX**2 - ca.sumsqr(y["d"]), L_D**2 - ca.sumsqr(y["d'"])),
)
ABOVE = Claim("lambda_min(K) > delta", "lambda_min(K) >= |D - D_hat| at all times.", "(40)", margin=gain_left)
GAIN_FLOOR = Claim("c", f"lambda_min(K) - |D - D_hat| >= {FLOOR:g} N m.", "(40)", (), lambda y: gain_left(y) - FLOOR)
REACHES = Claim(
    "s is reached",
    "t |s(t)| <= V2(0) / c.",
    "(42)",
    (GAIN_FLOOR,),
    lambda y: V2_AT_START / FLOOR - y["t"] * ca.norm_2(y["s"]),
)
SLOW = Claim(
    "slow",
    "|qd| and |qd_hat| are below 10^6 rad/s.",
    "Theorem 2",
    margin=lambda y: 1e6 - ca.vertcat(ca.norm_2(y["plant.qd"]), ca.norm_2(y["observer.state.qd_hat"])),
)
WITHIN_4 = Declared(ASSUMPTION_4)
KEPT = (WITHIN_4, Declared(ABOVE))  # what the proof of Theorem 2 asks of each run
