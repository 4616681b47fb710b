"""Refusals of the marks and the panels of a figure."""

from __future__ import annotations

from itertools import pairwise

from workbench.core.validation.refusals import describe, refusal

NARROWEST = 0.4  # share of the text's width


def check_sources(mark: object, count: int, sources: tuple[object, ...]) -> None:
    """Refuse sources that are not one for each of `count` bars or points."""
    if sources and len(sources) != count:
        label = describe(getattr(mark, "label", ""))
        raise ValueError(
            f"`{type(mark).__name__}({label}, sources=...)` must have a source, or None, for each of {count} marks, or "
            f"be left out; got {len(sources)}."
        )


def check_cut(cut: float | None, limits: tuple[float, float] | None, scale: str) -> None:
    """Refuse a cut of an abscissa that is logarithmic, has no limits, or has others."""
    if cut is None:
        return
    low, high = limits or (cut, cut)
    if not low < cut < high or scale != "linear":
        raise refusal("Panel(xcut=...)", "a number between the two of `xlim`, on a linear axis", cut)


def check_steps(across: tuple[float, ...], up: tuple[float, ...]) -> None:
    """Refuse steps of the numbers at an axis that do not rise from above zero."""
    for name, steps in (("xsteps", across), ("ysteps", up)):
        if any(not low < high < float("inf") for low, high in pairwise((0.0, *steps))):
            raise refusal(f"Panel({name}=...)", "positive numbers in rising order", steps)


def check_aspect(equal: bool, scales: tuple[str, str], cut: float | None) -> None:
    """Refuse axes of one scale that are logarithmic or cut."""
    if equal and (scales != ("linear", "linear") or cut is not None):
        raise refusal("Panel(aspect='equal')", "on two linear axes without `xcut`", scales)


def check_width(name: str, width: float) -> None:
    """Refuse the width of a figure, a share of the text's, in which letters have no room, or that no page has."""
    if not NARROWEST <= width <= 1:
        raise ValueError(
            f"`Figure('{name}', width=...)` must be a share of the text's width from {NARROWEST:g}, where letters "
            f"still have room, to 1; got {describe(width)}."
        )
