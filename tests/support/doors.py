"""Every door of the workbench: its functions, methods and dataclasses that refuse by their type hints."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, is_dataclass
from types import ModuleType
from typing import Any

import workbench
from workbench.core.validation import signatures

OPENED = signatures.check_arguments(lambda: None).__code__
CHECKED = "_door_of_class.<locals>.__post_init__"


@dataclass(frozen=True)
class Argument:
    """One argument of a door: the call that a message names, its name, and how the door is asked about a value."""

    door: str
    name: str
    ask: Callable[[object], object]

    def __str__(self) -> str:
        return f"{self.door}({self.name}=...)"


def doors() -> dict[str, list[Argument]]:
    """The arguments of all doors of each module that has one."""
    found = {module.__name__: list(_arguments(module)) for module in _modules()}
    return {name: arguments for name, arguments in found.items() if arguments}


def _modules() -> Iterator[ModuleType]:
    for _, name, _ in pkgutil.walk_packages(workbench.__path__, "workbench."):
        if not name.endswith("__main__"):
            yield importlib.import_module(name)


def _arguments(module: ModuleType) -> Iterator[Argument]:
    for thing in list(vars(module).values()):
        if getattr(thing, "__module__", "") != module.__name__:
            continue
        if inspect.isclass(thing):
            yield from _fields(thing)
            for part in vars(thing).values():
                yield from _parameters(part.__func__ if isinstance(part, staticmethod | classmethod) else part)
        else:
            yield from _parameters(thing)


def _parameters(function: Any) -> Iterator[Argument]:
    if getattr(function, "__code__", None) is not OPENED:
        return
    call, signature, fits, _, _ = signatures._plan(function.__wrapped__)
    for name, parameter in signature.parameters.items():
        if name not in ("self", "cls", "_cls") and parameter.kind is not parameter.VAR_KEYWORD:
            yield Argument(call, name, fits[name])


def _fields(cls: type) -> Iterator[Argument]:
    if not is_dataclass(cls) or getattr(vars(cls).get("__post_init__"), "__qualname__", "") != CHECKED:
        return
    fits: Mapping[str, Any] = signatures._fits(cls)
    for name, (_, call, fit) in fits.items():
        yield Argument(cls.__name__, name, lambda value, call=call, fit=fit: signatures._fit(call, fit, value))
