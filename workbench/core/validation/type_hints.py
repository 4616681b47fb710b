"""Type hints: the conversion of a value to the type of a hint, and the words for a hint in a message."""

from __future__ import annotations

import functools
import inspect
import os
import types
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, TypeGuard, TypeVar, Union, get_args, get_origin, overload

import casadi as ca
import numpy as np

from workbench.core.validation.refusals import (
    WORDS,
    advice_for,
    as_array,
    as_number,
    as_path,
    as_text,
    as_whole,
    describe,
    name_of,
    with_article,
)

Types = tuple[type, ...]
Fit = Callable[[object], object]  # from a value to the same value in the type of a hint, or a `KindError`
T = TypeVar("T")
FEW = 3  # types that a message names, if there are more than four
SEVERAL = (Sequence, Collection, Iterable, list, tuple)


class KindError(Exception):
    """The error of a value that does not fit a hint: the requirement, the value, and its place among several.

    The value is described when it is asked for: most misfits are those of a union, another part of which fits.
    """

    def __init__(self, must: str, value_text: str | Callable[[], str], place: str = "") -> None:
        self.must, self.place, self._got = must, place, value_text

    @property
    def value_text(self) -> str:
        """The value in a few words."""
        return self._got if isinstance(self._got, str) else self._got()


class _Sight(type):
    def __getattr__(cls, name: str) -> object:
        if name.startswith("_"):
            raise AttributeError(name)
        return Any

    def __getitem__(cls, item: object) -> object:
        return Any


class OutOfSight(metaclass=_Sight):
    """A stand-in for a name that only the type checker or an inner function knows: it takes any value."""


@overload
def fit_of(hint: type[T]) -> Callable[[object], T]: ...
@overload
def fit_of(hint: Any) -> Callable[[object], Any]: ...
def fit_of(hint: Any) -> Fit:
    """The function that makes a value fit a type hint; a type that `isinstance` does not know takes anything."""
    kind, parts = get_origin(hint) or hint, get_args(hint)
    if isinstance(hint, TypeVar):
        return fit_of(hint.__bound__ or Any)
    if kind is Annotated:
        return fit_of(parts[0])
    if kind is Callable and parts and isinstance(parts[0], list) and parts[1] in (None, type(None)):
        return functools.partial(_function, len(parts[0]), words(hint))
    if kind in PLAIN:
        return functools.partial(_plain, PLAIN[kind], words(hint))
    if kind in (Union, types.UnionType):
        fit = functools.partial(_union, _classes(hint), _direct(parts), tuple(map(fit_of, parts)), words(hint))
        return functools.partial(_path, fit) if any(part in (Path, os.PathLike) for part in parts) else fit
    if kind is Path:
        return functools.partial(_path, functools.partial(_instance, kind, words(hint)))
    if kind is Literal:
        return functools.partial(_plain, lambda value: value if _among(value, parts) else None, words(hint))
    if kind is np.ndarray:
        return functools.partial(_plain, _whole_array if _is_whole(parts) else _array, words(hint))
    if kind in SEVERAL and parts:
        several = kind is not tuple or parts[-1] is Ellipsis
        fits = tuple(map(fit_of, parts[:1] if several else parts))
        return functools.partial(_items, kind, _classes(parts[0]) if several else (), fits, several, words(hint))
    if kind in (Mapping, dict) and parts:
        return functools.partial(_mapping, kind, fit_of(parts[0]), fit_of(parts[1]), words(hint))
    return functools.partial(_instance, kind, words(hint)) if _can_be_asked(kind) else lambda value: value


def words(hint: Any) -> str:
    """A hint in the words of a message: `an AbstractArm or None`."""
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
    return "a function" if kind is Callable else WORDS.get(kind) or with_article(kind)


def _kinds(hints: Iterable[object]) -> str:
    bare = (get_args(hint)[0] if get_origin(hint) is Annotated else hint for hint in hints)
    options = [kind for hint in bare for kind in (get_args(hint) if _is_union(hint) else (hint,))]
    return _or("any value" if kind in (Any, object) else name_of(kind) for kind in options)


def _or(options: Iterable[str]) -> str:
    """The options in a sentence; of many, the first ones and a count of the others."""
    named = list(dict.fromkeys(options))
    return " or ".join([*named[:FEW], f"{len(named) - FEW} other kinds"] if len(named) > FEW + 1 else named)


def _classes(hint: object) -> Types:
    """The classes of a hint whose instances need no conversion."""
    options = get_args(hint) if _is_union(hint) else (hint,)
    return tuple(k for k in options if isinstance(k, type) and k not in PLAIN and _can_be_asked(k))


def _direct(parts: tuple[object, ...]) -> dict[type, Fit]:
    """The part of a union for a value of exactly this type, where no part before it takes such a value."""
    fits: dict[type, Fit] = {}
    for part in parts:
        if not isinstance(part, type) or part not in (bool, int, float, str, type(None)):
            break
        if part is not int or float not in fits:  # as float takes whole numbers too
            fits.setdefault(part, fit_of(part))
    return fits


def _is_union(hint: object) -> bool:
    return get_origin(hint) in (Union, types.UnionType)


def _is_whole(parts: tuple[object, ...]) -> bool:
    scalar = (get_args(parts[-1]) or (float,))[0] if parts else float
    return issubclass(get_origin(scalar) or scalar, np.integer)


