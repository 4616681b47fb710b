"""A ledger of twenty chunks."""

import numpy as np

from workbench.study.ledger import store
from workbench.study.ledger.chunk import chunk_of
from workbench.study.ledger.store import FOLDER, StudyRecord, chunks, open_ledger

COUNT = 20
CHUNKS = [chunk_of(f"s/{i:02d}-{i}/f", {"a": np.full(500, float(i))}) for i in range(COUNT)]


def filled(out):
    """The folder of a closed ledger with all chunks."""
    with open_ledger(out) as ledger:
        ledger.describe(StudyRecord("s", "s.py"))
        for chunk in CHUNKS:
            ledger.write_durably(chunk)
    return out / FOLDER


def held(out):
    return [chunk for chunk in chunks(out) if chunk.name != store.ABOUT]


def completed(out):
    """What a later run finds, and adds."""
    with open_ledger(out) as ledger:
        for chunk in CHUNKS:
            if chunk.name not in ledger:
                ledger.write_durably(chunk)
        return ledger.remarks
