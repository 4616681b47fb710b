"""Digests of the memory of a law, by which a machine shows the bits of thousands of periods in few bytes."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from workbench.core.validation.refusals import Array

Words = npt.NDArray[np.uint64]
Floats = npt.NDArray[np.float32]
Reals = Array | Floats

BASIS, PRIME = 0xCBF29CE484222325, 0x100000001B3  # of FNV-1a with 64 bits


def digest(rows: Reals) -> Words:
    """FNV-1a with 64 bits of the bytes of each row, in the order of this processor's memory from its least byte on.

    Every NaN counts as the one of the sign 0 and the first bit of the fraction.
    """
    rows = np.where(np.isnan(rows), rows.dtype.type(np.nan), rows)
    octets = np.ascontiguousarray(rows, dtype=rows.dtype.newbyteorder("<")).view(np.uint8)
    octets = np.ascontiguousarray(octets.reshape(len(rows), -1).T)
    total = np.full(len(rows), BASIS, dtype=np.uint64)
    for column in octets:
        total = (total ^ column) * np.uint64(PRIME)
    return total
