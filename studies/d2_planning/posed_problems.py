"""Problems of predictive control that are posed here with all their data: plants of this study, and a published law."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial

import numpy as np
from scipy.linalg import expm, solve_discrete_lyapunov

import workbench as wb
from studies.d2_planning.predictive import design_of
from studies.d2_planning.problems import PROBLEMS, weights

MIDDLE = {"inputs": 0.1, "rates": 0.0316}  # of the ranges of the knobs
PUBLISHED = "a published law"


@dataclass(frozen=True, eq=False)
class PosedProblem:
    """A problem with its exact solver, and the numbers of the law with the sweeps that are derived for it."""

    exact: wb.planning.ExactMpc
    numbers: wb.planning.SplittingNumbers


def middle(key: str) -> PosedProblem:
    """A problem of the comparison with weights in the middle of their ranges."""
    design = design_of(PROBLEMS[key], MIDDLE)
    return PosedProblem(design.exact, design.numbers)


def cart_on_rail() -> PosedProblem:
    """The cart-pole with limits on its force."""
    design = cart_pole()
    return PosedProblem(design.exact, design.numbers)


def short_rail() -> PosedProblem:
    """The same with hard limits on the position, too."""
    design = cart_pole(x=(-0.5, 0.5))
    return PosedProblem(design.exact, design.numbers)


def cart_pole(**limits: tuple[float, float]) -> wb.planning.PredictiveDesign:
    """The cart-pole at 50 Hz with 20 stages and |F| <= 3 N, and perhaps limits of states."""
    linear = wb.linearize(wb.open_loop(wb.CartPole()), 0.0, np.zeros(4), at_rest=True)
    Q, R = np.diag([10.0, 1.0, 10.0, 1.0]), [[0.1]]
    return wb.predictive_design(linear, 0.02, Q, R, 20, limits={"F": (-3.0, 3.0), **limits})


@cache
def published_law() -> PosedProblem:
    """Section 7.1 of Bemporad, Morari, Dua and Pistikopoulos (2002): y = 2/(s^2 + 3 s + 2) u, sampled every 0.1 s.

    It looks two samples ahead, with Q = I, R = 0.01 and |u| <= 2. P is that with which the printed gains are met.
    """
    model = expm(0.1 * np.array([[-3.0, -1.0, 0.5**0.5], [2.0, 0.0, 0.0], [0.0, 0.0, 0.0]]))
    A, B = model[:2, :2], model[:2, 2:]
    limits = wb.planning.MpcLimits(inputs=(-2.0, 2.0))
    problem = wb.planning.mpc_problem(A, B, np.eye(2), [[0.01]], 2, limits, P=solve_discrete_lyapunov(A, np.eye(2)))
    return PosedProblem(wb.planning.exact_mpc(problem), wb.planning.splitting_numbers(problem))


@dataclass(frozen=True, eq=False)
class InfeasibleState:
    """A state from which no inputs keep hard limits, in deviations from the rest."""

    problem: wb.planning.LinearMpc
    x: wb.Array


def limited_problem(key: str, states: dict[str, tuple[float, float]]) -> wb.planning.LinearMpc:
    """A problem of the comparison with hard limits of states by name."""
    own = PROBLEMS[key]
    linear = wb.linearize(wb.open_loop(own.plant), 0.0, np.array(own.x0), u=np.array(own.u0), at_rest=True)
    low, high = (
        np.array([states.get(name, (-np.inf, np.inf))[end] for name in own.plant.states.labels]) for end in (0, 1)
    )
    limits = wb.planning.MpcLimits(inputs=(np.array(own.low), np.array(own.high)), states=(low, high))
    return wb.planning.sampled_mpc(linear, own.period, *weights(own, MIDDLE), own.stages, limits)


def infeasible_cart() -> InfeasibleState:
    """A cart that cannot stop before the end of its rail."""
    return InfeasibleState(cart_pole(x=(-0.5, 0.5)).problem, np.array([0.45, 1.5, 0.0, 0.0]))


def infeasible_arm() -> InfeasibleState:
    """An arm that cannot stop before a wall."""
    arm = PROBLEMS["arm"]
    problem = limited_problem("arm", {"q[0]": (-0.2, 1.0)})
    return InfeasibleState(problem, np.array([0.9, 0.6, 6.0, 0.0]) - arm.x0)


def infeasible_tanks() -> InfeasibleState:
    """A tank below one that will flood it."""
    tank = PROBLEMS["tank"]
    problem = limited_problem("tank", dict.fromkeys(tank.plant.states.labels, (0.0, 15.0)))
    return InfeasibleState(problem, np.array([14.9, 12.7, 14.0, 1.4]) - tank.x0)


def infeasible_quadrotor() -> InfeasibleState:
    """A quadrotor that cannot stop above the ground."""
    problem = limited_problem("quadrotor", {"y": (-1.0, 1.0)})
    return InfeasibleState(problem, np.array([0.0, -0.8, 0.0, 0.0, -4.0, 0.0]))


INFEASIBLE: dict[str, Callable[[], InfeasibleState]] = {
    "a cart at 0.45 m with 1.5 m/s, |x| ≤ 0.5 m": infeasible_cart,
    "the paper's arm, q[0] at 0.9 rad with 6 rad/s, q[0] ≤ 1 rad": infeasible_arm,
    "four tanks, h_1 at 14.9 cm below h_3 at 14 cm, all levels ≤ 15 cm": infeasible_tanks,
    "a quadrotor at y = −0.8 m falling with 4 m/s, y ≥ −1 m": infeasible_quadrotor,
}


POSED: dict[str, Callable[[], PosedProblem]] = {
    **{PROBLEMS[key].name: partial(middle, key) for key in PROBLEMS},
    "a cart-pole": cart_on_rail,
    "a cart-pole, |x| ≤ 0.5 m": short_rail,
    PUBLISHED: published_law,
}
