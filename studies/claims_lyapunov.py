"""V2 of (36) and what (40) and (42) say of it, as margins along the repaired law in the first scenario."""

import casadi as ca
from paper_laws import ARM, proposed_repaired

from workbench.core import Claim
from workbench.core.claim import Declared, Signals
from workbench.verify.margins import SignalsOf, derivative

ODE = proposed_repaired("FS").ode("repaired")
GAIN = "controller.K"
FLOOR = 4.0  # N m, a c that lambda_min(K) - delta keeps in the runs that count
ENOUGH = 2.0  # N m, a gain beyond any |D - D_hat|, which is at most twice D_max


def V2(y: Signals) -> ca.SX:
    """(36)."""
    s, M = y["s"], ARM.mass_matrix(y["observer.state.q_hat"])
    value: ca.SX = ca.dot(s, M @ s) / 2 + ca.trace(y["controller.P"]) / 2
    return value


def least_gain(y: Signals) -> ca.SX:
    """lambda_min of K's symmetric part, in N m."""
    K = (y[GAIN] + y[GAIN].T) / 2
    value: ca.SX = (K[0, 0] + K[1, 1]) / 2 - ca.sqrt(((K[0, 0] - K[1, 1]) / 2) ** 2 + K[0, 1] ** 2)
    return value


def _decreases(y: Signals) -> ca.SX:
    return ca.if_else(least_gain(y) >= ENOUGH, -derivative(ODE, V2(y)), 0)


def _at_start() -> float:
    """V2(0), in J: the estimates start at zero wherever the arm does, so it is the same in all runs."""
    value = ca.Function("V2", [ODE.t, ODE.x, ODE.p], [V2(SignalsOf(ODE))])
    return float(value(0, ODE.states.default, ODE.parameters.default))


V2_AT_START = _at_start()
GAIN_FLOOR = Claim(
    "c",
    f"lambda_min(K) - |D - D_hat| >= {FLOOR:g} N m.",
    "(40)",
    (),
    lambda y: least_gain(y) - ca.norm_2(y["d_error"]) - FLOOR,
)
DECREASES = Declared(
    Claim("V2 decreases", f"V2' <= 0 wherever lambda_min(K) >= {ENOUGH:g} N m.", "(40)", (), _decreases)
)
REACHES = Declared(
    Claim(
        "s is reached",
        "t |s(t)| <= V2(0) / c.",
        "(42)",
        (GAIN_FLOOR,),
        lambda y: V2_AT_START / FLOOR - y["t"] * ca.norm_2(y["s"]),
    )
)
