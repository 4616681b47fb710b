"""Blocks: frozen dataclasses of plain numbers, each with its unit and its bounds."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import MISSING, Field, dataclass, field, fields, is_dataclass
from types import FunctionType
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Protocol, TypeVar, dataclass_transform, get_args

import casadi as ca
import numpy as np

from workbench.core.field_help import with_parameters
from workbench.core.layout import Entry, Layout
from workbench.core.numbers import Bounds, Quantity, fit_shape, shown_numbers
from workbench.core.units import ANY, checked_unit, fill_unit
from workbench.core.validation.notebook_display import cell, show, table_to_html
from workbench.core.validation.refusals import numbers, one_of, refusal, with_article
from workbench.core.validation.signatures import check_arguments, fit_field

if TYPE_CHECKING:
    from _typeshed import DataclassInstance
    from typing_extensions import TypeIs

# The user gives a float or an array; in the lifted twin the same field holds an SX.
Scalar = Any
Vector = Any
Matrix = Any
# Arguments of a block's methods: one number, a column of n numbers, the whole memory, all states.
Number = Annotated[ca.SX, "1"]
Column = Annotated[ca.SX, "n"]
Memory = Annotated[Mapping[str, ca.SX], "memory"]
States = Annotated[Mapping[str, ca.SX], "states"]

T = TypeVar("T")
MADE_IN_PYTHON = 1 << 9  # of a class's flags: others take no new attributes
PLACE = re.compile(r"\{(\w+)\}")  # of a text in a unit


class Block(Protocol):
    """An instance of a class made by `block`."""

    __block__: ClassVar[bool]
    __dataclass_fields__: ClassVar[dict[str, Field[object]]]


@check_arguments
def parameter(
    default: object = MISSING,
    *,
    unit: str,
    low: float = -np.inf,
    high: float = np.inf,
    strict: bool = False,
    symmetric: bool = False,
    definite: Literal["", "semi", "positive"] = "",
    shape: tuple[str, ...] = (),
    symbol: str = "",
    is_derived: bool = False,
) -> Any:
    """A field of a block that is a parameter of its equations: a number, a vector or a matrix.

    In a loop the parameter has the path of the field as its name, such as `plant.k`, and can be varied. A field
    without a default must be given. A field with the default None may be left out.

    Parameters
    ----------
    default
        The value if none is given.
    unit
        The unit, as "N/m", or "" for none. A name in braces is an attribute of the block, as in "{unit}/s".
    low, high, strict
        The bounds of every number. With `strict` a number must not be equal to a bound.
    symmetric, definite
        For a matrix: True if it must be symmetric; "positive" or "semi" if it must be positive (semi)definite, too.
    shape
        One entry for each axis: a count as "3", a letter for an axis of any length, or "n" for the `dof` of the block.
        Axes with the same letter have the same length. () is one number; ("*",) is one number or a vector.
    symbol
        The letter of the parameter in printed equations, as "K_p". The default is the name of the field.
    is_derived
        True for a number that a design computes together with others. It has no knob of its own on a page.

    Examples
    --------
    >>> @wb.block
    ... class Spring:
    ...     k: float = wb.parameter(default=100.0, unit="N/m", low=0)
    >>> Spring().k, Spring(k=50).k
    (100.0, 50.0)
    """
    bounds = Bounds(low, high, strict, symmetric, definite)
    return _quantity(default, Quantity(unit, bounds, shape, symbol, is_symbolic=True, is_derived=is_derived))


@check_arguments
def initial(default: object = MISSING, *, unit: str, shape: tuple[str, ...] = (), symbol: str = "") -> Any:
    """A field of a block that is a state of its equations; the value of the field is the initial value of the state.

    It is not a parameter of the equations: a run sets it as an initial state. The arguments are those of `parameter`.

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
    return _quantity(default, Quantity(unit, Bounds(), shape, symbol, is_symbolic=False))


