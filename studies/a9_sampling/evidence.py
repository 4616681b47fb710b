"""All that a9 measures: the laws in continuous time and by computers, their order, and the longest safe periods."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from itertools import combinations

import casadi as ca
import numpy as np

from studies.a9_sampling.loops import (
    HORIZON,
    REALISTIC,
    SCENARIOS,
    SUBSTEP,
    TV,
    WAYS,
    Audit,
    Computer,
    digital,
    metrics,
    name_of,
)
from studies.paper.card import CARD as PAPER
from studies.paper.card import MARGIN, PROPOSED, PUBLISHED
from studies.paper.laws import ARM
from studies.paper.linearization import SEVEN, loop_of
from workbench.loop import DigitalLoop
from workbench.metrics import measure, total_variation
from workbench.notation.formula import Number, Product, Quotient, symbol
from workbench.study import Results, Work
from workbench.study.evidence import LargestSetting, LoopLimits, Threshold, largest_setting
from workbench.study.evidence.divergence_causes import Causes
from workbench.study.evidence.law_tables import order
from workbench.study.study import Outcome
from workbench.validation.refusals import Array

PERIODS = (1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2)  # s; each divides the 10 ms of (43)
APART = (5e-3, 1e-2)  # s, the periods at which integrator and law are told apart
QUIET = 2.0  # times the total variation of the continuous loop, at most
RULE = Quotient(Product((Number(Fraction(2)), symbol("phi"), symbol("lambda_min"))), symbol("K"))  # of thumb, in s
GRID = 1e-2  # s, that of (43), which every period divides
PARTS = (500, 200, 100, 50, 20, 10, 5, 2, 1)  # of the grid: the periods that a search looks at before it narrows
CLOSE = 1.12  # how far apart the longest safe period and the next one tried may be
STEPS = (5e-5, 1e-4, 2e-4, 5e-4, 1e-3, 2e-3)  # s, of RK4 through a loop in continuous time
SUBSTEPS = (1, 2, 5)  # of the plant within a period of the computer
SHORT = 10.0  # s, of the runs over the step
SWITCHING = {"clip": "layer", "sign": "relay"}
EVERY = 25  # a state in so many of those of a run, one in 10 ms, is looked at by the rule of thumb
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
    """The rule of thumb of a law in s, infinite without a gain K, and the search for its longest period that does not
    chatter (quiet), without a period of delay and with it.
    """

    rule: float
    quiet: tuple[Threshold, Threshold]
    sure: bool = True  # the error of the step leaves the ends of both as they are


def in_ms(found: Threshold) -> str:
    """The longest period of a search in ms, as a table has it."""
    if not found.largest:
        return f"below {1e3 * found.next:.2g}"
    return f"{1e3 * found.largest:.2g}" + (" or more" if np.isinf(found.next) else "")


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
        """The largest relative error of a metric by half the substep, of all runs of `ROWS` that stayed finite."""
        scores = (self.at(metric, period, way)(law, *place) for law, way, _ in ROWS for place in PLACES)
        return max(error / value for value, error in scores if np.isfinite(value))

    def factor(self, law: str, scenario: str, joint: int, period: float = REALISTIC, noisy: bool = False) -> float:
        """Total variation with a computer over that in continuous time."""
        now = self.at(TV, period, noisy=noisy)(law, scenario, joint)[0]
        return now / self.still(TV)(law, scenario, joint)[0]


def gathered(results: Results) -> Evidence:
    """The evidence in the runs and searches of the study."""
    audits: dict[Key, Audit] = {(o.case.law, o.case.scenario, None): _continuous(o) for o in results.outcomes}
    audits |= {one: Audit.of(results.sample(name_of(*one))) for one in plan()}
    quiet = dict(zip(((one.law, one.delay) for one in searches(results)), results.work("quiet"), strict=True))
    rules = {law: min(rule_of_thumb(results[scenario, law]) for scenario in SCENARIOS) for law in SEVEN}
    safe = {}
    for law, rule in rules.items():
        both = quiet[law, False], quiet[law, True]
        safe[law] = Safe(rule, (both[0].threshold, both[1].threshold), all(one.sure for one in both))
    return Evidence(audits, safe)


def works(results: Results) -> tuple[Work, ...]:
    """The searches for the longest quiet periods, and the curves over the step."""
    return Work("quiet", longest_quiet, searches(results), seconds=5.0), Work("steps", curve, CURVES, seconds=1.0)


def plan() -> Iterator[tuple[str, str, Computer]]:
    """The laws and the computers on which they run."""
    for law, way in (*((law, "euler") for law in SEVEN), (PROPOSED, "cayley")):
        for scenario in SCENARIOS:
            yield from ((law, scenario, Computer(period, stepping=way)) for period in PERIODS)
            yield law, scenario, Computer(REALISTIC, delay=True, stepping=way)
    for way in ("cayley34", "fine"):
        yield from ((PROPOSED, scenario, Computer(T, stepping=way)) for scenario in SCENARIOS for T in APART)


def _continuous(outcome: Outcome) -> Audit:
    found = outcome.measurement
    pairs = {name: np.array([one.pair for one in found.scores_of(name)]).T for name in found.names}
    values, errors = ({name: both[i] for name, both in pairs.items()} for i in (0, 1))
    return Audit(values, errors, {})


@dataclass(frozen=True)
class Search:
    """A law whose longest quiet period is sought, with or without a period of delay.

    `most` is the total variation that it may have in N m/s, by scenario and joint.
    """

    law: str
    delay: bool
    most: tuple[tuple[float, ...], ...]


def searches(results: Results) -> tuple[Search, ...]:
    """A search for each law, without delay and with it, held against its runs in continuous time."""
    made = []
    for law in SEVEN:
        runs = [results[scenario, law] for scenario in SCENARIOS]
        most = tuple(tuple(QUIET * run.score(TV, joint).pair[0] for joint in (0, 1)) for run in runs)
        made += [Search(law, delay, most) for delay in (False, True)]
    return tuple(made)


def longest_quiet(search: Search) -> LargestSetting:
    """The longest of the periods 10 ms / m that is quiet in both scenarios."""
    limits = []
    for scenario, most in zip(SCENARIOS, search.most, strict=True):
        loop = partial(computed, search.law, scenario, search.delay)
        limits.append(LoopLimits(loop, metrics, {TV: most}, HORIZON[scenario], SUBSTEP))
    return largest_setting(tuple(limits), [GRID / part for part in PARTS], ratio=CLOSE, between=middle)


def computed(law: str, scenario: str, delay: bool, period: float) -> DigitalLoop:
    """A law with exact readings and all memories by explicit Euler."""
    return digital(law, scenario, Computer(period, delay))


def middle(low: float, high: float) -> float | None:
    """The period 10 ms / m between two others that is nearest to their geometric mean; None between neighbours."""
    most, least = round(GRID / low), round(GRID / high)
    return GRID / round(np.sqrt(most * least)) if most - least > 1 else None


def rule_of_thumb(outcome: Outcome) -> float:
    """The least 2 phi lambda_min(M) / K along a run within its layer, in s, with the largest K that M sees.

    Infinite without a K.
    """
    law, run = outcome.case.law, outcome.measurement.trajectories
    if law in ("PID", "super-twisting"):
        return np.inf
    some = np.arange(len(run.t) - 1, 0, -EVERY)[::-1]
    chosen = some[(np.abs(run["s"][0][some]) < PAPER["phi"]).all(axis=1)]
    q = ca.SX.sym("q", 2)
    M = ca.Function("M", [q], [ARM.mass_matrix(q)])
    least = np.array([np.linalg.eigvalsh(np.array(M(pose)))[0] for pose in run["q"][0][chosen]])
    K = np.full((1, 1), np.max(PAPER["SMC: K"])) if law == "SMC" else run["controller.K"][0][chosen]
    K = np.linalg.norm(K, 2, axis=(1, 2)) if K.ndim == 3 else K.max(axis=1)
    return float((2 * PAPER["phi"] * least / K).min())


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


@dataclass(frozen=True, eq=False)
class Curve:
    """TV (N, 2) in N m/s over steps h (N,) in s, of one law, one switching, with or without a computer."""

    law: str
    switching: str
    digital: bool
    h: Array
    TV: Array


CURVES = tuple((law, way, held) for law in ("SMC", PROPOSED) for way in SWITCHING for held in (False, True))


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
        metric = total_variation(REALISTIC if held else h)
        found = measure(equation, (metric,), until=SHORT, every=SHORT, h=h)
        rows.append([found.score(TV, joint).pair[0] for joint in (0, 1)])
    return Curve(law, switching, held, steps, np.array(rows))
