"""V2 of (36), and what (42) says of it as a margin along the law as printed, but for C, in the first scenario."""

import casadi as ca

from studies.a2_claims import statements as paper
from studies.a2_claims.loops import printed_but_for_c
from studies.paper.laws import ARM
from workbench.claims.claim_margins import SignalsOf
from workbench.core import Claim
from workbench.core.claim import Declared, Signals

ODE = printed_but_for_c().ode("as printed but for C")
FLOOR = 2.0  # N m, a c that lambda_min(K) - delta keeps in the runs that count


def V2(y: Signals) -> ca.SX:
    """(36)."""
    s, M = y["s"], ARM.mass_matrix(y["observer.state.q_hat"])
    value: ca.SX = ca.dot(s, M @ s) / 2 + ca.trace(y["controller.P"]) / 2
    return value


def _at_start() -> float:
    """V2(0), in J: the estimates start at zero wherever the arm does, so it is the same in all runs."""
    value = ca.Function("V2", [ODE.t, ODE.x, ODE.p], [V2(SignalsOf(ODE))])
    return float(value(0, ODE.states.default, ODE.parameters.default))


V2_AT_START = _at_start()
GAIN_FLOOR = Claim(
    "c", f"lambda_min(K) - |D - D_hat| >= {FLOOR:g} N m.", "(40)", (), lambda y: paper.gain_left(y) - FLOOR
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
