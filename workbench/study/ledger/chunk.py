"""Chunk: named arrays as bytes that are the same on every machine, with their digest before them."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from workbench.core.validation.refusals import Array

FORMAT = b"workbench record 2"  # the first line of a record; counts up when its meaning changes


@dataclass(frozen=True)
class Chunk:
    """A JSON head, which names arrays and their shapes, and their numbers, little-endian doubles."""

    name: str
    head: bytes
    data: bytes = b""

    @cached_property
    def digest(self) -> bytes:
        """The SHA-256 of the lines of name and head, and of the data behind them."""
        return hashlib.sha256(b"\n".join((self.name.encode(), self.head, self.data))).digest()

    def __bytes__(self) -> bytes:
        """The record: a line each of format, digest, name and head, and then the data."""
        lines = (FORMAT, self.digest.hex().encode(), self.name.encode(), self.head, self.data)
        return b"\n".join(lines)

    @property
    def content(self) -> dict[str, Any]:
        """The content of the head."""
        return dict(json.loads(self.head))

    def arrays(self) -> dict[str, Array]:
        """The arrays by name."""
        import numpy as np

        arrays, start = {}, 0
        for name, shape in self.content.get("arrays", []):
            size = math.prod(shape)
            arrays[name] = np.frombuffer(self.data, "<f8", size, start).reshape(shape).astype(float)
            start += 8 * size
        return arrays


def chunk_of(name: str, arrays: Mapping[str, Array], content: Mapping[str, object] | None = None) -> Chunk:
    """Arrays of floats as a chunk, with plain data beside them."""
    import numpy as np

    shapes, data = [], []
    for key, array in arrays.items():
        shapes.append([key, list(array.shape)])
        quiet = np.where(np.isnan(array), np.nan, array)  # of all NaN the quiet one: equal results are equal bytes
        data.append(quiet.astype("<f8").tobytes())
    return Chunk(name, plain({**(content or {}), "arrays": shapes}), b"".join(data))


def parse_chunk(record: bytes) -> Chunk | None:
    """The chunk of a record; None if the record is damaged, or is not of this format."""
    form, *lines = record.split(b"\n", 4)
    if form != FORMAT or len(lines) != 4:
        return None
    digest, name, head, data = lines
    chunk = Chunk(name.decode(errors="replace"), head, data)
    return chunk if chunk.digest.hex().encode() == digest and _is_whole(chunk) else None


def _is_whole(chunk: Chunk) -> bool:
    """True if the head is plain data whose arrays fill the data."""
    try:
        shapes = [shape for name, shape in chunk.content.get("arrays", []) if isinstance(name, str)]
        sizes = [size for shape in shapes for size in shape]
        whole = all(type(size) is int and size >= 0 for size in sizes)
        return whole and 8 * sum(map(math.prod, shapes)) == len(chunk.data)
    except (ValueError, TypeError, RecursionError):  # no JSON, or another one than ours
        return False


def plain(data: object) -> bytes:
    """Plain data as JSON that is the same in every process."""
    return json.dumps(data, sort_keys=True, separators=(",", ":")).encode()
