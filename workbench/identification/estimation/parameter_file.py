"""Files of fitted parameters: JSON with a mark of its format, read as plain data, each field of which is checked."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn, TypedDict

import numpy as np

from workbench.core.validation.refusals import Array, describe

FORMAT = "workbench fitted parameters, version 1"
MOST_BYTES = 10_000_000  # of a file: 500 parameters with their covariance
CALL = "FittedParameters.from_file(path)"
LARGEST = float(np.finfo(float).max)  # the bound of a number that has none
TEXTS, ARRAYS = ("names", "units", "warnings"), ("centre", "covariance", "low", "high")
FIELDS = ("format", *TEXTS, "source", *ARRAYS)


class ParameterFields(TypedDict):
    """The fields of fitted parameters, as their file has them."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    centre: Array
    covariance: Array
    low: Array
    high: Array
    source: str
    warnings: tuple[str, ...]


def write_parameter_file(path: str | os.PathLike[str], parameters: ParameterFields) -> None:
    """Write the fields; a bound that is none becomes null. A folder is refused."""
    if Path(path).is_dir():
        raise ValueError(f"`FittedParameters.save(path=...)` must name a file; '{path}' is a folder.")
    made: dict[str, object] = {"format": FORMAT}
    for name, value in parameters.items():
        made[name] = np.asarray(value).tolist() if name in ARRAYS else value
    for name, ends in (("low", parameters["low"]), ("high", parameters["high"])):
        made[name] = [end if abs(end) < LARGEST else None for end in np.asarray(ends).tolist()]
    Path(path).write_text(json.dumps(made, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def read_parameter_file(path: str | os.PathLike[str]) -> ParameterFields:
    """The fields of a file, of the right kinds; their sizes and values are checked by what is made of them."""
    file = Path(path)
    if not file.is_file():
        raise LookupError(f"`{CALL}` must be a file that `save` wrote; there is no file '{file}'.")
    if file.stat().st_size > MOST_BYTES:
        raise _refused(file, f"of at most {MOST_BYTES:,} bytes", f"{file.stat().st_size:,}")
    try:
        made = json.loads(file.read_text(encoding="utf-8"), parse_constant=_no_number, object_pairs_hook=_once)
    except (ValueError, RecursionError) as error:
        raise _refused(file, "in JSON", f"{error}".rstrip(".")) from None
    if not isinstance(made, dict) or made.get("format") != FORMAT:
        got = made.get("format") if isinstance(made, dict) else made
        raise _refused(file, f"with the format '{FORMAT}'", describe(got))
    if set(made) != set(FIELDS):
        missing, more = sorted(set(FIELDS) - set(made)), sorted(set(made) - set(FIELDS))
        raise _refused(file, f"with the fields {', '.join(FIELDS)}", f"no {missing}" if missing else f"also {more}")
    if not isinstance(made["source"], str):
        raise _refused(file, "with a text as 'source'", describe(made["source"]))
    names, units, warnings = (_texts(file, made, name) for name in TEXTS)
    centre, low, high = (
        _numbers(file, name, made[name], empty)
        for name, empty in (("centre", None), ("low", -LARGEST), ("high", LARGEST))
    )
    rows = made["covariance"]
    if not isinstance(rows, list):
        raise _refused(file, "with rows of numbers as 'covariance'", describe(rows))
    covariance = [_numbers(file, "covariance", row, None) for row in rows]
    if any(len(row) != len(rows) for row in covariance):
        raise _refused(file, "with a square matrix as 'covariance'", f"rows of {[len(row) for row in covariance]}")
    return ParameterFields(
        names=names,
        units=units,
        centre=centre,
        covariance=np.array(covariance),
        low=low,
        high=high,
        source=made["source"],
        warnings=warnings,
    )


def _refused(file: Path, must: str, got: str) -> ValueError:
    return ValueError(f"`{CALL}` must be a file that `save` wrote, {must}; '{file}' has {got}.")


def _texts(file: Path, made: dict[str, object], name: str) -> tuple[str, ...]:
    value = made[name]
    if not isinstance(value, list) or not all(isinstance(one, str) for one in value):
        raise _refused(file, f"with a list of texts as '{name}'", describe(value))
    return tuple(value)


def _numbers(file: Path, name: str, value: object, empty: float | None) -> Array:
    """A list of numbers, in which null is the number `empty`, if it has one."""
    values: Sequence[object] = value if isinstance(value, list) else [None]
    values = [empty if one is None else one for one in values]
    if not all(isinstance(one, int | float) and not isinstance(one, bool) for one in values):
        raise _refused(file, f"with numbers as '{name}'", describe(value))
    return np.array(values, dtype=float)


def _no_number(text: str) -> NoReturn:
    raise ValueError(f"{text} is no number of JSON")


def _once(pairs: list[tuple[str, object]]) -> dict[str, object]:
    names = [name for name, _ in pairs]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise ValueError(f"{twice[0]!r} comes twice")
    return dict(pairs)
