"""The door of a public function or class: it converts arguments to their type hints, or refuses them by name."""

from __future__ import annotations

import functools
import inspect
import re
import types
from collections.abc import Callable, Mapping, Sequence
from dataclasses import Field, fields, is_dataclass
from typing import TYPE_CHECKING, Annotated, Protocol, TypeVar, Union, cast, get_args, get_origin, get_type_hints

import casadi as ca
import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import error_text
from workbench.core.validation.type_hints import Fit, KindError, OutOfSight, fit_of

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Callee = TypeVar("Callee", bound=Callable[..., object])
Argument = TypeVar("Argument")
Clean = TypeVar("Clean")

PORTS = {  # of a block, each a layout
    "memory": "the whole memory",
    "_own": "the whole memory",  # of an element, which depends on the size of its signal
    "states": "all states",
    "reads": "all that the block reads",
    "follows": "all that the law follows",
    "inputs": "all inputs",
}
SHAPED_TYPES = ca.SX, np.ndarray
AXIS = re.compile(r"(\d*)([a-z]*)")


class _Entry(Protocol):
    @property
    def name(self) -> str: ...
    @property
    def shape(self) -> tuple[int, ...]: ...


class _Port(Protocol):
    @property
    def entries(self) -> Sequence[_Entry]: ...
    @property
    def names(self) -> Sequence[str]: ...


def check_arguments(target: Callee) -> Callee:
    """The same function, or dataclass below `@dataclass`, whose arguments must fit its type hints.

    Whole numbers, numbers and truths of NumPy become Python's, numbers on axes arrays of doubles, lists tuples. Rules
    that no hint can name (a finite number, say) are for `workbench.core.validation.refusals`.
    """
    if isinstance(target, type):
        return cast(Callee, _door_of_class(target))

    @functools.wraps(target)
    def checked_call(*args: object, **kwargs: object) -> object:
        call, signature, fits, axes, plain = _plan(target)
        if plain is not None:  # as `bind` does it, which takes longer than many a function
            named = dict(zip(plain, args, strict=False)) | kwargs
            if len(named) < len(args) + len(kwargs) or not named.keys() <= fits.keys():
                return target(*args, **kwargs)  # whose own error names the function
            named = {name: fit(named[name]) for name, fit in fits.items() if name in named}
            if axes:
                _refuse_misshapen(call, named.get("self"), axes, named)
            return target(**named)
        try:
            bound = signature.bind(*args, **kwargs)
        except TypeError:
            return target(*args, **kwargs)
        given = bound.arguments
        for name in given:
            given[name] = fits[name](given[name])
        if axes:
            _refuse_misshapen(call, given.get("self"), axes, given)
        return target(*bound.args, **bound.kwargs)

    return cast(Callee, checked_call)


def fit_field(owner: DataclassInstance, field: Field[object]) -> object:
    """The value of a field, made to fit the field's type, or a refusal."""
    value = getattr(owner, field.name)
    default, call, fit = _fits(type(owner))[field.name]
    return value if value is default else _fit(call, fit, value)


