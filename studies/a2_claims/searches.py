"""What a2 searches: for each claim that a run can break, the equation, the claim and the bounds of the search.

`python -m studies.a2_claims.searches` searches again and stores the worst runs in `witnesses`, which is due
whenever an equation has changed: a stored run replays on the equation it was found for, and on no other.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path

import casadi as ca
import numpy as np

from studies.a2_claims import statements as paper
from studies.a2_claims.loops import (
    I,
    beside_rest,
    filtered,
    first_scenario,
    momentum,
    nonlinear,
    printed_but_for_c,
    weighted,
)
from studies.a2_claims.lyapunov import ODE, REACHES
from studies.paper.laws import RIVALS, proposed_repaired
from workbench.claims.counterexample import CounterExample, Pair, Replay
from workbench.claims.falsify import Budget, Found, Hunt
from workbench.controllers import AosmcRgs
from workbench.core import Claim
from workbench.core.claim import Declared, Signals, declared
from workbench.metrics import AbstractMetric, late_error, measure
from workbench.observers import OracleFilter, PrintedFilter
from workbench.observers.disturbance_observers import CHEN_DISSIPATES, MOMENTUM_FOLLOWS, ORACLE_FOLLOWS, PRINTED_FOLLOWS

WITNESSES = Path(__file__).parent / "witnesses"
SEED = 1
REACH = {"plant.q": (-np.pi, np.pi), "plant.qd": (-3.0, 3.0)}  # rad, rad/s: Assumption 1, as the searches take it
H, STIFF, PRINTED = 1e-3, 1e-3 / 12, 1e-4  # s: steps of the observer, of the law as repaired and as printed
QUICK = Budget(32, 6, 0)


WITHIN_4, ABOVE = Declared(paper.ASSUMPTION_4), Declared(paper.ABOVE)


def disturbances(path: str) -> dict[str, tuple[float, float]]:
    """Sines of any phase; which of them are too large or too fast, the hypothesis says."""
    return {f"{path}amplitude": (0.0, paper.D_MAX), f"{path}frequency": (0.0, 5.0), f"{path}phase": (-np.pi, np.pi)}


def late(after: float, bound: float) -> Declared:
    """A part of Theorem 1 that a run of finite length can break: |q - q_hat| <= bound [rad] from `after` s on."""

    def margin(y: Signals) -> ca.SX:
        return ca.if_else(y["t"] < after, 1e3, bound**2 - ca.sumsqr(y["q_error"]))

    return Declared(Claim("late", f"|q - q_hat| <= {bound:g} rad from {after:g} s on.", "(23)", (), margin))


def _slow(y: Signals) -> ca.SX:
    return 1e6 - ca.vertcat(ca.norm_2(y["plant.qd"]), ca.norm_2(y["observer.state.qd_hat"]))


SLOW = Declared(Claim("slow", "|qd| and |qd_hat| are below 10^6 rad/s.", "Theorem 2", (), _slow))
FED = disturbances("disturbance.")
ACTING = disturbances("plant.disturbance.")
ESTIMATES = {"q_hat": (-np.pi, np.pi), "qd_hat": (-120.0, 120.0)}


def _law(name: str, claim: str) -> Callable[[], Hunt]:
    """A rival's own promise in the first scenario, whatever the start and the disturbance."""

    def hunt() -> Hunt:
        promise = next(found for found in declared(RIVALS[name], "controller.") if found.claim.name == claim)
        return Hunt(first_scenario(name), promise, REACH | ACTING, 4.0, 5e-4, (WITHIN_4,))

    return hunt


def _repaired(target: Declared | AbstractMetric, until: float = 2.0) -> Callable[[], Hunt]:
    """A promise of the repaired law in the first scenario, or a metric of it."""
    return lambda: Hunt(proposed_repaired("FS").ode("repaired"), target, REACH | ACTING, until, STIFF, (WITHIN_4,))


def _promise(name: str) -> Declared:
    return Declared(next(claim for claim in AosmcRgs.claims if claim.name == name), "controller.")


