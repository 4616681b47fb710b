"""The longest safe period of a law: by bisection on runs, by exact multipliers, and by the rule of thumb."""

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Any

import casadi as ca
import numpy as np
from scipy.linalg import expm

from studies.paper.card import CARD as PAPER
from studies.paper.laws import ARM
from studies.paper.linearization import cut, loop_of, states
from workbench.core import Ode, Signals
from workbench.design.linear import along
from workbench.design.linear.linear_path import LinearPath
from workbench.loop import ClosedLoop
from workbench.notation.formula import Number, Product, Quotient, symbol
from workbench.study.study import Outcome
from workbench.validation.refusals import Array

RULE = Quotient(Product((Number(Fraction(2)), symbol("phi"), symbol("lambda_min"))), symbol("K"))  # of thumb, in s
GRID = 1e-2  # s, that of (43), which every period divides
PARTS = (500, 200, 100, 50, 20, 10, 5, 2, 1)  # of the grid: the periods where a search begins
CLOSE = 1.12  # how far apart the longest safe period and the next one tried may be
EVERY = 25  # a state in so many of those of a run, one in 10 ms, is linearised
LONGEST, HALVINGS = 0.1, 30  # s; of the bisection for multipliers, 1e-6 of the period


@dataclass(frozen=True)
class Longest:
    """The longest period found safe, 0 if none, and the shortest found not to be, infinite if none; in s."""

    safe: float
    unsafe: float

    @property
    def text(self) -> str:
        """In ms, as a table has it."""
        if not self.safe:
            return f"below {1e3 * self.unsafe:.2g}"
        return f"{1e3 * self.safe:.2g}" + (" or more" if np.isinf(self.unsafe) else "")

    def meets(self, period: float, factor: float) -> bool:
        """True if a period is that close to the longest safe one, wherever this lies between the ends."""
        return self.unsafe / factor <= period <= factor * self.safe


def longest(safe: Callable[[float], bool]) -> Longest:
    """By bisection over the periods 10 ms / m, which takes every period shorter than a safe one to be safe."""
    asked = cache(lambda m: safe(GRID / m))
    low, high = -1, len(PARTS)  # the last place that is safe, and the first that is not
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if asked(PARTS[middle]) else (low, middle)
    if low < 0:
        return Longest(0.0, GRID / PARTS[0])
    if high == len(PARTS):
        return Longest(GRID / PARTS[-1], np.inf)
    good, bad = PARTS[low], PARTS[high]
    while good > CLOSE * bad and good - bad > 1:
        middle = round(np.sqrt(good * bad))
        good, bad = (middle, bad) if asked(middle) else (good, middle)
    return Longest(GRID / good, GRID / bad)


@dataclass(frozen=True, eq=False)
class Frozen:
    """A loop cut at the torque, linear at N states: the first `plant` states move, the others a computer remembers.

    `counted` (N, nx, nu) is what the rates of an observer make of the torque that it counts on.
    """

    path: LinearPath
    plant: int
    counted: Array


def multipliers(loop: Frozen, period: float, delay: bool = False) -> np.ndarray[Any, np.dtype[np.complex128]]:
    """The multipliers (N, m) of a loop with a computer, frozen at N states.

    The plant moves by exp(A T) while the torque is held; what the computer remembers by one step of explicit Euler.
    With `delay` plant and observer have the torque of the period before.
    """
    A, B, C, T, plant = loop.path.A, loop.path.B, loop.path.Cy, period, loop.plant
    N, nx, nu = B.shape
    whole = np.zeros((N, plant + nu, plant + nu))
    whole[:, :plant, :plant], whole[:, :plant, plant:] = A[:, :plant, :plant], B[:, :plant]
    held = expm(T * whole)
    free, driven = np.tile(np.eye(nx), (N, 1, 1)), T * loop.counted
    free[:, plant:] += T * (A - loop.counted @ C)[:, plant:]
    free[:, :plant, :plant], driven[:, :plant] = held[:, :plant, :plant], held[:, :plant, plant:]
    if not delay:
        return np.asarray(np.linalg.eigvals(free + driven @ C))
    waiting = np.concatenate([C, np.zeros((N, nu, nu))], axis=2)
    return np.asarray(np.linalg.eigvals(np.concatenate([np.concatenate([free, driven], axis=2), waiting], axis=1)))


