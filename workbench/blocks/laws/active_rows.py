"""The small system of a sweep of predictive control, to which only rows that act contribute."""

from __future__ import annotations

from functools import reduce

import casadi as ca

from workbench.core.bounded_loop import bounded_loop


def any_of(truths: ca.SX) -> ca.SX:
    """True if one of the truths (n, 1) holds."""
    return reduce(ca.logic_or, ca.vertsplit(truths))


def active_sums(gap: ca.SX, acts: ca.SX, modes: ca.SX) -> ca.SX:
    """The lower triangle of W' diag W, column by column, and behind it W' diag gap, where diag has `acts`.

    A stage without an active row leaves the sums as they are. Gap and `acts` are (nc, N), and the modes W (nc r, N).
    """
    nc, N = gap.shape
    r = modes.shape[0] // nc

    def add(sums: ca.SX, own: ca.SX, active: ca.SX, W: ca.SX) -> tuple[ca.SX, ...]:
        W = ca.reshape(W, nc, r)
        weighted = W * ca.repmat(active, 1, r)
        terms = [ca.dot(weighted[:, i], W[:, j]) for i, j in _places(r)] + [weighted[:, i].T @ own for i in range(r)]
        return (ca.if_else(any_of(active != 0.0), sums + ca.vertcat(*terms), sums),)

    (sums,) = bounded_loop(N, add, ca.SX.zeros(len(_places(r)) + r), gap, acts, modes)
    return sums


def solve_small_system(L: ca.SX, sums: ca.SX) -> ca.SX:
    """t (r, 1) of (L^-1 + W' diag W) t = W' diag gap, by factors L D L' without pivots; see `active_sums`."""
    r = L.numel()
    G = {place: sums[i] for i, place in enumerate(_places(r))}
    t = [sums[len(G) + i] for i in range(r)]
    for i in range(r):
        G[i, i] += 1 / L[i]
    for j in range(r):
        column = {i: G[i, j] / G[j, j] for i in range(j + 1, r)}
        for i in range(j + 1, r):
            for k in range(j + 1, i + 1):
                G[i, k] -= column[i] * G[k, j]
            t[i] -= column[i] * t[j]
        G.update({(i, j): value for i, value in column.items()})
    for j in reversed(range(r)):
        t[j] = t[j] / G[j, j] - sum((G[i, j] * t[i] for i in range(j + 1, r)), ca.SX(0.0))
    return ca.vertcat(*t)


def _places(r: int) -> list[tuple[int, int]]:
    """The places of the lower triangle of a matrix of r rows, column by column."""
    return [(i, j) for j in range(r) for i in range(j, r)]
