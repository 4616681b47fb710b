"""Completion of a ledger: the chunks, cases or items of works that it lacks are computed into it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from workbench.study.ledger.chunk import Chunk
from workbench.study.ledger.store import Ledger, RunCounter, Task, complete
from workbench.study.run_options import StudyOptions

Execute = Callable[[Sequence[Task]], Iterator[Chunk]]


@dataclass(frozen=True, eq=False)
class Pieces:
    """Pieces of one kind that a ledger shall hold, each a record of it.

    Attributes
    ----------
    kind
        Their name in messages, in the plural.
    tasks
        A task for each piece.
    execute
        Computes the pieces of some tasks, and yields each when it is done.
    cost
        What all of them cost, in words; nothing is said before the start if it is empty.
    unit, count
        The name, in the plural, and the number of what the progress counts.
    """

    kind: str
    tasks: tuple[Task, ...]
    execute: Execute
    cost: str
    unit: str
    count: int


def complete_pieces(pieces: Pieces, ledger: Ledger, order: StudyOptions, study: str) -> None:
    """Compute the pieces that the ledger lacks, for the study of that name.

    Raises
    ------
    LookupError
        If nothing shall be computed, and a piece is missing.
    """
    count, missing = len(pieces.tasks), sum(task.name not in ledger for task in pieces.tasks)
    if not missing:
        return
    if order.only_report:
        raise LookupError(
            f"{missing} of {count} {pieces.kind} are missing in '{ledger.out}': {run_again(ledger, order)}."
        )
    if pieces.cost:
        there = f"; {count - missing} of {count} {pieces.kind} are there already." if missing < count else "."
        order.say(f"{study}: {pieces.cost}{there}")
    with order.bar(study, pieces.unit) as tell:
        complete(pieces.tasks, ledger, pieces.execute, RunCounter(pieces.count, lambda: tell), order.acknowledge)


def run_again(ledger: Ledger, order: StudyOptions) -> str:
    """The command that computes what is missing, as the end of a sentence."""
    return f"`workbench run {order.script} --out {ledger.out}` computes them"
