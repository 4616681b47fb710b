"""Kinds: what a type hint takes, and the words for it."""

from __future__ import annotations

import functools
import types
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import casadi as ca
import numpy as np

from workbench.validation.words import WORDS, a, as_array, as_number, as_text, as_whole, described, name_of, way

Fit = Callable[[Any], Any]  # from a value to the same, made to be of the kind, or a `KindError`
FEW = 3  # kinds that a message names, of more than one beyond them
SEVERAL = (Sequence, Collection, Iterable, list, tuple)


class KindError(Exception):
    """A value that is not of the kind: what it must be, what came, and where among several."""

    def __init__(self, must: str, got: str, place: str = "") -> None:
        self.must, self.got, self.place = must, got, place


class _Sight(type):
    def __getattr__(cls, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        return Any

    def __getitem__(cls, item: Any) -> Any:
        return Any


class OutOfSight(metaclass=_Sight):
    """In place of a name that is imported for the type checker alone, or known within a function: it fits anything."""


def fit_of(hint: Any) -> Fit:
    """What makes a value fit a type hint; a type that cannot be asked takes anything."""
    kind, parts = get_origin(hint) or hint, get_args(hint)
    if isinstance(hint, TypeVar):
        return fit_of(hint.__bound__ or Any)
    if kind is Annotated:
        return fit_of(parts[0])
    if hasattr(kind, "_fields"):
        return functools.partial(_fit_of_named, kind, tuple(map(fit_of, _hints_of(kind).values())))
    if kind in PLAIN:
        return functools.partial(_plain, PLAIN[kind], words(hint))
    if kind in (Union, types.UnionType):
        return functools.partial(_fit_of_union, _classes(hint), tuple(map(fit_of, parts)), words(hint))
    if kind is Literal:
        return functools.partial(_plain, lambda value: value if _among(value, parts) else None, words(hint))
    if kind is np.ndarray:
        return functools.partial(_plain, _whole_array if _is_whole(parts) else _array, words(hint))
    if kind in SEVERAL and parts:
        several = kind is not tuple or parts[-1] is Ellipsis
        fits = tuple(map(fit_of, parts[:1] if several else parts))
        return functools.partial(_fit_of_items, kind, _classes(parts[0]) if several else (), fits, several, hint)
    if kind in (Mapping, dict) and parts:
        return functools.partial(_fit_of_mapping, kind, fit_of(parts[0]), fit_of(parts[1]), words(hint))
    if kind is type and parts:
        return functools.partial(_plain, lambda value: _class(value, parts[0]), words(hint))
    return functools.partial(_instance, kind, words(hint)) if _can_be_asked(kind) else lambda value: value


def words(hint: Any) -> str:
    """A type as one says it: `an AbstractArm or None`."""
    kind, parts = get_origin(hint) or hint, get_args(hint)
    if kind in (Union, types.UnionType):
        return _or(map(words, parts))
    if kind is Annotated:
        return words(parts[0])
    if kind is Literal:
        return f"one of {', '.join(map(repr, parts))}"
    if kind is np.ndarray:
        return f"{'whole ' if _is_whole(parts) else ''}numbers, in an array or lists"
    if kind in SEVERAL and parts:
        return f"a tuple of {_kinds(part for part in parts if part is not Ellipsis)}"
    if kind in (Mapping, dict) and parts:
        return f"a mapping from {_kinds(parts[:1])} to {_kinds(parts[1:])}, as a dict is"
    if kind is type and parts:
        return f"a class, {name_of(parts[0])} or one made of it"
    return "a function" if kind is Callable else WORDS.get(kind) or a(kind)


def _kinds(hints: Iterable[Any]) -> str:
    bare = (get_args(hint)[0] if get_origin(hint) is Annotated else hint for hint in hints)
    options = [kind for hint in bare for kind in (get_args(hint) if _is_union(hint) else (hint,))]
    return _or(name_of(kind) for kind in options)


def _or(options: Iterable[str]) -> str:
    """The options in a sentence, of many the first ones."""
    named = list(dict.fromkeys(options))
    rest = [f"{len(named) - FEW} other kinds"] if len(named) > FEW + 1 else []
    return " or ".join(named[:FEW] + rest if rest else named)


def _classes(hint: Any) -> tuple[type, ...]:
    """The classes of a hint whose instances fit as they are."""
    options = get_args(hint) if _is_union(hint) else (hint,)
    return tuple(k for k in options if isinstance(k, type) and k not in PLAIN and _can_be_asked(k))


def _is_union(hint: Any) -> bool:
    return get_origin(hint) in (Union, types.UnionType)


def _is_whole(parts: tuple[Any, ...]) -> bool:
    """Whether an array's type is one of whole numbers."""
    scalar = (get_args(parts[-1]) or (float,))[0] if parts else float
    return issubclass(get_origin(scalar) or scalar, np.integer)


def _can_be_asked(kind: Any) -> bool:
    """Whether `isinstance` takes a kind: no protocol, and nothing that is out of sight."""
    try:
        isinstance(None, kind)
    except TypeError:
        return False
    return kind not in (Any, object, OutOfSight)


def _plain(clean: Fit, must: str, value: Any) -> Any:
    fit = clean(value)
    if fit is None:
        raise KindError(must, described(value))
    return fit


def _instance(kind: Any, must: str, value: Any) -> Any:
    if not isinstance(value, kind):
        raise KindError(must, described(value) + way(kind, value))
    return value


def _truth(value: Any) -> bool | None:
    return bool(value) if isinstance(value, bool | np.bool_) else None


def _expression(value: Any) -> ca.SX | None:
    """An expression as it is, numbers as one without symbols."""
    if isinstance(value, ca.SX):
        return value
    array = as_array(value)
    return ca.SX(array) if array is not None and array.ndim <= 2 else None


def _array(value: Any) -> Any:
    """An array of doubles as it is, as it may be large, and others as a new one."""
    return value if type(value) is np.ndarray and value.dtype == np.float64 else as_array(value)


def _whole_array(value: Any) -> Any:
    """Whole numbers that an `int64` holds, as such."""
    array = as_array(value)
    if array is None or not (np.isfinite(array) & (array == np.rint(array))).all():
        return None
    given = np.array(value)
    held = given.size == 0 or (int(given.min()) >= -(2**63) and int(given.max()) < 2**63)
    return given.astype(int) if held else None


def _among(value: Any, choices: tuple[Any, ...]) -> bool:
    return any(type(value) is type(choice) and value == choice for choice in choices)


def _class(value: Any, parent: Any) -> Any:
    return value if isinstance(value, type) and issubclass(value, get_origin(parent) or parent) else None


PLAIN: dict[Any, Fit] = {
    int: as_whole,
    float: as_number,
    str: as_text,
    bool: _truth,
    ca.SX: _expression,
    Callable: lambda value: value if callable(value) else None,
}


def _fit_of_union(asked: tuple[type, ...], fits: tuple[Fit, ...], must: str, value: Any) -> Any:
    if isinstance(value, asked):
        return value
    misfits = []
    for fit in fits:
        try:
            return fit(value)
        except KindError as misfit:
            misfits.append(misfit)
    most = max(misfits, key=lambda misfit: (len(misfit.place), len(misfit.got)))  # which item, or what is to be done
    raise KindError(must, most.got, most.place)


def _hints_of(kind: Any) -> dict[str, Any]:
    """The types of a named tuple's fields, of which some have none."""
    return dict.fromkeys(kind._fields, Any) | get_type_hints(kind)


def _fit_of_items(
    kind: Any, asked: tuple[type, ...], fits: tuple[Fit, ...], several: bool, hint: Any, value: Any
) -> Any:
    """A tuple, or the list that is asked for, of items that fit; text is none, though it has letters."""
    if type(value) is tuple and asked and kind is not list and all(isinstance(item, asked) for item in value):
        return value
    try:
        if isinstance(value, str | bytes | Mapping) or (kind is not Iterable and not hasattr(value, "__getitem__")):
            raise TypeError
        items = tuple(value)
    except Exception:  # whatever an object says when it is asked for its items
        raise KindError(words(hint), described(value) + (_alone(fits[0], value) if several else "")) from None
    if not several and len(items) != len(fits):
        raise KindError(words(hint), f"{len(items)} of them")
    fitting = []
    for i, item in enumerate(items):
        try:
            fitting.append(fits[0 if several else i](item))
        except KindError as misfit:
            raise KindError(words(hint), misfit.got, f"[{i}]{misfit.place}") from None
    return fitting if kind is list else tuple(fitting)


def _alone(fit: Fit, value: Any) -> str:
    """What is to be done where one item came in place of several."""
    try:
        fit(value)
    except KindError:
        return ""
    return ": one alone is written `(...,)`, with its comma"


def _fit_of_named(kind: Any, fits: tuple[Fit, ...], value: Any) -> Any:
    """A named tuple whose fields fit."""
    if not isinstance(value, kind):
        raise KindError(a(kind), described(value))
    fitting = []
    for name, item, fit in zip(value._fields, value, fits, strict=True):
        try:
            fitting.append(fit(item))
        except KindError as misfit:
            raise KindError(f"{a(kind)} whose `{name}` is {misfit.must}", misfit.got, misfit.place) from None
    return kind(*fitting)


def _fit_of_mapping(kind: Any, key_fit: Fit, value_fit: Fit, must: str, value: Any) -> Any:
    if not isinstance(value, kind):
        raise KindError(must, described(value))
    fitting = {}
    for key, item in value.items():
        try:
            fitting[key_fit(key)] = value_fit(item)
        except KindError as misfit:
            raise KindError(must, misfit.got, f"[{described(key)}]{misfit.place}") from None
    same = all(new is old for new, old in zip(fitting.values(), value.values(), strict=True))
    return value if same else fitting
