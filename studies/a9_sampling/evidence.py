"""The runs of a9: the laws in continuous time and in computers, their order, and the longest quiet periods."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import combinations, product

import numpy as np

import workbench as wb
from studies.a9_sampling.loops import REALISTIC, WAYS, Audit, Computer, name_of
from studies.paper.card import MARGIN, PROPOSED_LAW, PUBLISHED_COLUMNS
from studies.paper.linearization import SEVEN, loop_of
from studies.paper.quiet_periods import RMSE, SCENARIOS, TV, QuietPeriod, paper_searches, quiet_period

PERIODS = (1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2)  # s; each divides the 10 ms of (43)
APART = (5e-3, 1e-2)  # s, the periods at which integrator and law are told apart
STEPS = (5e-5, 1e-4, 2e-4, 5e-4, 1e-3, 2e-3)  # s, of RK4 through a loop in continuous time
SUBSTEPS = (1, 2, 5)  # of the plant within a period of the computer
SHORT = 10.0  # s, of the runs over the step
SWITCHING = {"clip": "layer", "sign": "relay"}
PLACES = tuple((scenario, joint) for scenario in SCENARIOS for joint in (0, 1))
ROWS = (  # of tables and figures: a law, how its memory steps, and what it is called there
    (PROPOSED_LAW, "euler", f"{PROPOSED_LAW}, Euler"),
    (PROPOSED_LAW, "cayley", f"{PROPOSED_LAW}, Cayley"),
    *((law, "euler", law) for law in SEVEN if law != PROPOSED_LAW),
)
Key = tuple[str, str, Computer | None]  # law, scenario, and the computer; None for continuous time
Pair = tuple[str, int, str, str]  # scenario, joint, the law that is lower, the law that is higher
Score = tuple[float, float]
Scores = Callable[[str, str, int], Score]  # of a law, a scenario and a joint


@dataclass(frozen=True, eq=False)
class Evidence:
    """The loops in continuous time and those run by computers, and the longest quiet periods."""

    audits: Mapping[Key, Audit]
    quiet: tuple[QuietPeriod, ...]

    def audit(self, law: str, scenario: str, period: float, stepping: str = "euler", delay: bool = False) -> Audit:
        """A law with its layer run by a computer; AOSMC-RGS steps in one of `WAYS`, all others by explicit Euler."""
        way = stepping if law == PROPOSED_LAW else "euler"
        return self.audits[law, scenario, Computer(period, delay, stepping=way)]

    def continuous_scores(self, metric: str) -> Scores:
        """The scores in continuous time."""
        return lambda law, scenario, joint: self.audits[law, scenario, None].score(metric, joint)

    def computer_scores(
        self, metric: str, period: float, stepping: str = "euler", delay: bool = False, noisy: bool = False
    ) -> Scores:
        """The scores with a computer."""
        return lambda law, scenario, joint: self.audit(law, scenario, period, stepping, delay).score(
            metric, joint, noisy
        )

    def lost_by(
        self, way: str, scenario: str, period: float, above: float = np.inf, delay: bool = False
    ) -> wb.core.Integers:
        """(1 + runs,): 1 for a run of AOSMC-RGS that diverges, or has more than `above` times the continuous RMSE.

        The run with exact readings comes first.
        """
        audit = self.audit(PROPOSED_LAW, scenario, period, way, delay)
        still = [self.continuous_scores(RMSE)(PROPOSED_LAW, scenario, joint)[0] for joint in (0, 1)]
        errors = np.vstack([audit.values[RMSE], audit.noisy[RMSE]])
        return (np.isnan(errors) | (errors > above * np.array(still))).any(axis=1).astype(int)

    def causes(self, scenario: str, period: float, above: float = np.inf, delay: bool = False) -> wb.evidence.Causes:
        """Why AOSMC-RGS loses the runs that explicit Euler loses, at a period at which all ways were run."""
        ways = {way: self.lost_by(way, scenario, period, above, delay) for way in WAYS}
        return wb.evidence.Causes({way: lost[ways["euler"] == 1] for way, lost in ways.items()})

    def worst_step(self, metric: str, period: float) -> float:
        """The largest relative error of a metric by half the substep, of all runs of `ROWS` that stayed finite."""
        scores = (self.computer_scores(metric, period, way)(law, *place) for law, way, _ in ROWS for place in PLACES)
        return max(error / value for value, error in scores if np.isfinite(value))

    def growth(self, metric: str, law: str, now: Scores, scenarios: tuple[str, ...] = SCENARIOS) -> float:
        """The largest ratio of a metric with a computer to the same in continuous time, over joints and scenarios."""
        still = self.continuous_scores(metric)
        places = [place for place in PLACES if place[0] in scenarios]
        return max(now(law, *place)[0] / still(law, *place)[0] for place in places)

    def searches_with(self, **fields: object) -> tuple[QuietPeriod, ...]:
        """The searches whose fields have these values."""
        return tuple(
            one for one in self.quiet if all(getattr(one.search, name) == value for name, value in fields.items())
        )


def gather_evidence(results: wb.Results) -> Evidence:
    """The evidence in the runs and searches of the study."""
    audits: dict[Key, Audit] = {(o.case.law, o.case.scenario, None): _continuous(o) for o in results.outcomes}
    audits |= {one: Audit.of(results.sample(name_of(*one))) for one in plan()}
    return Evidence(audits, results.work("quiet"))


def works() -> tuple[wb.Work, ...]:
    """The searches for the longest quiet periods, and the curves over the step."""
    return wb.Work("quiet", quiet_period, paper_searches(), seconds=10.0), wb.Work("steps", curve, CURVES, seconds=1.0)


def plan() -> Iterator[tuple[str, str, Computer]]:
    """The laws and the computers on which they run."""
    for law, way in (*((law, "euler") for law in SEVEN), (PROPOSED_LAW, "cayley")):
        for scenario in SCENARIOS:
            yield from ((law, scenario, Computer(period, stepping=way)) for period in PERIODS)
            yield law, scenario, Computer(REALISTIC, delay=True, stepping=way)
    for scenario, period, way in product(SCENARIOS, APART, WAYS):
        if way in ("cayley34", "fine"):
            yield PROPOSED_LAW, scenario, Computer(period, stepping=way)
        yield PROPOSED_LAW, scenario, Computer(period, delay=True, stepping=way)


def _continuous(outcome: wb.study.Outcome) -> Audit:
    found = outcome.measurement
    pairs = {name: np.array([one.pair for one in found.scores_of(name)]).T for name in found.names}
    values, errors = ({name: both[i] for name, both in pairs.items()} for i in (0, 1))
    return Audit(values, errors, {})


def side_of(a: Score, b: Score, margin: float = MARGIN) -> str:
    """The side of b on which a lies; a run that diverged is above all others, and beside another one undecided."""
    if np.isinf(a[0]) or np.isinf(b[0]):
        return "undecided" if a[0] == b[0] else "above" if np.isinf(a[0]) else "below"
    return wb.evidence.order(a, b, margin)


def printed_pairs(scores: Scores, margin: float = MARGIN) -> dict[str, set[Pair]]:
    """The 60 pairs of the two published tables, by (43): below as printed, above, or too close to call."""
    kinds: dict[str, set[Pair]] = {"below": set(), "above": set(), "undecided": set()}
    for scenario, joint in PLACES:
        values = PUBLISHED_COLUMNS[scenario, joint + 1].values
        for a, b in combinations(sorted(values, key=lambda law: values[law]), 2):
            side = side_of(scores(a, scenario, joint), scores(b, scenario, joint), margin)
            kinds[side].add((scenario, joint, a, b))
    return kinds


@dataclass(frozen=True, eq=False)
class Curve:
    """TV (N, 2) in N m/s over steps h (N,) in s, of one law, one switching, with or without a computer."""

    law: str
    switching: str
    digital: bool
    h: wb.Array
    TV: wb.Array


CURVES = tuple((law, way, held) for law in ("SMC", PROPOSED_LAW) for way in SWITCHING for held in (False, True))


def curve(kind: tuple[str, str, bool]) -> Curve:
    """TV over the step of a law and a switching, in continuous time or run by a computer.

    The torque is looked at once a step, or once a period of the computer, which holds it.
    """
    law, switching, held = kind  # by a computer
    loop = loop_of(law, "FS")
    loop = replace(loop, controller=replace(loop.controller, saturation=switching))
    equation = loop.digital(REALISTIC) if held else loop.ode()
    steps = np.array([REALISTIC / m for m in SUBSTEPS] if held else STEPS)
    rows = []
    for h in steps.tolist():
        metric = wb.total_variation(REALISTIC if held else h)
        found = wb.measure(equation, (metric,), until=SHORT, every=SHORT, h=h)
        rows.append([found.score(TV, joint).pair[0] for joint in (0, 1)])
    return Curve(law, switching, held, steps, np.array(rows))
