"""What a2 searches: for each claim that a run can break, the equation, the claim and the bounds of the search.

`python studies/claims_hunts.py` searches again and stores the worst runs in `studies/witnesses`, which is due
whenever an equation has changed: a stored run replays on the equation it was found for, and on no other.
"""

from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path

import casadi as ca
import numpy as np
from claims_loops import I, beside_rest, filtered, first_scenario, free_arm, momentum, nonlinear
from claims_lyapunov import DECREASES, ODE, REACHES
from paper_laws import RIVALS

from workbench.controllers import AosmcRgs
from workbench.core import Claim
from workbench.core.claim import Declared, Signals, declared
from workbench.metrics import AbstractMetric, late_error, measure
from workbench.observers import OracleFilter, PrintedFilter
from workbench.observers.promises import CHEN_DISSIPATES, MOMENTUM_FOLLOWS, ORACLE_FOLLOWS, PRINTED_FOLLOWS
from workbench.verify.counterexample import CounterExample, Replay
from workbench.verify.falsify import Budget, Found, Hunt

WITNESSES = Path(__file__).parent / "witnesses"
SEED = 1
REACH = {"plant.q": (-np.pi, np.pi), "plant.qd": (-3.0, 3.0)}  # rad, rad/s: Assumption 1, as the searches take it
D_MAX, L_D = 0.65, 2.2  # N m, N m/s: Assumption 4, just above what both scenarios need
H, STIFF = 1e-3, 1e-3 / 12  # s: steps of the observer and the rivals, and of the proposed law
WIDE, QUICK = Budget(512, 14, 3), Budget(32, 6, 0)


def _assumption_4(y: Signals) -> ca.SX:
    return ca.vertcat(D_MAX**2 - ca.sumsqr(y["d"]), L_D**2 - ca.sumsqr(y["d'"]))


WITHIN_4 = Declared(
    Claim("Assumption 4, in numbers", f"|D| <= {D_MAX} N m, |D'| <= {L_D} N m/s.", "(8)", (), _assumption_4)
)


def disturbances(path: str) -> dict[str, tuple[float, float]]:
    """Sines of any phase; which of them are too large or too fast, the hypothesis says."""
    return {f"{path}amplitude": (0.0, D_MAX), f"{path}frequency": (0.0, 5.0), f"{path}phase": (-np.pi, np.pi)}


def late(after: float, bound: float) -> Declared:
    """A part of Theorem 1 that a run of finite length can break: |q - q_hat| <= bound [rad] from `after` s on."""

    def margin(y: Signals) -> ca.SX:
        return ca.if_else(y["t"] < after, 1e3, bound**2 - ca.sumsqr(y["q_error"]))

    return Declared(Claim("late", f"|q - q_hat| <= {bound:g} rad from {after:g} s on.", "(23)", (), margin))


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
    return lambda: Hunt(ODE, target, REACH | ACTING, until, STIFF, (WITHIN_4,))


def _promise(name: str) -> Declared:
    return Declared(next(claim for claim in AosmcRgs.claims if claim.name == name), "controller.")


# By name: the search, and how much of it.
TABLE: Mapping[str, tuple[Callable[[], Hunt], Budget]] = {
    "false_rest": (lambda: Hunt(beside_rest(30 * I, 50 * I), late(9.0, 0.01), ESTIMATES, 10.0, 2 * H), Budget()),
    "swinging_arm": (lambda: Hunt(free_arm(), late(3.5, 5.0), REACH, 4.0, H), WIDE),
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
    "decrease": (_repaired(DECREASES), QUICK),
    "finite_time": (_repaired(REACHES), QUICK),
    "late_error": (_repaired(late_error(5.0), 8.0), QUICK),
}


@cache
def hunt(name: str) -> Hunt:
    """A search by name; its equations are made once."""
    return TABLE[name][0]()


@cache
def found(name: str) -> Found:
    """What a search comes to."""
    return hunt(name).search(SEED, TABLE[name][1])


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
