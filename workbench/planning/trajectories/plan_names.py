"""Names of a plan's limits and values, and the vectors that they make; each misfit is refused in a sentence."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workbench.core import Layout
from workbench.core.validation.refusals import Array, as_array, known_name, refusal
from workbench.planning.trajectories.phase import NamedNumbers
from workbench.planning.trajectories.plan_problem import INF, Ends

LONGEST = 1e12  # s, of a duration that is given


def places_of(name: object, layout: Layout, of: str) -> list[int]:
    """The places of a quantity or of one of its numbers in the flat vector of a layout."""
    known = dict.fromkeys((*layout.names, *layout.labels))
    label = known_name(name, known, of)
    return [int(place) for place in layout.indices(label)]


def fixed_values(call: str, values: NamedNumbers, layout: Layout, of: str) -> Ends:
    """Ends (size,) at which low and high are the values given, and infinite elsewhere."""
    ends = Ends.free(layout.size)
    for name, value in values.items():
        places = places_of(name, layout, of)
        numbers = fixed_numbers(f"{call}={{{name!r}: ...}})", value, len(places))
        ends.low[places] = ends.high[places] = numbers
    return ends


def limit_pair(call: str, name: str, value: object, size: int) -> tuple[Array, Array]:
    """The least and the greatest values (size,) of a limit; None stands for no limit."""
    where = f"{call}={{{name!r}: ...}})"
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise refusal(where, "a pair of the least and the greatest value, or None for no limit", value)
    low, high = (_end(where, end, size, sign) for end, sign in zip(value, (-1.0, 1.0), strict=True))
    return low, high


def limit_values(call: str, limits: NamedNumbers, layout: Layout, of: str) -> Ends:
    """Ends (size,) of all quantities of a layout."""
    ends = Ends.free(layout.size)
    for name, value in limits.items():
        places = places_of(name, layout, of)
        low, high = limit_pair(call, name, value, len(places))
        ends.low[places], ends.high[places] = low, high
    return ends


def duration_pair(call: str, value: object) -> tuple[float, float]:
    """The least and the greatest duration in s, equal where it is fixed."""
    array = as_array(value)
    if array is None and isinstance(value, list | tuple) and len(value) == 2 and value[1] is None:
        array = as_array([value[0], INF])
    must = "a duration in s, or the least and the greatest one"
    if array is None or array.shape not in ((), (2,)):
        raise refusal(call, must, value)
    low, high = (float(end) for end in np.broadcast_to(array, 2))
    if not 0 <= low <= LONGEST or not (0 < high <= LONGEST or high == INF) or (array.shape == () and not low > 0):
        raise refusal(call, f"{must}, positive and at most {LONGEST:g} s, or None for no greatest one", value)
    return low, high


def guess_rows(call: str, guess: Mapping[str, object], layout: Layout) -> dict[int, Array]:
    """By place, the values of a guess at even times."""
    rows: dict[int, Array] = {}
    for name, value in guess.items():
        places = places_of(name, layout, "states and inputs")
        array = as_array(value)
        if array is None or array.ndim not in (1, 2) or len(array) < 2 or not np.isfinite(array).all():
            raise refusal(f"{call}={{{name!r}: ...}})", "finite values at two or more even times", value)
        columns = array.reshape(len(array), -1)
        if columns.shape[1] != len(places):
            raise refusal(f"{call}={{{name!r}: ...}})", f"of shape (times, {len(places)})", value)
        rows |= {place: np.asarray(columns[:, i]) for i, place in enumerate(places)}
    return rows


def _end(call: str, end: object, size: int, sign: float) -> Array:
    if end is None:
        return np.full(size, sign * INF)
    array = as_array(end)
    if array is None or array.size not in (1, size) or np.isnan(array).any():
        raise refusal(call, f"a pair of numbers, arrays of {size} numbers, or None for no limit", end)
    return np.asarray(np.broadcast_to(array.ravel(), size).astype(float))


def fixed_numbers(call: str, value: object, size: int) -> Array:
    """The numbers (size,) of a value at one instant."""
    array = as_array(value)
    if array is None or array.size not in (1, size) or not np.isfinite(array).all():
        must = "a finite number" if size == 1 else f"{size} finite numbers"
        raise refusal(call, must, value)
    return np.asarray(np.broadcast_to(array.ravel(), size))
