"""The section `Parameters` of a block's docstring, made from the declarations of its fields.

A docstring may explain fields in a section `Parameters` of its own. To each explanation come the shape, the unit, the
bounds and the default of the field; a field without an explanation takes the one of a base class.
"""

from __future__ import annotations

import inspect
import re
import textwrap
from collections.abc import Iterator
from dataclasses import MISSING, Field, fields
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np

from workbench.core.numbers import Quantity
from workbench.core.units import ANY

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

HEAD = "Parameters\n----------\n"
SECTION = re.compile(r"^(\w[\w ]*)\n-{3,}$", re.MULTILINE)  # the heading of a section
WIDTH = 110  # letters of a line
OPTIONAL = "optional"  # of a field whose default is a block or a layout
SHAPES = {0: "number", 1: "vector", 2: "matrix"}  # by the number of axes


def with_parameters(cls: type[DataclassInstance]) -> str:
    """The docstring of a block with a section `Parameters` that has an entry for each field of its constructor."""
    doc = inspect.cleandoc(cls.__doc__ or "")
    texts: dict[str, str] = {}
    for base in cls.__mro__[::-1]:
        texts |= dict(_entries(base.__doc__))
    described = [(f, texts.get(f.name, "")) for f in fields(cls) if f.init]
    alike = groupby(described, key=lambda pair: (pair[1] or pair[0].name, _kind(pair[0])))
    entries = [_entry(*zip(*group, strict=True)) for _, group in alike]
    start, end = _section(doc)
    parts = doc[:start].rstrip(), HEAD + "\n".join(entries) if entries else "", doc[end:].strip()
    return "\n\n".join(part for part in parts if part)


def _section(doc: str) -> tuple[int, int]:
    """The places at which the section `Parameters` begins and ends, or the one at which it would stand."""
    heads = list(SECTION.finditer(doc))
    own = next((i for i, head in enumerate(heads) if head[1] == "Parameters"), None)
    if own is None:
        start = heads[0].start() if heads else len(doc)
        return start, start
    return heads[own].start(), heads[own + 1].start() if own + 1 < len(heads) else len(doc)


def _entries(docstring: str | None) -> Iterator[tuple[str, str]]:
    """Each field that a section `Parameters` explains, with its explanation; `a, b` explains two fields."""
    doc = inspect.cleandoc(docstring or "")
    start, end = _section(doc)
    names: list[str] = []
    lines: list[str] = []
    for line in [*filter(None, doc[start:end].removeprefix(HEAD).splitlines()), ""]:
        if line.startswith(" "):
            lines.append(line.strip())
            continue
        yield from ((name, " ".join(lines)) for name in names)
        names, lines = [name.strip() for name in line.partition(" : ")[0].split(",")], []


def _entry(alike: tuple[Field[object], ...], texts: tuple[str, ...]) -> str:
    """The entry of one field, or of several of one kind that share an explanation."""
    f, defaults = alike[0], list(dict.fromkeys(filter(None, map(_default, alike))))
    default = " and ".join(filter(None, (", ".join(defaults[:-1]), *defaults[-1:])))
    default = f"default {default}" if default and default != OPTIONAL else default
    head = f"{', '.join(f.name for f in alike)} : {', '.join(filter(None, (_kind(f), default)))}"
    choices = [f'- "{name}": {meaning}.' for name, meaning in f.metadata.get("option", {}).items()]
    own = texts[0].partition(choices[0])[0] if choices else texts[0]  # a base class has the choices in its text
    lines = [*textwrap.wrap(own, WIDTH), *([""] if choices else [])]  # a list of reStructuredText
    for choice in choices:
        lines += textwrap.wrap(choice, WIDTH, subsequent_indent="  ")
    return "\n".join([head, *(f"    {line}".rstrip() for line in lines)])


def _kind(f: Field[object]) -> str:
    quantity: Quantity | None = f.metadata.get("quantity")
    if quantity is None:
        return "" if "option" in f.metadata else _type(f)
    axes, bounds = quantity.shape, quantity.bounds
    shape = f" ({', '.join(axes)}{',' if len(axes) == 1 else ''})" if axes else ""
    either = {"*": "number or vector", "n": "number or vector (n,)"}  # one number may stand for all of a vector
    kind = either.get("".join(axes), f"{SHAPES.get(len(axes), 'array')}{shape}")
    start = "" if quantity.is_symbolic else "initial value of a state"
    definite = {"semi": "positive semidefinite", "positive": "positive definite"}.get(bounds.definite, "")
    matrix = definite or ("symmetric" if bounds.symmetric else "")
    return ", ".join(
        filter(None, (f"{kind}{_unit(quantity.unit)}", _range(bounds.low, bounds.high, bounds.strict), matrix, start))
    )


def _unit(unit: str) -> str:
    """A unit in brackets; the attributes in it, such as the unit of a signal, stand in backticks."""
    return "" if ANY in unit else f" [{re.sub('[{}]', '`', unit) or '1'}]"


def _range(low: float, high: float, strict: bool) -> str:
    """The bounds in words."""
    ends = ("above", "below") if strict else ("at least", "at most")
    both = [f"{word} {end:g}" for word, end in zip(ends, (low, high), strict=True) if np.isfinite(end)]
    return " and ".join(both)


def _type(f: Field[object]) -> str:
    hint = f.type if isinstance(f.type, str) else getattr(f.type, "__name__", str(f.type))
    return re.sub(r"\b(?:\w+\.)+(?=\w)", "", hint)


def _default(f: Field[object]) -> str:
    value = f.default
    if value is MISSING:
        if f.default_factory is MISSING:
            return ""
        if "quantity" not in f.metadata:  # a factory of a user's own is not called before an object is made
            return OPTIONAL
        value = f.default_factory()
    plain = (bool, int, float, str, type(None))
    if isinstance(value, plain) or (isinstance(value, tuple) and all(isinstance(part, plain) for part in value)):
        return repr(value)
    return OPTIONAL
