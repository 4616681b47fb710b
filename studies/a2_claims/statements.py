"""What the AOSMC-RGS paper claims, with its equations and hypotheses, as data for the ledger."""

import casadi as ca

from workbench.core import Claim
from workbench.core.claim import Signals

D_MAX, L_D = 0.65, 2.2  # N m, N m/s: Assumption 4 in numbers, just above the needs of both scenarios


def least_gain(y: Signals) -> ca.SX:
    """lambda_min of the symmetric part of K, in N m."""
    K = (y["controller.K"] + y["controller.K"].T) / 2
    value: ca.SX = (K[0, 0] + K[1, 1]) / 2 - ca.sqrt(((K[0, 0] - K[1, 1]) / 2) ** 2 + K[0, 1] ** 2)
    return value


def gain_left(y: Signals) -> ca.SX:
    """lambda_min(K) - |D - D_hat|, in N m: the c of (40) at an instant."""
    value: ca.SX = least_gain(y) - ca.norm_2(y["d_error"])
    return value


def _bounded(y: Signals) -> ca.SX:
    return ca.vertcat(D_MAX**2 - ca.sumsqr(y["d"]), L_D**2 - ca.sumsqr(y["d'"]))


INERTIA = Claim("(2)", "M is the inertia matrix of the arm.", "(2)")
CORIOLIS = Claim("(3)", "C is the Coriolis matrix of the arm.", "(3)")
GRAVITY = Claim("(4)", "G is the gravity vector of the arm.", "(4)")

ASSUMPTION_1 = Claim("Assumption 1", "The initial states lie in a bounded set.", "(5), (6)")
ASSUMPTION_2 = Claim(
    "Assumption 2", "M is symmetric, and alpha1 I <= M(q) <= alpha2 I for all q, alpha1 > 0.", "(7)", (INERTIA,)
)
ASSUMPTION_3 = Claim("Assumption 3", "M' - 2C is skew-symmetric, with C as (3) prints it.", "(3), section 2.3")
ASSUMPTION_3_DERIVED = Claim("Assumption 3, derived C", "M' - 2C is skew-symmetric, with C as derived.", "section 2.3")
ASSUMPTION_4 = Claim("Assumption 4", "|D(t)| <= D_max and |D'(t)| <= L_D in both scenarios.", "(8)", margin=_bounded)
ABOVE = Claim("lambda_min(K) > delta", "lambda_min(K) >= |D - D_hat| at all times.", "(40)", margin=gain_left)
ASSUMPTIONS = (ASSUMPTION_1, ASSUMPTION_2, ASSUMPTION_3_DERIVED, ASSUMPTION_4)

LIPSCHITZ = Claim(
    "(15)", "The mismatch of (14) has |Delta| <= rho (|x1~| + |x2~|) with one rho for all states and torques.", "(15)"
)
LYAPUNOV = Claim(
    "(22)",
    "V1 = x1~^T P1 x1~ / 2 + x2~^T P2 x2~ / 2 has V1' <= -alpha V1 for some P1, P2, L1, L2.",
    "(17), (22)",
    (LIPSCHITZ,),
)
PAPER_GAINS = Claim(
    "Theorem 1, gains of section 5",
    "With L1 = 30 I, L2 = 50 I the errors of (10) tend to zero from every initial estimate.",
    "Theorem 1, section 5",
    (ASSUMPTION_2, LYAPUNOV),
)
NEAR_ZERO = Claim(
    "Theorem 1, small errors at rest",
    "With L1 = 30 I, L2 = 50 I small errors of (10) decay beside the arm at rest, hanging or upright.",
    "Theorem 1, section 5",
)
DISTURBANCE_OBSERVER = Claim("(24)", "D_hat, the integral of eta, tends to D.", "(24)", (ASSUMPTION_4,))

