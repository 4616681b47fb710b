"""V2 of (36) and what (40) and (42) say of it, as margins along the repaired law in the first scenario."""

import casadi as ca
from paper_laws import ARM, proposed_repaired

from workbench.core import Claim
from workbench.core.claim import Declared, Signals
from workbench.verify.margins import SignalsOf, derivative

ODE = proposed_repaired("FS").ode("repaired")
GAIN = "controller.K"
FLOOR = 4.0  # N m, a c that lambda_min(K) - delta keeps in the runs that count


def V2(y: Signals) -> ca.SX:
    """(36)."""
    s, M = y["s"], ARM.mass_matrix(y["observer.state.q_hat"])
    value: ca.SX = ca.dot(s, M @ s) / 2 + ca.trace(y["controller.P"]) / 2
    return value


def c(y: Signals) -> ca.SX:
    """lambda_min(K) - |D - D_hat|, with K's symmetric part, in N m: the c of (40) with the least delta."""
    K = (y[GAIN] + y[GAIN].T) / 2
    least = (K[0, 0] + K[1, 1]) / 2 - ca.sqrt(((K[0, 0] - K[1, 1]) / 2) ** 2 + K[0, 1] ** 2)
    value: ca.SX = least - ca.norm_2(y["d_error"])
    return value


def _decreases(y: Signals) -> ca.SX:
    rate = derivative(ODE, V2(y))
    return ca.if_else(c(y) > 0, -rate - c(y) * ca.norm_2(y["s"]), 0)


def _at_start() -> float:
    """V2(0), in J: the estimates start at zero wherever the arm does, so it is the same in all runs."""
    value = ca.Function("V2", [ODE.t, ODE.x, ODE.p], [V2(SignalsOf(ODE))])
    return float(value(0, ODE.states.default, ODE.parameters.default))


V2_AT_START = _at_start()
GAIN_FLOOR = Claim(
    "lambda_min(K) - delta", f"lambda_min(K) - |D - D_hat| >= {FLOOR:g} N m.", "(40)", (), lambda y: c(y) - FLOOR
)
DECREASES = Declared(Claim("(40) along a run", "V2' <= -c |s| wherever c > 0.", "(40)", (), _decreases))
REACHES = Declared(
    Claim(
        "(42) along a run",
        "t |s(t)| <= V2(0) / c, which is (42) for all sigma at once.",
        "(42)",
        (GAIN_FLOOR,),
        lambda y: V2_AT_START / FLOOR - y["t"] * ca.norm_2(y["s"]),
    )
)
