"""The answers of a work as a file that any program reads: JSON, with each item beside its answer."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from workbench.study.ledger.answers import plain_json
from workbench.study.ledger.chunk import Chunk
from workbench.study.ledger.durability import write_durably
from workbench.study.ledger.ownership import refuse_links


def write_answers(name: str, chunks: Sequence[Chunk], folder: Path) -> Path:
    """Write the answers to a file of the folder, which is there whole or not at all."""
    held = [(chunk.content, chunk.arrays()) for chunk in chunks]
    rows = [{"item": content["item"], "answer": plain_json(content["answer"], arrays)} for content, arrays in held]
    refuse_links(folder.parent, f"{folder.name}/{name}.json")
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / f"{name}.json"
    write_durably(file, json.dumps(rows, indent=1, ensure_ascii=False).encode(errors="replace"))
    return file
