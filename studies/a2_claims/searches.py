"""The searches for the worst run: by claim, the equation, the target and the bounds.

`python -m studies.a2_claims.searches` searches again and stores the worst runs in `witnesses`, which is due
whenever an equation has changed: a stored run replays on the equation it was found for, and on no other.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from studies.a2_claims import margins
from studies.a2_claims.loops import I, beside_rest, filtered, observed, printed_but_for_c, weighted
from studies.a2_claims.margins import D_MAX, KEPT, WITHIN_4
from studies.paper.card import CARD
from studies.paper.laws import ARM, RIVALS, proposed_repaired, rival
from workbench.claims.counterexample import CounterExample, Pair
from workbench.claims.falsify import Budget, Found, Hunt
from workbench.controllers.aosmc_rgs import K_STAYS_DEFINITE, P_STAYS_DEFINITE
from workbench.core import Ode
from workbench.core.claim import Declared, declared
from workbench.metrics import AbstractMetric, late_error, measure
from workbench.observers import MomentumObserver, NonlinearDisturbanceObserver, OracleFilter, PrintedFilter
from workbench.observers.disturbance_observers import CHEN_DISSIPATES, MOMENTUM_FOLLOWS, ORACLE_FOLLOWS, PRINTED_FOLLOWS

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
    return Search(lambda: filtered(kind), promise, FED, 10.0, 5e-3, budget=Budget())


def _disturbance_observer(kind: type, promise: Declared) -> Search:
    """A disturbance observer beside the true state."""
    return Search(lambda: observed(kind(ARM, CARD["l"])), promise, ANY_RUN, 4.0, 5e-4, budget=WIDE)


def _repaired(target: Declared | AbstractMetric, until: float = 2.0) -> Search:
    """A promise of the repaired law in the first scenario, or a metric of it."""
    return Search(lambda: proposed_repaired("FS").ode("repaired"), target, ANY_RUN, until, STIFF)


TABLE: Mapping[str, Search] = {
    "false_rest": Search(
        lambda: beside_rest(30 * I, 50 * I), margins.late(9.0, 0.01), ESTIMATES, 10.0, 2e-3, (), Budget()
    ),
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
    "finite_time": Search(lambda: margins.ODE, Declared(margins.REACHES), ANY_RUN, 2.0, PRINTED, KEPT),
    "bounded": Search(
        lambda: weighted(printed_but_for_c(), 0.01, 1.0).ode(), Declared(margins.SLOW), ANY_RUN, 4.0, PRINTED, KEPT
    ),
    "late_error": _repaired(late_error(5.0), 8.0),
}


@cache
def hunt(name: str) -> Hunt:
    """A search by name; its equations are made once."""
    search = TABLE[name]
    return Hunt(search.ode(), search.target, search.box, search.until, search.h, search.kept)


@cache
def found(name: str) -> Found:
    """The outcome of a search, its worst run in as few decimals as show it."""
    return hunt(name).shortened(hunt(name).search(SEED, TABLE[name].budget))


def line(name: str) -> str:
    """The line of Python that runs the worst run of a search again, from the numbers that it prints."""
    numbers: dict[str, list[float]] = {}
    for label, number in found(name).worst.sought.items():
        numbers.setdefault(label.split("[")[0], []).append(number)
    return f'rerun("{name}", {numbers})'


def rerun(name: str, numbers: Mapping[str, Sequence[float]]) -> Pair:
    """A run of a search: the metric, its error, and the worst of its hypotheses, negative where all are kept."""
    return hunt(name).at(numbers)


def stored(name: str) -> CounterExample:
    """The worst run that was stored."""
    return CounterExample.read(WITNESSES / f"{name}.json")


def worst_component(name: str) -> int:
    """The component of a margin that the stored worst run breaks most, from 0 on."""
    task, example = hunt(name), stored(name)
    p, x0 = example.rows(task.ode)
    score = measure(task.watched, (task.metric,), p, x0, until=example.until, h=example.h).scores[task.metric.name]
    return int(np.argmax(score.value[0]))


if __name__ == "__main__":
    for name in TABLE:
        if (worst := found(name).worst) is not None:
            worst.write(WITNESSES / f"{name}.json")
