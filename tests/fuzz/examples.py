"""Calls of public names, as the examples of the docstrings make them: with the arguments of a user, and what came."""

from __future__ import annotations

import dis
import doctest
import importlib
import inspect
import pkgutil
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import CodeType, FrameType, ModuleType
from typing import Any

import numpy as np

import workbench as wb
from workbench.core.validation import signatures

LONG = 0.5  # s of the processor: a call that takes longer is taken only where no other is seen
OWNERS = ("self", "cls", "_cls")
RETURNS = {dis.opmap[name] for name in ("RETURN_VALUE", "RETURN_CONST", "YIELD_VALUE") if name in dis.opmap}
WITHIN = ("workbench.design.loop_boxes",)  # rooms whose callers have checked what they hand on
MOST = 12  # calls that are kept of one function

# The files that examples read.
FILES = {
    "pendulum.urdf": """<robot name="pendulum">
  <link name="base"/>
  <link name="rod"><inertial><origin xyz="0 0 -0.5"/><mass value="1.5"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="hinge" type="continuous"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/></joint>
</robot>"""
}


@dataclass(frozen=True)
class Seen:
    """A call that an example made: its arguments by name, those by place as "*0", its object, result and time.

    It is `own` in the example of its own docstring, and `written` where the example itself makes it.
    """

    given: dict[str, Any]
    owner: Any
    result: Any
    own: bool
    written: bool
    seconds: float


@dataclass(frozen=True)
class Learned:
    """The calls of each function by the identity of its code, and what examples answered that they do not show."""

    calls: dict[int, list[Seen]] = field(default_factory=dict)
    misfits: list[str] = field(default_factory=list)

    def of(self, function: Any) -> list[Seen]:
        """All calls of a function or class."""
        return self.calls.get(id(code_of(function)), [])

    def best(self, function: Any) -> Seen | None:
        """The call of a function or class in its own example, and of several that with the most arguments."""
        return min(
            self.of(function),
            key=lambda one: (one.seconds > LONG, not one.own, not one.written, -len(one.given)),
            default=None,
        )


def modules() -> list[str]:
    """The face, and each folder of the workbench with an `__all__`."""
    names = [name for _, name, folder in pkgutil.walk_packages(wb.__path__, "workbench.") if folder]
    names = [name for name in names if name not in WITHIN]
    return ["workbench", *(name for name in sorted(names) if hasattr(importlib.import_module(name), "__all__"))]


def public_names() -> dict[str, Any]:
    """Functions and classes in an `__all__`, by module and name of where they are written."""
    held = {}
    for module in modules():
        room = importlib.import_module(module)
        for name in room.__all__:
            thing = getattr(room, name)
            if (inspect.isroutine(thing) or isinstance(thing, type)) and thing.__module__.startswith("workbench"):
                held[f"{thing.__module__}.{thing.__qualname__}"] = thing
    return dict(sorted(held.items()))


def code_of(thing: Any) -> CodeType | None:
    """The code of a function behind its doors, of what makes an object of a class, or of a method."""
    if isinstance(thing, type):
        makers = (vars(thing).get(name) for name in ("__init__", "__new__"))
        return next((code for maker in makers if (code := code_of(maker))), None)
    plain = inspect.unwrap(getattr(thing, "__func__", thing))
    return getattr(plain, "__code__", None)


def learn(names: dict[str, Any]) -> Learned:
    """Run the examples of these names in the working folder, and keep their calls of functions of the workbench.

    Those of a name that `wb` offers, by itself or in a room, know `wb` and `np` alone; others the names of their file.
    """
    rooms = [wb, *(room for name in wb.__all__ if isinstance(room := getattr(wb, name), ModuleType))]
    offered = [getattr(room, name) for room in rooms for name in room.__all__]
    for name, text in FILES.items():
        Path(name).write_text(text, encoding="utf-8")
    learned = Learned({id(code): [] for code in _codes(names)})
    for name, thing in names.items():
        shown = {"wb": wb, "np": np, "__name__": "example"}
        if thing not in offered:
            shown |= {name: held for name, held in vars(sys.modules[thing.__module__]).items() if name != "annotations"}
        example = doctest.DocTestParser().get_doctest(inspect.getdoc(thing) or "", shown, name, None, None)
        own, before = code_of(thing), sys.gettrace()
        sys.settrace(_watcher(learned, own))
        try:
            doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(example, out=learned.misfits.append)
        finally:
            sys.settrace(before)
    return learned