RATE_ALONG_10 = Claim("(30), along (10)", "The first line of (30) is ds/dt along the observer (10).", "(10), (30)")
RATE_ALONG_35 = Claim(
    "(30), along (35)", "The first line of (30) is ds/dt where the estimates obey (35), x1~ = 0.", "(30), (35)"
)
SUBSTITUTED = Claim("(30), second line", "The second line of (30) follows from the first by (27)-(29).", "(27)-(30)")
REPAIRED_RATE = Claim(
    "(30), repaired",
    "With qd_r = qd_d - Lambda e1 in (28) for qd_d, M s' + C s = -K sat(s / phi) + D_hat - D along (35).",
    "(28), (35), repaired",
)
LINEARISED = Claim(
    "(31)",
    "Within the layer, with sat(s / phi) replaced by s, s' is approximately -M^-1 K s + Lambda e2 where D_hat = D.",
    "(31)",
    (RATE_ALONG_10, SUBSTITUTED),
)
SHAPES = Claim("(33), shapes", "-P s sign(s) is a matrix, as K' is.", "(33)")
ANY_WEIGHTS = "For all Q, R > 0, of which the paper states none,"
GAIN = Claim(
    "(33), gain", f"{ANY_WEIGHTS} K(t) of (33) stays positive definite, as (29) asks.", "(29), (33)", (SHAPES,)
)
OPTIMAL_INPUT = Claim(
    "(34), input", "u = e2 is the input -R^-1 B^T P s with which the Riccati equation minimises (32).", "(31)-(34)"
)
OPTIMAL = Claim(
    "(34), cost",
    f"{ANY_WEIGHTS} u = -R^-1 B^T P s with P(t) of (34) makes (32) least for (31).",
    "(31), (32), (34)",
)
OPTIMAL_LOOP = Claim(
    "(34), cost of the loop",
    f"{ANY_WEIGHTS} (32), with s and e2 of the closed loop, is less with P(t) of (34) than with P(t) = P(0).",
    "(32), (34)",
    (LINEARISED, OPTIMAL_INPUT),
)

REWRITTEN = Claim(
    "(35)", "The estimates of (10) obey (35), M(q_hat) qd_hat' + C qd_hat + G + D = tau, where x1~ = 0.", "(10), (35)"
)
DECREASE = Claim("(39)", "V2' <= -lambda_min(K) |s| + |s| delta + 'bounded term'.", "(39)", (ASSUMPTION_3, GAIN))
DECREASE_STRICT = Claim(
    "(40)", f"{ANY_WEIGHTS} V2' <= -c |s| with c = lambda_min(K) - delta > 0.", "(40)", (ABOVE, DECREASE, OPTIMAL)
)
CONVERGENCE_35 = Claim(
    "(41), along (35)",
    f"{ANY_WEIGHTS} s and e1 tend to zero under every disturbance of Assumption 4 where the estimates obey (35).",
    "(35), (41)",
    (ASSUMPTION_4, ABOVE, DECREASE_STRICT),
)
CONVERGENCE_10 = Claim(
    "(41), along (10)",
    f"{ANY_WEIGHTS} s and e1 tend to zero under every disturbance of Assumption 4 where the estimates obey (10).",
    "(10), (41)",
    (ASSUMPTION_4, ABOVE, REWRITTEN, DECREASE_STRICT),
)
FINITE_TIME = Claim(
    "(42)",
    f"{ANY_WEIGHTS} |s(t)| <= sigma from t = V2(0) / (c sigma) on, for every precision sigma; C is derived.",
    "(42)",
    (ASSUMPTION_4, ABOVE, DECREASE_STRICT),
)
BOUNDED = Claim(
    "Theorem 2, bounded signals",
    f"{ANY_WEIGHTS} all signals of the loop stay bounded, as printed but for C, which is derived.",
    "Theorem 2",
    ASSUMPTIONS,
)
BOUNDED_ABOVE = Claim(
    "Theorem 2, bounded velocities",
    "With the gain of its proof, lambda_min(K) > delta, |qd| and |qd_hat| stay below 1e6 rad/s; C is derived.",
    "Theorem 2, as read here",
    (*ASSUMPTIONS, ABOVE),
)

TRACKING = Claim("superior tracking", "AOSMC-RGS tracks better than each rival, by the printed RMSE.", "section 5")
STEADY = Claim("lower steady-state error", "The steady-state error of AOSMC-RGS is below each rival's.", "section 5")
AMPLITUDE = Claim("smaller control amplitude", "AOSMC-RGS has smaller torques than each rival.", "section 5")
CHATTERING = Claim("less chattering", "AOSMC-RGS chatters less than each rival.", "section 5")
OVERSHOOT = Claim("reduced overshoot", "AOSMC-RGS overshoots less than each rival.", "abstract, section 5")
SETTLING = Claim("faster settling", "AOSMC-RGS settles faster than each rival.", "abstract, section 5")
EFFORT = Claim("lower control effort", "AOSMC-RGS needs less control effort than each rival.", "abstract")
REJECTION = Claim(
    "better disturbance rejection", "AOSMC-RGS rejects disturbances better than each rival.", "abstract, sections 5, 6"
)
ACCURACY = Claim("observer accuracy", "(10) estimates the states with minimal estimation errors.", "section 5")