def _can_be_asked(kind: Any) -> TypeGuard[type]:
    """True if `isinstance` accepts the type, which it does not for some protocols."""
    try:
        isinstance(None, kind)
    except TypeError:
        return False
    return kind not in (Any, object, OutOfSight)


def _plain(clean: Fit, must: str, value: object) -> object:
    if (fit := clean(value)) is None:
        raise KindError(must, functools.partial(describe, value))
    return fit


def _instance(kind: type, must: str, value: object) -> object:
    if not isinstance(value, kind):
        raise KindError(must, lambda: describe(value) + advice_for(kind, value))
    return value


def _path(fit: Fit, value: object) -> object:
    """A value that fits; of one that is to be a path, only such as a file can have."""
    if isinstance(value, str | os.PathLike) and as_path(value) is None:
        raise KindError("a path that a file can have", describe(value))
    return fit(value)


def _function(count: int, must: str, value: Any) -> object:
    """A function that is told so many things, as far as it says; for those that answer there is `answer`."""
    if not callable(value):
        raise KindError(must, describe(value))
    try:
        signature = inspect.signature(value)
    except (TypeError, ValueError):  # a function in C says nothing; a class in C is none of the user's
        if isinstance(value, type):
            raise KindError(must, describe(value)) from None
        return value
    try:
        signature.bind(*range(count))
    except TypeError:
        arguments = f"{count or 'no'} argument{'' if count == 1 else 's'}"
        called = f"`{getattr(value, '__name__', type(value).__name__)}{signature}`"
        raise KindError(must, f"{called}, which cannot be called with {arguments}") from None
    return value


def _truth(value: object) -> bool | None:
    return bool(value) if isinstance(value, bool | np.bool_) else None


def _expression(value: object) -> ca.SX | None:
    """An expression unchanged, numbers as an expression without symbols."""
    if isinstance(value, ca.SX):
        return value
    array = as_array(value)
    return ca.SX(array) if array is not None and array.ndim <= 2 else None


def _array(value: object) -> object:
    """An array of doubles without a copy, as it may be large; any other one as a new array of doubles."""
    return value if type(value) is np.ndarray and value.dtype == np.float64 else as_array(value)


def _whole_array(value: object) -> object:
    """An array of whole numbers that an `int64` holds."""
    if (array := as_array(value)) is None or not (np.isfinite(array) & (array == np.rint(array))).all():
        return None
    given = np.array(value)
    fits = given.size == 0 or (int(given.min()) >= -(2**63) and int(given.max()) < 2**63)
    return given.astype(int) if fits else None


def _among(value: object, choices: tuple[object, ...]) -> bool:
    return any(type(value) is type(choice) and value == choice for choice in choices)


PLAIN: dict[object, Fit] = {
    int: as_whole,
    float: as_number,
    str: as_text,
    bool: _truth,
    ca.SX: _expression,
    Callable: lambda value: value if callable(value) else None,
}


def _union(asked_types: Types, direct: dict[type, Fit], fits: tuple[Fit, ...], must: str, value: object) -> object:
    if isinstance(value, asked_types):
        return value
    if (fit := direct.get(type(value))) is not None:
        try:
            return fit(value)
        except KindError:  # text that cannot be written
            pass
    misfits = []
    for fit in fits:
        try:
            return fit(value)
        except KindError as misfit:
            misfits.append(misfit)
    most = max(misfits, key=lambda misfit: (len(misfit.place), len(misfit.value_text)))  # the one that tells most
    raise KindError(must, most.value_text, most.place)


def _items(kind: type, asked_types: Types, fits: tuple[Fit, ...], several: bool, must: str, value: Any) -> object:
    """A tuple, or the list that the hint names, of items that fit; text is refused, though it has letters."""
    may_stay = type(value) is tuple and asked_types and kind is not list
    if may_stay and all(isinstance(item, asked_types) for item in value):
        return value
    try:
        if isinstance(value, str | bytes | Mapping) or (kind is not Iterable and not hasattr(value, "__getitem__")):
            raise TypeError
        items = tuple(value)
    except Exception:  # an object of the user's may raise anything when it is asked for its items
        raise KindError(must, describe(value) + (_alone(fits[0], value) if several else "")) from None
    if not several and len(items) != len(fits):
        raise KindError(must, f"{len(items)} of them")
    fitting = []
    for i, item in enumerate(items):
        try:
            fitting.append(fits[0 if several else i](item))
        except KindError as misfit:
            raise KindError(must, misfit.value_text, f"[{i}]{misfit.place}") from None
    return fitting if kind is list else tuple(fitting)


def _alone(fit: Fit, value: object) -> str:
    """The advice for one item that came in place of several."""
    try:
        fit(value)
    except KindError:
        return ""
    return ": one alone is written `(...,)`, with its comma"


def _mapping(kind: type, key_fit: Fit, value_fit: Fit, must: str, value: object) -> object:
    if not isinstance(value, Mapping) or not isinstance(value, kind):
        raise KindError(must, describe(value))
    fitting = {}
    for key, item in value.items():
        try:
            fitting[key_fit(key)] = value_fit(item)
        except KindError as misfit:
            raise KindError(must, misfit.value_text, f"[{describe(key)}]{misfit.place}") from None
    same = all(new is old for new, old in zip(fitting.values(), value.values(), strict=True))
    return value if same else fitting
