"""The right-hand side of W as one writes it by hand: in matrices of NumPy, and in scalars for a compiler."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

import workbench as wb
from studies.paper.workload import PARAMETERS


def _arm(
    q: wb.Array, qd: wb.Array, mass: wb.Array, length: wb.Array, gravity: float
) -> tuple[wb.Array, wb.Array, wb.Array]:
    """M, C and G."""
    m1, m2 = mass
    l1, l2 = length
    coupling, shear = m2 * l1 * l2 * np.cos(q[1]), m2 * l1 * l2 * np.sin(q[1])
    M12 = m2 * l2**2 + coupling
    M = np.array([[(m1 + m2) * l1**2 + m2 * l2**2 + 2 * coupling, M12], [M12, m2 * l2**2]])
    C = np.array([[-shear * qd[1], -shear * (qd[0] + qd[1])], [shear * qd[0], 0.0]])
    low = m2 * l2 * np.sin(q[0] + q[1])
    return M, C, gravity * np.array([(m1 + m2) * l1 * np.sin(q[0]) + low, low])


def in_matrices(p: wb.Array) -> Callable[[float, wb.Array], tuple[wb.Array, wb.Array]]:
    """(t, x) to x' (21,) and the torque (2,) in NumPy, for one run's parameters (40,)."""
    c: dict[str, Any] = PARAMETERS.unpack(p)
    Lambda, L1, L2, Q, w = c["Lambda"], c["L1"], c["L2"], np.diag(c["Q"]), c["reference.frequency"]
    weight = np.diag(Lambda**2 / c["R"])

    def rate(t: float, x: wb.Array) -> tuple[wb.Array, wb.Array]:
        q, qd, q_hat, qd_hat, d_hat = x[0:2], x[2:4], x[4:6], x[6:8], x[8:10]
        P, K = x[10:14].reshape(2, 2), x[14:16]  # P is symmetric: its rows are its columns
        angle = w * t + c["reference.phase"]
        q_d = c["reference.amplitude"] * np.sin(angle)
        qd_d = c["reference.amplitude"] * w * np.cos(angle)
        d = c["disturbance.amplitude"] * np.sin(c["disturbance.frequency"] * t + c["disturbance.phase"])

        M, C, G = _arm(q_hat, qd_hat, c["model.mass"], c["model.length"], c["model.gravity"])
        s = qd_hat - qd_d + Lambda * (q_hat - q_d)
        sat = np.minimum(np.maximum(s / c["phi"], -1.0), 1.0)
        tau = M @ (-(w**2) * q_d) + C @ qd_d + G + d_hat - K * sat
        inverse_model = np.linalg.inv(M)
        A = -inverse_model * K

        true_M, true_C, true_G = _arm(q, qd, c["arm.mass"], c["arm.length"], c["arm.gravity"])
        e, lag = q - q_d, q - q_hat
        rates = (
            qd,
            np.linalg.solve(true_M, tau - true_C @ qd - true_G - c["arm.friction"] * qd - d),
            qd_hat + L1 * lag,
            inverse_model @ (tau - C @ qd_hat - G) + L2 * lag,
            c["l"] * (d - d_hat),
            (A.T @ P + P @ A - P @ weight @ P + Q).ravel(),
            c["gamma"] * (P @ s) * np.sign(s) - c["sigma"] * (K - c["K0"]),
            e * e,
            np.abs(e),
            [tau @ tau],
        )
        return np.concatenate(rates), tau

    return rate


def _scalar_arm(xp: Any) -> Callable[..., tuple[Any, ...]]:
    """M11, M12, M22, the shear of C, G1 and G2."""

    def arm(q1: Any, q2: Any, m1: Any, m2: Any, l1: Any, l2: Any, g: Any) -> tuple[Any, ...]:
        coupling, own = m2 * l1 * l2 * xp.cos(q2), m2 * l2 * l2
        low = m2 * l2 * xp.sin(q1 + q2)
        M11 = (m1 + m2) * l1 * l1 + own + 2.0 * coupling
        return M11, own + coupling, own, m2 * l1 * l2 * xp.sin(q2), g * ((m1 + m2) * l1 * xp.sin(q1) + low), g * low

    return arm


def _scalar_riccati() -> Callable[..., tuple[Any, ...]]:
    """P' column by column for A = -N diag(K), N the inverse of M, and B R^-1 B^T = diag(b1, b2)."""

    def riccati(x: Any, N11: Any, N12: Any, N22: Any, b1: Any, b2: Any, Q1: Any, Q2: Any) -> tuple[Any, ...]:
        P11, P21, P12, P22, K1, K2 = x[10], x[11], x[12], x[13], x[14], x[15]
        A11, A12, A21, A22 = -N11 * K1, -N12 * K2, -N12 * K1, -N22 * K2
        return (
            A11 * P11 + A21 * P21 + P11 * A11 + P12 * A21 - (P11 * b1 * P11 + P12 * b2 * P21) + Q1,
            A12 * P11 + A22 * P21 + P21 * A11 + P22 * A21 - (P21 * b1 * P11 + P22 * b2 * P21),
            A11 * P12 + A21 * P22 + P11 * A12 + P12 * A22 - (P11 * b1 * P12 + P12 * b2 * P22),
            A12 * P12 + A22 * P22 + P21 * A12 + P22 * A22 - (P21 * b1 * P12 + P22 * b2 * P22) + Q2,
        )

    return riccati


