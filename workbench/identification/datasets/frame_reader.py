"""A table of pandas, or a Parquet file, as columns of a log."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from workbench.core.validation.refusals import describe, require
from workbench.identification.datasets.log_columns import LogChoice, LogColumns

if TYPE_CHECKING:
    import pandas as pd

EPOCH = "The times are counted from {}, the first of the log."


def read_frame(frame: pd.DataFrame, choice: LogChoice) -> LogColumns:
    """The columns of a table, whose times are a column or the index; dates are counted from the first one."""
    import pandas as pd

    require(choice.call, frame, pd.DataFrame)
    notes: tuple[str, ...] = ()
    if frame.index.name is not None or isinstance(frame.index, pd.DatetimeIndex | pd.TimedeltaIndex):
        frame = frame.rename_axis(index=str("t [s]" if frame.index.name is None else frame.index.name)).reset_index()
    frame = frame.rename(columns=str)
    heads = [head.strip() for head in frame.columns]
    frame.columns = pd.Index(heads)
    if len(set(heads)) < len(heads):
        twice = next(head for head in heads if heads.count(head) > 1)
        raise ValueError(
            f"`{choice.call}` must have different names of columns; the table has {heads.count(twice)} columns "
            f"{describe(twice)}."
        )
    head = choice.time_head(heads)
    if head is not None and frame[head].dtype.kind in "Mm":
        first = frame[head].iloc[0] if len(frame) else None
        is_date = frame[head].dtype.kind == "M"
        notes = (EPOCH.format(first),) if is_date else ()
        spans = (frame[head] - first if is_date else frame[head]).to_numpy().astype("timedelta64[ns]")
        t = spans.astype(np.int64) / 1e9
    else:
        numbers = None if head is None else _numbers(frame[head], head, choice)
        t, notes = choice.seconds(head, numbers, len(frame))
    plain = [one for one in heads if one != head and (choice.signals or _is_number(frame[one]))]
    if others := [one for one in heads if one != head and one not in plain]:
        notes = (*notes, f"Columns without numbers were left out: {', '.join(others)}.")
    picks = choice.pick(plain)
    columns = {name: _numbers(frame[head], head, choice) for head, (name, _) in picks.items()}
    return LogColumns(choice.source, t, columns, dict(picks.values()), notes)


def _is_number(column: pd.Series) -> bool:
    return column.dtype.kind in "biuf"


def _numbers(column: pd.Series, head: str, choice: LogChoice) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    if not _is_number(column):
        raise ValueError(
            f"`{choice.call}` must have numbers in each column that is used; '{head}' of {choice.source} has "
            f"{column.dtype}: leave it out by `signals`, or turn it into numbers."
        )
    return np.asarray(column.to_numpy(dtype=float, na_value=np.nan))


def read_parquet(path: str | Path, choice: LogChoice) -> LogColumns:
    """The columns of a Parquet file by pyarrow, which is in the extra `data`."""
    if not Path(path).is_file():
        raise LookupError(f"There is no file {choice.source}.")
    try:
        from pyarrow import ArrowException, parquet
    except ImportError:
        raise LookupError(
            f"`{choice.call}` needs pyarrow, which is not installed: pip install control-workbench[data]."
        ) from None
    try:
        return read_frame(parquet.read_table(path).to_pandas(), choice)
    except (ArrowException, OSError) as error:
        raise LookupError(f"{choice.source} cannot be read as Parquet: {describe(str(error))}.") from None
