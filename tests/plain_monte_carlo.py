"""The 'paper' scenario of a8 once more, by plain NumPy from the equations of the paper: no part of the workbench runs.

All arrays have the draws (B,) first. The computer runs at 1 kHz; the arm moves by one Runge-Kutta step a period.
"""

from dataclasses import dataclass

import numpy as np

PERIOD, STEPS = 1e-3, 6000
GRAVITY, FRICTION_SPEED = 9.81, 0.05  # m/s^2, rad/s
NOISE_Q, NOISE_QD = 1e-4, 5e-3  # rad, rad/s
LIMIT = np.array([100.0, 50.0])  # N m
AMPLITUDE, FREQUENCY = np.array([1.0, 0.5]), np.array([2.0, 3.0])  # of the wanted motion
ACCEPTABLE = {"RMSE": 0.5, "late RMSE": 0.005, "TV": 300.0, "effort": 50.0}


@dataclass(frozen=True)
class Arm:
    """Masses and lengths, (B, 2) each; equations (2) to (4), with the C of the Christoffel symbols for (3)."""

    m: np.ndarray
    l: np.ndarray

    def entries(self, q):
        """M_11, M_12 = M_21, M_22, m2 l1 l2 sin q2, G_1 and G_2."""
        m1, m2, l1, l2 = *self.m.T, *self.l.T
        q1, q2 = q.T
        near, far = m2 * l2, m2 * l1 * l2
        last, coupled = near * l2, far * np.cos(q2)
        hand = GRAVITY * near * np.sin(q1 + q2)
        shoulder = (m1 + m2) * l1
        first = shoulder * l1 + last + 2 * coupled
        return first, last + coupled, last, far * np.sin(q2), GRAVITY * shoulder * np.sin(q1) + hand, hand

    def matrices(self, q, qd):
        first, cross, last, turn, *gravity = self.entries(q)
        M, C, G = np.empty((len(q), 2, 2)), np.empty((len(q), 2, 2)), np.empty((len(q), 2))
        M[:, 0, 0], M[:, 0, 1], M[:, 1, 0], M[:, 1, 1] = first, cross, cross, last
        C[:, 0, 0], C[:, 0, 1] = -turn * qd[:, 1], -turn * (qd[:, 0] + qd[:, 1])
        C[:, 1, 0], C[:, 1, 1] = turn * qd[:, 0], 0.0
        G[:, 0], G[:, 1] = gravity
        return M, C, G

    def acceleration(self, q, qd, torque):
        """M^-1 (torque - C qd - G) by Cramer's rule."""
        first, cross, last, turn, upper, lower = self.entries(q)
        (one, two), (u, v) = qd.T, torque.T
        u, v = u + turn * two * (2 * one + two) - upper, v - turn * one**2 - lower
        found = np.empty(q.shape)
        found[:, 0], found[:, 1] = last * u - cross * v, first * v - cross * u
        return found / (first * last - cross**2)[:, None]


def times(M, v):
    """Matrices (B, 2, 2) by columns (B, 2)."""
    return M[:, :, 0] * v[:, :1] + M[:, :, 1] * v[:, 1:]


def wanted(t):
    angle = FREQUENCY * t
    return (
        AMPLITUDE * np.sin(angle),
        AMPLITUDE * FREQUENCY * np.cos(angle),
        -AMPLITUDE * FREQUENCY**2 * np.sin(angle),
    )


