"""Both sides of the equations that the paper derives by substitution: (12), (13), (16), (18), (20), (37) and (38).

Accelerations, matrices and the mismatch are letters, so that each identity holds whatever they stand for.
"""

import casadi as ca

Sides = tuple[ca.SX, ca.SX]


def _symmetric(name: str) -> ca.SX:
    a, b, c = (ca.SX.sym(f"{name}{place}") for place in ("11", "12", "22"))
    return ca.blockcat([[a, b], [b, c]])


def derivations() -> dict[str, Sides]:
    """Both sides by the name of the equation."""
    x1, x2, x1_hat, x2_hat, f, f_hat, Delta = (
        ca.SX.sym(name, 2) for name in ("x1", "x2", "x1_hat", "x2_hat", "f", "f_hat", "Delta")
    )
    L1, L2 = ca.SX.sym("L1", 2, 2), ca.SX.sym("L2", 2, 2)
    P1, P2 = _symmetric("P1_"), _symmetric("P2_")
    e1, e2, rate1, rate2 = (ca.SX.sym(name, 2) for name in ("e1", "e2", "rate1", "rate2"))
    V1 = (ca.dot(e1, P1 @ e1) + ca.dot(e2, P2 @ e2)) / 2
    along = ca.jtimes(V1, ca.vertcat(e1, e2), ca.vertcat(rate1, rate2))
    by_18 = ca.dot(e1, P1 @ rate1) + ca.dot(e2, P2 @ rate2)
    by_19 = ca.substitute(by_18, ca.vertcat(rate1, rate2), ca.vertcat(e2 - L1 @ e1, Delta - L2 @ e1))
    by_20 = ca.dot(e1, P1 @ e2) + ca.dot(e2, P2 @ Delta) - ca.dot(e1, P1 @ L1 @ e1) - ca.dot(e2, P2 @ L2 @ e1)
    difference = f - (f_hat + L2 @ (x1 - x1_hat))  # x2' - x2_hat', by (9) and (10)
    return {
        "(12)": (x2 - (x2_hat + L1 @ (x1 - x1_hat)), (x2 - x2_hat) - L1 @ (x1 - x1_hat)),
        "(13)": (difference, f - f_hat - L2 @ (x1 - x1_hat)),
        "(16)": (difference, -L2 @ (x1 - x1_hat) + (f - f_hat)),
        "(18)": (along, by_18),
        "(20)": (by_19, by_20),
        "(37)": _decrease(),
        "(38)": _trace(),
    }


def _decrease() -> Sides:
    """V2' of (36) by the product rule and the second line of (30), and as (37) prints it."""
    s, rate, e2, torque, miss = (ca.SX.sym(name, 2) for name in ("s", "rate", "e2", "K_sat", "D_miss"))
    M, M_rate, P, P_rate = (_symmetric(name) for name in ("M_", "M_rate_", "P_", "P_rate_"))
    Lambda = ca.SX.sym("Lambda", 2, 2)
    V2 = (ca.dot(s, M @ s) + ca.trace(P)) / 2
    letters = ca.vertcat(s, *(part[place] for part in (M, P) for place in (0, 1, 3)))
    rates = ca.vertcat(rate, *(part[place] for part in (M_rate, P_rate) for place in (0, 1, 3)))
    along = ca.jtimes(V2, letters, rates)
    # M s' of the second line of (30), linear in the rate of s: its part in V2' is s^T M s'
    moved = -torque - miss + M @ Lambda @ e2
    linear = ca.substitute(along, rate, ca.SX.zeros(2)) + ca.dot(s, moved)
    printed = -ca.dot(s, torque) - ca.dot(s, miss) + ca.dot(s, M @ Lambda @ e2) + ca.dot(s, M_rate @ s) / 2
    return linear, printed + ca.trace(P_rate) / 2


def _trace() -> Sides:
    """The trace of (34), and (38)."""
    A, B, P, weight, Q = (ca.SX.sym(name, 2, 2) for name in ("A", "B", "P", "R_inverse", "Q"))
    right = A.T @ P + P @ A - P @ B @ weight @ B.T @ P + Q
    parts = ca.trace(A.T @ P + P @ A) - ca.trace(P @ B @ weight @ B.T @ P) + ca.trace(Q)
    return ca.trace(right), parts
