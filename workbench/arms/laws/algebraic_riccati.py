"""The Riccati equation in CasADi expressions: the stabilising P, and a step of P' = A'P + PA - PGP + Q."""

import casadi as ca
import numpy as np

TINY = float(np.finfo(float).tiny)


def stabilising_solution(A: ca.SX, G: ca.SX, Q: ca.SX, doublings: int) -> ca.SX:
    """The stabilising P (n, n) for semidefinite G, Q: in closed form for n <= 2 and a definite G, else by doubling."""
    if A.shape[0] <= 2:
        return closed_form(A, G, Q)
    return doubling_solution(A, G, Q, norm(A) + ca.sqrt(norm(G) * norm(Q) + TINY), doublings)


def closed_form(A: ca.SX, G: ca.SX, Q: ca.SX) -> ca.SX:
    """P for one or two rows, without an iteration.

    The factor p(l) = l + c0 or l^2 + c1 l + c0 of the characteristic polynomial of H = [A, -G; -Q, -A'] with roots to
    the left is known by square roots alone, and p(H) [I; P] = 0 is linear in P. Both halves of that are solved together
    by least squares: either alone loses digits.

    References
    ----------
    Laub (1979), A Schur method for solving algebraic Riccati equations, IEEE TAC 24(6) (the invariant subspace).
    """
    n = A.shape[0]
    scale = ca.sqrt((ca.trace(Q) + TINY) / ca.trace(G))  # so that both halves weigh alike
    G, Q = scale * G, Q / scale
    if n == 1:
        c0 = ca.sqrt(A**2 + G * Q)
        upper, lower = (A + c0, -G), (-Q, -A + c0)
    else:
        crossed = ca.trace(_adjugate(Q) @ A.T @ _adjugate(G) @ A)
        c0 = ca.sqrt(_det(A) ** 2 + _det(G) * _det(Q) + crossed + TINY)
        c1 = ca.sqrt(2 * (c0 - _det(A)) + ca.trace(A) ** 2 + ca.trace(G @ Q))
        upper = (A @ A + G @ Q + c1 * A + c0 * ca.SX.eye(n), G @ A.T - A @ G - c1 * G)
        lower = (A.T @ Q - Q @ A - c1 * Q, Q @ G + A.T @ A.T - c1 * A.T + c0 * ca.SX.eye(n))
    normal = upper[1].T @ upper[1] + lower[1].T @ lower[1]
    right = upper[1].T @ upper[0] + lower[1].T @ lower[0]
    P = -right / normal if n == 1 else -_adjugate(normal) @ right / _det(normal)
    return scale * (P + P.T) / 2


def doubling_solution(A: ca.SX, G: ca.SX, Q: ca.SX, rate: ca.SX, doublings: int) -> ca.SX:
    """P by the structure-preserving doubling algorithm, from a Cayley transform at `rate` in 1/s.

    A pole l of the closed loop leaves an error ((rate - |l|) / (rate + |l|))^(2^(doublings + 1)) and of that order
    where l is complex; so `rate` is best in the middle of the poles. It must be above every eigenvalue of A.

    References
    ----------
    Chu, Fan and Lin (2005), A structure-preserving doubling algorithm for ... Riccati equations, LAA 396.
    """
    n = A.shape[0]
    eye = ca.SX.eye(n)
    E, F, P = _cayley(A, G, Q, rate)
    for _ in range(doublings):
        F, P = _even(F), _even(P)
        V = ca.solve(eye + F @ P, ca.horzcat(E, F @ E.T))
        E, F, P = E @ V[:, :n], F + E @ V[:, n:], P + E.T @ (P @ V[:, :n])
    return _even(P)


def cayley_step(A: ca.SX, G: ca.SX, Q: ca.SX, P: ca.SX, h: float) -> ca.SX:
    """P after h seconds of P' = A'P + PA - PGP + Q, by one Cayley step; symmetric where P is.

    With P = X2 X1^-1 the equation is linear, [X1; X2]' = H [X1; X2], H = [-A, G; Q, A']. The step takes X = (I - h H /
    2)^-1 (I + h H / 2) for exp(h H), symplectic and of second order: P+ = P0 + E' P (I + F P)^-1 E. But where 2 / h is
    an eigenvalue of A a semidefinite P stays so, and each stationary P of the equation is one of the step.

    References
    ----------
    Schiff and Shnider (1999), A natural approach to the numerical integration of Riccati ..., SINUM 36(5).
    """
    E, F, P0 = _cayley(A, G, Q, 2 / h)
    return _even(P0 + E.T @ P @ ca.solve(ca.SX.eye(A.shape[0]) + F @ P, E))


def _cayley(A: ca.SX, G: ca.SX, Q: ca.SX, rate: ca.SX | float) -> tuple[ca.SX, ca.SX, ca.SX]:
    """E, F and P0 of the map P0 + E' P (I + F P)^-1 E of P, which is the Cayley transform at `rate` in 1/s."""
    n = A.shape[0]
    eye = ca.SX.eye(n)
    moved = ca.solve(A - rate * eye, ca.horzcat(eye, G))
    inverse, by_G = moved[:, :n], moved[:, n:]
    W = ca.solve(A.T - rate * eye + Q @ by_G, ca.horzcat(eye, Q @ inverse))
    return eye + 2 * rate * W[:, :n].T, 2 * rate * by_G @ W[:, :n], 2 * rate * W[:, n:]


def residual(A: ca.SX, G: ca.SX, Q: ca.SX, P: ca.SX) -> ca.SX:
    """The certificate of a P: the norm of A'P + PA - PGP + Q over the sum of those of its terms."""
    PA, PGP = P @ A, P @ G @ P
    terms = 2 * norm(PA) + norm(PGP) + norm(Q) + TINY  # P = 0 where nothing costs leaves nothing
    left: ca.SX = norm(PA + PA.T - PGP + Q) / terms
    return left


def norm(X: ca.SX) -> ca.SX:
    """The Frobenius norm."""
    return ca.sqrt(ca.sumsqr(X))


def _even(X: ca.SX) -> ca.SX:
    return (X + X.T) / 2


def _det(X: ca.SX) -> ca.SX:
    return X[0, 0] * X[1, 1] - X[0, 1] * X[1, 0]


def _adjugate(X: ca.SX) -> ca.SX:
    return ca.blockcat([[X[1, 1], -X[0, 1]], [-X[1, 0], X[0, 0]]])
