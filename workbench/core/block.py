"""Blocks: frozen dataclasses of plain numbers, each with its unit and its bounds.

`parameter` declares a number of the equations, `parameters` a layout of them, `initial` the start of a block's memory,
`option` a named choice among readings. `block` makes the frozen class and checks what its user gives it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import MISSING, Field, dataclass, field, fields
from types import FunctionType
from typing import Any, Literal, TypeVar, dataclass_transform

import casadi as ca
import numpy as np

from workbench.core.layout import Bounds, Entry, Layout
from workbench.core.numbers import shaped
from workbench.core.port import ANY
from workbench.core.show import letters
from workbench.validation.doors import door, fitted
from workbench.validation.views import Markup, show, table_to_html
from workbench.validation.words import numbers, one_of, refusal

# What the user gives is a float or an array; in the lifted twin the same field holds an SX.
Scalar = Any
Vector = Any
Matrix = Any

T = TypeVar("T")
MADE_IN_PYTHON = 1 << 9  # of a class's flags: others take no new attributes
PLACE = re.compile(r"\{(\w+)\}")  # of a text in a unit


@dataclass(frozen=True)
class Quantity:
    """What a field of a block says of its number."""

    unit: str
    bounds: Bounds
    shape: tuple[str, ...]
    symbol: str
    lifted: bool


@door
def parameter(
    default: Any = MISSING,
    *,
    unit: str,
    low: float = -np.inf,
    high: float = np.inf,
    strict: bool = False,
    symmetric: bool = False,
    definite: Literal["", "semi", "positive"] = "",
    shape: tuple[str, ...] = (),
    symbol: str = "",
) -> Any:
    """A number, vector or matrix of the equations: `lift` turns it into symbols keyed by its path.

    `shape` names its axes, as in ("n",) or ("n", "n"), where `n` is the block's `dof`, or counts them, as in
    ("3",), or is ("*",) for one number or a vector of them; `symbol` is how it is printed. With `strict` the bounds
    themselves are refused, with `symmetric` any other matrix; `definite` is that of `Bounds`. A default of None
    declares a number that may be left out.

    Examples
    --------
    >>> @wb.block
    ... class Spring:
    ...     k: float = wb.parameter(default=100.0, unit="N/m", low=0)
    >>> Spring().k, Spring(k=50).k
    (100.0, 50.0)
    """
    bounds = Bounds(low, high, strict, symmetric, definite)
    return _quantity(default, Quantity(unit, bounds, shape, symbol, lifted=True))


@door
def initial(default: Any = MISSING, *, unit: str, shape: tuple[str, ...] = (), symbol: str = "") -> Any:
    """The start of a block's memory: a default in the layout of states, not a parameter.

    Examples
    --------
    >>> @wb.block
    ... class Integrator(wb.Plant):
    ...     x: float = wb.initial(default=1.0, unit="m")
    ...     inputs, outputs = wb.layout(v="m/s"), wb.layout(x="m")
    ...     def rate(self, t, x, u):
    ...         return {"x": u.v}
    >>> Integrator(x=2.0).states.names
    ('x',)
    """
    return _quantity(default, Quantity(unit, Bounds(), shape, symbol, lifted=False))


@door
def option(choices: Mapping[str, str], default: str) -> Any:
    """A named choice among readings of an equation; `choices` says what each of them means.

    Examples
    --------
    >>> @wb.block
    ... class Motor:
    ...     measured: str = wb.option({"speed": "omega is read", "position": "theta is read"}, default="speed")
    >>> Motor().measured
    'speed'
    """
    one_of("option(default=...)", default, choices)
    return field(default=default, metadata={"option": dict(choices)})


def parameters(*, init: Literal[False] = False) -> Any:
    """A layout of numbers of the equations, which `__post_init__` sets; `lift` turns each into symbols as well."""
    return field(init=init, default=Layout(), metadata={"parameters": True})


def socket(convert: Callable[[Any], Any], default: Any = MISSING) -> Any:
    """A part of a block, or what `convert` makes one of."""
    return field(default=default, metadata={"convert": convert})


def _quantity(default: Any, quantity: Quantity) -> Any:
    metadata = {"quantity": quantity}
    if isinstance(default, np.ndarray | list | tuple):
        return field(default_factory=lambda: default, metadata=metadata)
    return field(default=default, metadata=metadata)


def quantities(owner: Any) -> list[tuple[Field[Any], Quantity]]:
    """The fields of a block that hold numbers, with what they say of themselves."""
    return [(f, f.metadata["quantity"]) for f in fields(owner) if "quantity" in f.metadata]


def unit_of(owner: Any, quantity: Quantity) -> str:
    """The unit of a number, in which `{name}` stands for the text of an attribute: the unit of a signal, say.

    A text of several units, "m, rad", makes several, one for each number; one number that stands for all is in "m or
    rad".
    """
    texts = {name: str(getattr(owner, name)).split(", ") for name in PLACE.findall(quantity.unit)}
    units = [quantity.unit] * max(map(len, texts.values()), default=1)
    for name, each in texts.items():
        units = [unit.replace(f"{{{name}}}", each[i % len(each)]) for i, unit in enumerate(units)]
    if texts:
        units = [f"1{unit}" if unit.startswith("/") else unit.replace("/s/s", "/s^2") for unit in units]
    return ", ".join(units) if quantity.shape else " or ".join(dict.fromkeys(units))


def starts(block: object) -> Layout:
    """The fields that a block declares by `initial`, as the layout of its states."""
    held = ((f.name, np.asarray(getattr(block, f.name), dtype=float), q) for f, q in quantities(block) if not q.lifted)
    return Layout(tuple(Entry(name, x, unit_of(block, q), symbol=q.symbol) for name, x, q in held))


def options(owner: Any) -> dict[str, tuple[str, str]]:
    """The named choices of a block: field to (choice, what it means)."""
    chosen = {f.name: (getattr(owner, f.name), f.metadata["option"]) for f in fields(owner) if "option" in f.metadata}
    return {name: (choice, meaning[choice]) for name, (choice, meaning) in chosen.items()}


@dataclass_transform(
    frozen_default=True, eq_default=False, field_specifiers=(parameter, parameters, initial, option, socket, field)
)
def block(cls: type[T]) -> type[T]:
    """Make `cls` a frozen dataclass that refuses, when built, parts of a wrong type and numbers out of bounds.

    Examples
    --------
    >>> @wb.block
    ... class Tank(wb.Plant):
    ...     A: float = wb.parameter(default=2.0, unit="m^2", low=0, strict=True)
    ...     h: float = wb.initial(default=1.0, unit="m")
    ...     inputs, outputs = wb.layout(w="m^3/s"), wb.layout(h="m")
    ...     def rate(self, t, x, u):
    ...         return {"h": u.w / self.A}
    >>> wb.open_loop(Tank(A=4.0)).parameters.names
    ('A', 'w')
    >>> Tank(A=0.0)
    Traceback (most recent call last):
        ...
    ValueError: `Tank(A=...)` must be finite, with 0 < value [m^2]; got 0.
    """
    if not isinstance(cls, type) or not cls.__flags__ & MADE_IN_PYTHON:
        raise refusal("block(cls)", "a class of your own", cls)
    own: Callable[[T], None] | None = cls.__dict__.get("__post_init__")

    def __post_init__(self: T) -> None:
        _check_sockets(self)
        _check_options(self)
        _check_quantities(self)
        if own is not None:
            own(self)

    for name, method in list(vars(cls).items()):
        if not name.startswith("_") and isinstance(method, FunctionType | staticmethod):
            inner = method.__func__ if isinstance(method, staticmethod) else method
            setattr(cls, name, staticmethod(door(inner)) if isinstance(method, staticmethod) else door(inner))
    cls.__post_init__ = __post_init__  # type: ignore[attr-defined]
    cls.__block__ = True  # type: ignore[attr-defined]
    cls.__setstate__ = _restore  # type: ignore[attr-defined]
    cls._repr_html_ = vars(cls).get("_repr_html_", _repr_html_)  # type: ignore[attr-defined]
    show(cls)
    return dataclass(frozen=True, eq=False)(cls)


def _repr_html_(self: Any) -> str:
    """What a notebook shows of a block: its numbers, its choices, and the blocks it is made of."""
    rows: list[tuple[object, ...]] = [
        (f.name, letters(q.symbol or f.name), _plain(getattr(self, f.name)), unit_of(self, q))
        for f, q in quantities(self)
    ]
    named = [getattr(self, f.name) for f in fields(self) if "parameters" in f.metadata]
    rows += [
        (e.name, letters(e.symbol or e.name), _plain(e.default), e.unit)
        for held in named
        if isinstance(held, Layout)  # of a lifted twin they are symbols without units
        for e in held.entries
    ]
    rows += [(f.name, "", getattr(self, f.name), "") for f in _sockets(self) if _is_plain(getattr(self, f.name))]
    rows += [(name, "", choice, meaning) for name, (choice, meaning) in options(self).items()]
    for f in fields(self):
        value = getattr(self, f.name)
        for part in value if isinstance(value, tuple) else (value,):
            if is_block(part):
                rows.append((f.name, "", Markup(part._repr_html_()), ""))
    return table_to_html(type(self).__name__, ("name", "letter", "value", "unit"), rows)


def _plain(value: Any) -> object:
    """A number as text: of a lifted twin the symbols."""
    return str(value) if isinstance(value, ca.SX) else np.asarray(value).tolist()


def _is_plain(value: Any) -> bool:
    return isinstance(value, bool | int | float | str)


def _restore(self: Any, state: Mapping[str, Any]) -> None:
    """What copying and unpickling build a block with: NumPy's copies of its arrays can be written to."""
    for value in state.values():
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
    self.__dict__.update(state)


