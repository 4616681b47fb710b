"""The least gamma of a generalized plant in normal form, between a level that fails and one that holds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.matrices import EPS, DesignError
from workbench.design.synthesis.game_conditions import Game, GameVerdict
from workbench.design.synthesis.generalized_plant import PlantParts

FACTOR = 4.0  # from one level to the next, before both sides are known
MOST_FACTORS = 60
NOTHING = 1e-10  # of the plant's own size: a smaller gamma counts as zero
MOST_LEVELS = 150
NARROW = 1e-13  # the relative width at which the search ends
GAP = 1e-10  # the least relative distance of either side from the optimum
AT_BOUND = 1e-8  # relative: an optimum that is nearer to the bound of D11, where R is singular, counts as the bound
COPIES, DIGITS = 2, 2.0  # plants with other last digits, and the change in roundings
SAFETY = 4.0  # times the spread of their optima: the distance of either side
ABOVE = 1.001, 1.1, 2.0, 10.0, 100.0  # times the optimum: levels at which all conditions must hold
SEED = 35  # of these changes


@dataclass(frozen=True)
class LeastGamma:
    """The least gamma `value` between a level `low` that fails with a `failure`, and a level `high` at which all holds.

    All three are judged again with the last digits of the data changed, and lie apart by what that moves.
    """

    value: float
    low: float
    high: float
    failure: GameVerdict

    @property
    def width(self) -> float:
        """The relative distance of both sides."""
        return (self.high - self.low) / self.high if self.high > 0 else 0.0


def least_gamma(call: str, p: PlantParts) -> LeastGamma:
    """The infimum of the levels at which all conditions hold, and what rounding of the data does to it."""
    game, size = Game.of(p), _size(p)
    root = _root(call, game, size)
    if root <= NOTHING * size:
        return LeastGamma(0.0, 0.0, root, GameVerdict(""))
    if root <= game.bound:
        return LeastGamma(root, root * (1 - 8 * EPS), root * (1 + AT_BOUND), game.judge(root))
    random = np.random.default_rng(SEED)
    others = [Game.of(_changed(p, random)) for _ in range(COPIES)]
    roots = [root, *(_root(call, other, size) for other in others)]
    gap = GAP * root + SAFETY * (max(roots) - min(roots))
    low, high = max(min(roots) - gap, game.bound), max(roots) + gap
    return LeastGamma(float(np.median(roots)), low, high, game.judge(low))


def _root(call: str, game: Game, size: float) -> float:
    """The level, nearly, from which on all conditions hold; no more than the bound if that decides."""
    low, high = _bracket(call, game, size)
    if high <= NOTHING * size:
        return high
    if low <= game.bound:
        near = max(game.bound * (1 + AT_BOUND), NOTHING * size)
        if game.judge(near).holds:
            return game.bound
        low = near
    root = _narrow(game, low, high)
    for factor in ABOVE:
        verdict = game.judge(root * factor)
        if not verdict.holds:
            raise DesignError(
                f"`{call}`: rounding decides the conditions, as they hold at gamma = {root:.6g} and fail at "
                f"{root * factor:.6g}: {verdict.text}. Balance the plant or choose other units."
            )
    return root


def _changed(p: PlantParts, random: np.random.Generator) -> PlantParts:
    """The plant with the last digits of its numbers changed at random."""

    def change(M: Array) -> Array:
        return np.asarray(M * (1 + DIGITS * EPS * random.uniform(-1, 1, M.shape)))

    A, B1, B2, C1, C2, D11 = (change(getattr(p, name)) for name in ("A", "B1", "B2", "C1", "C2", "D11"))
    return PlantParts(A, B1, B2, C1, C2, D11, p.D12, p.D21, p.D22)


def _size(p: PlantParts) -> float:
    """The size of the errors that the plant's disturbances can make, by the norms of its matrices."""
    rate = float(np.linalg.norm(p.A)) or 1.0
    return float(np.linalg.norm(p.D11) + np.linalg.norm(p.C1) * np.linalg.norm(p.B1) / rate) or 1.0


def _bracket(call: str, game: Game, size: float) -> tuple[float, float]:
    """A level that fails, or the bound, and one that holds, no more than a factor apart unless the bound is below."""
    bound = game.bound
    high, low = max(2 * bound, size), bound
    for _ in range(MOST_FACTORS):
        if game.judge(high).holds:
            break
        low, high = high, high * FACTOR
    else:
        raise DesignError(
            f"`{call}`: no gamma up to {high:.3g} passes the conditions, so the plant is too near to one that no "
            "controller stabilises. Check its units, its actuators and its sensors."
        )
    while low <= bound and high > NOTHING * size:
        level = max(high / FACTOR, (bound + high) / 2 if bound > 0 else 0.0)
        if level <= bound * (1 + AT_BOUND):
            break
        if not game.judge(level).holds:
            low = level
            break
        high = level
    return low, high


def _narrow(game: Game, low: float, high: float) -> float:
    """The least level that holds: both sides come together by halves, and by the secant of the spectral radius."""
    known: list[tuple[float, float]] = []
    for count in range(MOST_LEVELS):
        if high - low <= NARROW * high:
            break
        level = _level(known, low, high, count)
        verdict = game.judge(level)
        if verdict.coupling > 0:  # it is known, and its inverse is nearly straight
            known = [*known[-1:], (level, 1 / verdict.coupling)]
        low, high = (low, level) if verdict.holds else (level, high)
    return high


def _level(known: list[tuple[float, float]], low: float, high: float, count: int) -> float:
    """The level to try next, inside the bracket: on either side of the secant's root in turn, or in the middle."""
    if count % 3 and len(known) == 2 and known[0][1] != known[1][1]:
        (a, fa), (b, fb) = known
        root = b + (1 - fb) * (b - a) / (fb - fa)
        step = max(abs(root - b) * 1e-2, NARROW * root / 4)
        level = root + (step if count % 3 == 1 else -step)
        if low < level < high:
            return level
    return float(np.sqrt(low * high)) if low > 0 and high > 2 * low else (low + high) / 2