def linear_limit(loop: Frozen, delay: bool = False) -> float:
    """The longest period up to `LONGEST`, in s, at which no mode faster than an eighth of the sampling rate grows.

    Slow modes that grow are those of continuous time too.
    """

    def decays(period: float) -> bool:
        z = multipliers(loop, period, delay)
        return bool((np.abs(z[np.abs(np.angle(z)) > np.pi / 4]) <= 1.0).all())

    low, high = 0.0, LONGEST
    if decays(high):
        return high
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if decays(middle) else (low, middle)
    return low


def frozen(outcome: Outcome) -> Frozen:
    """The linear models of a law's loop along its run, where it is within its layer."""
    law, ode, run = outcome.case.law, outcome.ode, outcome.measurement.trajectories
    loop, x, chosen = loop_of(law, outcome.case.scenario), states(outcome, ode), places(outcome)
    broken = cut(loop, law)
    values = ode.states.unpack(x[chosen]) | {"drive": run["tau"][0][chosen]}
    rows = broken.parameters.pack({name: value for name, value in values.items() if name in broken.parameters})
    left = [ode.states.slice(entry.name) for entry in broken.states.entries]
    return linear(loop, broken, run.t[chosen], np.concatenate([x[chosen, place] for place in left], axis=1), rows)


def linear(loop: ClosedLoop, broken: Ode, t: Array, x: Array, p: Array) -> Frozen:
    """The loop, which is `broken` once cut, linear at the states x (N, nx) with the parameters p (N, np)."""
    path, plant, seen = along(broken, t, x, p), loop.plant.states.size, loop.observer.memory
    z, now, n = seen.symbols(), ca.SX.sym("t"), loop.plant.dof
    tau, y = ca.SX.sym("tau", n), Signals({name: ca.SX.sym(name, n) for name in ("q", "qd", "d")})
    est = loop.observer.estimate(now, seen.view(z), y)
    rates = seen.flatten(loop.observer.rate(now, seen.view(z), y, est, Signals(tau=tau)))
    counts = ca.Function("counts", [z], [ca.densify(ca.jacobian(rates, tau))])
    counted, observed = np.zeros(path.B.shape), slice(plant, plant + seen.size)
    for k in range(len(t) if seen.size else 0):
        counted[k, observed] = np.array(counts(x[k, observed]))
    return Frozen(path, plant, counted)


def places(outcome: Outcome) -> np.ndarray[Any, np.dtype[np.intp]]:
    """The states that are linearised: those within the layer, of one in `EVERY`; of PID, which has none, each."""
    run = outcome.measurement.trajectories
    some = np.arange(len(run.t) - 1, 0, -EVERY)[::-1]
    if outcome.case.law == "PID":
        return some
    return np.asarray(some[(np.abs(run["s"][0][some]) < PAPER["phi"]).all(axis=1)])


def rule_of_thumb(outcome: Outcome) -> float:
    """The least 2 phi lambda_min(M) / K along a run, in s, with the largest K that M sees; infinite without a K."""
    law, run, chosen = outcome.case.law, outcome.measurement.trajectories, places(outcome)
    if law in ("PID", "super-twisting"):
        return np.inf
    q = ca.SX.sym("q", 2)
    M = ca.Function("M", [q], [ARM.mass_matrix(q)])
    least = np.array([np.linalg.eigvalsh(np.array(M(pose)))[0] for pose in run["q"][0][chosen]])
    K = np.full((1, 1), np.max(PAPER["SMC: K"])) if law == "SMC" else run["controller.K"][0][chosen]
    K = np.linalg.norm(K, 2, axis=(1, 2)) if K.ndim == 3 else K.max(axis=1)
    return float((2 * PAPER["phi"] * least / K).min())
