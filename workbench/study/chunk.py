"""Chunk: numbers under a name, as bytes that are the same on every machine, and their digest."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

FORMAT = b"workbench ledger 1\n"  # counts up when the meaning of a record changes


@dataclass(frozen=True)
class Chunk:
    """A JSON head, which names arrays and their shapes, and their numbers one behind the other, little-endian doubles.

    A NaN is stored as the one quiet NaN, so that equal results are equal bytes.
    """

    name: str
    head: bytes
    data: bytes = b""

    @property
    def digest(self) -> bytes:
        """The SHA-256 of the format, the name, the head and the data, each with its length."""
        found = hashlib.sha256(FORMAT)
        for part in (self.name.encode(), self.head, self.data):
            found.update(len(part).to_bytes(8, "little"))
            found.update(part)
        return found.digest()

    @property
    def said(self) -> Any:
        """What the head says."""
        return json.loads(self.head)

    def arrays(self) -> dict[str, Any]:
        """The arrays by name."""
        import numpy as np

        found, start = {}, 0
        for name, shape in self.said["arrays"]:
            size = int(np.prod(shape, dtype=int))
            found[name] = np.frombuffer(self.data, "<f8", size, start).reshape(shape).astype(float)
            start += 8 * size
        return found


def chunk_of(name: str, arrays: Mapping[str, Any]) -> Chunk:
    """Arrays of floats as a chunk."""
    import numpy as np

    head, data = [], []
    for key, array in arrays.items():
        head.append([key, list(array.shape)])
        data.append(np.where(np.isnan(array), np.nan, array).astype("<f8").tobytes())
    return Chunk(name, written({"arrays": head}), b"".join(data))


def written(said: Any) -> bytes:
    """Plain data as JSON that is the same in every process."""
    return json.dumps(said, sort_keys=True, separators=(",", ":")).encode()