@dataclass(frozen=True)
class Draw:
    """Shares of the nominal numbers, phases and starts of B arms, as a8 draws them."""

    arm: Arm
    friction: np.ndarray
    push: np.ndarray
    pace: np.ndarray
    phase: np.ndarray
    start: np.ndarray

    @staticmethod
    def of(rng, count):
        uniform = rng.uniform
        arm = Arm(uniform(0.8, 1.2, (count, 2)), uniform(0.97, 1.03, (count, 2)))
        friction, push = uniform(0, 2, (count, 1)), uniform(0, 2, (count, 1)) * [0.5, 0.4]
        pace, phase = uniform(0.5, 2, (count, 1)) * [3.0, 4.0], uniform(0, 2 * np.pi, (count, 2))
        return Draw(arm, friction, push, pace, phase, [np.pi, -np.pi] + uniform(-0.2, 0.2, (count, 2)))

    def rate(self, t, q, qd, tau):
        disturbance = self.push * np.sin(self.pace * t + self.phase)
        friction = self.friction * (0.1 * qd + 0.2 * np.tanh(qd / FRICTION_SPEED))
        return qd, self.arm.acceleration(q, qd, tau - friction - disturbance)


def moved(draw, t, q, qd, tau):
    """One classical Runge-Kutta step of the arm."""
    h = PERIOD
    a, b = draw.rate(t, q, qd, tau)
    c, d = draw.rate(t + h / 2, q + h / 2 * a, qd + h / 2 * b, tau)
    e, f = draw.rate(t + h / 2, q + h / 2 * c, qd + h / 2 * d, tau)
    g, i = draw.rate(t + h, q + h * e, qd + h * f, tau)
    return q + h / 6 * (a + 2 * c + 2 * e + g), qd + h / 6 * (b + 2 * d + 2 * f + i)


class Readings:
    """Positions and velocities as they are read."""

    def __init__(self, numbers, draw):
        del numbers
        self.d = np.zeros(draw.start.shape)

    def estimate(self, q, qd):
        return q, qd, self.d

    def step(self, q, tau):
        del q, tau


class Observers:
    """Observer (10) in Cayley steps of its correction, and an observer of the momentum in Euler steps."""

    def __init__(self, numbers, draw):
        self.L1, self.L2, self.l = (numbers[name] for name in ("L1", "L2", "l"))
        self.q, self.qd, self.p = draw.start.copy(), np.zeros(draw.start.shape), np.zeros(draw.start.shape)
        ones = np.ones(draw.start.shape)
        self.model = Arm(ones, ones)

    def estimate(self, q, qd):
        del q, qd
        M, self.C, self.G = self.model.matrices(self.q, self.qd)
        self.d = self.l * (self.p - times(M, self.qd))
        return self.q, self.qd, self.d

    def step(self, q, tau):
        h = PERIOD
        free = self.model.acceleration(self.q, self.qd, tau)
        self.p = self.p + h * (tau + times(self.C.transpose(0, 2, 1), self.qd) - self.G - self.d)
        # the arm by its acceleration, and the error by its Cayley transform: both as if the arm moved on so
        w = (q - self.q) / (1 + h / 2 * self.L1 + h**2 / 4 * self.L2)
        self.q = self.q + h * self.qd + h**2 / 2 * free + h * (self.L1 + h * self.L2) * w
        self.qd = self.qd + h * (free + self.L2 * w)


class Sliding:
    """What all sliding laws share."""

    def __init__(self, numbers, draw):
        self.n = numbers
        ones = np.ones(draw.start.shape)
        self.model = Arm(ones, ones)
        self.Lambda = np.array([numbers["Lambda_1"], numbers["Lambda_2"]])

    def surface(self, t, est):
        q, qd, d = est
        r, rd, rdd = wanted(t)
        e, ed = q - r, qd - rd
        M, C, G = self.model.matrices(q, qd)
        self.M, self.e, self.ed, self.s = M, e, ed, ed + self.Lambda * e
        self.sat = np.clip(self.s / self.n["phi"], -1, 1)
        return times(M, rdd - self.Lambda * ed) + times(C, rd - self.Lambda * e) + G + d


class Smc(Sliding):
    """A constant switching gain."""

    def torque(self, t, est):
        return self.surface(t, est) - np.array([self.n["K_1"], self.n["K_2"]]) * self.sat

    def step(self):
        pass