# By name: the search, and how much of it.
TABLE: Mapping[str, tuple[Callable[[], Hunt], Budget]] = {
    "false_rest": (lambda: Hunt(beside_rest(30 * I, 50 * I), late(9.0, 0.01), ESTIMATES, 10.0, 2 * H), Budget()),
    "printed_filter": (
        lambda: Hunt(filtered(PrintedFilter), Declared(PRINTED_FOLLOWS), FED, 10.0, 5 * H, (WITHIN_4,)),
        Budget(),
    ),
    "oracle_filter": (
        lambda: Hunt(filtered(OracleFilter), Declared(ORACLE_FOLLOWS), FED, 10.0, 5 * H, (WITHIN_4,)),
        Budget(),
    ),
    "momentum": (
        lambda: Hunt(
            momentum(), Declared(MOMENTUM_FOLLOWS, "observer.disturbance."), REACH | ACTING, 4.0, 5e-4, (WITHIN_4,)
        ),
        Budget(64, 10, 0),
    ),
    "nonlinear": (
        lambda: Hunt(
            nonlinear(), Declared(CHEN_DISSIPATES, "observer.disturbance."), REACH | ACTING, 4.0, 5e-4, (WITHIN_4,)
        ),
        Budget(64, 10, 0),
    ),
    "smc": (_law("SMC", "the surface pulls the error"), Budget(64, 10, 0)),
    "asmc": (_law("ASMC", "no gain turns negative"), Budget(64, 10, 0)),
    "super_twisting": (_law("super-twisting", "the integral part has a bounded rate"), Budget(64, 10, 0)),
    "repaired_gain": (_repaired(_promise("K stays positive definite")), QUICK),
    "riccati": (_repaired(_promise("P stays positive definite")), QUICK),
    "finite_time": (lambda: Hunt(ODE, REACHES, REACH | ACTING, 2.0, PRINTED, (WITHIN_4, ABOVE)), QUICK),
    "bounded": (
        lambda: Hunt(
            weighted(printed_but_for_c(), 0.01, 1.0).ode(), SLOW, REACH | ACTING, 4.0, PRINTED, (WITHIN_4, ABOVE)
        ),
        QUICK,
    ),
    "late_error": (_repaired(late_error(5.0), 8.0), QUICK),
}


@cache
def hunt(name: str) -> Hunt:
    """A search by name; its equations are made once."""
    return TABLE[name][0]()


@cache
def found(name: str) -> Found:
    """The outcome of a search, its worst run in as few decimals as show it."""
    return hunt(name).shortened(hunt(name).search(SEED, TABLE[name][1]))


def line(name: str) -> str:
    """The line of Python that runs the worst run of a search again, from the numbers that it prints."""
    worst = found(name).worst
    assert worst is not None
    numbers: dict[str, list[float]] = {}
    for label, number in worst.sought.items():
        numbers.setdefault(label.split("[")[0], []).append(number)
    return f'rerun("{name}", {numbers})'


def rerun(name: str, numbers: Mapping[str, Sequence[float]]) -> Pair:
    """A run of a search: the metric, its error, and the worst of its hypotheses, negative where all are kept."""
    return hunt(name).at(numbers)


def stored(name: str) -> CounterExample:
    """The worst run that was stored."""
    return CounterExample.read(WITNESSES / f"{name}.json")


def replay(name: str) -> Replay:
    """Run the stored worst run of a search again."""
    return hunt(name).replay(stored(name))


def worst_component(name: str) -> int:
    """Which component of a margin the stored worst run breaks most, from 0 on."""
    task, example = hunt(name), stored(name)
    p, x0 = example.rows(task.ode)
    score = measure(task.watched, (task.metric,), p, x0, until=example.until, h=example.h).scores[task.metric.name]
    return int(np.argmax(score.value[0]))


def store() -> None:
    """Search again, and store the worst runs."""
    for name in TABLE:
        worst = found(name).worst
        if worst is not None:
            worst.write(WITNESSES / f"{name}.json")


if __name__ == "__main__":
    store()
