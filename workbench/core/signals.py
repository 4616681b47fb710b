"""Signals: what passes between the blocks of a loop, by name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NoReturn

import casadi as ca

from workbench.core.layout import Layout
from workbench.validation.doors import door
from workbench.validation.views import LINE, table_to_html
from workbench.validation.words import known, nearest, refusal


class NoSignalError(AttributeError, LookupError):
    """A name that is none of the signals, asked for as an item or as an attribute."""


@door
class Signals(Mapping[str, ca.SX]):
    """A read-only mapping from names to columns of symbols, whose names are attributes too: `y["q"]` is `y.q`.

    Parameters
    ----------
    parts, named
        An expression for each name; a number stands for itself.

    Examples
    --------
    >>> y = wb.Signals(omega=3.0, v=12.0)
    >>> y.omega, y["v"], list(y)
    (3.0, 12.0, ['omega', 'v'])
    """

    __slots__ = ("_parts",)
    _parts: dict[str, ca.SX]

    def __init__(self, parts: Mapping[str, ca.SX] | None = None, /, **named: ca.SX) -> None:
        if not isinstance(parts, Mapping | None):
            raise refusal("Signals(parts)", "a mapping from names to expressions, as a dict is", parts)
        object.__setattr__(self, "_parts", {**(parts or {}), **named})

    def __getitem__(self, name: str) -> ca.SX:
        try:
            return self._parts[known(name, self._parts, "signals")]
        except LookupError as error:
            raise NoSignalError(str(error)) from None

    def __contains__(self, name: object) -> bool:
        return name in self._parts

    @door
    def get(self, name: str, default: Any = None) -> Any:
        """The signal of a name, or something else where there is none."""
        return self._parts.get(name, default)

    def __getattr__(self, name: str) -> ca.SX:
        if name.startswith("__") or name == "_parts":  # Python's own questions, those of `copy` among them
            raise AttributeError(name)
        if name in self._parts:
            return self._parts[name]
        held = ", ".join(self._parts) or "none"
        raise NoSignalError(f"There is no signal '{name}' among {held}.{nearest(name, self._parts)}")

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise AttributeError(f"Signals are read-only: '{name}' cannot be set. Take `signals | {{'{name}': ...}}`.")

    def __iter__(self) -> Iterator[str]:
        return iter(self._parts)

    def __len__(self) -> int:
        return len(self._parts)

    def __or__(self, other: Mapping[str, ca.SX]) -> Signals:
        return Signals({**self._parts, **other})

    def __reduce__(self) -> tuple[type[Signals], tuple[dict[str, ca.SX]]]:
        return Signals, (self._parts,)

    def __repr__(self) -> str:
        return f"<Signals {', '.join(self._parts) or 'without names'}>"

    def _repr_html_(self) -> str:
        """A table of names and expressions."""
        texts = {name: str(part) for name, part in self.items()}
        rows = [(name, text if len(text) <= LINE else f"{text[:LINE]}...") for name, text in texts.items()]
        return table_to_html("Signals", ("name", "expression"), rows)

    @door
    def only(self, names: Layout) -> Signals:
        """Those that a port has."""
        return Signals({name: self[name] for name in names.names})
