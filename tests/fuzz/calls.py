"""Valid calls of all public names, and the same with one to three arguments replaced by odd ones."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import islice
from typing import Any

import numpy as np

from . import examples
from .examples import Learned
from .oddities import ODD, PLAIN
from .ports import guess


@dataclass(frozen=True)
class Target:
    """A call of a public name, or of what one made: `function(**given)`."""

    name: str
    function: Callable[..., Any]
    given: dict[str, Any]
    optional: tuple[str, ...] = ()


@dataclass(frozen=True)
class Aims:
    """All targets, the objects of the workbench among their arguments, and the examples that answer otherwise."""

    targets: list[Target]
    objects: dict[str, Any]
    misfits: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class Call:
    """A target with some arguments replaced, as its reader would write it, and the call itself."""

    target: str
    text: str
    replaced: int
    make: Callable[[], Any]


def room_files() -> list[ModuleType]:
    """The files of calls that no example shows, each with `calls()` and `arguments()`."""
    return [importlib.import_module(f"{rooms.__name__}.{file.name}") for file in pkgutil.iter_modules(rooms.__path__)]


def aims() -> Aims:
    """Each public name that an example calls, the calls that no example shows, and what those objects can do."""
    names = examples.public_names()
    learned = examples.learn(names)
    found = [target for name, thing in names.items() if (target := _target(name, thing, learned))]
    arguments: dict[str, Callable[[Any], Any]] = {}
    things = _instances(learned)
    for file in room_files():
        arguments |= file.arguments()
        for call in file.calls():
            found.append(_of_room(call, learned))
            things.setdefault(type(made := call()), made)
    for kind, thing in things.items():
        if kind.__module__.startswith(("workbench", rooms.__name__)):
            found += _of_object(kind, thing, learned, arguments)
    return Aims(sorted(found, key=lambda target: target.name), _objects(found), learned.misfits)


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
    return Call(target.name, text, len(odd), lambda: _use(target.function(*places, **given)))


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


def _target(name: str, thing: Any, learned: Learned) -> Target | None:
    seen = learned.best(thing)
    if seen is None:
        return None
    given, optional = _varied(thing, seen.given)
    return Target(name, thing, given, optional)


def _varied(function: Any, given: dict[str, Any]) -> tuple[dict[str, Any], tuple[str, ...]]:
    """The arguments of a call that are not the defaults, and the names of those that are."""
    try:
        held = inspect.signature(function).parameters.values()
    except ValueError:
        return given, ()
    defaults = {p.name: p.default for p in held if p.default is not p.empty}
    own = {name: value for name, value in given.items() if name not in defaults or value is not defaults[name]}
    named = [p.name for p in held if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)]
    placed = any(name.startswith("*") for name in own) or any(p.kind is p.POSITIONAL_ONLY for p in held)
    return own, () if placed else tuple(name for name in named if name not in own)


def _instances(learned: Learned) -> dict[type, Any]:
    """One object of each class of the workbench that an example made."""
    found: dict[type, Any] = {}
    for seen in (one for calls in learned.calls.values() for one in calls):
        for thing in (seen.result, seen.owner):
            if type(thing).__module__.startswith("workbench") and not isinstance(thing, type):
                found.setdefault(type(thing), thing)
    return found


def _of_object(kind: type, thing: Any, learned: Learned) -> list[Target]:
    """Methods and properties of a class; not those of Python, of python-control, nor functions that a field holds."""
    found, own, elsewhere = [], getattr(kind, "__dataclass_fields__", {}), _of_control(kind)
    for attribute in (a for a in dir(kind) if not a.startswith("_") and a not in own and a not in elsewhere):
        how, label = inspect.getattr_static(kind, attribute), f"{kind.__module__}.{kind.__qualname__}.{attribute}"
        if isinstance(how, property | functools.cached_property):
            found.append(Target(label, functools.partial(getattr, thing, attribute), {}))
        elif inspect.isfunction(how) or isinstance(how, staticmethod | classmethod):
            seen = learned.best(how)
            here = seen.owner if seen and type(seen.owner) is kind else thing
            method = getattr(here, attribute)
            given, optional = _varied(method, seen.given if seen else {})
            missing = [p for p in inspect.signature(method).parameters.values() if p.name in optional]
            guessed = {p.name: guess(here, p.name) for p in missing if p.default is p.empty}
            found.append(Target(label, method, given | guessed, tuple(name for name in optional if name not in guessed)))
    return found


def _of_control(kind: type) -> set[str]:
    """The attributes that a class has from python-control."""
    return {name for base in kind.__mro__[1:] if base.__module__.startswith("control") for name in vars(base)}


def _objects(held: list[Target]) -> dict[str, Any]:
    """The workbench's own objects among the arguments of all calls, which are odd wherever another kind is wanted."""
    given = [value for target in held for value in target.given.values()]
    return {f"a {type(value).__name__}": value for value in given if type(value).__module__.startswith("workbench")}
