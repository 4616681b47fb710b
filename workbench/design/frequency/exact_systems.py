"""Systems that are small enough for exact arithmetic, and the sentence that says why one is not stable."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.frequency.half_planes import is_hurwitz
from workbench.design.frequency.integer_polynomials import bilinear, stretch
from workbench.design.frequency.proved_norm import proved_stability
from workbench.design.frequency.rational_matrices import integer_characteristic_polynomial, whole
from workbench.design.linear.operating_point import state_space
from workbench.design.matrices import DesignError, pole_text

if TYPE_CHECKING:
    import control

MOST_STATES = 40  # some ten seconds; the time grows with the fifth power
FEW_STATES = 10  # up to which exact arithmetic is faster than a proof in floating point
MOST_MINORS = 2000  # six inputs by six outputs have 923


def exact_state_space(call: str, system: control.StateSpace) -> tuple[Array, Array, Array, Array]:
    """A, B, C and D of a `StateSpace` with at most 40 states, all finite."""
    A, B, C, D = state_space(call, system)
    refuse_many_states(call, system, len(A))
    return A, B, C, D


def refuse_many_states(call: str, system: control.StateSpace, states: int) -> None:
    """Refuse a system with more states than exact arithmetic can take."""
    if states > MOST_STATES:
        raise DesignError(
            f"`{call}(system)` works in exact arithmetic, which takes seconds for {MOST_STATES} states and minutes for "
            f"more; '{system.name}' has {states}. Reduce its order first: `wb.reduction` takes up to 60 states, "
            "`control.balred` with Slycot more."
        )


def count_minors(ny: int, nu: int) -> int:
    """The number of minors of a transfer matrix (ny, nu)."""
    return sum(math.comb(ny, k) * math.comb(nu, k) for k in range(1, min(ny, nu) + 1))


def refuse_many_channels(call: str, ny: int, nu: int) -> None:
    """Refuse a transfer matrix (ny, nu) with more minors than can be expanded."""
    minors = count_minors(ny, nu)
    if minors > MOST_MINORS:
        raise DesignError(
            f"`{call}(system)` expands every minor of the transfer matrix, at most {MOST_MINORS} of them; {ny} outputs "
            f"by {nu} inputs have {minors}. Take fewer channels at a time."
        )


def is_stable(A: Array, discrete: bool) -> bool:
    """True if each eigenvalue of A lies inside the region of stability: proved, or decided in exact arithmetic."""
    proved = proved_stability(A, discrete) if len(A) > FEW_STATES else None
    if proved is not None:
        return proved
    numbers, rate = whole(A)
    p = stretch(integer_characteristic_polynomial(numbers), rate)
    return is_hurwitz(bilinear(p) if discrete else p)


def not_stable(A: Array, discrete: bool) -> str:
    """The sentence that names the pole which is nearest to instability, or beyond."""
    poles = np.linalg.eigvals(A)
    worst = complex(poles[(np.abs(poles) if discrete else poles.real).argmax()])
    region = "inside the unit circle" if discrete else "left of the imaginary axis"
    return f"the system is not stable: its pole near {pole_text(worst)} does not lie {region}"
