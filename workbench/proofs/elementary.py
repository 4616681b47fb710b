"""Enclosures of elementary functions at doubles: the one thing that IEEE arithmetic does not promise.

Sums, products, quotients and square roots of doubles are rounded rightly by the standard (IEEE 754), so
one step outward encloses them. Sines, exponentials and their kin are the library's word. Where Arb is
installed (extra `rigorous`) they are proved enclosures; elsewhere NumPy's values are widened by
`DOUBT` units in the last place, which is what NumPy states of its own functions.

References
----------
Johansson (2017), Arb: efficient arbitrary-precision midpoint-radius interval arithmetic, IEEE Trans. Computers 66.
"""

from __future__ import annotations

from importlib.util import find_spec

import numpy as np

from workbench.validation.refusals import Array

ARB = find_spec("flint") is not None  # the extra `rigorous`
if ARB:
    import flint

DOUBT = 4
# Rising functions, and the largest and least values of any: no enclosure need be wider.
RANGES = {
    "sin": (-1.0, 1.0),
    "cos": (-1.0, 1.0),
    "tanh": (-1.0, 1.0),
    "exp": (0.0, np.inf),
    "cosh": (1.0, np.inf),
    "log": (-np.inf, np.inf),
    "sinh": (-np.inf, np.inf),
    "atan": (-2.0, 2.0),
    "asin": (-2.0, 2.0),
    "acos": (0.0, 4.0),
}
NUMPY = {"atan": np.arctan, "asin": np.arcsin, "acos": np.arccos} | {
    name: getattr(np, name) for name in ("sin", "cos", "tanh", "exp", "cosh", "log", "sinh")
}


def guarantee() -> str:
    """On what the enclosures rest, in a few words."""
    return "ball arithmetic" if ARB else f"elementary functions taken as right within {DOUBT} last places"


def at_points(name: str, x: Array) -> tuple[Array, Array]:
    """Bounds (N,), (N,) from below and above of the function at doubles x (N,); not a number where it has no value."""
    x = np.asarray(x, dtype=float)
    if ARB:
        low, high = _balls(name, x)
    else:
        y = NUMPY[name](x)
        low, high = y - DOUBT * np.spacing(np.abs(y)), y + DOUBT * np.spacing(np.abs(y))
    least, greatest = RANGES[name]
    return np.maximum(low, least), np.minimum(high, greatest)


def _balls(name: str, x: Array) -> tuple[Array, Array]:
    """Arb's midpoint and radius, one step outward: of 53 bits and of 30, both are doubles."""
    function, ball = getattr(flint.arb, name), flint.arb
    balls = [function(ball(value)) for value in x.ravel().tolist()]
    middle = np.array([float(ball.mid()) for ball in balls]).reshape(x.shape)
    radius = np.array([float(ball.rad()) for ball in balls]).reshape(x.shape)
    return np.nextafter(middle - radius, -np.inf), np.nextafter(middle + radius, np.inf)
