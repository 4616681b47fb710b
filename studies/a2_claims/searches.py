"""The claims that a run can break, each with its margin, and the searches for the run that breaks it most.

`python -m studies.a2_claims.searches` searches again and stores the worst runs in `witnesses`, which is due
whenever an equation has changed: a stored run replays on the equation it was found for, and on no other.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

import casadi as ca
import numpy as np

from studies.a2_claims.loops import I, beside_rest, filter_24, observed, printed_but_for_c, with_weights
from studies.paper.card import CARD
from studies.paper.laws import ARM, RIVALS, proposed_repaired, rival
from workbench.claims.claim_margins import SignalsOf
from workbench.claims.counterexample import CounterExample, Pair
from workbench.claims.falsify import Budget, Found, Hunt
from workbench.controllers.aosmc_rgs import K_STAYS_DEFINITE, P_STAYS_DEFINITE
from workbench.core import Claim, Ode
from workbench.core.claim import Declared, Signals, declared
from workbench.metrics import AbstractMetric, late_error, measure
from workbench.observers import MomentumObserver, NonlinearDisturbanceObserver, OracleFilter, PrintedFilter
from workbench.observers.disturbance_observers import CHEN_DISSIPATES, MOMENTUM_FOLLOWS, ORACLE_FOLLOWS, PRINTED_FOLLOWS

D_MAX, L_D = 0.65, 2.2  # N m, N m/s: Assumption 4 in numbers, just above the needs of both scenarios
FLOOR = 2.0  # N m, a c that lambda_min(K) - delta keeps in the runs that count
ODE = printed_but_for_c().ode("as printed but for C")


def gain_left(y: Signals) -> ca.SX:
    """lambda_min(K) - |D - D_hat|, in N m: the c of (40) at an instant."""
    K = (y["controller.K"] + y["controller.K"].T) / 2
    least = (K[0, 0] + K[1, 1]) / 2 - ca.sqrt(((K[0, 0] - K[1, 1]) / 2) ** 2 + K[0, 1] ** 2)
    return least - ca.norm_2(y["d_error"])


def V2(y: Signals) -> ca.SX:
    """(36)."""
    s, M = y["s"], ARM.mass_matrix(y["observer.state.q_hat"])
    return ca.dot(s, M @ s) / 2 + ca.trace(y["controller.P"]) / 2


# In J: the estimates start at zero wherever the arm does, so it is the same in all runs.
V2_AT_START = float(
    ca.Function("V2", [ODE.t, ODE.x, ODE.p], [V2(SignalsOf(ODE))])(0, ODE.states.default, ODE.parameters.default)
)


def late(after: float, bound: float) -> Declared:
    """A part of Theorem 1 that a run of finite length can break: |q - q_hat| <= bound [rad] from `after` s on."""

    def margin(y: Signals) -> ca.SX:
        return ca.if_else(y["t"] < after, 1e3, bound**2 - ca.sumsqr(y["q_error"]))

    return Declared(Claim("late", f"|q - q_hat| <= {bound:g} rad from {after:g} s on.", "(23)", (), margin))


ASSUMPTION_4 = Claim(
    "Assumption 4",
    "|D(t)| <= D_max and |D'(t)| <= L_D in both scenarios.",
    "(8)",
    margin=lambda y: ca.vertcat(D_MAX**2 - ca.sumsqr(y["d"]), L_D**2 - ca.sumsqr(y["d'"])),
)
ABOVE = Claim("lambda_min(K) > delta", "lambda_min(K) >= |D - D_hat| at all times.", "(40)", margin=gain_left)
GAIN_FLOOR = Claim("c", f"lambda_min(K) - |D - D_hat| >= {FLOOR:g} N m.", "(40)", (), lambda y: gain_left(y) - FLOOR)
REACHES = Claim(
    "s is reached",
    "t |s(t)| <= V2(0) / c.",
    "(42)",
    (GAIN_FLOOR,),
    lambda y: V2_AT_START / FLOOR - y["t"] * ca.norm_2(y["s"]),
)
SLOW = Claim(
    "slow",
    "|qd| and |qd_hat| are below 10^6 rad/s.",
    "Theorem 2",
    margin=lambda y: 1e6 - ca.vertcat(ca.norm_2(y["plant.qd"]), ca.norm_2(y["observer.state.qd_hat"])),
)
WITHIN_4 = Declared(ASSUMPTION_4)
KEPT = (WITHIN_4, Declared(ABOVE))  # what the proof of Theorem 2 asks of each run

WITNESSES = Path(__file__).parent / "witnesses"
SEED = 1
REACH = {"plant.q": (-np.pi, np.pi), "plant.qd": (-3.0, 3.0)}  # rad, rad/s: Assumption 1, as the searches take it
ESTIMATES = {"q_hat": (-np.pi, np.pi), "qd_hat": (-120.0, 120.0)}
SINES = {"amplitude": (0.0, D_MAX), "frequency": (0.0, 5.0), "phase": (-np.pi, np.pi)}
FED = {f"disturbance.{name}": bounds for name, bounds in SINES.items()}
ANY_RUN = REACH | {f"plant.disturbance.{name}": bounds for name, bounds in SINES.items()}
STIFF, PRINTED = 1e-3 / 12, 1e-4  # s: steps of the law as repaired and as printed
QUICK, WIDE = Budget(32, 6, 0), Budget(64, 10, 0)


class Search(NamedTuple):
    """A search by its equation, what it wants broken or large, the box, horizon and step, hypotheses and budget."""

    ode: Callable[[], Ode]
    target: Declared | AbstractMetric
    box: Mapping[str, tuple[float, float]]
    until: float
    h: float
    kept: tuple[Declared, ...] = (WITHIN_4,)
    budget: Budget = QUICK


def _rival(law: str, claim: str) -> Search:
    """A rival's own promise in the first scenario, whatever the start and the disturbance."""
    promise = next(promise for promise in declared(RIVALS[law], "controller.") if promise.claim.name == claim)
    return Search(lambda: rival("FS", law).ode(f"{law}, first scenario"), promise, ANY_RUN, 4.0, 5e-4, budget=WIDE)


