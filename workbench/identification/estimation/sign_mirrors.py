"""Numbers whose signs a log cannot tell: with them negated, alone or two at once, no output changes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import chain, combinations

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.identification.datasets import Dataset
from workbench.identification.estimation.fit_search import spread
from workbench.identification.estimation.weighed_data import WeighedData

UNCHANGED = 1e-9  # of an output, in units of its spread: rounding of a run, and far below any noise
DISTINCT = 3.0  # standard errors between a number and zero, below which its sign is no question
NUMBERS_AT_ONCE = 2_000_000  # of the states of all candidates on the first samples of the log


def sign_mirrors(data: WeighedData, z: Array, errors: Array) -> list[tuple[int, ...]]:
    """The places in z (nz,) of numbers that can be negated at once without a change of any output, one or two each.

    Only numbers are tried that may have the other sign by their bounds, and whose standard `errors` (nz,) tell them
    from zero. First samples of the log sort out nearly all; the rest is tried along the whole log.
    """
    numbers = data.model.numbers
    places = [
        i
        for i, one in enumerate(numbers)
        if one.kind in ("parameter", "initial state")
        and one.low <= -z[i] <= one.high
        and abs(z[i]) > DISTINCT * errors[i]
    ]
    candidates = list(chain(combinations(places, 1), combinations(places, 2)))
    if not candidates:
        return []
    limit, first = UNCHANGED * spread(data), _first_samples(data, len(candidates) + 1)
    rows = np.vstack([z, [_negate(z, flips) for flips in candidates]])
    with np.errstate(all="ignore"):
        y = first.model.values(rows, 0)
        same = (np.abs(y[1:] - y[0]) <= limit).all(axis=(1, 2))
    left = [flips for flips, is_same in zip(candidates, same, strict=True) if is_same]
    return _without_unions([flips for flips in left if _is_mirror(data, z, flips, limit)])


def mirror_sentence(data: WeighedData, z: Array, errors: Array) -> str:
    """A sentence on numbers whose signs the log cannot tell; empty if there are none."""
    names = [[data.model.numbers[i].name for i in flips] for flips in sign_mirrors(data, z, errors)]
    if not names:
        return ""
    groups = "; ".join(" and ".join(group) + (" at once" if len(group) > 1 else "") for group in names)
    return f"No output changes with the other sign of {groups}: the mirror image fits as well. Exclude it by `bounds`."


def _negate(z: Array, flips: Sequence[int]) -> Array:
    mirrored = z.copy()
    mirrored[list(flips)] *= -1.0
    return mirrored


def _first_samples(data: WeighedData, runs: int) -> WeighedData:
    """The data of the first experiment alone, as long as so many runs have room."""
    model = data.model
    first, h = model.dataset.experiments[0], model.h[0]
    count = max(2, int(NUMBERS_AT_ONCE / (runs * model.ode.states.size * max(1.0, np.median(np.diff(first.t)) / h))))
    short = first.rows(0, min(len(first), count))
    part = replace(model, dataset=Dataset((short,)), x0=model.x0[:1], h=model.h[:1], begins=model.begins[:1])
    return WeighedData(part, (data.weighs[0][: len(short)],))


def _is_mirror(data: WeighedData, z: Array, flips: Sequence[int], limit: Array) -> bool:
    """True if the outputs of all experiments are the same with some numbers negated."""
    pairs = zip(data.errors(z), data.errors(_negate(z, flips)), strict=True)
    return all(bool((np.abs(mirrored - own) <= limit).all()) for own, mirrored in pairs)


def _without_unions(mirrors: Sequence[tuple[int, ...]]) -> list[tuple[int, ...]]:
    """The mirrors without pairs of numbers that can be negated alone."""
    alone = {flips[0] for flips in mirrors if len(flips) == 1}
    return [flips for flips in mirrors if len(flips) == 1 or not alone.issuperset(flips)]
