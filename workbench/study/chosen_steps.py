"""Steps that pilot runs chose: each is chosen once, and kept in the ledger of the study."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from workbench.engine.step_choice import StepChoice
from workbench.study.definition_text import DigestError
from workbench.study.definitions import Definitions
from workbench.study.ledger.chunk import Chunk, plain
from workbench.study.ledger.store import STEP


class ChosenSteps:
    """The records of chosen steps, by the digest of equation, metrics, pilot runs, times and tolerance."""

    def __init__(self, chunks: Iterable[Chunk] = ()) -> None:
        self.chunks = {chunk.name: chunk for chunk in chunks if chunk.name.startswith(f"{STEP}/")}

    def choice(self, key: tuple[object, ...], choose: Callable[[], StepChoice]) -> StepChoice:
        """The step that was chosen for these values, or is chosen now; always as it is read from its record."""
        try:
            name = f"{STEP}/{Definitions().digest(*key)[:32]}"
        except DigestError:  # a metric of the user's own, of which two could not be told apart
            return choose()
        if name not in self.chunks:
            self.chunks[name] = Chunk(name, plain({"choice": choose().record}))
        return StepChoice.from_record(self.chunks[name].content["choice"])


@contextmanager
def kept_in(steps: ChosenSteps) -> Iterator[None]:
    """Take the chosen steps of this context from `steps`, and keep new ones there."""
    mark = _here.set(steps)
    try:
        yield
    finally:
        _here.reset(mark)


def choice_of(key: tuple[object, ...], choose: Callable[[], StepChoice]) -> StepChoice:
    """The step that was chosen for these values, from the records of this context, or else one that is chosen now."""
    steps = _here.get()
    return choose() if steps is None else steps.choice(key, choose)


_here: ContextVar[ChosenSteps | None] = ContextVar("chosen steps", default=None)