def _codes(names: dict[str, Any]) -> Iterator[CodeType]:
    """The code of these names, and of each public method of the workbench."""
    classes = {
        thing
        for module in [held for name, held in sys.modules.items() if name.startswith("workbench")]
        for thing in vars(module).values()
        if isinstance(thing, type) and thing.__module__.startswith("workbench")
    }
    methods = (method for kind in classes for name, method in vars(kind).items() if not name.startswith("_"))
    yield from (code for thing in [*names.values(), *classes, *methods] if (code := code_of(thing)))


def _watcher(learned: Learned, own: CodeType | None) -> Callable[..., Any]:
    """The trace of an example: most of the calls that it sees, millions, are of no known function."""
    calls = learned.calls

    def watch(frame: FrameType, event: str, _: Any) -> Callable[..., Any] | None:
        code = frame.f_code
        seen = calls.get(id(code))
        if seen is None or (len(seen) >= MOST and code is not own):
            return None
        return _watch(seen, code is own, frame)

    return watch


def _watch(seen: list[Seen], is_own: bool, frame: FrameType) -> Callable[..., Any]:
    """Keep a call of a known function when it returns, with its arguments as they were before a door converts them."""
    code = frame.f_code
    outer, start = frame.f_back, time.process_time()
    doored = outer is not None and outer.f_code.co_name == "opened" and outer.f_globals is vars(signatures)
    given = _at_the_door(code, outer.f_locals) if outer is not None and doored else _given(code, frame.f_locals)
    owner = given.pop(code.co_varnames[0], None) if code.co_varnames[:1] and code.co_varnames[0] in OWNERS else None
    caller = outer.f_back if outer is not None and doored else outer
    written = caller is not None and caller.f_code.co_filename.startswith("<doctest")
    frame.f_trace_lines = False

    def leave(frame: FrameType, event: str, result: Any) -> Any:
        if event == "return" and code.co_code[frame.f_lasti] in RETURNS:
            made = owner if code.co_name == "__init__" else result
            seen.append(Seen(given, owner, made, is_own, written, time.process_time() - start))
        return leave

    return leave


def _given(code: CodeType, values: dict[str, Any]) -> dict[str, Any]:
    """Arguments by the names of a frame; by place where the call takes any number of them."""
    places, names = code.co_varnames[: code.co_argcount], code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]
    given = {name: values[name] for name in names}
    rest = iter(code.co_varnames[len(names) :])
    if code.co_flags & inspect.CO_VARARGS:
        free = [name for name in places if name not in OWNERS]
        places_and_rest = [*(given.pop(name) for name in free), *values[next(rest)]]
        given |= {f"*{i}": value for i, value in enumerate(places_and_rest)}
    if code.co_flags & inspect.CO_VARKEYWORDS:
        given |= values[next(rest)]
    return given


def _at_the_door(code: CodeType, values: dict[str, Any]) -> dict[str, Any]:
    """Arguments as they came to the door of this code."""
    places, args = code.co_varnames[: code.co_argcount], values["args"]
    if code.co_flags & inspect.CO_VARARGS:
        owner = {places[0]: args[0]} if places[:1] and places[0] in OWNERS else {}
        return owner | {f"*{i}": value for i, value in enumerate(args[len(owner) :])} | values["kwargs"]
    return dict(zip(places, args, strict=False)) | values["kwargs"]
