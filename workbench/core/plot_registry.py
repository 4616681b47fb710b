"""The functions that draw objects, by class: `report` enters them here, and the `.plot()` of an object asks for one."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module

from workbench.core.validation.refusals import refusal

PLOTTERS: dict[type, Callable[..., object]] = {}


def draw(subject: object, *args: object, **options: object) -> object:
    """The picture of an object, or of several of one class by their names.

    Raises
    ------
    ValueError
        If nothing draws objects of this class.
    """
    if isinstance(subject, Mapping) and not subject:
        raise ValueError("`plot(thing)` must be an object, or a mapping from names to some; got an empty mapping.")
    first = next(iter(subject.values())) if isinstance(subject, Mapping) else subject
    if type(first) not in PLOTTERS:
        _ = import_module("workbench").plot  # the face is above all floors; it loads the room that enters its functions
    if type(first) not in PLOTTERS:
        kinds = ", ".join(sorted(f"`{kind.__name__}`" for kind in PLOTTERS))
        must = f"an object that has a picture ({kinds}), or a mapping from names to some"
        raise refusal("plot(thing)", must, subject)
    return PLOTTERS[type(first)](subject, *args, **options)
