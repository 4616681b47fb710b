"""An MCAP file, or a recording of rosbag2 in MCAP, as columns of a log: messages flattened to numbers by path."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import IO, TYPE_CHECKING

import numpy as np

from workbench.core.validation.refusals import describe, one_of
from workbench.identification.datasets.log_columns import LogChoice, LogColumns, unite_clocks

if TYPE_CHECKING:
    from mcap.records import Channel, Message, Schema

LONGEST_ARRAY = 64  # numbers of one field: an image or a point cloud is no signal
CLOCKS = ("log_time", "publish_time", "header.stamp")
Clock = tuple[list[float], dict[str, list[float]]]  # times in s, and numbers by path


def read_mcap(path: str | Path, choice: LogChoice) -> LogColumns:
    """The numbers of all messages of the topics that are wanted, at the times of the log or of their headers."""
    clock = one_of(f"{choice.call}: time", choice.time or CLOCKS[0], CLOCKS)
    topics: dict[str, list[tuple[int, dict[str, float]]]] = {}
    longer: set[str] = set()
    for file in _files(path, choice):
        for schema, channel, message, content in _messages(file, choice):
            numbers = dict(_flat(channel.topic, content, longer))
            stamp = _stamp(clock, schema, channel, message, content, choice)
            topics.setdefault(channel.topic, []).append((stamp, numbers))
    if not topics:
        wanted = f" of {', '.join(choice.signals)}" if choice.signals else ""
        raise ValueError(f"`{choice.call}` must have messages{wanted}; {choice.source} has none.")
    return _columns(topics, choice, longer, clock)


def _columns(
    topics: Mapping[str, Sequence[tuple[int, Mapping[str, float]]]], choice: LogChoice, longer: set[str], clock: str
) -> LogColumns:
    begin = min(stamp for messages in topics.values() for stamp, _ in messages)
    heads = list(dict.fromkeys(path for messages in topics.values() for _, numbers in messages for path in numbers))
    picks = choice.pick(heads)
    groups = []
    for messages in topics.values():
        paths = dict.fromkeys(path for _, numbers in messages for path in numbers if path in picks)
        t = np.array([(stamp - begin) / 1e9 for stamp, _ in messages])
        columns = {picks[path][0]: np.array([numbers.get(path, np.nan) for _, numbers in messages]) for path in paths}
        if columns:
            groups.append((t, columns))
    notes = [f"The times are those of {clock}, counted from {begin // 10**9}.{begin % 10**9:09d} s since 1970."]
    if longer and not choice.signals:
        notes.append(f"Arrays of more than {LONGEST_ARRAY} numbers were left out: {', '.join(sorted(longer))}.")
    return unite_clocks(choice, groups, dict(picks.values()), notes)


def _files(path: str | Path, choice: LogChoice) -> list[Path]:
    """The file, or the MCAP files in the folder of a rosbag2 recording."""
    place = Path(path)
    if place.is_file() and place.suffix != ".db3":
        return [place]
    files = sorted(place.glob("*.mcap")) if place.is_dir() else []
    if place.suffix == ".db3" or (not files and list(place.glob("*.db3"))):
        raise ValueError(
            f"`{choice.call}` must be an MCAP file; {choice.source} is a rosbag2 recording in SQLite, which holds no "
            "definitions of its messages: convert it by `ros2 bag convert` with `storage_id: mcap`."
        )
    if not files:
        raise LookupError(f"There is no MCAP file {choice.source}.")
    return files


def _messages(file: Path, choice: LogChoice) -> Iterator[tuple[Schema | None, Channel, Message, object]]:
    """The messages of the topics that are wanted, in the order of the file, decoded."""
    try:
        from mcap.exceptions import McapError
        from mcap.reader import make_reader
        from mcap_ros2.decoder import DecoderFactory
    except ImportError:
        raise LookupError(
            f"`{choice.call}` needs mcap and mcap-ros2-support, which are not installed: "
            "pip install control-workbench[logs]."
        ) from None
    factory = DecoderFactory()
    decoders = {}
    with file.open("rb") as handle:
        try:
            topics = _topics(handle, choice)
            handle.seek(0)
            for schema, channel, message in make_reader(handle).iter_messages(topics=topics):
                if channel.id not in decoders:
                    decoders[channel.id] = factory.decoder_for(channel.message_encoding, schema)
                    if decoders[channel.id] is None and channel.message_encoding == "json":
                        decoders[channel.id] = json.loads
                decoder = decoders[channel.id]
                if decoder is None and choice.signals:
                    raise ValueError(
                        f"`{choice.call}` must have messages of ROS 2 or in JSON; '{channel.topic}' of {choice.source} "
                        f"has the encoding '{channel.message_encoding}'."
                    )
                if decoder is not None:
                    yield schema, channel, message, decoder(message.data)
        except McapError as error:
            raise ValueError(
                f"`{choice.call}` must be a whole MCAP file; {choice.source} is none: {describe(str(error))}."
            ) from None


def _topics(handle: IO[bytes], choice: LogChoice) -> list[str] | None:
    """The topics of the signals that are named, or None for all topics."""
    from mcap.reader import make_reader

    if not choice.signals:
        return None
    summary = make_reader(handle).get_summary()
    if summary is None:
        return None
    new = {name: old for old, name in (choice.names or {}).items()}
    paths = [new.get(signal, signal) for signal in choice.signals]
    known = dict.fromkeys(channel.topic for channel in summary.channels.values())
    topics = [topic for topic in known if any(path == topic or path.startswith(f"{topic}.") for path in paths)]
    if not topics:
        raise LookupError(
            f"There is no topic of {describe(paths[0])} in {choice.source}; its topics are {', '.join(known)}."
        )
    return topics


def _flat(path: str, value: object, longer: set[str]) -> Iterator[tuple[str, float]]:
    """The numbers in a message by their paths, as `/encoders.position[0]`."""
    if isinstance(value, bool | int | float | np.number):
        yield path, float(value)
    elif isinstance(value, Mapping):
        for key, part in value.items():
            yield from _flat(f"{path}.{key}", part, longer)
    elif isinstance(value, str | bytes) or value is None:
        return
    elif isinstance(value, Sequence | np.ndarray):
        if len(value) > LONGEST_ARRAY:
            longer.add(path)
            return
        for i, part in enumerate(value):
            yield from _flat(f"{path}[{i}]", part, longer)
    else:
        for key in getattr(value, "__slots__", ()):
            if not key.startswith("_"):
                yield from _flat(f"{path}.{key}", getattr(value, key), longer)


def _stamp(
    clock: str, schema: Schema | None, channel: Channel, message: Message, content: object, choice: LogChoice
) -> int:
    """The time of a message in ns."""
    if clock != "header.stamp":
        return message.log_time if clock == "log_time" else message.publish_time
    stamp: object = content
    for key in ("header", "stamp"):
        stamp = stamp.get(key) if isinstance(stamp, Mapping) else getattr(stamp, key, None)
    parts = [stamp.get(key) if isinstance(stamp, Mapping) else getattr(stamp, key, None) for key in ("sec", "nanosec")]
    if not all(isinstance(part, int) for part in parts):
        raise ValueError(
            f"`{choice.call}: time` is 'header.stamp', and the messages of '{channel.topic}'"
            f"{f', {schema.name},' if schema else ''} have none: choose other topics by `signals`, or 'log_time'."
        )
    return int(str(parts[0])) * 10**9 + int(str(parts[1]))