def answer(
    call: str, must: str, ask: Callable[[], Argument], fit: Callable[[Argument], Clean], refuses: bool = False
) -> Clean:
    """The answer of a function of the user's own, made to fit; its own refusals pass if it `refuses` for itself.

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
        raise ValueError(f"`{call}` must {must}; it raised {error_text(error)}.") from error
    try:
        return fit(given)
    except KindError as misfit:
        raise ValueError(f"`{call}` must {must}; it gave {misfit.value_text}{_where(misfit)}.") from None


def _fit(call: str, fit: Fit, value: object) -> object:
    try:
        return fit(value)
    except KindError as misfit:
        raise ValueError(f"`{call}` must be {misfit.must}; got {misfit.value_text}{_where(misfit)}.") from None


def _where(misfit: KindError) -> str:
    return f" at {misfit.place}" if misfit.place else ""


def _door_of_class(cls: type) -> type:
    own = getattr(cls, "__post_init__", None)

    def __post_init__(self: DataclassInstance) -> None:
        for name, (default, call, fit) in _fits(type(self)).items():
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
def _fits(cls: type[DataclassInstance]) -> dict[str, tuple[object, str, Fit]]:
    """The default of each field, its name in a message, and the function that makes a value fit."""
    hints, given = _hints(cls), [f for f in fields(cls) if f.init]
    return {f.name: (f.default, f"{cls.__name__}({f.name}=...)", fit_of(hints.get(f.name, object))) for f in given}


@functools.cache
def _plan(
    function: Callable[..., object],
) -> tuple[str, inspect.Signature, dict[str, Fit], list[tuple[str, str]], tuple[str, ...] | None]:
    """The name of a function in messages, its signature, the fit of each argument, and the axes that hints declare.

    The last are the names of arguments by place, None where some have no name.
    """
    hints, call = _hints(function), function.__qualname__.rpartition("<locals>.")[2].removesuffix(".__init__")
    signature, axes = inspect.signature(function), []
    fits: dict[str, Fit] = {}
    for name, parameter in signature.parameters.items():
        hint = hints.get(name, object)
        if parameter.kind is parameter.VAR_POSITIONAL:
            hint = tuple[hint, ...]  # type: ignore[valid-type]
        fits[name] = functools.partial(_fit, f"{call}({name}=...)", fit_of(hint))
        if parameter.kind is parameter.VAR_KEYWORD:
            fits[name] = fit_of(object)
        axes += [(name, axis) for axis in _axes(hint)]
    kinds = {parameter.kind for parameter in signature.parameters.values()}
    by_place = (p.name for p in signature.parameters.values() if p.kind is p.POSITIONAL_OR_KEYWORD)
    unnamed = kinds - {inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY}
    return call, signature, fits, axes, None if unnamed else tuple(by_place)


@functools.cache
def _hints(thing: Callable[..., object]) -> dict[str, object]:
    unseen: dict[str, object] = {}
    while True:
        try:
            return get_type_hints(thing, localns=unseen or None, include_extras=True)
        except NameError as error:
            if error.name is None or error.name in unseen:
                raise
            unseen[error.name] = OutOfSight


def _axes(hint: object) -> list[str]:
    """The axis that an `Annotated` hint declares, or the hint's options do."""
    options = get_args(hint) if get_origin(hint) in (Union, types.UnionType) else (hint,)
    return [get_args(option)[1] for option in options if get_origin(option) is Annotated]


def _refuse_misshapen(call: str, owner: object, axes: list[tuple[str, str]], arguments: Mapping[str, object]) -> None:
    """Refuse arguments that have not as many entries as declared: "1", "n", "2n", or all names of a port of the block.

    An axis is named as a `parameter` names it; in one call it has one size, which a block's `dof` or its numbers tell.
    """
    sizes = _sizes(owner)
    for name, axis in sorted(axes, key=lambda declared: declared[1] in PORTS):
        value = arguments.get(name)
        if axis in PORTS:
            if isinstance(value, Mapping):
                _refuse_port(f"{call}({name}=...)", axis, getattr(owner, axis, None), value, sizes)
            continue
        if not isinstance(value, SHAPED_TYPES):
            continue
        times, letter = AXIS.fullmatch(axis).groups()  # type: ignore[union-attr]
        size = int(times or 1) * (sizes.setdefault(letter, value.shape[0]) if letter else 1)
        if value.shape != (size, 1):
            why = f", one number for each of {letter} = {sizes[letter]}" if letter else ""
            raise ValueError(f"`{call}({name}=...)` must have shape ({size}, 1){why}; got {value.shape}.")


def _refuse_port(
    call: str,
    of: str,
    port: _Port | Callable[[int], _Port] | None,
    value: Mapping[str, ca.SX],
    sizes: Mapping[str, int],
) -> None:
    if callable(port):
        port = port(sizes.get("n", 0))
    if port is None:
        return
    for entry in port.entries:
        if entry.name not in value:
            raise LookupError(f"`{call}` must hold {PORTS[of]}, {', '.join(port.names)}; got no '{entry.name}'.")
        want, got = (entry.shape + (1, 1))[:2], ca.SX(value[entry.name]).shape
        if got != want:
            raise ValueError(f"`{call}` must hold '{entry.name}' in shape {want}; got {got}.")


def _sizes(owner: object) -> dict[str, int]:
    """The lengths of the axes that a block's `dof`, or its own numbers, give."""
    sizes: dict[str, int] = {}
    for field in fields(owner) if is_dataclass(owner) else ():
        value, quantity = getattr(owner, field.name), field.metadata.get("quantity")
        if quantity is not None and value is not None:
            sizes |= {axis: value.shape[i] for i, axis in enumerate(quantity.shape) if axis.isalpha()}
    return sizes | ({"n": owner.dof} if hasattr(owner, "dof") else {})
