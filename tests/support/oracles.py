"""Closed loops of the paper's arm written out by hand in NumPy, to check the workbench against.

Nothing here comes from the workbench but names: a parameter is looked up by its path
(`plant.arm.links[0].mass`), a state likewise (`controller.K`), and the equations are typed from the
paper and the papers it stands on, with (3) put right.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

REFERENCES = "reference.amplitude", "reference.frequency", "reference.phase"
DISTURBANCES = "plant.disturbance.amplitude", "plant.disturbance.frequency", "plant.disturbance.phase"


# The arm, the wanted motion, the disturbance


def matrices(p, arm, q, qd):
    """(2), (3) with C[1,2] = -m2 l1 l2 sin q2 (q1' + q2'), and (4)."""
    m1, m2 = p[f"{arm}.links[0].mass"], p[f"{arm}.links[1].mass"]
    l1, l2, g = p[f"{arm}.links[0].length"], p[f"{arm}.links[1].length"], p[f"{arm}.gravity"]
    c2, s2 = np.cos(q[1]), np.sin(q[1])
    M = np.array(
        [
            [m1 * l1**2 + m2 * (l1**2 + l2**2 + 2 * l1 * l2 * c2), m2 * (l2**2 + l1 * l2 * c2)],
            [m2 * (l2**2 + l1 * l2 * c2), m2 * l2**2],
        ]
    )
    k = m2 * l1 * l2 * s2
    C = np.array([[-k * qd[1], -k * (qd[0] + qd[1])], [k * qd[0], 0.0]])
    tip = m2 * g * l2 * np.sin(q[0] + q[1])
    G = np.array([(m1 + m2) * g * l1 * np.sin(q[0]) + tip, tip])
    return M, C, G


def wanted(t, p):
    a, w, f = (p[name] for name in REFERENCES)
    return a * np.sin(w * t + f), a * w * np.cos(w * t + f), -a * w * w * np.sin(w * t + f)


def disturbance(t, p):
    a, w, f = (p[name] for name in DISTURBANCES)
    return a * np.sin(w * t + f)


# The laws: (p, z, q, qd, D_hat, reference) -> torque, rates of the law's own states


def sat(x, kind):
    return np.tanh(x) if kind == "tanh" else np.clip(x, -1.0, 1.0)


def errors(p, q, qd, ref):
    q_d, qd_d, qdd_d = ref
    Lambda = p["controller.Lambda"]
    e, ed = q - q_d, qd - qd_d
    return e, ed, ed + Lambda * e, qd_d - Lambda * e, qdd_d - Lambda * ed


def pid(gravity=False):
    def law(p, z, q, qd, d, ref):
        e, ed = q - ref[0], qd - ref[1]
        tau = -p["controller.Kp"] * e - p["controller.Ki"] * z["controller.integral"] - p["controller.Kd"] * ed
        if gravity:
            tau = tau + matrices(p, "controller.model", q, qd)[2]
        return tau, {"controller.integral": e}

    return law


def sliding_mode(kind="clip"):
    def law(p, z, q, qd, d, ref):
        M, C, G = matrices(p, "controller.model", q, qd)
        _, _, s, v, a = errors(p, q, qd, ref)
        return M @ a + C @ v + G - p["controller.K"] * sat(s / p["controller.phi"], kind), {}

    return law


def learned(p, form, growth, s, K):
    """The three ways for a gain to grow."""
    if form == "dead_zone":
        return np.where(np.abs(s) > p["controller.adaptation.width"], growth, 0.0)
    if form == "leakage":
        return growth - p["controller.adaptation.sigma"] * (K - p["controller.adaptation.level"])
    return growth


def adaptive_sliding_mode(kind="clip", form="plain"):
    def law(p, z, q, qd, d, ref):
        M, C, G = matrices(p, "controller.model", q, qd)
        _, _, s, v, a = errors(p, q, qd, ref)
        K = z["controller.K"]
        tau = M @ a + C @ v + G - K * sat(s / p["controller.phi"], kind)
        return tau, {"controller.K": learned(p, form, p["controller.gamma"] * np.abs(s), s, K)}

    return law


def fuzzy_asmc(kind="clip", form="plain"):
    def law(p, z, q, qd, d, ref):
        M, C, G = matrices(p, "controller.model", q, qd)
        _, _, s, v, a = errors(p, q, qd, ref)
        K = z["controller.K"]
        trend = (np.abs(s) - z["controller.s_slow"]) / p["controller.lag"]
        r = np.array([rules(p, size, v) for size, v in zip(np.abs(s), trend, strict=True)])
        tau = M @ a + C @ v + G - K * sat(s / p["controller.phi"], kind)
        return tau, {
            "controller.K": learned(p, form, p["controller.gamma"] * r * np.abs(s), s, K),
            "controller.s_slow": trend,
        }

    return law


def rules(p, size, trend):
    """Every rule by itself: its weight is the product of two memberships."""
    above = below = 0.0
    for a, x in enumerate(p["controller.rules.sizes"]):
        for b, v in enumerate(p["controller.rules.trends"]):
            mu = np.exp(-0.5 * ((size - x) / p["controller.rules.size_width"]) ** 2)
            nu = np.exp(-0.5 * ((trend - v) / p["controller.rules.trend_width"]) ** 2)
            above += mu * nu * p["controller.rules.scale"][a, b]
            below += mu * nu
    return above / below


def rbf_asmc(kind="clip", form="plain"):
    def law(p, z, q, qd, d, ref):
        M, C, G = matrices(p, "controller.model", q, qd)
        e, ed, s, v, a = errors(p, q, qd, ref)
        K, W = z["controller.K"], z["controller.W"]
        x = np.concatenate([e, ed])
        h = np.exp(-0.5 * (((x - p["controller.centres"]) / p["controller.widths"]) ** 2).sum(axis=1))
        tau = M @ a + C @ v + G + W.T @ h - K * sat(s / p["controller.phi"], kind)
        W_rate = -p["controller.Gamma"] * np.outer(h, s) - p["controller.sigma"] * W
        return tau, {
            "controller.K": learned(p, form, p["controller.gamma"] * np.abs(s), s, K),
            "controller.W": W_rate,
        }

    return law


def super_twisting(kind="clip"):
    def law(p, z, q, qd, d, ref):
        M, C, G = matrices(p, "controller.model", q, qd)
        _, _, s, _, a = errors(p, q, qd, ref)
        switch = sat(s / p["controller.phi"], kind)
        u = -p["controller.k1"] * np.sqrt(np.abs(s)) * switch + z["controller.w"]
        return M @ (a + u) + C @ qd + G, {"controller.w": -p["controller.k2"] * switch}

    return law


def aosmc_rgs(velocity, gain_sign, gain_shape, riccati="forward", kind="clip"):
    def law(p, z, q, qd, d, ref):
        M, C, G = matrices(p, "controller.model", q, qd)
        _, _, s, v, a = errors(p, q, qd, ref)
        if velocity == "printed":
            v, a = ref[1], ref[2]
        K, P = z["controller.K"], z["controller.P"]
        tau = M @ a + C @ v + G + d - K @ sat(s / p["controller.phi"], kind)
        growth = {
            "outer": np.outer(P @ s, np.sign(s)),
            "elementwise": np.diag(P @ s * np.sign(s)),
            "diagonal": P * np.abs(s),
            "norm": P * np.abs(s).sum(),
        }[gain_shape]
        P_rate = np.zeros_like(P)
        if riccati == "forward":
            A, B = -np.linalg.inv(M) @ K, np.diag(p["controller.Lambda"])
            P_rate = A.T @ P + P @ A - P @ B @ np.linalg.inv(p["controller.R"]) @ B.T @ P + p["controller.Q"]
        return tau, {"controller.K": growth if gain_sign == "raised" else -growth, "controller.P": P_rate}

    return law


# The observers: (p, z, q, qd, D) -> estimates, and a function of the torque for the rates of their own states


def full_state(p, z, q, qd, D):
    return (q, qd, np.zeros(2)), lambda tau: {}


def luenberger(p, z, q, qd, D):
    q_hat, qd_hat = z["observer.q_hat"], z["observer.qd_hat"]
    return (q_hat, qd_hat, np.zeros(2)), lambda tau: _copy(p, "observer", q_hat, qd_hat, q, tau)


def _copy(p, name, q_hat, qd_hat, q, tau):
    """(10)."""
    M, C, G = matrices(p, f"{name}.model", q_hat, qd_hat)
    return {
        f"{name}.q_hat": qd_hat + p[f"{name}.L1"] @ (q - q_hat),
        f"{name}.qd_hat": np.linalg.inv(M) @ (tau - C @ qd_hat - G) + p[f"{name}.L2"] @ (q - q_hat),
    }


def with_disturbance(disturbance_observer, state="full", compensated=False):
    """A state observer, full or (10), and one of the four below."""

    def observer(p, z, q, qd, D):
        full = state == "full"
        v = (q, qd) if full else (z["observer.state.q_hat"], z["observer.state.qd_hat"])
        d, d_rate = disturbance_observer(p, z, *v, D)

        def rates(tau):
            own = {} if full else _copy(p, "observer.state", *v, q, tau - d if compensated else tau)
            return own | {f"observer.disturbance.{name}": rate for name, rate in d_rate(tau).items()}

        return (*v, d), rates

    return observer


def printed_filter(p, z, q, qd, D):
    """(24)."""
    eta, D_hat = z["observer.disturbance.eta"], z["observer.disturbance.D_hat"]
    return D_hat, lambda tau: {"eta": -p["observer.disturbance.l"] * (eta - D), "D_hat": eta}


def oracle_filter(p, z, q, qd, D):
    D_hat = z["observer.disturbance.D_hat"]
    return D_hat, lambda tau: {"D_hat": -p["observer.disturbance.l"] * (D_hat - D)}


def nonlinear_disturbance_observer(p, z, q, qd, D):
    M, C, G = matrices(p, "observer.disturbance.model", q, qd)
    l = p["observer.disturbance.l"]
    D_hat = z["observer.disturbance.z"] - l * qd
    return D_hat, lambda tau: {"z": l * np.linalg.inv(M) @ (tau - C @ qd - G - D_hat)}


def momentum_observer(p, z, q, qd, D):
    M, C, G = matrices(p, "observer.disturbance.model", q, qd)
    D_hat = p["observer.disturbance.l"] * (z["observer.disturbance.p_hat"] - M @ qd)
    return D_hat, lambda tau: {"p_hat": tau + C.T @ qd - G - D_hat}


# The loop


def closed_loop(law, observer=full_state):
    """(t, states by name, parameters by name) -> rates by name."""

    def rates(t, z, p):
        q, qd = z["plant.q"], z["plant.qd"]
        D = disturbance(t, p)
        (q_hat, qd_hat, D_hat), observer_rates = observer(p, z, q, qd, D)
        tau, law_rates = law(p, z, q_hat, qd_hat, D_hat, wanted(t, p))
        M, C, G = matrices(p, "plant.arm", q, qd)
        qdd = np.linalg.inv(M) @ (tau - C @ qd - G - D)
        return {"plant.q": qd, "plant.qd": qdd} | observer_rates(tau) | law_rates

    return rates


# Comparing (the names and the order of the flat vectors are the workbench's, matrices column by column)


def flat(parts, names):
    return np.concatenate([np.asarray(parts[name]).ravel(order="F") for name in names])


def worst_difference(ode, rates, rng, cases=25):
    """The largest difference between two right-hand sides at random states and parameters, in units of their size."""
    worst = 0.0
    for _ in range(cases):
        t, x = rng.uniform(0, 10), rng.uniform(-1.5, 1.5, ode.states.size)
        p = ode.parameters.default * rng.uniform(0.8, 1.2, ode.parameters.size)
        ours = np.array(ode.f(t, x, p)).ravel()
        theirs = flat(rates(t, ode.states.unpack(x), ode.parameters.unpack(p)), ode.states.names)
        worst = max(worst, float(np.max(np.abs(ours - theirs) / (1 + np.abs(theirs).max()))))
    return worst


def integrate(ode, rates, until):
    """The last state of the hand-written loop from the default state, by DOP853 at tolerances near rounding."""
    p = ode.parameters.unpack(ode.parameters.default)

    def rhs(t, x):
        return flat(rates(t, ode.states.unpack(x), p), ode.states.names)

    done = solve_ivp(rhs, (0, until), ode.states.default, method="DOP853", rtol=1e-12, atol=1e-13)
    assert done.success
    return done.y[:, -1]
