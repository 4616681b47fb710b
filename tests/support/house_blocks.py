"""The blocks and metrics of the workbench, as the examples of their docstrings make them."""

from __future__ import annotations

import doctest
import importlib
import inspect
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

import workbench as wb

SEEN = "it was not made by the example of its docstring"


def public_classes(rooms: tuple[str, ...], kind: type) -> dict[str, type]:
    """The classes of a kind in the `__all__` of some rooms, without the abstract ones."""
    held = [getattr(importlib.import_module(room), name) for room in rooms for name in _names(room)]
    return {
        f"{thing.__module__.split('.')[1]}.{thing.__name__}": thing
        for thing in held
        if isinstance(thing, type) and issubclass(thing, kind) and not inspect.isabstract(thing)
    }


def _names(room: str) -> tuple[str, ...]:
    return tuple(importlib.import_module(room).__all__)


@cache
def example_of(cls: type) -> Any:
    """The first object of a class that the example of its docstring makes."""
    made: list[Any] = []
    check = cls.__post_init__

    def watched(self: Any) -> None:
        check(self)
        if type(self) is cls:
            made.append(self)

    cls.__post_init__ = watched
    try:
        shown = {"wb": wb, "np": np, "__name__": "example"}
        shown |= {k: v for k, v in vars(importlib.import_module(cls.__module__)).items() if k != "annotations"}
        example = doctest.DocTestParser().get_doctest(inspect.getdoc(cls) or "", shown, cls.__name__, None, None)
        doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(example, out=lambda text: None)
    finally:
        cls.__post_init__ = check
    assert made, f"`{cls.__name__}`: {SEEN}"
    return made[0]


# Tests of a kit that compile, run a loop or start a program: they run by `make test-all` for all blocks but a few.
LONG_TESTS = (
    "test_runs_have_the_same_bits_alone_and_in_any_batch",
    "test_a_run_in_a_computer_is_finite",
    "test_its_graph_has_the_bits_of_its_loop",
    "test_its_module_of_python_has_the_bits_of_its_loop",
    "test_its_c_code_has_the_bits_of_its_loop",
    "test_it_has_the_bits_of_its_loop_in_a_browser",
    "test_it_is_written_in_each_form",
    "test_its_live_page_computes_the_same_numbers",
)


def without(*names: str) -> Callable[[type], type]:
    """A class of tests less those of these names, or those that it has of them."""

    def less(cls: type) -> type:
        for name in names:
            if hasattr(cls, name):
                setattr(cls, name, None)
        return cls

    return less
