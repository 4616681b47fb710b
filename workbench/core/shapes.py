"""Shapes of a drawing: lines, circles and words whose places are expressions in the time, states and parameters."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import casadi as ca
import numpy as np

from workbench.core.expressions import refuse_misfit
from workbench.core.validation.refusals import Array, describe, one_of, refusal, text
from workbench.core.validation.signatures import check_arguments
from workbench.core.validation.type_hints import fit_of

TONES = ("body", "link", "ground", "liquid", "path")
PAIR = "two numbers or expressions, to the right and upward in m"
AS_EXPRESSION = fit_of(ca.SX)  # CasADi itself crashes on numbers of more than 64 bits
# The direction from which what moves in space is seen: turned about the vertical, and from a little above.
AZIMUTH, ELEVATION = math.radians(20.0), math.radians(18.0)


@dataclass(frozen=True, eq=False, init=False)
@check_arguments
class Line:
    """A line through `points`, (n, 2) in m to the right and upward; one that is `is_closed` is filled.

    The tone is that of a 'body', a 'link', the 'ground', a 'liquid' or a 'path'; the width in m may be an expression in
    the parameters, 0 for the thinnest line. The ground may go on beyond the picture.

    Raises
    ------
    ValueError
        If the points are not two or more pairs of numbers or expressions, the width is none, or the tone is unknown.

    Examples
    --------
    >>> rod = wb.core.Line([(0.0, 0.0), (1.0, 2.0)], width=0.05)
    >>> rod.points.shape, rod.tone
    ((2, 2), 'link')
    """

    points: ca.SX
    tone: str
    width: ca.SX
    is_closed: bool

    @check_arguments
    def __init__(self, points: object, tone: str = "link", width: object = 0.0, is_closed: bool = False) -> None:
        call = "Line(points=...)"
        if isinstance(points, str) or not isinstance(points, Sequence | np.ndarray):
            raise refusal(call, f"two or more points, each {PAIR}", points)
        if len(points) < 2:
            raise ValueError(f"`{call}` must be two or more points; got {len(points)}.")
        rows = [_pair(call, point, f" at [{i}]") for i, point in enumerate(points)]
        places, one = ca.vertcat(*(row.T for row in rows)), _one("Line(width=...)", width)
        _set_fields(self, points=places, tone=tone, width=one, is_closed=is_closed)

    def __post_init__(self) -> None:
        one_of("Line(tone=...)", self.tone, TONES)


@dataclass(frozen=True, eq=False, init=False)
@check_arguments
class Circle:
    """A circle about `centre`, (2,), of a radius, both in m; that of a 'path' is a point that leaves its track.

    Raises
    ------
    ValueError
        If the centre is no pair of numbers or expressions, the radius is none, or the tone is unknown.

    Examples
    --------
    >>> wb.core.Circle((0.0, 1.0), 0.2).centre.shape
    (2, 1)
    """

    centre: ca.SX
    radius: ca.SX
    tone: str

    @check_arguments
    def __init__(self, centre: object, radius: object, tone: str = "body") -> None:
        place, one = _pair("Circle(centre=...)", centre), _one("Circle(radius=...)", radius)
        _set_fields(self, centre=place, radius=one, tone=tone)

    def __post_init__(self) -> None:
        one_of("Circle(tone=...)", self.tone, TONES)


@dataclass(frozen=True, eq=False, init=False)
@check_arguments
class Word:
    """A few letters about `place`, (2,) in m, as the number of a tank.

    Examples
    --------
    >>> wb.core.Word((0.0, 0.1), "T").letters
    'T'
    """

    place: ca.SX
    letters: str

    @check_arguments
    def __init__(self, place: object, letters: str) -> None:
        _set_fields(self, place=_pair("Word(place=...)", place), letters=letters)

    def __post_init__(self) -> None:
        text("Word(letters=...)", self.letters)


Shape: TypeAlias = Line | Circle | Word
SHAPES = "shapes, each a `Line`, a `Circle` or a `Word`, or None where there is no picture"


def _set_fields(shape: Shape, **fields: object) -> None:
    """Give a shape its fields, which its own door then checks."""
    for name, value in fields.items():
        object.__setattr__(shape, name, value)
    shape.__post_init__()


def _pair(call: str, value: object, where: str = "") -> ca.SX:
    """Two numbers or expressions as a column (2, 1)."""
    try:
        given = ca.vertsplit(value) if isinstance(value, ca.SX | ca.DM) else value
        parts = [AS_EXPRESSION(part) for part in given] if isinstance(given, Collection) and len(given) == 2 else []
    except Exception:  # whatever it is that came
        raise refusal(call, f"{PAIR}{where}", value) from None
    if [part.shape for part in parts] != [(1, 1)] * 2:
        raise refusal(call, f"{PAIR}{where}", value)
    return ca.densify(ca.vertcat(*parts))


def _one(call: str, value: object) -> ca.SX:
    """One number or expression."""
    try:
        part = AS_EXPRESSION(value)
    except Exception:  # whatever it is that came
        raise refusal(call, "a number or an expression, in m", value) from None
    if part.shape != (1, 1):
        raise refusal(call, "a number or an expression, in m", value)
    return ca.densify(part)


def project(place: ca.SX) -> ca.SX:
    """A place (3, 1) in space, z upward, as it is seen along y, from somewhat to the side and from above: (2, 1).

    The view is that of parallel rays, so that what is parallel stays so and no length grows.
    """
    right, depth = (
        math.cos(AZIMUTH) * place[0] + math.sin(AZIMUTH) * place[1],
        math.cos(AZIMUTH) * place[1] - math.sin(AZIMUTH) * place[0],
    )
    return ca.vertcat(right, math.cos(ELEVATION) * place[2] + math.sin(ELEVATION) * depth)


@dataclass(frozen=True, eq=False)
@check_arguments
class Drawing:
    """The picture of a plant: its moving coordinates as one column, and its shapes as plain data.

    A shape has a `kind` 'line', 'circle' or 'word', a `tone`, and either `points`, the places of x0, y0, x1, y1, ... in
    the column (of a circle x, y and its radius), or the same numbers under `fixed`. A line has a `width` in m and is
    `closed` or not; a word has `letters`.
    """

    coordinates: ca.SX  # (n, 1), in t, x and p of the equation; in m
    shapes: tuple[Mapping[str, object], ...]

    def __post_init__(self) -> None:
        refuse_misfit("Drawing", "coordinates", self.coordinates, self.coordinates.numel(), 1, "a column")

    @property
    def data(self) -> dict[str, object]:
        """The shapes as JSON takes them; the view is fitted to all that is drawn."""
        return {"view": None, "follow": False, "shapes": [dict(shape) for shape in self.shapes]}


def drawing_of(call: str, shapes: object, p: ca.SX, numbers: Array) -> Drawing | None:
    """The drawing of the shapes that `call` returned, widths taken at the `numbers` of the parameters p; None if none.

    Raises
    ------
    ValueError
        If they are no shapes, or a fixed coordinate or a width is no finite number.
    """
    if shapes is None or (isinstance(shapes, tuple | list) and not shapes):
        return None
    if not isinstance(shapes, tuple | list):
        raise ValueError(f"`{call}` must return {SHAPES}; it returned {describe(shapes)}.")
    for i, shape in enumerate(shapes):
        if not isinstance(shape, Line | Circle | Word):
            raise ValueError(f"`{call}` must return {SHAPES}; it returned {describe(shape)} at [{i}].")
    widths = _widths(call, [shape.width for shape in shapes if isinstance(shape, Line)], p, numbers)
    column: list[ca.SX] = []
    places: dict[int, int] = {}
    plain = []
    for i, shape in enumerate(shapes):
        where, looks = _looks(shape)
        if isinstance(shape, Line):
            looks["width"] = widths.pop(0)
        plain.append(looks | _places_of(f"{call}[{i}]", where, column, places))
    return Drawing(ca.vertcat(*column) if column else ca.SX(0, 1), tuple(plain))


def _widths(call: str, widths: list[ca.SX], p: ca.SX, numbers: Array) -> list[float]:
    """The widths of lines in m, at the numbers of the parameters p."""
    try:
        values = np.array(ca.Function("widths", [p], [ca.vertcat(*widths)])(numbers)).ravel().tolist()
    except RuntimeError:  # of CasADi, for a symbol without a value
        raise ValueError(f"`{call}` must return widths of parameters alone; got {describe(widths)}.") from None
    for width in values:
        if not (math.isfinite(width) and width >= 0):
            raise ValueError(f"`{call}` must return widths that are finite and not negative; got {width:g} m.")
    return list(values)


def _looks(shape: Shape) -> tuple[ca.SX, dict[str, object]]:
    """The coordinates of a shape in a row, and its kind, tone and letters."""
    if isinstance(shape, Word):
        return shape.place, {"kind": "word", "tone": "body", "letters": shape.letters}
    if isinstance(shape, Circle):
        return ca.vertcat(shape.centre, shape.radius), {"kind": "circle", "tone": shape.tone}
    return ca.vec(shape.points.T), {"kind": "line", "tone": shape.tone, "closed": shape.is_closed}


def _places_of(call: str, where: ca.SX, column: list[ca.SX], places: dict[int, int]) -> dict[str, object]:
    """The coordinates as numbers where none of them moves, else as places in the column, each expression once."""
    if where.is_constant():
        fixed = np.array(ca.DM(where)).ravel()
        if not np.isfinite(fixed).all():
            raise ValueError(f"`{call}` must have finite coordinates; got {describe(fixed)}.")
        return {"fixed": fixed.tolist()}
    points = []
    for part in ca.vertsplit(where):
        key = part.element_hash()
        if key not in places:
            places[key] = len(column)
            column.append(part)
        points.append(places[key])
    return {"points": points}
