"""All that a9 measures: the laws in continuous time and by computers, their order, and the longest safe periods."""

from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from studies.a9_sampling.loops import REALISTIC, SCENARIOS, TV, WAYS, Audit, Computer, audit, exact
from studies.a9_sampling.safe_periods import Longest, frozen, linear_limit, longest, rule_of_thumb
from studies.paper.card import PUBLISHED
from studies.paper.comparison import MARGIN
from studies.paper.linearization import PROPOSED, SEVEN
from workbench.study.evidence.causes import Causes
from workbench.study.evidence.law_tables import order
from workbench.study.study import Outcome, Results

PERIODS = (1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2)  # s; each divides the 10 ms of (43)
APART = (5e-3, 1e-2)  # s, the periods at which integrator and law are told apart
QUIET = 2.0  # times the total variation of the continuous loop, at most
PLACES = tuple((scenario, joint) for scenario in SCENARIOS for joint in (0, 1))
ROWS = (  # of tables and figures: a law, how its memory steps, and what it is called there
    (PROPOSED, "euler", f"{PROPOSED}, Euler"),
    (PROPOSED, "cayley", f"{PROPOSED}, Cayley"),
    *((law, "euler", law) for law in SEVEN if law != PROPOSED),
)
Key = tuple[str, str, Computer | None]  # law, scenario, and the computer; None for continuous time
Pair = tuple[str, int, str, str]  # scenario, joint, the law that is lower, the law that is higher
Score = tuple[float, float]
Scores = Callable[[str, str, int], Score]  # of a law, a scenario and a joint


@dataclass(frozen=True)
class Safe:
    """The longest periods of a law that do not chatter (quiet), and what foretells them.

    `rule`, infinite without a gain K, and `multipliers` are in s; pairs are without a period of delay and with it.
    """

    rule: float
    multipliers: tuple[float, float]
    quiet: tuple[Longest, Longest]


@dataclass(frozen=True, eq=False)
class Evidence:
    """The loops in continuous time and those run by computers, and the safe periods by law."""

    audits: Mapping[Key, Audit]
    safe: Mapping[str, Safe]

    def found(self, law: str, scenario: str, period: float, stepping: str = "euler", delay: bool = False) -> Audit:
        """A law with its layer run by a computer; AOSMC-RGS steps in one of `WAYS`, all others by explicit Euler."""
        way = stepping if law == PROPOSED else "euler"
        return self.audits[law, scenario, Computer(period, delay, stepping=way)]

    def still(self, metric: str) -> Scores:
        """The scores in continuous time."""
        return lambda law, scenario, joint: self.audits[law, scenario, None].score(metric, joint)

    def at(
        self, metric: str, period: float, stepping: str = "euler", delay: bool = False, noisy: bool = False
    ) -> Scores:
        """The scores with a computer."""
        return lambda law, scenario, joint: self.found(law, scenario, period, stepping, delay).score(
            metric, joint, noisy
        )

    def causes(self, scenario: str, period: float) -> Causes:
        """Why the runs of AOSMC-RGS diverge that explicit Euler loses, of those periods at which all ways were run."""
        ways = {way: self.found(PROPOSED, scenario, period, way).lost for way in WAYS}
        return Causes({way: lost[ways["euler"] == 1] for way, lost in ways.items()})

    def worst_step(self, metric: str, period: float) -> float:
        """The largest relative change of a metric by half the substep, of all runs of `ROWS` that stayed finite."""
        scores = (self.at(metric, period, way)(law, *place) for law, way, _ in ROWS for place in PLACES)
        return max(error / value for value, error in scores if np.isfinite(value))

    def factor(self, law: str, scenario: str, joint: int, period: float = REALISTIC, noisy: bool = False) -> float:
        """Total variation with a computer over that in continuous time."""
        now = self.at(TV, period, noisy=noisy)(law, scenario, joint)[0]
        return now / self.still(TV)(law, scenario, joint)[0]


def gathered(results: Results) -> Evidence:
    """Everything, two at a time: one runs while the next is built."""
    audits: dict[Key, Audit] = {(o.case.law, o.case.scenario, None): _continuous(o) for o in results.outcomes}
    asked = tuple(plan())
    with ThreadPoolExecutor(2) as pool:
        audits |= zip(asked, pool.map(lambda one: audit(*one), asked), strict=True)
        outcomes = [tuple(results[scenario, law] for scenario in SCENARIOS) for law in SEVEN]
        safe = dict(zip(SEVEN, pool.map(lambda runs: _safe(runs, audits), outcomes), strict=True))
    return Evidence(audits, safe)


def plan() -> Iterator[tuple[str, str, Computer]]:
    """The laws and the computers on which they run."""
    for law, way in (*((law, "euler") for law in SEVEN), (PROPOSED, "cayley")):
        for scenario in SCENARIOS:
            yield from ((law, scenario, Computer(period, stepping=way)) for period in PERIODS)
            yield law, scenario, Computer(REALISTIC, delay=True, stepping=way)
    for way in ("cayley34", "fine"):
        yield from ((PROPOSED, scenario, Computer(T, stepping=way)) for scenario in SCENARIOS for T in APART)


def _continuous(outcome: Outcome) -> Audit:
    scores = outcome.measurement.scores.items()
    values, errors = ({name: getattr(s, kind).reshape(-1) for name, s in scores} for kind in ("value", "error"))
    return Audit(values, errors, {})


def _safe(runs: tuple[Outcome, ...], audits: Mapping[Key, Audit]) -> Safe:
    law, loops = runs[0].case.law, tuple(map(frozen, runs))

    def quiet(scenario: str, period: float, delay: bool) -> bool:
        key = (law, scenario, Computer(period, delay))
        values = audits[key].values if key in audits else exact(*key)
        return bool((values[TV] <= QUIET * audits[law, scenario, None].values[TV]).all())

    late = (False, True)
    return Safe(
        min(map(rule_of_thumb, runs)),
        tuple(min(linear_limit(loop, delay) for loop in loops) for delay in late),
        tuple(longest(lambda T, delay=delay: all(quiet(s, T, delay) for s in SCENARIOS)) for delay in late),
    )


def judged(a: Score, b: Score) -> str:
    """The side of b on which a lies; a run that diverged is above all others, and beside another one undecided."""
    if np.isinf(a[0]) or np.isinf(b[0]):
        return "undecided" if a[0] == b[0] else "above" if np.isinf(a[0]) else "below"
    return order(a, b, MARGIN)


def printed(scores: Scores) -> dict[str, set[Pair]]:
    """The 60 pairs of the two published tables that hold, are turned or stay open by RMSE (43)."""
    kinds: dict[str, set[Pair]] = {"below": set(), "above": set(), "undecided": set()}
    for scenario, joint in PLACES:
        values = PUBLISHED[scenario, joint + 1].values
        for a, b in combinations(sorted(values, key=lambda law: values[law]), 2):
            kinds[judged(scores(a, scenario, joint), scores(b, scenario, joint))].add((scenario, joint, a, b))
    return kinds


def tally(kinds: Mapping[str, set[Pair]]) -> str:
    """The printed pairs counted, as a sentence has them."""
    hold, turned, open_ = (len(pairs) for pairs in kinds.values())
    return f"{hold} of {hold + turned + open_} hold, {turned} are turned, {open_} open"
