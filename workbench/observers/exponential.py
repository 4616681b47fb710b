"""The function phi of a matrix, by which a linear equation is stepped exactly over a period."""

from __future__ import annotations

import casadi as ca

# Taylor's series to this order at M / 2^SQUARINGS errs by 1e-16 there, while the poles of M stay below 40 in size.
ORDER, SQUARINGS = 15, 6


def phi(M: ca.SX) -> ca.SX:
    """M^-1 (exp(M) - I) = I + M / 2 + M^2 / 6 + ..., also where M has no inverse.

    With it x' = M x + g has x(1) = x(0) + phi(M) x'(0).
    """
    one, small = ca.SX.eye(M.shape[0]), M / 2**SQUARINGS
    value = one
    for order in range(ORDER, 1, -1):
        value = one + small @ value / order
    for _ in range(SQUARINGS):
        value = value + value @ small @ value / 2  # phi(2 M) = phi(M) (I + exp(M)) / 2
        small = 2 * small
    return value
