"""Doors: a public function or class takes what its type hints say, made Python's own, and refuses the rest by name."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from dataclasses import Field, fields
from typing import Any, NamedTuple, TypeVar, cast, get_type_hints

from workbench.validation.kinds import Fit, KindError, OutOfSight, fit_of
from workbench.validation.shapes import Part, parts_of, refuse_misshapen
from workbench.validation.views import show
from workbench.validation.words import raised

Door = TypeVar("Door", bound=Callable[..., Any])


class Plan(NamedTuple):
    """What a function takes: by place, by name, beyond the last place, and what of it has a declared shape."""

    call: str
    names: list[str]
    places: list[tuple[str, Fit]]
    named: dict[str, tuple[str, Fit]]
    rest: tuple[str, Fit]
    parts: list[Part]


def door(thing: Door) -> Door:
    """The same function, or dataclass below `@dataclass`, whose arguments must be of the kinds that its hints name.

    Whole numbers, numbers and truths of NumPy become Python's, numbers on axes arrays of doubles, lists tuples. What a
    hint does not name, finite numbers, say, is for the words of `workbench.validation.words`.
    """
    if isinstance(thing, type):
        return cast(Door, _door_of_class(thing))

    @functools.wraps(thing)
    def opened(*args: Any, **kwargs: Any) -> Any:
        plan = _plan(thing)
        rest = len(args) - len(plan.places)
        fitting = [_fit(*place, value) for place, value in zip(plan.places + [plan.rest] * rest, args, strict=False)]
        kwargs = {name: _fit(*plan.named[name], v) if name in plan.named else v for name, v in kwargs.items()}
        if plan.parts:
            given = dict(zip(plan.names, fitting, strict=False)) | kwargs
            refuse_misshapen(plan.call, given.get("self"), plan.parts, given)
        return thing(*fitting, **kwargs)

    return cast(Door, opened)


def fitted(owner: Any, field: Field[Any]) -> Any:
    """The value of a field, made to fit the field's type, or a refusal."""
    value = getattr(owner, field.name)
    default, call, fit = _fits(cast(Any, type(owner)))[field.name]
    return value if value is default else _fit(call, fit, value)


def answer(call: str, must: str, ask: Callable[[], Any], fit: Fit, refuses: bool = False) -> Any:
    """What a function of the user's own gives, made to fit; what it raises passes where it `refuses` for itself.

    Raises
    ------
    ValueError
        If the answer does not fit, or the function raises; the message says what `call` must do.
    """
    try:
        given = ask()
    except Exception as error:
        if refuses and type(error) in (ValueError, LookupError):
            raise
        raise ValueError(f"`{call}` must {must}; it raised {raised(error)}.") from error
    try:
        return fit(given)
    except KindError as misfit:
        raise ValueError(f"`{call}` must {must}; it gave {misfit.got}{_where(misfit)}.") from None


def _fit(call: str, fit: Fit, value: Any) -> Any:
    try:
        return fit(value)
    except KindError as misfit:
        raise ValueError(f"`{call}` must be {misfit.must}; got {misfit.got}{_where(misfit)}.") from None


def _where(misfit: KindError) -> str:
    return f" at {misfit.place}" if misfit.place else ""


def _door_of_class(cls: type) -> type:
    own = getattr(cls, "__post_init__", None)

    def __post_init__(self: Any) -> None:
        for name, (default, call, fit) in _fits(cast(Any, type(self))).items():
            value = getattr(self, name)
            clean = value if value is default else _fit(call, fit, value)
            if clean is not value:
                object.__setattr__(self, name, clean)
        if own is not None:
            own(self)

    cls.__post_init__ = __post_init__  # type: ignore[attr-defined]
    show(cls)
    return cls


@functools.cache
def _fits(cls: Any) -> dict[str, tuple[Any, str, Fit]]:
    """Of each field that is given: its default, how a message calls it, and what makes a value fit."""
    hints, given = _hints(cls), [f for f in fields(cls) if f.init]
    return {f.name: (f.default, f"{cls.__name__}({f.name}=...)", fit_of(hints.get(f.name, Any))) for f in given}


@functools.cache
def _plan(function: Any) -> Plan:
    hints, call = _hints(function), function.__qualname__.rpartition("<locals>.")[2].removesuffix(".__init__")
    plan = Plan(call, [], [], {}, ("", fit_of(Any)), [])
    for name, parameter in inspect.signature(function).parameters.items():
        fit = (f"{call}({name}=...)", fit_of(hints.get(name, Any)))
        if parameter.kind is parameter.VAR_POSITIONAL:
            plan = plan._replace(rest=fit)
        elif parameter.kind is not parameter.VAR_KEYWORD:
            plan.named[name] = fit
        if parameter.kind in (parameter.POSITIONAL_ONLY, parameter.POSITIONAL_OR_KEYWORD):
            plan.places.append(fit)
            plan.names.append(name)
        plan.parts.extend(parts_of(name, hints.get(name, Any)))
    return plan


@functools.cache
def _hints(thing: Any) -> dict[str, Any]:
    """The type hints of a class or a function."""
    unseen: dict[str, Any] = {}
    while True:
        try:
            return get_type_hints(thing, localns=unseen or None, include_extras=True)
        except NameError as error:
            if error.name is None or error.name in unseen:
                raise
            unseen[error.name] = OutOfSight
