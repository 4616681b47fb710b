"""The Hamiltonian of a Riccati equation, a Moebius map, and the Cayley transform of a step."""

import numpy as np


def hamiltonian(A, G, Q):
    return np.block([[-A, G], [Q, A.T]])


def moebius(X, P):
    n = len(P)
    return (X[n:, :n] + X[n:, n:] @ P) @ np.linalg.inv(X[:n, :n] + X[:n, n:] @ P)


def cayley(H, h):
    eye = np.eye(len(H))
    return np.linalg.solve(eye - h / 2 * H, eye + h / 2 * H)
