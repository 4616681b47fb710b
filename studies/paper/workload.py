"""Workload W: the AOSMC-RGS loop of 21 states and 40 parameters on which speed is measured."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

import casadi as ca
import numpy as np

import workbench as wb

H, HORIZON = 1e-3, 10.0  # s
SEED = 20  # of all parameters that are drawn

STATES = wb.Layout(
    (
        wb.core.Entry("q", np.array([np.pi, -np.pi]), "rad"),
        wb.core.Entry("qd", np.zeros(2), "rad/s"),
        wb.core.Entry("q_hat", np.zeros(2), "rad"),
        wb.core.Entry("qd_hat", np.zeros(2), "rad/s"),
        wb.core.Entry("d_hat", np.zeros(2), "N m"),
        wb.core.Entry("P", 10 * np.eye(2), "N m/rad"),
        wb.core.Entry("K", np.full(2, 5.0), "N m"),
        wb.core.Entry("ise", np.zeros(2), "rad^2 s"),
        wb.core.Entry("iae", np.zeros(2), "rad s"),
        wb.core.Entry("energy", np.zeros(()), "N^2 m^2 s"),
    )
)
PARAMETERS = wb.Layout(
    (
        wb.core.Entry("arm.mass", np.ones(2), "kg"),
        wb.core.Entry("arm.length", np.ones(2), "m"),
        wb.core.Entry("arm.gravity", np.array(9.81), "m/s^2"),
        wb.core.Entry("arm.friction", np.full(2, 0.01), "N m s/rad"),
        wb.core.Entry("model.mass", np.ones(2), "kg"),
        wb.core.Entry("model.length", np.ones(2), "m"),
        wb.core.Entry("model.gravity", np.array(9.81), "m/s^2"),
        wb.core.Entry("Lambda", np.full(2, 6.0), "1/s"),
        wb.core.Entry("phi", np.array(0.01), "rad/s"),
        wb.core.Entry("gamma", np.array(1.0), "1/s"),
        wb.core.Entry("sigma", np.array(0.5), "1/s"),
        wb.core.Entry("K0", np.full(2, 5.0), "N m"),
        wb.core.Entry("Q", np.ones(2), "N m/(rad s)"),
        wb.core.Entry("R", np.ones(2), "N m/(rad s)"),
        wb.core.Entry("L1", np.full(2, 30.0), "1/s"),
        wb.core.Entry("L2", np.full(2, 50.0), "1/s^2"),
        wb.core.Entry("l", np.array(50.0), "1/s"),
        wb.core.Entry("reference.amplitude", np.array([1.0, 0.5]), "rad"),
        wb.core.Entry("reference.frequency", np.array([2.0, 3.0]), "rad/s"),
        wb.core.Entry("reference.phase", np.zeros(2), "rad"),
        wb.core.Entry("disturbance.amplitude", np.array([0.5, 0.4]), "N m"),
        wb.core.Entry("disturbance.frequency", np.array([3.0, 4.0]), "rad/s"),
        wb.core.Entry("disturbance.phase", np.array([0.0, np.pi / 2]), "rad"),
    )
)
# The ten numbers that differ from run to run, each drawn evenly between these multiples of its default.
VARIATION_RANGES: Mapping[str, tuple[float, float]] = {
    "arm.mass": (0.9, 1.1),
    "arm.length": (0.95, 1.05),
    "arm.friction": (0.0, 2.0),
    "disturbance.amplitude": (0.5, 1.5),
    "gamma": (0.5, 1.5),
    "sigma": (0.5, 1.5),
}
VARIED_COLUMNS = tuple(i for name in VARIATION_RANGES for i in range(PARAMETERS.size)[PARAMETERS.slice(name)])
MEMORY = wb.Layout((wb.core.Entry("tau_before", np.zeros(2), "N m"), wb.core.Entry("variation", np.zeros(()), "N m")))


def arm(q: ca.SX, qd: ca.SX, mass: ca.SX, length: ca.SX, gravity: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
    """M, C and G of two point masses at the ends of massless links, angles from the downward vertical."""
    (m1, m2), (l1, l2) = ca.vertsplit(mass), ca.vertsplit(length)
    coupling, shear = m2 * l1 * l2 * ca.cos(q[1]), m2 * l1 * l2 * ca.sin(q[1])
    M12 = m2 * l2**2 + coupling
    M = ca.blockcat([[(m1 + m2) * l1**2 + m2 * l2**2 + 2 * coupling, M12], [M12, m2 * l2**2]])
    C = ca.blockcat([[-shear * qd[1], -shear * (qd[0] + qd[1])], [shear * qd[0], 0]])
    low = m2 * l2 * ca.sin(q[0] + q[1])
    return M, C, gravity * ca.vertcat((m1 + m2) * l1 * ca.sin(q[0]) + low, low)


def inverse(M: ca.SX) -> ca.SX:
    """The inverse of a symmetric matrix (2, 2)."""
    a, b, d = M[0, 0], M[0, 1], M[1, 1]
    return ca.blockcat([[d, -b], [-b, a]]) / (a * d - b**2)


@cache
def loop() -> wb.Ode:
    """The loop of the AOSMC-RGS paper with a repaired gain law, and five integrals that score it.

        arm       M q'' + C q' + G + b q' + D = tau                                         (1)
        observer  q_hat' = qd_hat + L1 (q - q_hat)                                         (10)
                  qd_hat' = M^-1 (tau - C qd_hat - G) + L2 (q - q_hat)
        filter    D_hat' = l (D - D_hat)                                                   (24), repaired
        law       e1 = q_hat - q_d,   e2 = qd_hat - qd_d,   s = e2 + Lambda e1             (25), (26)
                  tau = M qdd_d + C qd_d + G + D_hat - diag(K) sat(s / phi)                (27) - (29)
        gain      K' = gamma (P s) o sign(s) - sigma (K - K0)                              (33), repaired
                  P' = A^T P + P A - P B R^-1 B^T P + Q,   A = -M^-1 diag(K),  B = Lambda  (34)
        scores    integrals of e_i^2, |e_i| and |tau|^2 with e = q - q_d

    M, C and G of the observer and of the law are those of `model` at the estimates. (33) has its sign
    turned and a leakage added, (3) its entry [1,2] put right: as printed the loop is lost.
    """
    t, x, p = ca.SX.sym("t"), STATES.symbols(), PARAMETERS.symbols()
    X, c = STATES.view(x), PARAMETERS.view(p)
    angle = c["reference.frequency"] * t + c["reference.phase"]
    q_d = c["reference.amplitude"] * ca.sin(angle)
    qd_d = c["reference.amplitude"] * c["reference.frequency"] * ca.cos(angle)
    qdd_d = -(c["reference.frequency"] ** 2) * q_d
    d = c["disturbance.amplitude"] * ca.sin(c["disturbance.frequency"] * t + c["disturbance.phase"])

    M, C, G = arm(X["q_hat"], X["qd_hat"], c["model.mass"], c["model.length"], c["model.gravity"])
    inverse_model = inverse(M)
    s = X["qd_hat"] - qd_d + c["Lambda"] * (X["q_hat"] - q_d)
    sat = ca.fmin(ca.fmax(s / c["phi"], -1), 1)
    tau = M @ qdd_d + C @ qd_d + G + X["d_hat"] - X["K"] * sat
    A = -inverse_model @ ca.diag(X["K"])
    P, weight = X["P"], ca.diag(c["Lambda"] ** 2 / c["R"])

    true_M, true_C, true_G = arm(X["q"], X["qd"], c["arm.mass"], c["arm.length"], c["arm.gravity"])
    e, lag = X["q"] - q_d, X["q"] - X["q_hat"]
    rates = {
        "q": X["qd"],
        "qd": inverse(true_M) @ (tau - true_C @ X["qd"] - true_G - c["arm.friction"] * X["qd"] - d),
        "q_hat": X["qd_hat"] + c["L1"] * lag,
        "qd_hat": inverse_model @ (tau - C @ X["qd_hat"] - G) + c["L2"] * lag,
        "d_hat": c["l"] * (d - X["d_hat"]),
        "P": A.T @ P + P @ A - P @ weight @ P + ca.diag(c["Q"]),
        "K": c["gamma"] * (P @ s) * ca.sign(s) - c["sigma"] * (X["K"] - c["K0"]),
        "ise": e**2,
        "iae": ca.fabs(e),
        "energy": ca.sumsqr(tau),
    }
    return wb.Ode.of(
        "workload W", STATES, PARAMETERS, (t, x, p), rates, {"e": e, "tau": tau}, {"e": "rad", "tau": "N m"}
    )


@cache
def workload(h: float = H) -> wb.core.StepMap:
    """W by RK4 at the step h [s], with the total variation of the torque summed over the steps beside it."""
    step = wb.rk4(loop(), h)
    symbols = MEMORY.symbols()
    tau, z = step.outputs.view(step.rule.output)["tau"], MEMORY.view(symbols)
    change = ca.if_else(step.rule.k > 0, ca.sum1(ca.fabs(tau - z["tau_before"])), 0)
    return step.with_memory(MEMORY, symbols, MEMORY.flatten({"tau_before": tau, "variation": z["variation"] + change}))


def rows_of(runs: int) -> wb.Array:
    """Parameters (B, 40) of the first so many runs, the same ones in every measurement."""
    rows, column = np.tile(PARAMETERS.default, (runs, 1)), 0
    # drawn row by row, so that more runs begin with the same ones
    even = np.random.default_rng(SEED).random((runs, len(VARIED_COLUMNS)))
    for name, (low, high) in VARIATION_RANGES.items():
        size = PARAMETERS[name].size
        rows[:, PARAMETERS.slice(name)] *= low + (high - low) * even[:, column : column + size]
        column += size
    return rows


def rmse(x: wb.Array, horizon: float) -> wb.Array:
    """The root of the mean square error of each joint (..., 2) from states (..., >= 21) at the horizon [s]."""
    return np.asarray(np.sqrt(x[..., STATES.slice("ise")] / horizon))


def run(p: wb.Array, horizon: float, h: float = H) -> wb.Array:
    """The RMSE (B, 2) by the engine at the step h [s], with nothing kept but the end."""
    return rmse(wb.simulate(workload(h), p, until=horizon, every=horizon).x[:, -1], horizon)