def _filter(kind: type[PrintedFilter] | type[OracleFilter], promise: Declared) -> Search:
    """(24) alone, as printed or repaired."""
    return Search(lambda: filter_24(kind), promise, FED, 10.0, 5e-3, budget=Budget())


def _disturbance_observer(kind: type, promise: Declared) -> Search:
    """A disturbance observer beside the true state."""
    return Search(lambda: observed(kind(ARM, CARD["l"])), promise, ANY_RUN, 4.0, 5e-4, budget=WIDE)


def _repaired(target: Declared | AbstractMetric, until: float = 2.0) -> Search:
    """A promise of the repaired law in the first scenario, or a metric of it."""
    return Search(lambda: proposed_repaired("FS").ode("repaired"), target, ANY_RUN, until, STIFF)


TABLE: Mapping[str, Search] = {
    "false_rest": Search(lambda: beside_rest(30 * I, 50 * I), late(9.0, 0.01), ESTIMATES, 10.0, 2e-3, (), Budget()),
    "printed_filter": _filter(PrintedFilter, Declared(PRINTED_FOLLOWS)),
    "oracle_filter": _filter(OracleFilter, Declared(ORACLE_FOLLOWS)),
    "momentum": _disturbance_observer(MomentumObserver, Declared(MOMENTUM_FOLLOWS, "observer.disturbance.")),
    "nonlinear": _disturbance_observer(
        NonlinearDisturbanceObserver, Declared(CHEN_DISSIPATES, "observer.disturbance.")
    ),
    "smc": _rival("SMC", "the surface pulls the error"),
    "asmc": _rival("ASMC", "no gain turns negative"),
    "super_twisting": _rival("super-twisting", "the integral part has a bounded rate"),
    "repaired_gain": _repaired(Declared(K_STAYS_DEFINITE, "controller.")),
    "riccati": _repaired(Declared(P_STAYS_DEFINITE, "controller.")),
    "finite_time": Search(lambda: ODE, Declared(REACHES), ANY_RUN, 2.0, PRINTED, KEPT),
    "bounded": Search(
        lambda: with_weights(printed_but_for_c(), 0.01, 1.0).ode(), Declared(SLOW), ANY_RUN, 4.0, PRINTED, KEPT
    ),
    "late_error": _repaired(late_error(5.0), 8.0),
}


@cache
def hunt(name: str) -> Hunt:
    """A search by name; its equations are made once."""
    search = TABLE[name]
    return Hunt(search.ode(), search.target, search.box, search.until, search.h, search.kept)


@cache
def outcome(name: str) -> Found:
    """The outcome of a search, its worst run in as few decimals as show it."""
    return hunt(name).shortened(hunt(name).search(SEED, TABLE[name].budget))


def line(name: str) -> str:
    """The line of Python that runs the worst run of a search again, from the numbers that it prints."""
    numbers: dict[str, list[float]] = {}
    for label, number in outcome(name).worst.sought.items():
        numbers.setdefault(label.split("[")[0], []).append(number)
    return f'rerun("{name}", {numbers})'


def rerun(name: str, numbers: Mapping[str, Sequence[float]]) -> Pair:
    """A run of a search: the metric, its error, and the worst of its hypotheses, negative where all are kept."""
    return hunt(name).at(numbers)


def stored_run(name: str) -> CounterExample:
    """The worst run that was stored."""
    return CounterExample.read(WITNESSES / f"{name}.json")


def worst_component(name: str) -> int:
    """The component of a margin that the stored worst run breaks most, from 0 on."""
    task, example = hunt(name), stored_run(name)
    p, x0 = example.rows(task.ode)
    score = measure(task.watched, (task.metric,), p, x0, until=example.until, h=example.h).scores[task.metric.name]
    return int(np.argmax(score.value[0]))


if __name__ == "__main__":
    for name in TABLE:
        if (worst := outcome(name).worst) is not None:
            worst.write(WITNESSES / f"{name}.json")
