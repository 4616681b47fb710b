"""Answers: plain data as a chunk, and read back from it bit by bit.

Plain data are None, truth values, numbers, text, tuples, lists, dicts with text keys, arrays of numbers, and frozen
dataclasses or named tuples of these. The reader names the classes; nothing in a record is executed.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import get_args, get_type_hints

import numpy as np
from numpy.typing import NDArray

from workbench.core.validation.refusals import Array, with_article
from workbench.study.ledger.chunk import Chunk, chunk_of

NUMBERS = "fiucb"  # the kinds of arrays
LARGEST = 2**63 - 1  # of the whole numbers in an array
DEEPEST = 100  # of tuples, lists, dicts and dataclasses in one another
Classes = Mapping[str, type]


class AnswerError(ValueError):
    """The error of an answer that is no plain data, with its place."""


def classes_of(hint: object) -> dict[str, type]:
    """The frozen dataclasses and named tuples in a type hint and in the hints of their fields, by their names.

    Raises
    ------
    AnswerError
        If two have one name.
    """
    found: dict[str, type] = {}
    for kind in _classes_in(hint, set()):
        if found.setdefault(kind.__qualname__, kind) is not kind:
            raise AnswerError(f"there are two classes `{kind.__qualname__}`; give one another name")
    return found


def _classes_in(hint: object, seen: set[object]) -> Iterator[type]:
    for part in get_args(hint):
        yield from _classes_in(part, seen)
    if isinstance(hint, type) and (is_dataclass(hint) or _is_named_tuple(hint)) and hint not in seen:
        seen.add(hint)
        yield hint
        try:
            hints = get_type_hints(hint)
        except NameError:  # a name that only type checkers see
            hints = {}
        for part in hints.values():
            yield from _classes_in(part, seen)


def chunk_of_answer(name: str, item: str, answer: object, classes: Classes) -> Chunk:
    """An answer as a chunk, with its item in words.

    Raises
    ------
    AnswerError
        If it is not plain data, or holds a class that is not in `classes`.
    """
    _refuse_deep(answer)
    arrays: dict[str, Array] = {}
    tree = _tree(answer, "the answer", classes, arrays)
    return chunk_of(name, arrays, {"item": item, "answer": tree})


def answer_of(chunk: Chunk, classes: Classes) -> object:
    """The answer in a chunk; a `LookupError` if it holds a class that is not named."""
    return _value(chunk.content["answer"], classes, chunk.arrays())


def has_answer(chunk: Chunk) -> bool:
    """True if a chunk holds the answer of a work."""
    return b'"answer":' in chunk.head and "answer" in chunk.content


def _refuse_deep(answer: object) -> None:
    """Refuse an answer whose parts lie deeper in one another than a reader goes, as one that holds itself does."""
    level = [answer]
    for _ in range(DEEPEST):
        level = list({id(part): part for value in level for part in _parts(value)}.values())
        if not level:
            return
    raise AnswerError(f"the answer holds itself, or has parts more than {DEEPEST} deep in one another")


def _parts(value: object) -> Iterable[object]:
    if isinstance(value, Mapping):
        return value.values()
    if isinstance(value, list | tuple):
        return value
    return vars(value).values() if is_dataclass(value) and hasattr(value, "__dict__") else ()


def _tree(value: object, place: str, classes: Classes, arrays: dict[str, Array]) -> object:
    """A value as JSON: what JSON does not tell apart stands in an object of one key, which names its kind."""
    if value is None or isinstance(value, bool | np.bool_):
        return None if value is None else bool(value)
    if isinstance(value, str):
        return str(value)
    if isinstance(value, np.timedelta64) or (isinstance(value, np.inexact) and not _fits_double(value.dtype)):
        raise AnswerError(f"{place} is {with_article(type(value))}, and plain data are doubles and whole numbers")
    if isinstance(value, int | np.integer):
        return int(value)
    if isinstance(value, float | np.floating):
        return float(value)
    if isinstance(value, complex | np.complexfloating):
        return {"complex": [float(value.real), float(value.imag)]}
    if isinstance(value, np.ndarray):
        return _tree_of_array(value, place, arrays)
    if isinstance(value, Mapping):
        for key in value:
            if not isinstance(key, str):
                raise AnswerError(f"{place} has the key {key!r}, and a dict of plain data has text for keys")
        return {"dict": [[key, _tree(held, f"{place}[{key!r}]", classes, arrays)] for key, held in value.items()]}
    if isinstance(value, list) or type(value) is tuple:
        parts = [_tree(part, f"{place}[{i}]", classes, arrays) for i, part in enumerate(value)]
        return {type(value).__name__: parts}
    return _tree_of_object(value, place, classes, arrays)


def _fits_double(dtype: np.dtype[np.generic]) -> bool:
    return dtype.itemsize <= (16 if dtype.kind == "c" else 8)


def _tree_of_array(value: NDArray[np.generic], place: str, arrays: dict[str, Array]) -> object:
    kind = value.dtype.kind
    if np.ma.is_masked(value):
        raise AnswerError(f"{place} is an array that is masked in part: fill it, with NaN for instance")
    if kind not in NUMBERS or not _fits_double(value.dtype):
        raise AnswerError(f"{place} is an array of {value.dtype}, and plain data are doubles, whole numbers or truths")
    if kind in "fc":
        name = f"array {len(arrays)}"
        pairs = np.ascontiguousarray(value.astype(complex)).view(float) if kind == "c" else value
        arrays[name] = np.asarray(pairs, dtype=float).reshape(*value.shape, 2) if kind == "c" else pairs.astype(float)
        return {"pairs" if kind == "c" else "array": name}
    if kind == "u" and value.size and value.max() > LARGEST:
        raise AnswerError(f"{place} holds a whole number above {LARGEST}")
    return {"truths" if kind == "b" else "integers": [list(value.shape), value.ravel().tolist()]}


def _tree_of_object(value: object, place: str, classes: Classes, arrays: dict[str, Array]) -> object:
    kind = type(value)
    name = kind.__qualname__
    if not (is_dataclass(value) or _is_named_tuple(kind)):
        raise AnswerError(
            f"{place} is {with_article(kind)}; plain data are numbers, text, None, tuples, lists, dicts by text, "
            "arrays of numbers, and frozen dataclasses of these"
        )
    if is_dataclass(value) and not vars(kind)["__dataclass_params__"].frozen:
        raise AnswerError(f"{place} is {with_article(kind)}, a dataclass that is not frozen")
    if classes.get(name) is not kind:
        raise AnswerError(
            f"{place} is {with_article(kind)}, which the hint of the result does not name: write `-> {name}` at the "
            f"function, or `Work(answer={name})`"
        )
    names = [field.name for field in fields(value) if field.init] if is_dataclass(value) else vars(kind)["_fields"]
    held = [[one, _tree(getattr(value, one), f"{place}.{one}", classes, arrays)] for one in names]
    return {"object": [name, held]}


def _value(tree: object, classes: Classes, arrays: Mapping[str, Array]) -> object:
    if not isinstance(tree, dict):
        return tree
    ((kind, held),) = tree.items()
    if kind in ("array", "pairs"):
        values = arrays[held]
        return values if kind == "array" else np.ascontiguousarray(values).view(complex)[..., 0]
    if kind in ("integers", "truths"):
        shape, numbers = held
        return np.array(numbers, dtype=bool if kind == "truths" else np.int64).reshape(shape)
    if kind == "complex":
        return complex(*held)
    if kind in ("dict", "object"):
        pairs = held if kind == "dict" else held[1]
        parts = {key: _value(part, classes, arrays) for key, part in pairs}
        return parts if kind == "dict" else classes[held[0]](**parts)
    parts_of = [_value(part, classes, arrays) for part in held]
    return parts_of if kind == "list" else tuple(parts_of)


def _is_named_tuple(kind: type) -> bool:
    return issubclass(kind, tuple) and hasattr(kind, "_fields")


def plain_json(tree: object, arrays: Mapping[str, Array]) -> object:
    """The answer of a record as plain JSON for readers, in which numbers that JSON lacks are text."""
    if isinstance(tree, float) and not math.isfinite(tree):
        return repr(tree)
    if not isinstance(tree, dict):
        return tree
    ((kind, held),) = tree.items()
    if kind in ("array", "pairs"):
        return (
            plain_json({"list": arrays[held].tolist()}, arrays)
            if arrays[held].ndim
            else plain_json(float(arrays[held]), arrays)
        )
    if kind in ("integers", "truths"):
        return np.array(held[1]).reshape(held[0]).tolist()
    if kind in ("dict", "object"):
        return {key: plain_json(part, arrays) for key, part in (held if kind == "dict" else held[1])}
    return [plain_json({"list": part} if isinstance(part, list) else part, arrays) for part in held]
