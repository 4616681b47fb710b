"""A ULog file, as PX4 writes it, as columns of a log."""

from __future__ import annotations

from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import numpy as np

from workbench.core.validation.refusals import describe
from workbench.identification.datasets.log_columns import LogChoice, LogColumns, unite_clocks


def read_ulog(path: str | Path, choice: LogChoice) -> LogColumns:
    """The fields of the topics that are wanted, `vehicle_attitude.q[0]`, at the time stamps of each topic.

    A second instance of a topic is `sensor_accel#1`.
    """
    try:
        from pyulog import ULog
    except ImportError:
        raise LookupError(
            f"`{choice.call}` needs pyulog, which is not installed: pip install control-workbench[logs]."
        ) from None
    if not Path(path).is_file():
        raise LookupError(f"There is no file {choice.source}.")
    if choice.time is not None:
        raise ValueError(f"`{choice.call}` has the time stamps of the file, and takes no `time`.")
    new = {name: old for old, name in (choice.names or {}).items()}
    topics = {new.get(signal, signal).partition(".")[0].partition("#")[0] for signal in choice.signals}
    try:
        with Path(path).open("rb") as handle, redirect_stdout(StringIO()):  # pyulog prints of damaged parts
            log = ULog(handle, sorted(topics) or None)
    except Exception as error:  # pyulog raises what its parser met: struct.error, IndexError, Exception
        raise ValueError(
            f"`{choice.call}` must be a ULog file; {choice.source} is none: {describe(str(error))}."
        ) from None
    tables = {}
    for part in log.data_list:
        topic = f"{part.name}#{part.multi_id}" if part.multi_id else part.name
        tables[topic] = {f"{topic}.{field}": numbers for field, numbers in part.data.items()}
    heads = [head for topic, table in tables.items() for head in table if head != f"{topic}.timestamp"]
    if not heads:
        wanted = f" of {', '.join(choice.signals)}" if choice.signals else ""
        raise ValueError(f"`{choice.call}` must have messages{wanted}; {choice.source} has none.")
    picks = choice.pick(heads)
    begin = min(int(table[f"{topic}.timestamp"][0]) for topic, table in tables.items())
    groups = []
    for topic, table in tables.items():
        t = (table[f"{topic}.timestamp"].astype(np.int64) - begin) / 1e6
        columns = {picks[head][0]: table[head].astype(float) for head in table if head in picks}
        if columns:
            groups.append((t, columns))
    notes = [f"The time stamps in us were converted to s, and are counted from {begin / 1e6:.6f} s after the start."]
    if log.dropouts:
        lost = sum(dropout.duration for dropout in log.dropouts) / 1000
        notes.append(f"The recorder lost samples {len(log.dropouts)} times, for {lost:.3g} s in all.")
    if log.file_corruption:
        notes.append("Parts of the file are damaged, and were left out by pyulog.")
    return unite_clocks(choice, groups, dict(picks.values()), notes)