def is_block(thing: Any) -> bool:
    """Whether `thing` is an instance of a class made by `block`."""
    return getattr(type(thing), "__block__", False)


def _sockets(owner: Any) -> list[Field[Any]]:
    """The fields of a block that hold neither a number of its equations nor a named choice."""
    return [f for f in fields(owner) if f.init and not f.metadata.keys() & {"quantity", "option"}]


def _check_sockets(owner: Any) -> None:
    for f in _sockets(owner):
        if "convert" in f.metadata:
            object.__setattr__(owner, f.name, f.metadata["convert"](getattr(owner, f.name)))
        object.__setattr__(owner, f.name, fitted(owner, f))


def _check_options(owner: Any) -> None:
    for f in fields(owner):
        if (choices := f.metadata.get("option")) is not None:
            one_of(f"{type(owner).__name__}({f.name}=...)", getattr(owner, f.name), choices)


def _check_quantities(owner: Any) -> None:
    """Turn every number into a read-only float array of its declared shape, or say what is wrong with it."""
    sizes: dict[str, int] = {}
    dof = _dof(owner)
    if dof is not None:
        sizes["n"] = dof
    for f, quantity in quantities(owner):
        if f.default is None and getattr(owner, f.name) is None:
            continue
        value = numbers(f"{type(owner).__name__}({f.name}=...)", getattr(owner, f.name))
        value = shaped(f"{type(owner).__name__}({f.name}=...)", value, quantity.shape, sizes)
        value.flags.writeable = False
        object.__setattr__(owner, f.name, float(value) if value.ndim == 0 else value)
        if not quantity.bounds.allow(value).all():
            held = unit_of(owner, quantity)
            unit = f" [{held}]" if held and ANY not in held else ""
            raise ValueError(
                f"`{type(owner).__name__}({f.name}=...)` must be {quantity.bounds}{unit}; got {_show(value)}."
            )


def _dof(owner: Any) -> int | None:
    """The number of joints, unless what it is counted from is not yet known to be right."""
    try:
        return int(owner.dof)
    except Exception:  # whatever an object says of itself when it is asked for its size
        return None


def _show(value: np.ndarray[Any, Any]) -> str:
    return f"{float(value):g}" if value.ndim == 0 else np.array2string(value, separator=", ")
