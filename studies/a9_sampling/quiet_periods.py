"""The longest quiet period of a law in a computer, by scenario, start, delay and observer: what a9 and b4 share."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial

import casadi as ca
import numpy as np

from studies.a1_paper_tables.study import PROPOSED_STEP, STEPS
from studies.a9_sampling.loops import HORIZON, SUBSTEP, TV, metrics
from studies.paper.card import CARD as PAPER
from studies.paper.card import PROPOSED
from studies.paper.laws import ARM, proposed_repaired
from studies.paper.linearization import SEVEN, loop_of
from workbench.loop import ClosedLoop, DigitalLoop, Instruments
from workbench.metrics import Measurement, measure
from workbench.notation.formula import Number, Product, Quotient, symbol
from workbench.observers import FullState, MomentumObserver, WithDisturbance
from workbench.study.evidence import LargestSetting, LoopLimits, largest_setting
from workbench.validation.refusals import Array

QUIET = 2.0  # times the total variation of the loop in continuous time, at most
FACTORS = (1.5, 3.0, 10.0)  # in its place, as variations
RULE = Quotient(Product((Number(Fraction(2)), symbol("phi"), symbol("lambda_min"))), symbol("K"))  # of thumb, in s
GRID = 1e-2  # s, the sample time of (43), which every period divides
PARTS = (400, 200, 100, 50, 20, 10, 5, 2, 1)  # of the grid: the periods that a search looks at before it narrows
CLOSE = 1.12  # how far apart the longest quiet period and the next one tried may be
EVERY = 25  # of the kept states of a run, one in 10 ms, the rule of thumb looks at one in so many
GAINLESS = ("PID", "super-twisting")  # the rule of thumb has no gain K for these
HANDED_OVER = 2.5e-4  # s, the period at which b4 hands AOSMC-RGS over
PAPERS, ON_REFERENCE = "paper", "reference"  # starts
STARTS = {PAPERS: "the paper's start", ON_REFERENCE: "a start on the reference"}
TRUTH, MOMENTUM = "truth", "momentum"  # what AOSMC-RGS knows of the disturbance
OBSERVERS = {
    TRUTH: "observer (10) and the true disturbance",
    MOMENTUM: "measured velocities and an observer of the momentum",
}


@dataclass(frozen=True)
class QuietSearch:
    """A law whose longest quiet period is sought in a scenario, from a start, with or without a period of delay.

    `observer` is that of AOSMC-RGS, and `limit` the largest torque in N m, None for no limit.
    """

    law: str
    scenario: str = "FS"
    start: str = PAPERS
    delay: bool = False
    observer: str = TRUTH
    limit: float | None = None

    @property
    def loop(self) -> ClosedLoop:
        """The loop in continuous time."""
        own = momentum_loop(self.scenario) if self.observer == MOMENTUM else loop_of(self.law, self.scenario)
        return own if self.start == PAPERS else on_reference(own)


@dataclass(frozen=True, eq=False)
class QuietPeriod:
    """The answer of a search.

    `TV` (2,) is the total variation in continuous time in N m/s, `K` the largest gain along that run in N m, and `rule`
    the rule of thumb in s; both are None for a law without a gain K.
    """

    search: QuietSearch
    found: LargestSetting
    TV: Array
    K: float | None
    rule: float | None


def conditions(search: QuietSearch) -> str:
    """Scenario, start and delay of a search, and what differs from the loop of a1, in words."""
    parts = [search.scenario, STARTS[search.start], "torque a period late" if search.delay else "no delay"]
    if search.observer != TRUTH:
        parts.append(OBSERVERS[search.observer])
    if search.limit is not None:
        parts.append(f"torque within {search.limit:g} N m")
    return ", ".join(parts)


def ends(quiet: QuietPeriod, factor: float = QUIET) -> tuple[float, float]:
    """The longest of the periods tried up to which TV is at most `factor` times that of continuous time, and the next.

    In s; the first is 0 if no period is quiet, the second infinite if all are.
    """
    met = QUIET * quiet.found.worst(TV) <= factor
    count = len(met) if met.all() else int(np.argmin(met))
    values = quiet.found.threshold.values
    return (0.0, *values)[count], (*values, float("inf"))[count]


def in_ms(bracket: tuple[float, float]) -> str:
    """The longest quiet period in ms, of a bracket in s; in words if it is outside of the periods tried."""
    low, high = bracket
    if not low:
        return f"below {1e3 * high:.2g}"
    return f"{1e3 * low:.2g}" + (" or more" if np.isinf(high) else "")


def at_hand_over(quiet: QuietPeriod, factor: float = QUIET) -> str:
    """The answer to the question whether a law is quiet at the period at which b4 hands AOSMC-RGS over."""
    met = ends(quiet, factor)[0] >= HANDED_OVER
    return f"{'quiet' if met else 'not quiet'} at {1e3 * HANDED_OVER:g} ms"


def paper_searches() -> tuple[QuietSearch, ...]:
    """The searches of a9: all laws in both scenarios, and from a start on the reference in the first one.

    The second reference jumps every 2 s, so no start can spare a law its errors there.
    """
    made = [
        QuietSearch(law, scenario, start, delay)
        for law in SEVEN
        for scenario, start in (("FS", PAPERS), ("SS", PAPERS), ("FS", ON_REFERENCE))
        for delay in (False, True)
    ]
    made += [QuietSearch(PROPOSED, "FS", start, True, MOMENTUM) for start in STARTS]
    return tuple(made)


def on_reference(loop: ClosedLoop) -> ClosedLoop:
    """The loop whose arm and observers start where and as fast as is wanted, as a machine is driven there before.

    An observer of the momentum starts with the momentum of that motion: with 0 it would take it for a disturbance.
    """
    q, qd = (np.array(ca.DM(part)).ravel() for part in loop.reference.motion(0.0)[:2])
    loop = replace(loop, plant=replace(loop.plant, q=q, qd=qd))
    if not isinstance(loop.observer, WithDisturbance):
        return loop
    state, disturbance = loop.observer.state, loop.observer.disturbance
    if not isinstance(state, FullState):
        state = replace(state, q_hat=q, qd_hat=qd)
    if isinstance(disturbance, MomentumObserver):
        disturbance = replace(disturbance, p_hat=np.array(ca.DM(ARM.mass_matrix(q))) @ qd)
    return replace(loop, observer=replace(loop.observer, state=state, disturbance=disturbance))


def momentum_loop(scenario: str = "FS") -> ClosedLoop:
    """AOSMC-RGS, repaired, on readings of q and qd; an observer of the momentum stands for the true disturbance."""
    return proposed_repaired(scenario, WithDisturbance(FullState(2), MomentumObserver(ARM, PAPER["l"])))


def quiet_period(search: QuietSearch) -> QuietPeriod:
    """The longest of the periods 10 ms / m with at most `QUIET` times the total variation of continuous time.

    All readings are exact, and all memories step by explicit Euler.
    """
    h = STEPS.get(search.law, PROPOSED_STEP) / 2
    still = measure(search.loop.ode(), metrics(1e-3), until=HORIZON[search.scenario], h=h, every=GRID)
    most = np.array([still.score(TV, joint).pair[0] for joint in (0, 1)])
    limits = LoopLimits(partial(computed, search), metrics, {TV: QUIET * most}, HORIZON[search.scenario], SUBSTEP)
    found = largest_setting(limits, [GRID / part for part in PARTS], ratio=CLOSE, between=middle)
    K, rule = (None, None) if search.law in GAINLESS else rule_of_thumb(search.law, still)
    return QuietPeriod(search, found, most, K, rule)


def computed(search: QuietSearch, period: float) -> DigitalLoop:
    """The loop of a search in a computer with exact readings and a period in s."""
    loop = search.loop
    bounds: Mapping[str, tuple[float, float]] = {"tau": (-search.limit, search.limit)} if search.limit else {}
    instruments = Instruments.of(loop.plant, limit=bounds) if bounds else None
    waiting = None
    if search.delay:  # the torque of the first instant waits already
        ode = loop.ode()
        waiting = {"tau": ode.outputs_at(0.0, ode.states.default)["tau"]}
    return DigitalLoop(loop, period, instruments, search.delay, waiting)


def middle(low: float, high: float) -> float | None:
    """The period 10 ms / m between two others that is nearest to their geometric mean; None between neighbours."""
    most, least = round(GRID / low), round(GRID / high)
    return GRID / round(np.sqrt(most * least)) if most - least > 1 else None


def rule_of_thumb(law: str, still: Measurement) -> tuple[float, float]:
    """The largest gain K in N m and the least 2 phi lambda_min(M) / K in s along a run, within the layer."""
    run = still.trajectories
    some = np.arange(len(run.t) - 1, 0, -EVERY)[::-1]
    chosen = some[(np.abs(run["s"][0][some]) < PAPER["phi"]).all(axis=1)]
    q = ca.SX.sym("q", 2)
    M = ca.Function("M", [q], [ARM.mass_matrix(q)])
    least = np.array([np.linalg.eigvalsh(np.array(M(pose)))[0] for pose in run["q"][0][chosen]])
    K = np.full((1, 1), np.max(PAPER["SMC: K"])) if law == "SMC" else run["controller.K"][0][chosen]
    K = np.linalg.norm(K, 2, axis=(1, 2)) if K.ndim == 3 else K.max(axis=1)
    return float(K.max()), float((2 * PAPER["phi"] * least / K).min())
