"""Ports: layouts of the signals that a block reads, gives and drives, with their units; and the roles of a loop."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal, NoReturn, TypeAlias, TypeVar, overload

import casadi as ca
import numpy as np

from workbench.core.layout import Entry, Layout
from workbench.core.units import checked_unit, join_units, read
from workbench.core.validation.notebook_display import LINE, table_to_html
from workbench.core.validation.refusals import Array, as_text, describe, known_name, nearest, numbers, refusal
from workbench.core.validation.signatures import check_arguments

Way: TypeAlias = Literal["read", "filtered", "estimated"]
Information: TypeAlias = tuple[tuple[tuple[str, tuple[Way, ...]], ...], bool, bool, bool]
T = TypeVar("T")
AFFIX = re.compile(r"d{1,3}|_\w+|\d+")  # of a name that is derived from another one: `xd`, `x_ref`, `x2`
NUMBER = re.compile(r"\d+")


class NoSignalError(AttributeError, LookupError):
    """The error of a missing signal, asked for as an item or as an attribute."""


@check_arguments
class Signals(Mapping[str, ca.SX]):
    """A read-only mapping from names of signals to their values, which are also attributes: `y["q"]` is `y.q`.

    The values are usually columns of CasADi symbols. `signals | {"q": ...}` is a copy with other values.

    Examples
    --------
    >>> y = wb.Signals(omega=3.0, v=12.0)
    >>> y.omega, y["v"], list(y)
    (3.0, 12.0, ['omega', 'v'])
    """

    __slots__ = ("_parts",)
    _parts: dict[str, ca.SX]

    def __init__(self, parts: Mapping[str, ca.SX] | None = None, /, **signals: ca.SX) -> None:
        if not isinstance(parts, Mapping | None):
            raise refusal("Signals(parts)", "a mapping from names to expressions, as a dict is", parts)
        object.__setattr__(self, "_parts", {**(parts or {}), **signals})

    def __getitem__(self, name: str) -> ca.SX:
        try:
            return self._parts[known_name(name, self._parts, "signals")]
        except LookupError as error:
            raise NoSignalError(str(error)) from None

    def __contains__(self, name: object) -> bool:
        return name in self._parts

    @overload
    def get(self, name: str, default: None = None) -> ca.SX | None: ...
    @overload
    def get(self, name: str, default: ca.SX | T) -> ca.SX | T: ...
    @check_arguments
    def get(self, name: str, default: object = None) -> object:
        """The value of the signal `name`, or `default` if there is no such signal."""
        return self._parts.get(name, default)

    def __getattr__(self, name: str) -> ca.SX:
        if name.startswith("__") or name == "_parts":  # Python's own questions, those of `copy` among them
            raise AttributeError(name)
        return self[name]

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
        texts = {name: str(part) for name, part in self.items()}
        rows = [(name, text if len(text) <= LINE else f"{text[:LINE]}...") for name, text in texts.items()]
        return table_to_html("Signals", ("name", "expression"), rows)

    @check_arguments
    def only(self, names: Layout) -> Signals:
        """The signals whose names are in the layout `names`."""
        return Signals({name: self[name] for name in names.names})


METHODS = {name for name in dir(Signals) if not name.startswith("_")}  # `y.name` would be one of these


@check_arguments
def layout(**signals: object) -> Layout:
    """Declare the signals of a port or a memory, with their units, shapes and initial values.

    Each keyword is the name of a signal. Its value is the unit, as "rad/s", or the pair of unit and initial value. The
    initial value is zero by default, and an array makes a signal of its shape.

    Raises
    ------
    ValueError
        If a value is neither a unit nor such a pair, or a name is that of a method of `Signals`.

    Examples
    --------
    >>> port = wb.layout(omega="rad/s", v=("V", 12.0), q=("rad", [0.0, 0.0]))
    >>> port.names, port["omega"].unit, port["q"].shape
    (('omega', 'v', 'q'), 'rad/s', (2,))
    """
    return Layout(tuple(_entry(name, value) for name, value in signals.items()))


def _entry(name: str, value: object) -> Entry:
    call = f"layout({name}=...)"
    if name in METHODS:
        raise ValueError(f"`{call}` must have another name, as `{name}` is a method of the `Signals` that hold it.")
    if (unit := as_text(value)) is not None:
        return Entry(name, np.array(0.0), checked_unit(call, unit))
    if isinstance(value, tuple) and len(value) == 2 and (unit := as_text(value[0])) is not None:
        return Entry(name, numbers(call, value[1]), checked_unit(call, unit))
    raise refusal(call, "a unit, as 'rad/s' is, or a unit and the numbers at the start", value)


def one_entry(port: Layout, name: str) -> Entry:
    """All signals of a port as one column with the unit of each number."""
    return Entry(name, np.zeros(port.size), join_units([unit for entry in port.entries for unit in entry.units]))


def misfits(demand: Layout, offer: Layout) -> list[str]:
    """The reasons why an offered port cannot serve a wanted one, a clause for each; '{gives}' in it is who offers."""
    clauses = []
    for entry in demand.entries:
        if entry.name not in offer:
            held = ", ".join(map(repr, offer.names)) or "none"
            near = misspelt(entry.name, offer)
            clauses.append(f"'{entry.name}', where {{gives}} {held}{near.replace(' Did', '; did')}")
            continue
        other = offer[entry.name]
        if entry.size != other.size:
            want, got = ("one number" if e.size == 1 else f"{e.size} numbers" for e in (entry, other))
            clauses.append(f"'{entry.name}' as {want}, where {{gives}} it as {got}")
        elif not all(read(a).fits(read(b)) for a, b in zip(entry.units, other.units, strict=True)):
            want, got = (e.unit or "1" for e in (entry, other))
            clauses.append(f"'{entry.name}' in [{want}], where {{gives}} it in [{got}]")
    return clauses


def misspelt(name: str, port: Layout) -> str:
    """The question "Did you mean ...?" if a name is a misspelt signal of the port; else empty."""
    return nearest(name, [other for other in port.names if not _are_related(name, other)])


def _are_related(one: str, other: str) -> bool:
    """True if two names are those of two signals, and not one of them misspelt: `x` and `xd`, `h_1` and `h_2`."""
    short, long = sorted((one, other), key=len)
    affix = AFFIX.fullmatch(long[len(short) :]) if long.startswith(short) else None
    return affix is not None or long.endswith(f"_{short}") or NUMBER.sub("", one) == NUMBER.sub("", other)


def signals_of(call: str, port: Layout, parts: object) -> Signals:
    """The signals that a block returns for a port: every name of it, each in its shape, and no other name."""
    shapes = [f"'{e.name}'" if e.size == 1 else f"'{e.name}' {(e.shape + (1, 1))[:2]}" for e in port.entries]
    must = f"return {', '.join(shapes) or 'an empty mapping'}"
    if not isinstance(parts, Mapping):
        raise ValueError(f"`{call}` must {must}; it returned {describe(parts)}.")
    for name in port.names:
        if name not in parts:
            held = ", ".join(map(repr, parts)) or "an empty mapping"
            raise ValueError(f"`{call}` must {must}; it returned {held}, without '{name}'.")
    for name in parts:
        if name not in port:
            raise ValueError(
                f"`{call}` must {must}, and no more; it returned {describe(name)} too.{nearest(name, port.names)}"
            )
    return Signals({entry.name: column(call, entry.name, entry.shape, parts[entry.name]) for entry in port.entries})


def column(call: str, name: str, shape: tuple[int, ...], value: ca.SX | ca.DM | Array | float) -> ca.SX:
    """The expression that a method returned for a signal, in the signal's shape."""
    want = (shape + (1, 1))[:2]
    try:
        part: ca.SX = ca.SX(value)
    except Exception:
        raise ValueError(
            f"`{call}` must return '{name}' as an expression of shape {want}; it returned {describe(value)}."
        ) from None
    if part.shape != want:
        raise ValueError(f"`{call}` must return '{name}' in shape {want}; it returned shape {part.shape}.")
    return part


