"""M, C and G of an arm from its energies.

Each function differentiates over fresh symbols and then puts in what it was given, so that q may be
any expression: an estimate, say.
"""

from collections.abc import Callable

import casadi as ca


def at(q: ca.SX, derive: Callable[[ca.SX], ca.SX]) -> ca.SX:
    """The expression that `derive` returns for fresh symbols, with `q` (n, 1) substituted for them."""
    symbols = ca.SX.sym("q", q.shape[0])
    return ca.substitute(derive(symbols), symbols, q)


def mass_matrix(kinetic_energy: Callable[[ca.SX, ca.SX], ca.SX], q: ca.SX) -> ca.SX:
    """M(q) = d^2 T / d qd^2, (n, n)."""
    qd = ca.SX.sym("qd", q.shape[0])
    return at(q, lambda symbols: ca.densify(ca.hessian(kinetic_energy(symbols, qd), qd)[0]))


def coriolis_matrix(mass: Callable[[ca.SX], ca.SX], q: ca.SX, qd: ca.SX) -> ca.SX:
    """C(q, qd), (n, n), of the Christoffel symbols: C_ij = sum_k (dM_ij/dq_k + dM_ik/dq_j - dM_jk/dq_i) qd_k / 2.

    The first term is M' along qd; the other two are the transposes of each other, d(M qd)/dq and its transpose.
    """
    n = q.shape[0]
    speed = ca.SX.sym("qd", n)  # a loop in qd would be differentiated, too, by what it does not depend on

    def derive(symbols: ca.SX) -> ca.SX:
        M = mass(symbols)
        along = ca.reshape(ca.jtimes(ca.vec(M), symbols, speed), n, n)
        across = ca.jacobian(M @ speed, symbols)
        return ca.densify((along + across - across.T) / 2)

    return ca.substitute(at(q, derive), speed, qd)


def gravity_vector(potential_energy: Callable[[ca.SX], ca.SX], q: ca.SX) -> ca.SX:
    """G(q) = dU/dq, (n, 1)."""
    return at(q, lambda symbols: ca.densify(ca.gradient(potential_energy(symbols), symbols)))


def torque(kinetic: ca.SX, potential: ca.SX, q: ca.SX, qd: ca.SX, qdd: ca.SX) -> ca.SX:
    """tau = d/dt dT/dqd - dT/dq + dU/dq, (n, 1): Lagrange's equation of energies over the symbols q and qd."""
    momentum = ca.gradient(kinetic, qd)
    along = ca.jtimes(momentum, ca.vertcat(q, qd), ca.vertcat(qd, qdd))
    return ca.densify(along - ca.gradient(kinetic - potential, q))
