"""Work: a function of a study, computed once for each of its items; the answers are kept in the ledger."""

from __future__ import annotations

import typing
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import FunctionType
from typing import get_origin, get_type_hints

from workbench.core.validation.notebook_display import brief
from workbench.core.validation.refusals import error_text, positive, refusal
from workbench.core.validation.signatures import check_arguments
from workbench.study.definition_text import DigestError
from workbench.study.definitions import Definitions
from workbench.study.document.phrases_and_tables import check_name
from workbench.study.ledger.answers import AnswerError, answer_of, chunk_of_answer, classes_of
from workbench.study.ledger.chunk import Chunk
from workbench.study.user_values import UserValue

GUESS = 2.0  # s for an item of a work that states no time
LONGEST = 1e9  # s of an item
MAX_LETTERS = 60  # letters of an item in a message


class WorkError(ValueError):
    """An error in an item of a work: its message names both, and its cause is the error itself."""


@dataclass(frozen=True, eq=False)
@check_arguments
class Work:
    """A function that a study computes for each of some items: a replay, a search, a fit, a scan.

    For a plain run of a loop with metrics use a `Case` or a `Sweep` instead. `results.work(name)` gives the answers in
    the order of the items. Each answer is one record of the ledger, computed once for each
    version of its code.

    Attributes
    ----------
    function
        A function at the top of a module, with one item as its argument. It is computed again if it changes, or any
        code of the study that it calls. It returns plain data: numbers, text, None, tuples, lists, dicts with text
        keys, arrays of numbers, and frozen dataclasses of these, which its return annotation names.
    over
        The items, all distinct: numbers, text, tuples, arrays, frozen dataclasses, loops.
    answer
        The type of the result, if the function has no return annotation.
    seconds
        The time in s that an item takes on one processor, for the estimate; 2 s is assumed if it is not given.

    Raises
    ------
    ValueError
        If `function` is not at the top of a module, `seconds` is not positive, or two classes of answers have one name.
    LookupError
        If an annotation of `function` names a type that does not exist at run time.

    Examples
    --------
    >>> def speed_after_5_s(volts: float) -> float:
    ...     motor = wb.open_loop(wb.DCMotor())
    ...     return wb.simulate(motor, motor.parameters.pack({"v": volts}), until=5.0)["omega"][0, -1]
    >>> speeds = wb.Work("speeds", speed_after_5_s, over=(1.0, 2.0))
    >>> speeds.name, speeds.function(1.0).round(3)
    ('speeds', np.float64(0.1))
    """

    name: str
    function: Callable[[UserValue], UserValue]
    over: tuple[UserValue, ...]
    answer: object = None
    seconds: float | None = None

    def __post_init__(self) -> None:
        check_name("Work", self.name)
        call = f"Work({self.name!r}, function=...)"
        bare = getattr(self.function, "__wrapped__", self.function)  # of one in a cache, or behind a door
        if not isinstance(bare, FunctionType):
            raise refusal(call, "a function at the top of a module", self.function)
        if "<" in bare.__qualname__ or (bare.__closure__ and bare is self.function):
            raise ValueError(
                f"`{call}` must be a function at the top of a module, which another process finds by its name; got "
                f"'{bare.__qualname__}'. Write it as a `def` and put what it needs into `over`."
            )
        if self.seconds is not None:
            call = f"Work({self.name!r}, seconds=...)"
            if positive(call, self.seconds) > LONGEST:
                raise refusal(call, f"at most {LONGEST:g} s, thirty years", self.seconds)
        if not (
            self.answer is None or self.answer is typing.Any or isinstance(self.answer, type) or get_origin(self.answer)
        ):
            raise refusal(f"Work({self.name!r}, answer=...)", "a type or a type hint, as `float` is", self.answer)
        _ = self.classes

    @cached_property
    def classes(self) -> dict[str, type]:
        """The classes of which answers may consist, by their names."""
        call = f"Work({self.name!r}, answer=...)"
        hint = self.answer
        if hint is None:
            try:
                hint = get_type_hints(self.function).get("return")
            except NameError as error:
                raise LookupError(
                    f"`{call}` is needed, as the hints of '{self.function.__qualname__}' name '{error.name}', which is "
                    "not there when it runs: import it outside of `TYPE_CHECKING`, or give the type of the result."
                ) from None
        try:
            return classes_of(hint)
        except AnswerError as error:
            raise ValueError(f"`{call}` must name different classes: {error}.") from None


@dataclass(frozen=True, eq=False)
class CompiledWork:
    """A work with the name of a record for each item; the name has the digest of all that the answer depends on."""

    work: Work
    names: tuple[str, ...]

    @property
    def size(self) -> int:
        """The number of its items."""
        return len(self.names)

    @property
    def seconds_of_item(self) -> float:
        """The time in s that an item takes on one processor."""
        return self.work.seconds or GUESS

    def name(self, first: int, last: int) -> str:
        """The name of the record of the item `first`."""
        del last
        return self.names[first]

    def chunk(self, first: int, last: int) -> Chunk:
        """The answer of the item `first` as a chunk, which is computed here."""
        from workbench.design.matrices import one_thread  # brings SciPy's linear algebra, which few studies wait for

        del last
        work, item = self.work, self.work.over[first]
        try:
            with one_thread():  # with more, items wait for one another, and bits depend on the number of threads
                answer = work.function(item)
        except (SystemExit, GeneratorExit) as error:  # which would end the study, and say nothing
            why = f"by {error_text(error)}: return an answer"
            raise WorkError(f"The work '{work.name}' ends the study by itself at {item_text(item)}, {why}.") from error
        except Exception as error:
            why = error_text(error).removesuffix(".")
            raise WorkError(f"The work '{work.name}' fails at {item_text(item)}: {why}.") from error
        try:
            return chunk_of_answer(self.names[first], item_text(item), answer, work.classes)
        except AnswerError as error:
            raise WorkError(f"The work '{work.name}' must give plain data, and at {item_text(item)} {error}.") from None
        except Exception as error:  # an object of the user's may raise anything when it is asked for its parts
            why = f"its answer raised {error_text(error).removesuffix('.')}"
            raise WorkError(f"The work '{work.name}' must give plain data, and at {item_text(item)} {why}.") from error

    def answers(self, read: Callable[[str], Chunk]) -> tuple[UserValue, ...]:
        """The answers, from the records that `read` returns by their names."""
        return tuple(answer_of(read(name), self.work.classes) for name in self.names)


def compile_works(works: Sequence[Work]) -> tuple[CompiledWork, ...]:
    """Works with the names of their records; each definition that they call is read once."""
    definitions = Definitions()
    return tuple(compile_work(work, definitions) for work in works)


def compile_work(work: Work, definitions: Definitions | None = None) -> CompiledWork:
    """A work with the names of its records.

    Raises
    ------
    ValueError
        If two items are the same, or the function or an item uses what cannot be told apart by its contents.
    """
    definitions = definitions or Definitions()
    names: dict[str, int] = {}
    for i, item in enumerate(work.over):
        try:
            digest = definitions.digest(work.function, tuple(work.classes.values()), item)
        except DigestError as error:
            raise DigestError(f"`Work({work.name!r}, ...)` at {item_text(item)}: {error}") from None
        name = f"{work.name}/item/{digest[:16]}"
        if name in names:
            raise ValueError(
                f"`Work({work.name!r}, over=...)` needs distinct items; number {names[name]} and {i} are the same, "
                f"{item_text(item)}."
            )
        names[name] = i
    return CompiledWork(work, tuple(names))


def item_text(item: object) -> str:
    """An item in a message."""
    return brief(item, MAX_LETTERS)
