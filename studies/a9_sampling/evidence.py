"""All that a9 measures, put together: audits over the period, the longest safe periods, and continuous time."""

from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from studies.a9_sampling.card import PERIODS, QUIET, REALISTIC, TRACKS
from studies.a9_sampling.loops import RMSE, SCENARIOS, SWITCHING, TV, WAYS, Audit, Computer, audit, exact
from studies.a9_sampling.safe_periods import Longest, exact_limit, frozen, longest, rule_of_thumb
from studies.paper.card import LAWS, PUBLISHED
from studies.paper.comparison import MARGIN
from studies.paper.linearization import PROPOSED, SEVEN
from workbench.study.evidence.causes import Causes
from workbench.study.evidence.law_tables import order
from workbench.study.study import Outcome, Results
from workbench.validation.refusals import Array

APART = (5e-3, 1e-2)  # s, the periods at which integrator and law are told apart
SOME = (2e-4, 1e-3, 5e-3)  # s, the periods at which the other ways to switch are looked at
PLACES = tuple((scenario, joint) for scenario in SCENARIOS for joint in (0, 1))
ROWS = (  # of tables and figures: a law, how its memory steps, and what it is called there
    (PROPOSED, "euler", f"{PROPOSED}, Euler"),
    (PROPOSED, "cayley", f"{PROPOSED}, Cayley"),
    *((law, "euler", law) for law in SEVEN if law != PROPOSED),
)
Score = tuple[float, float]
Scores = Callable[[str, str, int], Score]  # of a law, a scenario and a joint


@dataclass(frozen=True)
class Safe:
    """The longest periods of a law that do not chatter (quiet) and keep the error (tracks); what foretells the first.

    `rule`, None without a gain K, and `multipliers` are in s; the names with `late` are with a period of delay.
    """

    rule: float | None
    multipliers: float
    late_multipliers: float
    quiet: Longest
    late_quiet: Longest
    tracks: Longest
    late_tracks: Longest


@dataclass(frozen=True, eq=False)
class Evidence:
    """The loops in continuous time by (law, scenario), those run by computers, and the safe periods by law."""

    continuous: Mapping[tuple[str, str], Audit]
    audits: Mapping[tuple[str, str, Computer], Audit]
    safe: Mapping[str, Safe]

    def still(self, metric: str) -> Scores:
        """The scores in continuous time."""
        return lambda law, scenario, joint: self.continuous[law, scenario].score(metric, joint)

    def at(
        self, metric: str, period: float, delay: bool = False, noisy: bool = False, stepping: str = "euler"
    ) -> Scores:
        """The scores with a computer, in which AOSMC-RGS steps in one of `WAYS` and all others by explicit Euler."""

        def score(law: str, scenario: str, joint: int) -> Score:
            way = stepping if law == PROPOSED else "euler"
            found = self.audits[law, scenario, Computer(period, delay, stepping=way)]
            return found.noisy_score(metric, joint) if noisy else found.score(metric, joint)

        return score

    def lost(self, law: str, scenario: str, period: float, stepping: str = "euler") -> int:
        """How many runs without delay diverged, the one with exact readings and those with noise."""
        way = stepping if law == PROPOSED else "euler"
        return int(self.audits[law, scenario, Computer(period, stepping=way)].lost.sum())

    def causes(self, scenario: str, period: float) -> Causes:
        """Why the runs of AOSMC-RGS diverge that explicit Euler loses, of those periods at which all ways were run."""
        ways = {way: self.audits[PROPOSED, scenario, Computer(period, stepping=way)].lost for way in WAYS}
        return Causes({way: lost[ways["euler"] == 1] for way, lost in ways.items()})

    def worst_step(self, metric: str, period: float) -> float:
        """The largest relative change of a metric by half the substep, of all runs of `ROWS` that stayed finite."""
        found = (self.at(metric, period, stepping=way)(law, *place) for law, way, _ in ROWS for place in PLACES)
        return max(error / value for value, error in found if np.isfinite(value))


def gathered(results: Results) -> Evidence:
    """Everything, two at a time: one runs while the next is built."""
    continuous = {(o.case.law, o.case.scenario): _audit(o) for o in results.outcomes}
    asked = tuple(plan())
    with ThreadPoolExecutor(2) as pool:
        audits = dict(zip(asked, pool.map(lambda one: audit(*one), asked), strict=True))
        outcomes = [tuple(results[scenario, law] for scenario in SCENARIOS) for law in SEVEN]
        safe = dict(zip(SEVEN, pool.map(lambda runs: _safe(runs, continuous, audits), outcomes), strict=True))
    return Evidence(continuous, audits, safe)