class Rbf(Sliding):
    """A gain that grows with |s|, and a network of five Gaussians along (e, ed)."""

    def __init__(self, numbers, draw):
        super().__init__(numbers, draw)
        count = len(draw.start)
        self.K, self.W = np.full((count, 2), numbers["K(0)"]), np.zeros((count, 5, 2))

    def torque(self, t, est):
        free = self.surface(t, est)
        x = np.concatenate([self.e, self.ed], axis=1)[:, None, :] - np.linspace(-1, 1, 5)[:, None]
        self.h = np.exp(-(x**2).sum(axis=-1) / 2)
        return free + np.einsum("bj,bjn->bn", self.h, self.W) - self.K * self.sat

    def step(self):
        self.K = self.K + PERIOD * self.n["gamma"] * np.abs(self.s)
        grown = -self.n["Gamma"] * self.h[:, :, None] * self.s[:, None, :] - self.n["sigma"] * self.W
        self.W = self.W + PERIOD * grown


class Aosmc(Sliding):
    """(33) with a plus as an outer product in Euler steps, (34) in Cayley steps of its Hamiltonian."""

    def __init__(self, numbers, draw):
        super().__init__(numbers, draw)
        eye = np.broadcast_to(np.eye(2), (len(draw.start), 2, 2))
        self.K, self.P = numbers["K(0)"] * eye, numbers["P(0)"] * eye

    def torque(self, t, est):
        return self.surface(t, est) - times(self.K, self.sat)

    def step(self):
        h, eye = PERIOD, np.eye(4)
        A = -np.linalg.solve(self.M, self.K)
        B = np.broadcast_to(np.diag(self.Lambda**2 / self.n["R"]), A.shape)
        Q = np.broadcast_to(self.n["Q"] * np.eye(2), A.shape)
        # with P = Y / X: X' = -A X + B Y, Y' = Q X + A^T Y gives P' = A^T P + P A - P B P + Q
        H = np.concatenate([np.concatenate([-A, B], 2), np.concatenate([Q, A.transpose(0, 2, 1)], 2)], 1)
        XY = np.linalg.solve(eye - h / 2 * H, (eye + h / 2 * H))
        X = XY[:, :2, :2] + XY[:, :2, 2:] @ self.P
        Y = XY[:, 2:, :2] + XY[:, 2:, 2:] @ self.P
        self.K = self.K + h * times(self.P, self.s)[:, :, None] * np.sign(self.s)[:, None, :]
        P = Y @ np.linalg.inv(X)
        self.P = (P + P.transpose(0, 2, 1)) / 2


def costs(law, observer, numbers, draw, rng):
    """The cost of each draw, (B,), as a8 defines it."""
    control, sensing = law(numbers, draw), observer(numbers, draw)
    q, qd = draw.start.copy(), np.zeros(draw.start.shape)
    squares, late, effort, changes, last = (np.zeros(q.shape) for _ in range(5))
    for k in range(STEPS):
        t = k * PERIOD
        read = q + NOISE_Q * rng.standard_normal(q.shape), qd + NOISE_QD * rng.standard_normal(q.shape)
        tau = np.clip(control.torque(t, sensing.estimate(*read)), -LIMIT, LIMIT)
        sensing.step(read[0], tau)
        control.step()
        before = (q - wanted(t)[0]) ** 2
        q, qd = moved(draw, t, q, qd, tau)
        mean = (before + (q - wanted(t + PERIOD)[0]) ** 2) / 2  # trapezoid: errors of 1e-6 at 1 ms
        squares += mean
        late += mean * (k >= STEPS // 2)
        effort += tau**2
        changes += np.abs(tau - last) * (k > 0)
        last = tau
    found = {
        "RMSE": np.sqrt(squares / STEPS),
        "late RMSE": np.sqrt(2 * late / STEPS),
        "TV": changes / (STEPS * PERIOD),
        "effort": np.sqrt(effort / STEPS),
    }
    return sum(np.hypot(*value.T) / ACCEPTABLE[name] for name, value in found.items())
