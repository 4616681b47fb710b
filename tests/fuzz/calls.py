"""Valid calls of all public names, and the same with one to three arguments replaced by odd ones."""

from __future__ import annotations

import functools
import importlib
import inspect
import pkgutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import islice
from types import ModuleType
from typing import Any

import numpy as np

from . import rooms
from .oddities import ODD, PLAIN


@dataclass(frozen=True)
class Target:
    """A call of a public name, or of what one made: `function(*fixed, **given)`, of which only `given` is replaced."""

    name: str
    function: Callable[..., Any]
    given: dict[str, Any]
    optional: tuple[str, ...] = ()
    fixed: tuple[Any, ...] = ()


@dataclass(frozen=True)
class Aims:
    """All targets, and the objects of the workbench among their arguments."""

    targets: list[Target]
    objects: dict[str, Any]


@dataclass(frozen=True)
class Call:
    """A target with some arguments replaced, as its reader would write it, and the call itself."""

    target: str
    text: str
    replaced: int
    make: Callable[[], Any]


def room_files() -> list[ModuleType]:
    """The files of all rooms, each with `MODULES`, `calls()` and `arguments()`."""
    return [importlib.import_module(f"{rooms.__name__}.{file.name}") for file in pkgutil.iter_modules(rooms.__path__)]


def public_names(module: str) -> list[str]:
    """The names in `__all__`, or else those that a module defines itself, without what begins with an underscore."""
    held = importlib.import_module(module)
    if hasattr(held, "__all__"):
        return list(held.__all__)
    own = {name: value for name, value in vars(held).items() if getattr(value, "__module__", None) == module}
    return [name for name, value in own.items() if not name.startswith("_") and callable(value)]


def aims(files: list[ModuleType]) -> Aims:
    """Each public name, and each public method and property of what it makes."""
    found: list[Target] = []
    for file in files:
        arguments = file.arguments()
        for name, call in file.calls().items():
            if isinstance(call, functools.partial):
                found.append(_target(name, call))
                found += _of_object(name, call(), arguments)
    return Aims(sorted(found, key=lambda target: target.name), _objects(found))


def call_of(held: Aims, seed: int, number: int) -> Call:
    """The call of that number."""
    rng = np.random.default_rng([seed, number])
    target = held.targets[int(rng.integers(len(held.targets)))]
    given, names = dict(target.given), [*target.given, *target.optional]
    shown = dict.fromkeys(target.given, "...")
    odd = rng.permutation(names)[: rng.integers(1, 4)] if names else []
    for name in map(str, odd):
        pool = ODD if rng.random() < 0.85 else PLAIN
        if rng.random() < 0.08:
            pool = {word: lambda value=value: value for word, value in held.objects.items()} or pool
        word = list(pool)[int(rng.integers(len(pool)))]
        value = pool[word]()
        old = given.get(name)
        if isinstance(old, list | tuple) and len(old) and type(old) in (list, tuple) and rng.random() < 0.3:
            place = int(rng.integers(len(old)))
            value, word = type(old)([*old[:place], value, *old[place + 1 :]]), f"[.. {word} at {place} ..]"
        given[name], shown[name] = value, word
    text = f"{target.name}({', '.join(f'{name}={word}' for name, word in shown.items())})"
    places = [given.pop(name) for name in list(given) if name.startswith("*")]
    return Call(target.name, text, len(odd), lambda: _use(target.function(*target.fixed, *places, **given)))


def _use(result: Any) -> None:
    """Take the first of what an iterator gives, as only then it is called, and all properties of an object.

    Those of python-control, from which some classes come, are its own.
    """
    if isinstance(result, Iterator):
        list(islice(result, 3))
    if type(result).__module__.startswith("workbench"):
        elsewhere = _of_control(type(result))
        for name in (name for name in dir(type(result)) if not name.startswith("_") and name not in elsewhere):
            if isinstance(inspect.getattr_static(type(result), name), property | functools.cached_property):
                getattr(result, name)


def _target(name: str, call: functools.partial[Any]) -> Target:
    given, optional = _named(call.func, call.args, call.keywords)
    return Target(name, call.func, given, optional)


def _named(function: Any, args: tuple[Any, ...], kwargs: dict[str, Any]) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Arguments by name, those that have no name by place ("*0"), and the names that are left."""
    try:
        signature = inspect.signature(function)
    except ValueError:
        return {f"*{i}": value for i, value in enumerate(args)} | kwargs, ()
    kinds = [p for p in signature.parameters.values() if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)]
    named = [p.name for p in kinds if p.kind is p.POSITIONAL_OR_KEYWORD]
    if any(p.kind in (p.VAR_POSITIONAL, p.POSITIONAL_ONLY) for p in signature.parameters.values()):
        return {f"*{i}": value for i, value in enumerate(args)} | kwargs, ()
    given = dict(zip(named, args, strict=False)) | kwargs
    return given, tuple(p.name for p in kinds if p.name not in given)


def _of_object(name: str, thing: Any, arguments: dict[str, Callable[[Any], Any]]) -> list[Target]:
    """Methods and properties of a thing that a room made; not of a module, of Python, of python-control."""
    kind, found = type(thing), []
    if not kind.__module__.startswith(("workbench", rooms.__name__)):
        return []
    own = getattr(kind, "__dataclass_fields__", {})  # a field that holds a function is no method
    elsewhere = _of_control(kind)
    for attribute in (a for a in dir(kind) if not a.startswith("_") and a not in own and a not in elsewhere):
        how = inspect.getattr_static(kind, attribute)
        label = f"{name}(...).{attribute}"
        if isinstance(how, property | functools.cached_property):
            found.append(Target(label, functools.partial(getattr, thing, attribute), {}))
        elif inspect.isfunction(how) or isinstance(how, staticmethod | classmethod):
            method = getattr(thing, attribute)
            guess = {}
            for p in inspect.signature(method).parameters.values():
                maker = arguments.get(f"{kind.__name__}.{attribute}.{p.name}") or arguments.get(p.name)
                if p.default is p.empty and p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY):
                    guess[p.name] = maker(thing) if maker else [0.1, 0.2]
            optional = tuple(p for p in inspect.signature(method).parameters if p not in guess)
            plain = all(
                p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)
                for p in inspect.signature(method).parameters.values()
            )
            found.append(Target(label, method, guess, optional if plain else ()))
    return found


def _of_control(kind: type) -> set[str]:
    """The attributes that a class has from python-control."""
    return {name for base in kind.__mro__[1:] if base.__module__.startswith("control") for name in vars(base)}


def _objects(held: list[Target]) -> dict[str, Any]:
    """The workbench's own objects among the arguments of all calls, which are odd wherever another kind is wanted."""
    given = [value for target in held for value in target.given.values()]
    return {f"a {type(value).__name__}": value for value in given if type(value).__module__.startswith("workbench")}