def plan() -> Iterator[tuple[str, str, Computer]]:
    """Which laws run on which computers."""
    for period in PERIODS:
        yield from ((law, scenario, Computer(period)) for law in SEVEN for scenario in SCENARIOS)
        yield from ((PROPOSED, scenario, Computer(period, stepping="cayley")) for scenario in SCENARIOS)
    yield from ((law, scenario, Computer(REALISTIC, delay=True)) for law in SEVEN for scenario in SCENARIOS)
    yield from ((PROPOSED, scenario, Computer(REALISTIC, True, stepping="cayley")) for scenario in SCENARIOS)
    for way in ("cayley34", "fine"):
        yield from ((PROPOSED, scenario, Computer(T, stepping=way)) for scenario in SCENARIOS for T in APART)
    for switching, laws in SWITCHING.items():
        yield from ((law, "FS", Computer(period, switching=switching)) for law in laws for period in SOME)


def _audit(outcome: Outcome) -> Audit:
    scores = outcome.measurement.scores.items()
    values, errors = ({name: getattr(s, kind).reshape(-1) for name, s in scores} for kind in ("value", "error"))
    return Audit(values, errors, {}, outcome.diverged_at)


def _safe(
    runs: tuple[Outcome, ...],
    continuous: Mapping[tuple[str, str], Audit],
    audits: Mapping[tuple[str, str, Computer], Audit],
) -> Safe:
    law, loops = runs[0].case.law, tuple(map(frozen, runs))

    def values(key: tuple[str, str, Computer]) -> Mapping[str, Array]:
        return audits[key].values if key in audits else exact(*key)

    def keeps(metric: str, factor: float, delay: bool) -> Callable[[float], bool]:
        def kept(period: float) -> bool:
            keys = ((law, scenario, Computer(period, delay)) for scenario in SCENARIOS)
            return all(within(values(key), continuous[key[:2]].values, metric, factor) for key in keys)

        return kept

    return Safe(
        rule=rule_of_thumb(runs),
        multipliers=exact_limit(loops),
        late_multipliers=exact_limit(loops, delay=True),
        quiet=longest(keeps(TV, QUIET, delay=False)),
        late_quiet=longest(keeps(TV, QUIET, delay=True)),
        tracks=longest(keeps(RMSE, TRACKS, delay=False)),
        late_tracks=longest(keeps(RMSE, TRACKS, delay=True)),
    )


def within(values: Mapping[str, Array], still: Mapping[str, Array], metric: str, factor: float) -> bool:
    """Whether a metric is at most so many times what it is in continuous time, at both joints; never if it is NaN."""
    return bool((values[metric] <= factor * still[metric]).all())


@dataclass(frozen=True)
class Flip:
    """Two laws that change places: `better` is below `worse` in continuous time, above it at `period` in s."""

    scenario: str
    joint: int
    better: str
    worse: str
    period: float


def flips(evidence: Evidence, metric: str, stepping: str = "euler") -> tuple[Flip, ...]:
    """Each pair of the paper's laws that changes places, with exact readings and with noisy ones alike."""
    found = []
    still = evidence.still(metric)
    for scenario, joint in PLACES:
        for a, b in combinations(LAWS, 2):
            before = order(still(a, scenario, joint), still(b, scenario, joint), MARGIN)
            if before == "undecided":
                continue
            better, worse = (a, b) if before == "below" else (b, a)
            for period in PERIODS:
                both = (evidence.at(metric, period, noisy=noisy, stepping=stepping) for noisy in (False, True))
                if all(judged(now(better, scenario, joint), now(worse, scenario, joint)) == "above" for now in both):
                    found.append(Flip(scenario, joint, better, worse, period))
                    break
    return tuple(found)


def judged(a: Score, b: Score) -> str:
    """How two scores stand; a run that diverged is above all others, and beside another one undecided."""
    if np.isinf(a[0]) or np.isinf(b[0]):
        return "undecided" if a[0] == b[0] else "above" if np.isinf(a[0]) else "below"
    return order(a, b, MARGIN)


@dataclass(frozen=True)
class Printed:
    """The printed pairs of laws, (scenario, joint, lower, higher), as some scores have them."""

    below: frozenset[tuple[str, int, str, str]]
    above: frozenset[tuple[str, int, str, str]]
    undecided: frozenset[tuple[str, int, str, str]]

    @property
    def text(self) -> str:
        """Counted, in words."""
        pairs = len(self.below) + len(self.above) + len(self.undecided)
        return f"{len(self.below)} of {pairs} hold, {len(self.above)} are turned, {len(self.undecided)} open"


def printed(scores: Scores) -> Printed:
    """The 60 pairs of the two published tables, judged by RMSE (43)."""
    kinds: dict[str, list[tuple[str, int, str, str]]] = {"below": [], "above": [], "undecided": []}
    for scenario, joint in PLACES:
        values = PUBLISHED[scenario, joint + 1].values
        for a, b in combinations(sorted(values, key=lambda law: values[law]), 2):
            kinds[judged(scores(a, scenario, joint), scores(b, scenario, joint))].append((scenario, joint, a, b))
    return Printed(*(frozenset(kinds[kind]) for kind in ("below", "above", "undecided")))
