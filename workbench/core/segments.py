"""Segments: the parts of a step from switch to switch, and from corner to corner."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from workbench.core.state_corners import Corners
from workbench.core.switches import NEAR, Switches
from workbench.core.validation.refusals import Array


@dataclass(frozen=True, eq=False)
class Segments:
    """The parts of a step from switch to switch, each a Runge-Kutta step of the first n states.

    A segment begins at the offset s [s] from t_k and ends at `end`; the first begins at 0 with the states `start`, the
    last ends at `length`.
    """

    s: ca.SX  # symbol of the offset, (1, 1)
    start: ca.SX  # (n, 1), in h, k, t, x, p and w
    rate: ca.SX  # (n, 1), in t, m, x and p; m is the middle of the segment
    end: ca.SX  # in s, (1, 1), in h, k, s, x and p; x is the state at s
    length: ca.SX  # of the step in s, (1, 1), in h
    first: ca.SX  # the offset of the first switch, or the length, (1, 1), in h, k, t, x, p and w
    switches: Switches
    e: ca.SX | None = None  # symbol of the states at the end of the step without its segments; None without corners

    @staticmethod
    def of(
        switches: Switches,
        begin: ca.SX,
        length: ca.SX,
        x: ca.SX,
        start: ca.SX,
        substeps: int = 1,
        corners: Corners | None = None,
    ) -> Segments:
        """The segments of a step from `begin` on, which end at its switches and at its substeps."""
        s = ca.SX.sym("s")
        at = switches.after(begin, s, length)
        first = ca.substitute(at, ca.vertcat(s, x), ca.vertcat(0, start))
        if substeps > 1:
            near, h = NEAR * (begin + length), length / substeps
            grid = (ca.floor((s + near) / h) + 1) * h
            at = ca.if_else(grid < at - near, grid, at)
        if corners is None:
            return Segments(s, start, switches.rate, at, length, first, switches)
        e, at = ca.SX.sym("e", x.numel()), ca.fmin(at, corners.next(begin, s, length))
        first = ca.if_else(corners.lies_between(begin, start, length, e), 0, first)
        return Segments(s, start, switches.rate, at, length, first, switches, e)

    def can_occur(self, p: Array) -> bool:
        """True if a run with one of the rows p (B, np) may have a segment that ends within a step."""
        return self.e is not None or self.switches.can_occur(p)

    @property
    def parts(self) -> list[ca.SX]:
        """All that a kernel makes of them, as `graph.stepped` reads it."""
        return [ca.densify(part) for part in (self.first, self.length, self.end, self.start, self.rate)]
