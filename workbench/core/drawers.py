"""The functions that draw objects, by class: `report` enters them here, and the `.plot()` of an object asks for one."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module

from workbench.core.validation.refusals import refusal

DRAWERS: dict[type, Callable[..., object]] = {}


def draw(thing: object, *args: object, **options: object) -> object:
    """The picture of an object, or of several of one class by their names.

    Raises
    ------
    ValueError
        If nothing draws objects of this class.
    """
    if isinstance(thing, Mapping) and not thing:
        raise ValueError("`plot(thing)` must be an object, or a mapping from names to some; got an empty mapping.")
    first = next(iter(thing.values())) if isinstance(thing, Mapping) else thing
    if type(first) not in DRAWERS:
        _ = import_module("workbench").plot  # the face is above all floors; it loads the room that enters its functions
    if type(first) not in DRAWERS:
        kinds = ", ".join(sorted(f"`{kind.__name__}`" for kind in DRAWERS))
        must = f"an object that has a picture ({kinds}), or a mapping from names to some"
        raise refusal("plot(thing)", must, thing)
    return DRAWERS[type(first)](thing, *args, **options)
