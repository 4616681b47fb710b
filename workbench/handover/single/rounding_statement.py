"""One sentence on what a law in single precision differs from the same law in doubles, and the numbers behind it."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from workbench.core import SampledLaw
from workbench.core.validation.refusals import Array, refusal, vector, whole
from workbench.core.validation.refusals import seed as as_seed
from workbench.core.validation.signatures import check_arguments
from workbench.handover.single.rounding_bounds import NO_CAUSE, RoundingBound, rounding_bound
from workbench.handover.single.single_precision import LawArguments

ROWS = 10_000  # at once, which is some 100 MB for a law of a thousand operations
QUEUE = "hold.next"  # where a command waits for the next instant; 'hold.next.2' for the one behind it


class ArgumentBox(NamedTuple):
    """The least and the largest memory, readings and references [z; y; r]."""

    low: Array
    high: Array


@dataclass(frozen=True, eq=False)
@check_arguments
class StatedBound:
    """The largest bound of |single - double| over many rows, for one period from the same memory.

    Attributes
    ----------
    places
        The rows in words, as 'random points of a box of memory, readings and references'.
    u_bound, z_bound
        The largest bound of each command (nu,) and each number of the memory (nz,), among the rows that have one. That
        of a command which waits is of what the law commands, and not of the one that leaves the queue.
    u_share, z_share
        The share of rows without a bound.
    reasons
        The share of rows in which a command has no bound for this operation.
    """

    law: SampledLaw
    rows: int
    places: str
    u_bound: Array
    z_bound: Array
    u_share: Array
    z_share: Array
    unbounded_share: float  # the share of rows in which a command has no bound
    reasons: Mapping[str, float]

    def __repr__(self) -> str:
        return (
            f"<StatedBound of '{self.law.name}': {self.rows:,} rows, {percent(self.unbounded_share)} without a bound>"
        )

    @property
    def sentence(self) -> str:
        """The bounds of the commands, with their units, and the share of rows that have none."""
        parts = [f"{name} by at most {ceiling(bound)}{unit}" for name, unit, bound in self._commands()]
        text = (
            f"In single precision the law differs from that in doubles in {_joined(parts)}, over one period from the "
            f"same memory (proved at each of {self.rows:,} {self.places})"
        )
        if not self.unbounded_share:
            return f"{text}."
        why = _joined([f"{word} ({percent(share)})" for word, share in self.reasons.items()])
        share = percent(self.unbounded_share)
        return f"{text}; at {share} of them a decision is within its rounding and no bound holds: {why}."

    def _commands(self) -> Iterator[tuple[str, str, float]]:
        for entry in self.law.commands.entries:
            bounds = self.u_bound[self.law.commands.slice(entry.name)]
            units = [f" {unit}" if unit else "" for unit in entry.units]
            if len(set(units)) == 1:
                yield entry.name, units[0], float(bounds.max())
            else:
                yield from zip(entry.labels(), units, bounds.tolist(), strict=True)


@check_arguments
def box_of(z: ArrayLike, y: ArrayLike, r: ArrayLike | None = None, margin: float = 0.1) -> ArgumentBox:
    """The ranges of recorded memory (N, nz), readings (N, ny) and references (N, nr), wider by a share of each."""
    held = [np.asarray(part, float) for part in (z, y, np.zeros((len(np.asarray(y)), 0)) if r is None else r)]
    rows = np.concatenate(held, axis=1)
    low, high = rows.min(axis=0), rows.max(axis=0)
    more = 0.5 * margin * (high - low)
    return ArgumentBox(low - more, high + more)


@check_arguments
def stated_bound(
    law: SampledLaw,
    low: ArrayLike,
    high: ArrayLike,
    samples: int = 100_000,
    seed: int = 0,
    instants: int = 100_000,
) -> StatedBound:
    """The bound of |single - double| over random points of a box, uniform and independent in each number.

    Parameters
    ----------
    low, high
        The least and the largest [z; y; r], as `box_of` makes them from a recorded run.
    samples
        How many points.
    seed
        The seed of the points.
    instants
        The instant of a law that depends on time is one of the first so many.

    Raises
    ------
    ValueError
        If the box has another size than memory, readings and references have, or a side below zero.
    """
    size = law.memory.size + law.readings.size + law.references.size
    sides = [
        vector(f"stated_bound({name}=...)", side, size, "one for each of [z; y; r]")
        for name, side in (("low", low), ("high", high))
    ]
    if not np.all(sides[0] <= sides[1]):
        raise refusal("stated_bound(high=...)", "at least `low` in each number", high)
    count = whole("stated_bound(samples=...)", samples)
    draws = np.random.default_rng(as_seed("stated_bound(seed=...)", seed))

    def blocks() -> Iterator[LawArguments]:
        for start in range(0, count, ROWS):
            rows = min(ROWS, count - start)
            points = draws.uniform(sides[0], sides[1], (rows, size))
            k = draws.integers(0, instants if law.uses_time else 1, rows).astype(float)
            yield LawArguments(k, *np.split(points, [law.memory.size, law.memory.size + law.readings.size], axis=1))

    return _stated(law, blocks(), "random points of a box of memory, readings and references")


def _stated(law: SampledLaw, blocks: Iterable[LawArguments], places: str) -> StatedBound:
    nz, commands = law.memory.size, command_places(law)
    largest, lost = np.zeros(nz + law.commands.size), np.zeros(nz + law.commands.size, int)
    rows, without, words = 0, 0, Counter[str]()
    for block in blocks:
        held = rounding_bound(law, *block)
        bounds = np.concatenate([held.z_bound, held.u_bound], axis=1)
        finite = np.isfinite(bounds)
        largest = np.maximum(largest, np.where(finite, bounds, 0.0).max(axis=0))
        lost += (~finite).sum(axis=0)
        rows += len(bounds)
        without += int((~finite[:, commands]).any(axis=1).sum())
        words.update(_reasons(held, commands))
    shares = lost / max(rows, 1)
    reasons = {word: count / rows for word, count in words.most_common()}
    return StatedBound(
        law,
        rows,
        places,
        largest[commands],
        largest[:nz],
        shares[commands],
        shares[:nz],
        without / max(rows, 1),
        reasons,
    )


def _reasons(held: RoundingBound, commands: np.ndarray) -> dict[str, int]:
    """The number of rows in which a command has no bound for an operation, by its words."""
    causes = np.concatenate([held.z_cause, held.u_cause], axis=1)[:, commands]
    found = Counter[str]()
    for place in np.unique(causes[causes != NO_CAUSE]):
        found[held.reasons[int(place)]] += int((causes == place).any(axis=1).sum())
    return found


def command_places(law: SampledLaw) -> np.ndarray:
    """Where each number that the law commands stands in [z+; u]: a command that waits enters the queue in z+."""
    places, entries = list[int](), law.commands.entries
    for entry in entries:
        wait = law.delay.get(entry.name, 0)
        queue = QUEUE if wait == 1 else f"{QUEUE}.{wait}"
        if wait:
            before = sum(e.size for e in entries[: entries.index(entry)] if law.delay.get(e.name, 0) >= wait)
            start = law.memory.slice(queue).start + before
        else:
            start = law.memory.size + law.commands.slice(entry.name).start
        places += range(start, start + entry.size)
    return np.array(places, int)


def ceiling(value: float) -> str:
    """A positive number with two digits, rounded up."""
    if not (0 < value < math.inf):
        return f"{value:g}"
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return f"{math.ceil(value / unit) * unit:.2g}"


def percent(share: float) -> str:
    """A share in percent with two digits, rounded up."""
    return f"{ceiling(100 * share)} %"


def _joined(parts: list[str]) -> str:
    return " and ".join([", ".join(parts[:-1]), parts[-1]] if len(parts) > 1 else parts)