def _scalar_signals(xp: Any) -> Callable[..., tuple[Any, ...]]:
    """The reference, its first two derivatives, and the disturbance."""

    def signals(t: Any, p: Any) -> tuple[Any, ...]:
        w1, w2, angle1, angle2 = p[30], p[31], p[30] * t + p[32], p[31] * t + p[33]
        r1, r2 = p[28] * xp.sin(angle1), p[29] * xp.sin(angle2)
        v1, v2 = p[28] * w1 * xp.cos(angle1), p[29] * w2 * xp.cos(angle2)
        d1, d2 = p[34] * xp.sin(p[36] * t + p[38]), p[35] * xp.sin(p[37] * t + p[39])
        return r1, r2, v1, v2, -w1 * w1 * r1, -w2 * w2 * r2, d1, d2

    return signals


def in_scalars(xp: Any, jit: Callable[[Any], Any] = lambda function: function) -> Callable[..., tuple[Any, ...]]:
    """(t, x, p) to the 21 rates and the two torques, one scalar after the other.

    Parameters
    ----------
    xp
        What has sin, cos, sign, minimum, maximum and abs: NumPy, or jax.numpy.
    jit
        What compiles a function, as numba does.
    """
    arm, riccati, signals = jit(_scalar_arm(xp)), jit(_scalar_riccati()), jit(_scalar_signals(xp))

    def rate(t: Any, x: Any, p: Any) -> tuple[Any, ...]:
        q1, q2, w1, w2, z1, z2, v1, v2 = x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7]
        Lambda1, Lambda2, phi, gamma, sigma, K1, K2 = p[12], p[13], p[14], p[15], p[16], x[14], x[15]
        r1, r2, rd1, rd2, rdd1, rdd2, d1, d2 = signals(t, p)

        M11, M12, M22, c, G1, G2 = arm(z1, z2, p[7], p[8], p[9], p[10], p[11])
        s1, s2 = v1 - rd1 + Lambda1 * (z1 - r1), v2 - rd2 + Lambda2 * (z2 - r2)
        sat1 = xp.minimum(xp.maximum(s1 / phi, -1.0), 1.0)
        sat2 = xp.minimum(xp.maximum(s2 / phi, -1.0), 1.0)
        u1 = M11 * rdd1 + M12 * rdd2 - c * (v2 * rd1 + (v1 + v2) * rd2) + G1 + x[8] - K1 * sat1
        u2 = M12 * rdd1 + M22 * rdd2 + c * v1 * rd1 + G2 + x[9] - K2 * sat2
        det = M11 * M22 - M12 * M12
        N11, N12, N22 = M22 / det, -M12 / det, M11 / det
        f1, f2 = u1 + c * v2 * (2.0 * v1 + v2) - G1, u2 - c * v1 * v1 - G2

        T11, T12, T22, k, H1, H2 = arm(q1, q2, p[0], p[1], p[2], p[3], p[4])
        h1 = u1 + k * w2 * (2.0 * w1 + w2) - H1 - p[5] * w1 - d1
        h2 = u2 - k * w1 * w1 - H2 - p[6] * w2 - d2
        true = T11 * T22 - T12 * T12
        e1, e2, lag1, lag2 = q1 - r1, q2 - r2, q1 - z1, q2 - z2
        weights = Lambda1 * Lambda1 / p[21], Lambda2 * Lambda2 / p[22]
        dP = riccati(x, N11, N12, N22, weights[0], weights[1], p[19], p[20])
        Ps1, Ps2 = x[10] * s1 + x[12] * s2, x[11] * s1 + x[13] * s2
        return (
            *(w1, w2, (T22 * h1 - T12 * h2) / true, (T11 * h2 - T12 * h1) / true),
            *(v1 + p[23] * lag1, v2 + p[24] * lag2),
            *(N11 * f1 + N12 * f2 + p[25] * lag1, N12 * f1 + N22 * f2 + p[26] * lag2),
            *(p[27] * (d1 - x[8]), p[27] * (d2 - x[9])),
            *dP,
            gamma * Ps1 * xp.sign(s1) - sigma * (K1 - p[17]),
            gamma * Ps2 * xp.sign(s2) - sigma * (K2 - p[18]),
            *(e1 * e1, e2 * e2, xp.abs(e1), xp.abs(e2), u1 * u1 + u2 * u2, u1, u2),
        )

    compiled: Callable[..., tuple[Any, ...]] = jit(rate)
    return compiled
