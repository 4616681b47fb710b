"""Views of any object of the workbench: one line of text, and a table for a notebook."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from html import escape
from itertools import islice
from numbers import Number
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

T = TypeVar("T")

LINE, PART, FEW = 110, 40, 8  # letters of a line, letters of one of its parts, numbers that are written out


class HtmlText(str):
    """Text that is HTML already."""

    __slots__ = ()


def show(cls: type[T]) -> type[T]:
    """Give a class, below `@dataclass`, a line and a table to show itself by, unless it has its own."""
    for name, view in (("__repr__", one_line), ("_repr_html_", fields_to_html)):
        if name not in vars(cls):
            setattr(cls, name, view)
    return cls


def one_line(thing: DataclassInstance) -> str:
    """The class of a dataclass with the fields that are not empty, shortened to one line."""
    full = [(name, value) for name, value in _fields(thing) if value is not None]
    full = [(name, value) for name, value in full if not isinstance(value, str | tuple | Mapping) or len(value)]
    for most in range(3 * PART // 2, PART // 2 - 1, -PART // 4):
        parts = [f"{name}={brief(value, most)}" for name, value in full]
        line = f"{type(thing).__name__}({', '.join(parts)})"
        if len(line) <= LINE:
            return line
    while len(line := f"{type(thing).__name__}({', '.join([*parts, '...'])})") > LINE and parts:
        parts.pop()
    return line


def short_list(parts: Sequence[str]) -> str:
    """The parts that fit in a line, with the count of all if some are left out."""
    text, held = "", 0
    while held < len(parts) and len(text) + len(parts[held]) <= LINE - PART // 2:
        text += f"{', ' if held else ''}{parts[held]}"
        held += 1
    return text if held == len(parts) else f"{text}, ... {len(parts)} in all"


def brief(value: object, most: int = PART) -> str:
    """A value in about `most` letters: of large arrays the shape, of large objects the class."""
    if isinstance(value, str):
        return repr(value) if len(value) <= most else f"{value[: most - 3]!r}..."
    if isinstance(value, bool | None):
        return str(value)
    if isinstance(value, Number):
        return f"{value:.6g}" if isinstance(value, float | complex) else str(value)
    if isinstance(value, np.ndarray):
        return _array(value, most)
    if isinstance(value, Mapping | list | tuple | set | frozenset):
        left, right = {list: ("[", "]"), tuple: ("(", ")")}.get(type(value), ("{", "}"))
        parts = [brief(item, most) for item in islice(value, FEW)]
        text = ", ".join(parts) + "," * (type(value) is tuple and len(value) == 1)
        short = len(text) <= most and len(parts) == len(value)
        return f"{left}{text if short or not parts else f'{parts[0]}, ... {len(value)} in all'}{right}"
    if callable(value) and hasattr(value, "__name__"):
        return str(value.__name__)
    try:
        text, name = " ".join(repr(value).split()), getattr(value, "name", None)
    except Exception:  # an object of the user's may raise anything when it is asked for its text
        return f"{type(value).__name__}(...)"
    long = f"{brief(name)}, ..." if isinstance(name, str) and name else "..."
    short = len(text) <= most and " at 0x" not in text  # the address of a plain object tells nothing
    return text if short else f"{type(value).__name__}({long})"


def fields_to_html(thing: DataclassInstance) -> HtmlText:
    """A table of the fields of a dataclass: numbers in full, objects in a line."""
    rows = [(name, cell(value)) for name, value in _fields(thing)]
    return table_to_html(type(thing).__name__, ("name", "value"), rows)


def table_to_html(title: str, head: Sequence[str], rows: Iterable[Sequence[object]]) -> HtmlText:
    """A table whose cells are text, escaped, or markup that already is."""
    body = "".join(f"<tr>{''.join(f'<td>{_escape(part)}</td>' for part in row)}</tr>" for row in rows)
    top = "".join(f"<th>{escape(word)}</th>" for word in head)
    return HtmlText(f"<table><caption>{escape(title)}</caption><tr>{top}</tr>{body}</table>")


def _fields(thing: DataclassInstance) -> list[tuple[str, object]]:
    return [(f.name, getattr(thing, f.name)) for f in fields(thing) if f.repr]


def _array(array: NDArray[np.generic], most: int) -> str:
    """The numbers of an array if they are few and short, else its shape."""
    if array.ndim == 0:
        return brief(array.item())
    text = f"[{', '.join(_array(np.asarray(row), most) for row in array)}]" if array.size <= FEW else ""
    return text if 0 < len(text) <= most else f"<{' x '.join(map(str, array.shape))}>"


def cell(value: object) -> object:
    """A value as a cell of a table, with a line for each of its first parts."""
    if isinstance(value, np.ndarray) and FEW < value.size <= FEW**2:
        return HtmlText(f"<pre>{escape(np.array2string(value, precision=6))}</pre>")
    if isinstance(value, Mapping):
        lines = [f"{brief(key)}: {brief(part, LINE)}" for key, part in value.items()]
    else:
        lines = [brief(part, LINE) for part in value] if isinstance(value, list | tuple) else []
    if lines:
        more = [f"... {len(lines)} in all"] if len(lines) > FEW else []
        return HtmlText("<br/>".join(map(escape, lines[:FEW] + more)))
    return value if isinstance(value, str) else repr(value) if is_dataclass(value) else brief(value, LINE)


def _escape(part: object) -> str:
    return part if isinstance(part, HtmlText) else escape(str(part))
