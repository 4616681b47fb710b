"""Live figures: their plates, places and numbers, as a browser's machine computes them."""

from functools import cache
from pathlib import Path

import numpy as np

from tests.support.node import answered

ROOM = Path(__file__).parents[2] / "workbench" / "report" / "templates" / "live"


NUMBERS = "const numbers = list => Float64Array.from(list, x => x === null ? NaN : x);"


@cache
def scripts():
    return "\n".join((ROOM / f"{name}.js").read_text("utf-8") for name in ("curves", "rulers", "marks", "figures"))


def plain(numbers):
    """An array as JSON holds it, null for NaN."""
    return [None if number != number else number for number in np.asarray(numbers, dtype=float).tolist()]


def said(body, given=None):
    """What a script returns, which finds `given` under this name; no browser is needed for it."""
    return answered(f"{scripts()}\n{NUMBERS}\n{body}", given)


def places_of(x, found):
    """The places in an abscissa, no two of whose numbers are equal, of some of its numbers."""
    places = {number: place for place, number in enumerate(x.tolist())}
    return [places[number] for number in found.tolist()]
