"""What the AOSMC-RGS paper claims, with its equations and hypotheses, as data for the ledger."""

from workbench.core import Claim

INERTIA = Claim("(2)", "M is the inertia matrix of the arm.", "(2)")
CORIOLIS = Claim("(3)", "C is the Coriolis matrix of the arm.", "(3)")
GRAVITY = Claim("(4)", "G is the gravity vector of the arm.", "(4)")

ASSUMPTION_1 = Claim("Assumption 1", "The initial states lie in a bounded set.", "(5), (6)")
ASSUMPTION_2 = Claim(
    "Assumption 2", "M is symmetric, and alpha1 I <= M(q) <= alpha2 I for all q, alpha1 > 0.", "(7)", (INERTIA,)
)
ASSUMPTION_3 = Claim("Assumption 3", "M' - 2C is skew-symmetric, with C as (3) prints it.", "(3), section 2.3")
ASSUMPTION_3_DERIVED = Claim("Assumption 3, derived C", "M' - 2C is skew-symmetric, with C as derived.", "section 2.3")
ASSUMPTION_4 = Claim("Assumption 4", "|D(t)| <= D_max and |D'(t)| <= L_D in both scenarios.", "(8)")
ASSUMPTIONS = (ASSUMPTION_1, ASSUMPTION_2, ASSUMPTION_3_DERIVED, ASSUMPTION_4)

LIPSCHITZ = Claim(
    "(15)", "The mismatch of (14) has |Delta| <= rho (|x1~| + |x2~|) with one rho for all torques.", "(15)"
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
    f"{ANY_WEIGHTS} P(t) of (34) makes the cost (32) of the loop least, over a horizon of 10 s.",
    "(32), (34)",
    (LINEARISED, OPTIMAL_INPUT),
)

DECREASE = Claim("(39)", "V2' <= -lambda_min(K) |s| + |s| delta + 'bounded term'.", "(39)", (ASSUMPTION_3, GAIN))
DECREASE_STRICT = Claim(
    "(40)", f"{ANY_WEIGHTS} V2' <= -c |s| with c = lambda_min(K) - delta > 0.", "(40)", (DECREASE, OPTIMAL)
)
CONVERGENCE = Claim(
    "(41)", f"{ANY_WEIGHTS} s and e1 tend to zero under every disturbance of Assumption 4.", "(41)", (DECREASE_STRICT,)
)
FINITE_TIME = Claim(
    "(42)",
    f"{ANY_WEIGHTS} |s(t)| <= sigma from t = V2(0) / (c sigma) on, for every precision sigma.",
    "(42)",
    (DECREASE_STRICT,),
)
BOUNDED = Claim(
    "Theorem 2, bounded signals",
    f"{ANY_WEIGHTS} all signals of the loop stay bounded, as printed but for C, which is derived.",
    "Theorem 2",
    ASSUMPTIONS,
)

ASSUMED = "Repaired, and under the numbers that a1 assumes for the rivals,"
TRACKING = Claim("superior tracking", f"{ASSUMED} RMSE (43) is below that of each rival.", "section 5")
STEADY = Claim(
    "lower steady-state error", f"{ASSUMED} the largest late error is below that of each rival.", "section 5"
)
AMPLITUDE = Claim("smaller control amplitude", f"{ASSUMED} the peak torque is below that of each rival.", "section 5")
CHATTERING = Claim(
    "less chattering", f"{ASSUMED} the total variation of the torque is below that of each rival.", "section 5"
)
OVERSHOOT = Claim(
    "reduced overshoot", f"{ASSUMED} the overshoot after the jumps is below that of each rival.", "section 5"
)
SETTLING = Claim(
    "faster settling", f"{ASSUMED} the settling time after the jumps is below that of each rival.", "section 5"
)