@dataclass(frozen=True)
@check_arguments
class Roles:
    """The information that the command of a loop depends on, directly or through any memory.

    A reading acts as 'read' at its own instant, 'filtered' by a memory of that output alone, or 'estimated' where an
    estimate from other readings, too, stands for it. `models` has, by the path of each model of the arm, which of its
    'M', 'C' and 'G' the command depends on, and by that of a model of any other plant 'f' where it does: none where a
    model is given and not used.
    """

    law: str
    observer: str  # '' where there is none
    readings: Mapping[str, tuple[Way, ...]]  # by the name of each output of the plant; () where it does not act
    reference: tuple[str, ...]  # the wanted signals on which the command depends, 'q_ref' for that of q
    models: Mapping[str, tuple[str, ...]]
    unread: tuple[str, ...]  # signals which no instrument gives, a disturbance among them, of which an estimate acts
    truths: tuple[str, ...]  # of those, the ones that act themselves
    law_states: int  # numbers in its memory
    observer_states: int

    @property
    def information(self) -> Information:
        """The way of each output, and the use of a model, an estimated disturbance or the truth."""
        return tuple(self.readings.items()), any(self.models.values()), bool(self.unread), bool(self.truths)


@check_arguments
def information_classes(roles: Mapping[str, Roles]) -> tuple[tuple[str, ...], ...]:
    """The laws in classes of equal information, within which a comparison is fair.

    Examples
    --------
    >>> from workbench.blocks.loop import roles
    >>> from workbench.core import information_classes
    >>> law = wb.PID(wb.DCMotor().outputs, wb.DCMotor().inputs, Kp=10.0, Ki=20.0)
    >>> loop = wb.ClosedLoop(wb.DCMotor(), controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    >>> information_classes({"PID": roles(loop), "the same": roles(loop)})
    (('PID', 'the same'),)
    """
    classes: dict[Information, list[str]] = {}
    for law, held in roles.items():
        classes.setdefault(held.information, []).append(law)
    return tuple(map(tuple, classes.values()))
