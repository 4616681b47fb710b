"""Random formulas of every operation, with literal gains and a table; all stay finite."""

import casadi as ca
import numpy as np

GAINS = (180 / np.pi, np.pi / 180, 3.3, -4.7, 0.1, 10.0, 60 / (2 * np.pi), 1 / 3, 9.81, 2.0, -1.0, 1.0, 0.5)
TABLE = np.linspace(-2, 2, 5), np.array([-1.0, -0.7, 0.0, 0.9, 1.1])


def table(x):
    """A table, straight between its rows."""
    return ca.pw_lin(ca.SX(x), *map(ca.DM, TABLE))


# Operations of one number and of two, guarded.
ONE = (
    lambda a: ca.sin(a),
    lambda a: ca.cos(a),
    lambda a: ca.tanh(a),
    lambda a: ca.exp(ca.tanh(a)),
    lambda a: ca.exp(-a * a / 2),
    lambda a: ca.log(1 + a * a),
    lambda a: ca.sqrt(1 + ca.fabs(a)),
    lambda a: ca.sign(a),
    lambda a: ca.floor(a * 10) / 10,
    lambda a: a * a,
    lambda a: ca.tanh(a) ** 3,
    lambda a: (1 + ca.fabs(ca.tanh(a))) ** 1.5,
    lambda a: -a,
    lambda a: a * (180 / np.pi) * (np.pi / 180),
    lambda a: table(a),
    lambda a: 1 / (1 + a * a),
    lambda a: ca.tanh(a) / 3,
    lambda a: 0.0 * a,
    lambda a: ca.tan(ca.tanh(a)),
    lambda a: ca.fmod(a, 0.7),
    lambda a: ca.atan(a),
    lambda a: ca.asin(ca.tanh(a)),
    lambda a: ca.acos(ca.tanh(a)),
    lambda a: ca.sinh(ca.tanh(a)),
    lambda a: ca.cosh(ca.tanh(a)),
    lambda a: ca.log1p(a * a),
    lambda a: ca.expm1(ca.tanh(a)),
    lambda a: ca.ceil(a * 10) / 10,
)
TWO = (
    *(3 * (lambda a, b: a + b, lambda a, b: a - b, lambda a, b: ca.tanh(a) * b)),
    lambda a, b: a / (1 + b * b),
    lambda a, b: a / ca.sqrt(1 + b * b),
    lambda a, b: ca.atan2(a, b),
    lambda a, b: ca.fmin(a, b),
    lambda a, b: ca.hypot(a, b),
    lambda a, b: ca.fmax(a, b),
    lambda a, b: ca.fmod(a, 1 + b * b),
    lambda a, b: ca.sin(a + b) - ca.sin(a) * ca.cos(b),
    lambda a, b: ca.cos(ca.sin(a) - b),
    lambda a, b: ca.floor(a / (1 + b * b)),
    lambda a, b: 2 * a * ca.sin(b) + 2 * b * ca.sin(a),
)


def expression(rng, atoms, depth):
    """A random formula of some symbols that stays finite, as every operation is guarded."""
    if depth == 0 or rng.random() < 0.08:
        atom = atoms[rng.integers(len(atoms))]
        return atom * GAINS[rng.integers(len(GAINS))] if rng.random() < 0.4 else atom

    def part():
        return expression(rng, atoms, depth - 1)

    def choice(a, b):
        order = (lambda: a < b, lambda: a <= b, lambda: a > b, lambda: ca.logic_and(a > 0, b > 0))
        truths = (*order, lambda: ca.logic_or(a > 0, ca.logic_not(b > 0)), lambda: a != b, lambda: ca.sign(a) == 1)
        return ca.if_else(truths[rng.integers(len(truths))](), part(), part())

    two = (*TWO, choice, choice)
    if rng.random() < 0.35:
        return ONE[rng.integers(len(ONE))](part())
    return two[rng.integers(len(two))](part(), part())


class Draw:
    """The random numbers of each part of a loop: a part draws the same ones whenever it is asked."""

    def __init__(self, seed):
        self.seed = seed

    def __call__(self, *part):
        return np.random.default_rng([self.seed, *part])

    def formula(self, number, atoms, depth=3):
        """The formula of a number: whoever asks with other atoms gets the same one of these."""
        return expression(self(1, number), atoms, depth)
