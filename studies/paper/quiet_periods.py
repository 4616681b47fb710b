"""The longest quiet period of a law in a computer, by scenario, start, delay and observer: what a9 and b4 share."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial

import casadi as ca
import numpy as np

import workbench as wb
from studies.paper.card import CARD as PAPER
from studies.paper.card import PROPOSED_LAW
from studies.paper.comparison import PROPOSED_STEP, STEPS
from studies.paper.late_drive import LateDrive
from studies.paper.laws import ARM, proposed_repaired
from studies.paper.linearization import SEVEN, loop_of
from studies.paper.period_rules import PeriodRules, period_rules

RMSE, TV = "sampled RMSE", "TV"
SCENARIOS = ("FS", "SS")
HORIZON = {scenario: float(PAPER[f"{scenario}: horizon"]) for scenario in SCENARIOS}  # s
SUBSTEP = 2.5e-3  # s, at most: between two instants the plant is smooth
QUIET = 2.0  # times the total variation of the loop in continuous time, at most
FACTORS = (1.5, 3.0, 10.0)  # in its place, as variations
GRID = 1e-2  # s, the sample time of (43), which every period divides
PARTS = (400, 200, 100, 50, 20, 10, 5, 2, 1)  # of the grid: the periods that a search looks at before it narrows
CLOSER = 0.5  # of a part of the grid: no closer to an end lies another period
CLOSE = 1.12  # how far apart the longest quiet period and the next one tried may be
FINER = 1e-1  # s, whose parts are tried where two neighbours of the grid are farther apart
HANDED_OVER = 2.5e-4  # s, the period at which b4 hands AOSMC-RGS over
PAPERS, ON_REFERENCE = "paper", "reference"  # starts
STARTS = {PAPERS: "the paper's start", ON_REFERENCE: "a start on the reference"}
ACTING_TORQUE, COMMANDED_TORQUE = (
    "acting",
    "commanded",
)  # the torque on which the observer of AOSMC-RGS counts, if it comes late
TRUTH, MOMENTUM = "truth", "momentum"  # what AOSMC-RGS knows of the disturbance
OBSERVERS = {
    TRUTH: "observer (10) and the true disturbance",
    MOMENTUM: "measured velocities and an observer of the momentum",
}


@dataclass(frozen=True)
class QuietSearch:
    """A law whose longest quiet period is sought in a scenario, from a start, with or without a period of delay.

    `observer` belongs to AOSMC-RGS and counts on one torque: `counts_on` says which. `limit` is the largest torque in
    N m, None for no limit.
    """

    law: str
    scenario: str = "FS"
    start: str = PAPERS
    delay: bool = False
    observer: str = TRUTH
    limit: float | None = None
    counts_on: str = ACTING_TORQUE

    @property
    def loop(self) -> wb.ClosedLoop:
        """The loop in continuous time."""
        own = momentum_loop(self.scenario) if self.observer == MOMENTUM else loop_of(self.law, self.scenario)
        return own if self.start == PAPERS else on_reference(own)


@dataclass(frozen=True, eq=False)
class QuietPeriod:
    """The answer of a search.

    `TV` (2,) is the total variation in continuous time in N m/s, and `rules` are those of that run, None for a law
    without a gain K.
    """

    search: QuietSearch
    largest_setting: wb.evidence.LargestSetting
    TV: wb.Array
    rules: PeriodRules | None

    @property
    def rule(self) -> float | None:
        """The period in s that the eigenvalues of M^-1 K give, or None.

        The mode s_(k+1) = (1 - T rho / phi) s_k grows from T = 2 phi / rho on. With a torque that is a period late,
        s_(k+1) = s_k - T rho / phi s_(k-1) grows from half of that on. Observer (10), whose estimates give the law its
        s, makes up for the delay if it counts on the commanded torque.
        """
        return None if self.rules is None else self.rules.rule / self._periods

    @property
    def bound(self) -> float | None:
        """The bound in s, or None."""
        return None if self.rules is None else self.rules.bound / self._periods

    @property
    def _periods(self) -> int:
        search = self.search
        makes_up = search.law == PROPOSED_LAW and search.observer == TRUTH and search.counts_on == COMMANDED_TORQUE
        return 2 if search.delay and not makes_up else 1


def conditions(search: QuietSearch) -> str:
    """Scenario, start and delay of a search, and what differs from the loop of a1, in words."""
    parts = [search.scenario, STARTS[search.start], "torque one period late" if search.delay else "no delay"]
    if search.observer != TRUTH:
        parts.append(OBSERVERS[search.observer])
    if search.counts_on == COMMANDED_TORQUE:
        parts.append("the observer uses the commanded torque")
    if search.limit is not None:
        parts.append(f"torque within {search.limit:g} N m")
    return ", ".join(parts)


def ends(quiet: QuietPeriod, factor: float = QUIET) -> tuple[float, float]:
    """The longest of the periods tried up to which TV is at most `factor` times that of continuous time, and the next.

    In s; the first is 0 if no period is quiet, the second infinite if all are.
    """
    met = QUIET * quiet.largest_setting.worst(TV) <= factor
    count = len(met) if met.all() else int(np.argmin(met))
    values = quiet.largest_setting.threshold.values
    return (0.0, *values)[count], (*values, float("inf"))[count]


def in_ms(bracket: tuple[float, float]) -> str:
    """The longest quiet period in ms, of a bracket in s; in words if it is outside of the periods tried."""
    low, high = bracket
    if not low:
        return f"below {1e3 * high:.2g}"
    return f"{1e3 * low:.2g}" + (" or more" if np.isinf(high) else "")


def bracket_words(bracket: tuple[float, float]) -> str:
    """The longest quiet period in ms and the next one tried, which is not quiet."""
    low, high = bracket
    if not low:
        return f"not {1e3 * high:.3g}"
    return f"{1e3 * low:.3g}, {f'not {1e3 * high:.3g}' if np.isfinite(high) else 'the longest tried'}"


def at_hand_over(quiet: QuietPeriod, factor: float = QUIET) -> str:
    """The answer to the question whether a law is quiet at the period at which b4 hands AOSMC-RGS over."""
    met = ends(quiet, factor)[0] >= HANDED_OVER
    return f"{'quiet' if met else 'not quiet'} at {1e3 * HANDED_OVER:g} ms"


def paper_searches() -> tuple[QuietSearch, ...]:
    """The searches of a9: all laws in both scenarios, and from a start on the reference in the first one.

    The second reference jumps every 2 s, so no start can spare a law its errors there; AOSMC-RGS is run from it, too.
    """
    made = [
        QuietSearch(law, scenario, start, delay)
        for law in SEVEN
        for scenario, start in (("FS", PAPERS), ("SS", PAPERS), ("FS", ON_REFERENCE))
        for delay in (False, True)
    ]
    made += [QuietSearch(PROPOSED_LAW, "SS", ON_REFERENCE, delay) for delay in (False, True)]
    made += [QuietSearch(PROPOSED_LAW, "FS", start, True, MOMENTUM) for start in STARTS]
    late = [one for one in made if one.law == PROPOSED_LAW and one.delay]
    return (*made, *(replace(one, counts_on=COMMANDED_TORQUE) for one in late))


def on_reference(loop: wb.ClosedLoop) -> wb.ClosedLoop:
    """The loop whose arm and observers start where and as fast as is wanted, as a machine is driven there before.

    An observer of the momentum starts with the momentum of that motion: with 0 it would take it for a disturbance.
    """
    wanted = loop.reference
    if not isinstance(wanted, wb.Sines | wb.SquareWave):
        raise TypeError("The loop must follow one of the paper's references.")
    q, qd = (np.array(ca.DM(part)).ravel() for part in wanted.motion(ca.SX(0.0))[:2])
    loop = replace(loop, plant=replace(loop.plant, q=q, qd=qd))
    if not isinstance(loop.observer, wb.arms.observers.StateAndDisturbanceObserver):
        return loop
    state, disturbance = loop.observer.state, loop.observer.disturbance
    if not isinstance(state, wb.ArmFullState):
        state = replace(state, q_hat=q, qd_hat=qd)
    if isinstance(disturbance, wb.arms.observers.MomentumObserver):
        disturbance = replace(disturbance, p_hat=np.array(ca.DM(ARM.mass_matrix(ca.SX(q)))) @ qd)
    return replace(loop, observer=replace(loop.observer, state=state, disturbance=disturbance))


def momentum_loop(scenario: str = "FS") -> wb.ClosedLoop:
    """AOSMC-RGS, repaired, on readings of q and qd; an observer of the momentum stands for the true disturbance."""
    return proposed_repaired(
        scenario,
        wb.arms.observers.StateAndDisturbanceObserver(
            wb.ArmFullState(2), wb.arms.observers.MomentumObserver(ARM, PAPER["l"])
        ),
    )


def metrics(period: float) -> tuple[wb.metrics.AbstractMetric, ...]:
    """(43) and the total variation of the torque that is held, period by period."""
    return wb.metrics.sampled_rmse(PAPER["sample time of (43)"]), wb.total_variation(period)


def quiet_period(search: QuietSearch) -> QuietPeriod:
    """The longest of the periods tried with at most `QUIET` times the total variation of continuous time.

    All readings are exact, and all memories step by explicit Euler.
    """
    h = STEPS.get(search.law, PROPOSED_STEP) / 2
    still = wb.measure(search.loop.ode(), metrics(1e-3), until=HORIZON[search.scenario], h=h, every=GRID)
    most = np.array([still.score(TV, joint).pair[0] for joint in (0, 1)])
    limits = wb.LoopLimits(
        partial(computer_loop, search), variation, {TV: QUIET * most}, HORIZON[search.scenario], SUBSTEP
    )
    found = wb.largest_setting(limits, [GRID / part for part in PARTS], ratio=CLOSE, between=middle)
    return QuietPeriod(search, found, most, period_rules(search.law, still))


def variation(period: float) -> tuple[wb.metrics.AbstractMetric, ...]:
    """The total variation alone: it needs no period that divides the sample time of (43)."""
    return (wb.total_variation(period),)


def computer_loop(search: QuietSearch, period: float) -> wb.DigitalLoop:
    """The loop of a search in a computer with exact readings and a period in s."""
    loop = search.loop
    bounds: Mapping[str, tuple[float, float]] = {"tau": (-search.limit, search.limit)} if search.limit else {}
    instruments = wb.Instruments.of(loop.plant, limit=bounds) if bounds else None
    waiting = None
    if search.delay:  # the torque of the first instant waits already
        ode = loop.ode()
        first = ode.outputs_at(0.0, ode.states.default)["tau"]
        waiting = {"tau": first if search.limit is None else np.clip(first, -search.limit, search.limit)}
        if search.counts_on == COMMANDED_TORQUE:
            drive = LateDrive("tau", waits=waiting["tau"])
            return wb.DigitalLoop(replace(loop, plant=wb.EquippedPlant(loop.plant, (drive,))), period, instruments)
    return wb.DigitalLoop(loop, period, instruments, search.delay, waiting)


def middle(low: float, high: float) -> float | None:
    """The period 10 ms / m between two others that is nearest to their geometric mean.

    Between neighbours it is the nearest 100 ms / m, or None if these are neighbours, too.
    """
    for grid in (GRID, FINER):
        most, least = grid / low, grid / high
        part = round(np.sqrt(most * least))
        if least + CLOSER < part < most - CLOSER:
            return float(grid / part)
    return None
