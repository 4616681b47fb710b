"""The numbers of the AOSMC-RGS paper, each once: stated, derived or assumed.

What the paper does not state is assumed by a rule and not by taste: the rival laws share the surface,
the boundary layer and the first gain that the paper states for its own law, and PID gets the bandwidth
of that surface. The range beside each assumed number is where it could as well lie.
"""

import numpy as np

from workbench.study.comparison import Published
from workbench.study.provenance import Card, assumed, derived, stated

SHARED = "not stated; the rivals share what section 5 states for AOSMC-RGS"

CARD = Card(
    (
        stated("masses m1, m2", (1.0, 1.0), "kg", "section 5"),
        stated("lengths l1, l2", (1.0, 1.0), "m", "section 5"),
        stated("gravity g", 9.81, "m/s^2", "section 5"),
        stated("Lambda", (6.0, 6.0), "1/s", "section 5"),
        stated("phi", 0.01, "rad/s", "section 5; the unit follows from (26)"),
        stated("K(0)", np.diag([5.0, 5.0]), "N m", "section 5"),
        stated("P(0)", np.diag([10.0, 10.0]), "", "section 5"),
        stated("L1", np.diag([30.0, 30.0]), "1/s", "section 5"),
        stated("L2", np.diag([50.0, 50.0]), "1/s^2", "section 5"),
        stated("q_hat(0)", (0.0, 0.0), "rad", "section 5"),
        stated("qd_hat(0)", (0.0, 0.0), "rad/s", "section 5"),
        stated("qd(0)", (0.0, 0.0), "rad/s", "section 5"),
        stated("FS: q(0)", (np.pi, -np.pi), "rad", "section 5, first scenario"),
        stated("FS: reference amplitude", (1.0, 0.5), "rad", "section 5, first scenario"),
        stated("FS: reference frequency", (2.0, 3.0), "rad/s", "section 5, first scenario"),
        stated("FS: disturbance amplitude", (0.5, 0.4), "N m", "section 5, first scenario"),
        stated("FS: disturbance frequency", (3.0, 4.0), "rad/s", "section 5, first scenario"),
        derived("FS: disturbance phase", (0.0, np.pi / 2), "rad", "sine and cosine, section 5, first scenario"),
        stated("SS: q(0)", (0.0, -1.0), "rad", "section 5, second scenario"),
        stated("SS: disturbance amplitude", (0.5, 0.4), "N m", "section 5, second scenario"),
        stated("SS: disturbance frequency", (3.0, 4.0), "rad/s", "section 5, second scenario"),
        derived("SS: disturbance phase", (np.pi / 2, 0.0), "rad", "cosine and sine, section 5, second scenario"),
        assumed("SS: a1, a2", (0.8, 0.4), "rad", "not stated; round numbers at which the repaired law comes near the printed RMSE of SS", 0.2, 2.0),
        assumed("SS: f", 0.5, "Hz", "not stated; each level is held for 2 s, twelve time constants of the surface", 0.05, 1.0),
        assumed("SS: reference derivatives", "zero", "", "not stated; a jump has none, so it is left out"),
        assumed("FS: horizon", 25.08, "s", "not stated; at this one the repaired law meets the printed RMSE of FS", 5.0, 30.0),
        assumed("SS: horizon", 10.0, "s", "not stated; five levels of the square wave", 5.0, 30.0),
        assumed("Q", 599.0 * np.eye(2), "", "not stated; the fit of the repaired law to the printed RMSE of FS", 0.01, 1000.0),
        assumed("R", 6.43 * np.eye(2), "", "not stated; the fit of the repaired law to the printed RMSE of FS", 0.001, 1000.0),
        assumed("l", 18.5, "1/s", "not stated beyond l >> 1; the fit of the repaired law to the printed RMSE of FS", 1.0, 316.0),
        assumed("Q as printed", np.eye(2), "", "not stated; the plainest choice, for the law as printed", 0.01, 1000.0),
        assumed("R as printed", np.eye(2), "", "not stated; the plainest choice, for the law as printed", 0.001, 1000.0),
        assumed("SMC: K", (5.0, 5.0), "N m", SHARED, 1.0, 50.0),
        assumed("ASMC: K(0)", (5.0, 5.0), "N m", SHARED, 1.0, 50.0),
        assumed("ASMC: gamma", 5.0, "N m/rad", "not stated; one radian of |s| doubles the first gain", 1.0, 100.0),
        assumed("Fuzzy-ASMC: centres of |s|", (0.0, 0.5, 1.0), "rad/s", "no rule is stated; small, medium, large", 0.0, 2.0),
        assumed("Fuzzy-ASMC: width of |s|", 0.25, "rad/s", "half the distance of the centres", 0.1, 1.0),
        assumed("Fuzzy-ASMC: centres of the trend", (-5.0, 0.0, 5.0), "rad/s^2", "no rule is stated; falling, level, rising", -10.0, 10.0),
        assumed("Fuzzy-ASMC: width of the trend", 2.5, "rad/s^2", "half the distance of the centres", 1.0, 10.0),
        assumed("Fuzzy-ASMC: rules", ((0.0, 0.2, 0.5), (0.2, 1.0, 2.0), (1.0, 2.0, 4.0)), "1", "no rule is stated; learn faster where s is large and growing, not at all where it is small and falling", 0.0, 10.0),
        assumed("Fuzzy-ASMC: lag", 0.02, "s", "not stated; a third of the time of the fastest pole of the observer", 0.001, 0.1),
        assumed("RBF-ASMC: Gamma", 5.0, "N m/rad", "not stated; as fast as gamma", 1.0, 100.0),
        assumed("RBF-ASMC: sigma", 0.1, "1/s", "not stated; the network forgets in ten seconds", 0.0, 1.0),
        assumed("RBF-ASMC: centres", (-1.0, -0.5, 0.0, 0.5, 1.0), "rad, rad/s", "not stated; five on the diagonal of (e, ed)", -2.0, 2.0),
        assumed("RBF-ASMC: widths", (1.0, 1.0, 1.0, 1.0), "rad, rad/s", "not stated; twice the distance of the centres", 0.2, 3.0),
        assumed("super-twisting: k1", (10.0, 10.0), "(rad/s^3)^(1/2)", "not in the paper; above 1.5 times the root of k2", 1.0, 50.0),
        assumed("super-twisting: k2", (15.0, 15.0), "rad/s^3", "not in the paper; above the rate of M^-1 D, about 10 rad/s^3", 1.0, 100.0),
        assumed("PID: poles", 6.0, "1/s", "no gains are stated; a triple pole at the bandwidth of the surface", 2.0, 20.0),
        derived("PID: inertia", (3.0, 1.0), "kg m^2", "diagonal of M(q), averaged over q2"),
        derived("PID: Kp", (324.0, 108.0), "N m/rad", "3 poles^2 times inertia"),
        derived("PID: Ki", (648.0, 216.0), "N m/(rad s)", "poles^3 times inertia"),
        derived("PID: Kd", (54.0, 18.0), "N m s/rad", "3 poles times inertia"),
    )
)

LAWS = ("AOSMC-RGS", "ASMC", "Fuzzy-ASMC", "RBF-ASMC", "PID", "SMC")


def _column(scenario: str, joint: int, values: tuple[float, ...]) -> Published:
    where = f"{scenario}, RMSE of q{joint}"
    return Published(where, "RMSE", joint - 1, dict(zip(LAWS, values, strict=True)), digits=4)


# The two tables of section 5, one column each, in the order of LAWS.
PUBLISHED = {
    ("FS", 1): _column("first scenario", 1, (0.3538, 0.4461, 0.4869, 0.5086, 0.5847, 0.4822)),
    ("FS", 2): _column("first scenario", 2, (0.3542, 0.5019, 0.5825, 0.5747, 0.5872, 0.5683)),
    ("SS", 1): _column("second scenario", 1, (0.3575, 0.3723, 0.4401, 0.3837, 0.5787, 0.4613)),
    ("SS", 2): _column("second scenario", 2, (0.2234, 0.2437, 0.2267, 0.2330, 0.2517, 0.2335)),
}
