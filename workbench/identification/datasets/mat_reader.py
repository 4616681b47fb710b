"""A MAT file (version 5 or older) as columns of a log."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from workbench.core.csv_file import TIMES
from workbench.core.validation.refusals import Array, describe
from workbench.identification.datasets.log_columns import LogChoice, LogColumns

HDF5 = b"MATLAB 7.3 MAT-file"


def read_mat(path: str | Path, choice: LogChoice) -> LogColumns:
    """The vectors and matrices of a MAT file with a row for each time; `u` of a structure `data` is `data.u`."""
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    place = Path(path)
    if not place.is_file():
        raise LookupError(f"There is no file {choice.source}.")
    with place.open("rb") as handle:
        if handle.read(len(HDF5)) == HDF5:
            raise ValueError(
                f"`{choice.call}` must be a MAT file of version 5 or older; {choice.source} is one of version 7.3, "
                "which is HDF5: save it by `save(name, '-v7')` in MATLAB."
            )
    try:
        stored: Mapping[str, object] = loadmat(place, simplify_cells=True)
    except (MatReadError, ValueError, OSError, NotImplementedError, TypeError, KeyError) as error:
        raise ValueError(
            f"`{choice.call}` must be a MAT file; {choice.source} is none: {describe(str(error))}."
        ) from None
    parts = [part for key, value in stored.items() if not key.startswith("__") for part in _flat(key, value)]
    single = [f"{name} = {array:.9g}" for name, array in parts if not array.ndim]
    log = _columns({name: array for name, array in parts if array.ndim}, choice)
    return log.with_notes(f"Single numbers of the file: {', '.join(single)}.") if single else log


def _columns(arrays: dict[str, Array], choice: LogChoice) -> LogColumns:
    head = choice.time_head([_last(name) if choice.time is None and _last(name) in TIMES else name for name in arrays])
    if head is not None and head not in arrays:
        head = next(name for name in arrays if _last(name) == head)
    lengths = [array.size if 1 in array.shape or array.ndim == 1 else max(array.shape) for array in arrays.values()]
    rows = arrays[head].size if head else max(lengths, default=0)
    columns: dict[str, Array] = {}
    others = []
    for name, array in arrays.items():
        if name == head:
            continue
        table = array.reshape(rows, 1) if array.size == rows else array if len(array) == rows else array.T
        if table.ndim != 2 or len(table) != rows or rows < 2:
            others.append(name)
        elif table.shape[1] == 1:
            columns[name] = table[:, 0]
        else:
            columns |= {f"{name}[{i}]": table[:, i] for i in range(table.shape[1])}
    picks = choice.pick(list(columns))
    t, notes = choice.seconds(head, arrays[head].ravel() if head else None, rows)
    if others and not choice.signals:
        notes = (*notes, f"Variables without {rows} rows are no signals and were left out: {', '.join(others)}.")
    units = dict(picks.values())
    return LogColumns(choice.source, t, {name: columns[old] for old, (name, _) in picks.items()}, units, notes)


def _flat(name: str, value: object) -> Iterator[tuple[str, Array]]:
    """The arrays of numbers in a variable by their paths."""
    if isinstance(value, Mapping):
        for key, part in value.items():
            yield from _flat(f"{name}.{key}", part)
    elif isinstance(value, np.ndarray | int | float) and np.asarray(value).dtype.kind in "biuf":
        array = np.asarray(value, dtype=float)
        if array.ndim <= 2:
            yield name, array


def _last(name: str) -> str:
    return name.rpartition(".")[2]
