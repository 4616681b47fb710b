"""Small logs of robots, written as their recorders do: MCAP by its own writer, ULog byte by byte."""

import struct
from pathlib import Path

from mcap.writer import Writer as JsonWriter
from mcap_ros2.writer import Writer

JOINT_STATE = """
std_msgs/Header header
string[] name
float64[] position
float64[] velocity
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
FLOAT = "float64 data"
EPOCH = 1_700_000_000  # s


def write_mcap(path: Path, positions, efforts) -> Path:
    """A log of ROS 2, by times in ms: `/encoders` with positions, stamped 2 ms before, and `/effort` with numbers."""
    with path.open("wb") as handle:
        writer = Writer(handle)
        state = writer.register_msgdef("sensor_msgs/msg/JointState", JOINT_STATE)
        number = writer.register_msgdef("std_msgs/msg/Float64", FLOAT)
        for ms, values in positions:
            stamp = {"sec": EPOCH + (ms - 2) // 1000, "nanosec": (ms - 2) % 1000 * 1_000_000}
            header = {"stamp": stamp, "frame_id": "base"}
            content = {"header": header, "name": ["a", "b"], "position": list(values), "velocity": []}
            writer.write_message("/encoders", state, content, log_time=EPOCH * 10**9 + ms * 1_000_000)
        for ms, value in efforts:
            writer.write_message("/effort", number, {"data": value}, log_time=EPOCH * 10**9 + ms * 1_000_000)
        writer.finish()
    return path


def write_json_mcap(path: Path, texts) -> Path:
    """A log of JSON messages on `/state`, 10 ms apart."""
    with path.open("wb") as handle:
        writer = JsonWriter(handle)
        writer.start()
        schema = writer.register_schema("state", "jsonschema", b"{}")
        channel = writer.register_channel("/state", "json", schema)
        for i, text in enumerate(texts):
            writer.add_message(channel, log_time=i * 10_000_000, data=text.encode(), publish_time=i * 10_000_000)
        writer.finish()
    return path


def _message(kind: str, content: bytes) -> bytes:
    """A message of ULog: its size, its letter, its content."""
    return struct.pack("<HB", len(content), ord(kind)) + content


def write_ulog(path: Path, attitudes, gyros, dropout_ms: int = 0) -> Path:
    """A ULog file, version 1: `attitude` by (us, four numbers), and two instances of `gyro` by (us, instance, number).

    https://docs.px4.io/main/en/dev_log/ulog_file_format.html: the header, then the definitions (F), the subscriptions
    (A), the data (D) and the dropouts (O).
    """
    parts = [b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 1000)]
    parts += [_message("B", bytes(40))]
    parts += [
        _message("F", b"attitude:uint64_t timestamp;float[4] q;"),
        _message("F", b"gyro:uint64_t timestamp;float x;"),
    ]
    for number, (instance, name) in enumerate([(0, b"attitude"), (0, b"gyro"), (1, b"gyro")]):
        parts += [_message("A", struct.pack("<BH", instance, number) + name)]
    parts += [_message("D", struct.pack("<HQ4f", 0, us, *q)) for us, q in attitudes]
    parts += [_message("O", struct.pack("<H", dropout_ms))] if dropout_ms else []
    parts += [_message("D", struct.pack("<HQf", 1 + instance, us, x)) for us, instance, x in gyros]
    path.write_bytes(b"".join(parts))
    return path
