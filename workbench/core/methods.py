"""Explicit Runge-Kutta methods, in which each stage depends only on the state and on the stage before it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TypeVar

import casadi as ca

from workbench.core.validation.refusals import Array

Time = TypeVar("Time", ca.SX, float)
X = TypeVar("X", ca.SX, Array)
Constants = TypeVar("Constants")  # the arguments of an equation that are the same at each stage


@dataclass(frozen=True)
class Method:
    """x(t + h) = x + h / D sum_j w_j k_j with k_j = f(t + c_j h, x + a_(j-1) h k_(j-1)), k_1 = f(t, x) and w_1 = 1.

    For x' = lambda x a step multiplies x by the polynomial R(h lambda); `amplification` are its coefficients, highest
    power first.
    """

    name: str
    about: str  # the words for a reader after "by"
    order: int
    nodes: tuple[float, ...]  # c_j
    ahead: tuple[float, ...]  # a_j, from stage j to the next; 0 at the last
    weights: tuple[float, ...]  # w_j
    divisor: float  # D
    amplification: tuple[float, ...]
    gain: float = 1.1  # least ratio of its step to that of the classical method at which it is worth its cost
    corners: bool = False  # True if a step is divided at corners of the rate, as it is at its switches in time


# Hairer, Norsett and Wanner (1993), Solving Ordinary Differential Equations I, section II.1.
RK4 = Method(
    "rk4",
    "the classical Runge-Kutta method",
    4,
    (0.0, 0.5, 0.5, 1.0),
    (0.5, 0.5, 1.0, 0.0),
    (1.0, 2.0, 2.0, 1.0),
    6.0,
    (1 / 24, 1 / 6, 1 / 2, 1.0, 1.0),
)
# Of third order at the same cost, with a decaying real mode stable up to |h lambda| = 5.80 in the place of 2.79. The
# coefficient 0.019 of z^4 damps such modes (|R| < 0.82; without damping it would be 6.03). With c_3 and c_4 from a
# search for small errors of fourth order, the four conditions of third order give c_2 and the weights.
STABILISED_METHOD = Method(
    "stabilised",
    "a stabilised Runge-Kutta method of third order",
    3,
    (0.0, 0.3862970800971688, 0.8, 0.62),
    (0.3862970800971688, 0.8, 0.62, 0.0),
    (1.0, 2.0136542634761527, 2.2002832720702465, 0.5739448984245815),
    5.787882433970981,
    (0.019, 1 / 6, 1 / 2, 1.0, 1.0),
)
RESTARTED_METHOD = replace(
    RK4,
    name="restarted",
    about="the classical Runge-Kutta method, restarted at corners",
    corners=True,
    gain=1.5,
)
METHODS: Mapping[str, Method] = {method.name: method for method in (RK4, STABILISED_METHOD, RESTARTED_METHOD)}


def runge_kutta(
    f: Callable[[Time, X, Constants], X], t: Time, x: X, p: Constants, h: Time | float, method: Method = RK4
) -> X:
    """x(t + h) from x(t), as expressions or arrays, by a Runge-Kutta method; the classical one by default."""
    stage: X = x
    total: X | float = 0.0
    for node, ahead, weight in zip(method.nodes, method.ahead, method.weights, strict=True):
        rate = f(t + node * h, stage, p)
        stage, total = x + ahead * h * rate, total + weight * rate
    end: X = x + h / method.divisor * total
    return end