@check_arguments
def option(choices: Mapping[str, str], default: str) -> Any:
    """A field of a block that selects one of several forms of its equations by name.

    `choices` has the name of each form with an explanation; `default` is the name of the form if none is given.

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
    """A layout of numbers of the equations, which `__post_init__` sets; `lift` turns them into symbols as well."""
    return field(init=init, default=Layout(), metadata={"parameters": True})


def socket(convert: Callable[..., object], default: object = MISSING) -> Any:
    """A part of a block, which `convert` makes of the value given."""
    return field(default=default, metadata={"convert": convert})


def _quantity(default: object, quantity: Quantity) -> Any:
    metadata = {"quantity": quantity}
    if isinstance(default, np.ndarray | list | tuple):
        return field(default_factory=lambda: default, metadata=metadata)
    return field(default=default, metadata=metadata)


def quantities(owner: DataclassInstance | type[DataclassInstance]) -> list[tuple[Field[object], Quantity]]:
    """The fields of a block that hold numbers, with their declarations."""
    return [(f, f.metadata["quantity"]) for f in fields(owner) if "quantity" in f.metadata]


def unit_of_quantity(owner: object, quantity: Quantity) -> str:
    """The unit of a number, in which `{name}` stands for the text of an attribute: the unit of a signal, say."""
    names = PLACE.findall(quantity.unit)
    if missing := [name for name in names if not hasattr(owner, name)]:
        raise LookupError(
            f"`parameter(unit={quantity.unit!r})` of {with_article(type(owner))} must have names of its attributes in "
            f"braces, whose texts become parts of the unit; it has no {missing[0]!r}."
        )
    texts = {name: str(getattr(owner, name)).split(", ") for name in names}
    count = max(map(len, texts.values()), default=1)
    units = [
        fill_unit(quantity.unit, {name: each[i % len(each)] for name, each in texts.items()}) for i in range(count)
    ]
    return ", ".join(units) if quantity.shape else " or ".join(dict.fromkeys(units))


def initial_states(block: DataclassInstance) -> Layout:
    """The fields that a block declares by `initial`, as the layout of its states."""
    held = (
        (f.name, np.asarray(getattr(block, f.name), dtype=float), q) for f, q in quantities(block) if not q.is_symbolic
    )
    return Layout(tuple(Entry(name, x, unit_of_quantity(block, q), symbol=q.symbol) for name, x, q in held))


@dataclass_transform(
    frozen_default=True, eq_default=False, field_specifiers=(parameter, parameters, initial, option, socket, field)
)
def block(cls: type[T]) -> type[T]:
    """Class decorator for blocks (plants, laws, observers, references): it makes a frozen dataclass that checks fields.

    The class declares its fields by `parameter`, `initial` and `option`, or by a plain annotation, as `law:
    Controller`. An instance with a value of a wrong type or shape, or with a number out of bounds, is refused by a
    ValueError. The help of the class lists its fields with their units; a section `Parameters` of its docstring may
    explain them.

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
    own: Callable[[DataclassInstance], None] | None = cls.__dict__.get("__post_init__")

    def __post_init__(self: DataclassInstance) -> None:
        _check_fields(self)
        _check_quantities(self)
        if own is not None:
            own(self)

    for name, method in list(vars(cls).items()):
        if not name.startswith("_") and isinstance(method, FunctionType | staticmethod):
            inner = method.__func__ if isinstance(method, staticmethod) else method
            setattr(
                cls,
                name,
                staticmethod(check_arguments(inner)) if isinstance(method, staticmethod) else check_arguments(inner),
            )
    cls.__post_init__ = __post_init__  # type: ignore[attr-defined]
    cls.__block__ = True  # type: ignore[attr-defined]
    cls.__setstate__ = _restore  # type: ignore[attr-defined]
    cls._repr_html_ = vars(cls).get("_repr_html_", _repr_html_)  # type: ignore[attr-defined]
    show(cls)
    made = dataclass(frozen=True, eq=False)(cls)
    if is_dataclass(made):  # which it is, and which mypy then knows
        for f, quantity in quantities(made):
            checked_unit(f"{cls.__name__}.{f.name} = parameter(unit=...)", PLACE.sub("x", quantity.unit))
        made.__doc__ = with_parameters(made)
    return made


def _repr_html_(self: DataclassInstance) -> str:
    units = {f.name: unit_of_quantity(self, quantity) for f, quantity in quantities(self)}
    rows = [(f.name, cell(getattr(self, f.name)), units.get(f.name, "")) for f in fields(self)]
    return table_to_html(type(self).__name__, ("name", "value", "unit"), rows)


def _restore(self: object, state: Mapping[str, object]) -> None:
    for value in state.values():
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
    self.__dict__.update(state)


def is_block(thing: object) -> TypeIs[Block]:
    """True for an instance of a class made by `block`."""
    return getattr(type(thing), "__block__", False)


def _check_fields(owner: DataclassInstance) -> None:
    for f in fields(owner):
        value = getattr(owner, f.name)
        if (choices := f.metadata.get("option")) is not None:
            one_of(f"{type(owner).__name__}({f.name}=...)", value, choices)
        elif f.init and "quantity" not in f.metadata:
            if "convert" in f.metadata:
                object.__setattr__(owner, f.name, f.metadata["convert"](value))
            object.__setattr__(owner, f.name, fit_field(owner, f))
            if f.name == "unit":
                object.__setattr__(
                    owner, f.name, checked_unit(f"{type(owner).__name__}(unit=...)", getattr(owner, f.name))
                )


def _check_quantities(owner: DataclassInstance) -> None:
    sizes = _sizes(owner)
    for f, quantity in quantities(owner):
        if getattr(owner, f.name) is None and (f.default is None or type(None) in get_args(f.type)):
            continue
        call = f"{type(owner).__name__}({f.name}=...)"
        value = fit_shape(call, numbers(call, getattr(owner, f.name)), quantity.shape, sizes)
        value.flags.writeable = False
        object.__setattr__(owner, f.name, float(value) if value.ndim == 0 else value)
        if not quantity.bounds.allow(value).all():
            unit = unit_of_quantity(owner, quantity)
            unit = f" [{unit}]" if unit and ANY not in unit else ""
            raise ValueError(f"`{call}` must be {quantity.bounds}{unit}; got {shown_numbers(value)}.")


def _sizes(owner: object) -> dict[str, int]:
    try:
        dof = getattr(owner, "dof", None)
        return {} if dof is None else {"n": int(dof)}
    except Exception:  # a part of a wrong type may raise anything when it is counted
        return {}
