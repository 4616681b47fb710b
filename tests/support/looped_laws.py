"""Laws with bounded loops: a predictive law of splittings over a recursion, and loops drawn at random."""

import casadi as ca
import numpy as np
from scipy import linalg

import workbench as wb

HORIZON = 6


@wb.block
class Predictive(wb.Controller):
    """The first input of a plan within limits, by a few sweeps of splitting (ADMM) over a Riccati recursion."""

    A: np.ndarray = wb.parameter(shape=("nx", "nx"), unit="1")
    B: np.ndarray = wb.parameter(shape=("nx", "nu"), unit="1")
    K: np.ndarray = wb.parameter(shape=("nu", "nx"), unit="1")
    inverse: np.ndarray = wb.parameter(shape=("nu", "nu"), unit="1")
    limit: float = wb.parameter(unit="N")
    penalty: float = wb.parameter(unit="1")
    y: np.ndarray = wb.initial(default=np.zeros(HORIZON), unit="N", shape=("N",))
    w: np.ndarray = wb.initial(default=np.zeros(HORIZON), unit="N", shape=("N",))

    reads = wb.CartPole(phi=0.1).states
    follows = wb.layout()
    drives = wb.CartPole(phi=0.1).inputs
    sweeps = 3

    def plan(self, z, est):
        """The multipliers and shifted slacks after the sweeps, and the first input of each."""
        x0, A, B, K = self.reads.flatten(est), self.A, self.B, self.K
        closed = A - B @ K

        def back(p, w):
            return closed.T @ p - K.T @ w, self.inverse @ (B.T @ p + w)

        def forth(x, d, y):
            u = -K @ x - d
            v = ca.fmin(ca.fmax(u + y, -self.limit), self.limit)
            following = y + u - v
            return A @ x + B @ u, following, self.penalty * (following - v), v

        def sweep(both):
            _, d = wb.bounded_loop(HORIZON, back, ca.SX.zeros(4), both[HORIZON:].T, backward=True)
            _, y, w, v = wb.bounded_loop(HORIZON, forth, x0, d, both[:HORIZON].T)
            return ca.vertcat(y.T, w.T), v[0]

        return wb.bounded_loop(self.sweeps, sweep, ca.vertcat(z.y, z.w))

    def command(self, t, z, est, ref):
        return {"F": self.plan(z, est)[1][-1]}

    def update(self, t, z, est, ref):
        both, _ = self.plan(z, est)
        return {"y": both[:HORIZON], "w": both[HORIZON:]}


def predictive_loop(limit=3.0):
    """The law on a cart with a pole that starts tilted, in a computer at 50 Hz."""
    plant, period, penalty = wb.CartPole(phi=0.3), 0.02, 0.1
    point = wb.linearize(wb.open_loop(plant), 0.0, np.zeros(4))
    both = linalg.expm(period * np.block([[point.A, point.B], [np.zeros((1, 5))]]))
    A, B = both[:4, :4], both[:4, 4:]
    R = np.array([[0.1 + penalty]])
    P = linalg.solve_discrete_are(A, B, np.diag([10.0, 1.0, 10.0, 1.0]), R)
    inverse = linalg.inv(R + B.T @ P @ B)
    law = Predictive(A=A, B=B, K=inverse @ B.T @ P @ A, inverse=inverse, limit=limit, penalty=penalty)
    return wb.ClosedLoop(plant, observer=wb.FullState.of(plant), controller=law).digital(period)


TRUTHS = ("xd", "phid")  # that no instrument of the cart gives


class DrawnLoop:
    """A loop drawn by a seed: how it computes in CasADi, and pass by pass in plain Python."""

    def __init__(self, seed, depth=2):
        rng = self.rng = np.random.default_rng(seed)
        self.count, self.backward = int(rng.integers(1, 5)), bool(rng.integers(2))
        self.carried = int(rng.choice([0, 1, 2, 3, 30]))
        self.rows, self.made = (tuple(rng.integers(1, 4, rng.integers(0, 3)).tolist()) for _ in range(2))
        self.inner = DrawnLoop(seed + 1000, depth - 1) if depth and rng.integers(2) else None
        self.numbers = rng.uniform(-0.8, 0.8, (3 + sum(self.made) + self.carried, 6))

    def body(self, c, *rows, lib, x):
        """The next carried values and the rows; `lib` has the operations, and x are values from outside."""
        given = [*c, *(v for row in rows for v in row), *x]
        if self.inner is not None:
            place = iter(range(10_000))

            def take(n):
                return [given[next(place) % len(given)] for _ in range(n)]

            start = take(self.inner.carried)
            inner_rows = [[take(size) for _ in range(self.inner.count)] for size in self.inner.rows]
            end, *made = lib.loop(self.inner, start, inner_rows, [*x, given[0]])
            given += [*end, *(v for part in made for column in part for v in column)]

        def formula(i):
            a, b, e, f, g, _ = (float(number) for number in self.numbers[i])
            first, second, third = (given[(i * k + 1) % len(given)] for k in (1, 3, 5))
            return lib.sin(a * first + b * second) * e + lib.fmax(third * f, lib.fabs(first) * g)

        places = iter(range(len(self.numbers)))
        following = [formula(next(places)) for _ in range(self.carried)]
        return following, *[[formula(next(places)) for _ in range(size)] for size in self.made]


class InCasadi:
    """The operations of a drawn loop in CasADi, with `wb.bounded_loop`."""

    sin, fabs, fmax = staticmethod(ca.sin), staticmethod(ca.fabs), staticmethod(ca.fmax)

    def loop(self, drawn, start, rows, x):
        def body(c, *columns):
            parts = [[part[i] for i in range(part.numel())] for part in (c, *columns)]
            return tuple(ca.vertcat(ca.SX(0, 1), *part) for part in drawn.body(*parts, lib=self, x=x))

        matrices = [ca.horzcat(*(ca.vertcat(*column) for column in row)) for row in rows]
        carried = ca.vertcat(ca.SX(0, 1), *start)
        end, *made = wb.bounded_loop(drawn.count, body, carried, *matrices, backward=drawn.backward)
        columns = [[[part[i, k] for i in range(part.shape[0])] for k in range(drawn.count)] for part in made]
        return [end[i] for i in range(end.numel())], *columns


class InPython:
    """The same in Python, pass by pass."""

    sin, fabs, fmax = staticmethod(np.sin), staticmethod(np.abs), staticmethod(np.fmax)

    def loop(self, drawn, start, rows, x):
        carried, made = start, [[None] * drawn.count for _ in drawn.made]
        for k in range(drawn.count)[:: -1 if drawn.backward else 1]:
            carried, *own = drawn.body(carried, *(row[k] for row in rows), lib=self, x=x)
            for part, column in zip(made, own, strict=True):
                part[k] = column
        return carried, *made


def results(drawn, lib, x):
    """All results of a drawn loop from values x, as one list."""
    start = [x[i % len(x)] * (i + 1) for i in range(drawn.carried)]
    rows = [[[x[(i + k) % len(x)] + i for i in range(size)] for k in range(drawn.count)] for size in drawn.rows]
    end, *made = lib.loop(drawn, start, rows, x)
    return [*end, *(value for part in made for column in part for value in column)]
