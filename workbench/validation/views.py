"""How any object of the workbench shows itself: in one line of text, and as a table in a notebook."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from html import escape
from itertools import islice
from numbers import Number
from typing import Any, TypeVar

import numpy as np

T = TypeVar("T")

LINE, PART, FEW = 110, 36, 8  # letters of a line, letters of one of its parts, numbers that are written out


class Markup(str):
    """Text that is HTML already."""

    __slots__ = ()


def show(cls: type[T]) -> type[T]:
    """Give a class, below `@dataclass`, a line and a table to show itself by, unless it has its own."""
    for name, view in (("__repr__", one_line), ("_repr_html_", fields_to_html)):
        if name not in vars(cls):
            setattr(cls, name, view)
    return cls


def one_line(thing: Any) -> str:
    """The class of a dataclass with its first fields that hold something, and dots for what one line does not hold."""
    line = f"{type(thing).__name__}("
    held = [(name, value) for name, value in _fields(thing) if not _is_empty(value)]
    for i, (name, value) in enumerate(held):
        part = f"{', ' if i else ''}{name}={brief(value)}"
        if len(line) + len(part) > LINE:
            return f"{line}{', ' if i else ''}...)"
        line += part
    return f"{line})"


def brief(value: Any) -> str:
    """A value in a few letters: of large arrays the shape, of large objects the class."""
    if isinstance(value, str):
        return repr(value) if len(value) <= PART else f"{value[: PART - 3]!r}..."
    if isinstance(value, bool | None):
        return str(value)
    if isinstance(value, Number):
        return f"{value:.6g}" if isinstance(value, float | complex) else str(value)
    if isinstance(value, np.ndarray):
        return _array(value)
    if isinstance(value, Mapping | list | tuple | set | frozenset):
        left, right = {list: "[]", tuple: "()"}.get(type(value), "{}")
        return f"{left}{_items([brief(item) for item in islice(value, FEW)], len(value))}{right}"
    if callable(value) and hasattr(value, "__name__"):
        return str(value.__name__)
    text = " ".join(repr(value).split())
    if len(text) <= PART:
        return text
    name = getattr(value, "name", None)
    return f"{type(value).__name__}({brief(name) if isinstance(name, str) else ''}...)".replace("'...", "', ...")


def fields_to_html(thing: Any) -> Markup:
    """A table of the fields of a dataclass: numbers in full, objects in a line."""
    rows = [(name, _whole(value)) for name, value in _fields(thing)]
    return table_to_html(type(thing).__name__, ("name", "value"), rows)


def table_to_html(title: str, head: Sequence[str], rows: Iterable[Sequence[object]]) -> Markup:
    """A table whose cells are text, escaped, or markup that already is."""
    body = "".join(f"<tr>{''.join(f'<td>{_cell(cell)}</td>' for cell in row)}</tr>" for row in rows)
    top = "".join(f"<th>{escape(word)}</th>" for word in head)
    return Markup(f"<table><caption>{escape(title)}</caption><tr>{top}</tr>{body}</table>")


def _fields(thing: Any) -> list[tuple[str, Any]]:
    return [(f.name, getattr(thing, f.name)) for f in fields(thing) if f.repr]


def _is_empty(value: Any) -> bool:
    return value is None or (isinstance(value, str | tuple | Mapping) and not len(value))


def _items(parts: list[str], count: int) -> str:
    """The first parts that take no more letters than a part may, and how many there are where that is not all."""
    text = ", ".join(parts)
    return text if len(text) <= PART and len(parts) == count else f"{parts[0]}, ... {count} in all"


def _array(array: np.ndarray[Any, Any]) -> str:
    if array.size > FEW:
        return f"<{' x '.join(map(str, array.shape))}>"
    return f"[{', '.join(map(_array, array))}]" if array.ndim else brief(array.item())


def _whole(value: Any) -> object:
    """A value as a cell of a table."""
    if isinstance(value, np.ndarray) and FEW < value.size <= FEW**2:
        return Markup(f"<pre>{escape(np.array2string(value, precision=6))}</pre>")
    return repr(value) if is_dataclass(value) else value if isinstance(value, str) else brief(value)


def _cell(cell: object) -> str:
    return cell if isinstance(cell, Markup) else escape(str(cell))
