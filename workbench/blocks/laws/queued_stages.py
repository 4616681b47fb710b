"""A period of a plant with its last inputs as states: those on their way, or those before a limited change."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from workbench.blocks.laws.plant_stages import PlantStages, limited_rows


@dataclass(frozen=True)
class QueuedStages:
    """The states (x, q) of a plant and of its last inputs q, oldest first, over a period:

        x+ = F(t, x, v),   q+ = (q_2, ..., q_n, u),   v = q_1 with a delay, else u.

    Parameters
    ----------
    plant
        The plant over a period.
    nx, nq
        The numbers of states of the plant, and of entries of q, nu for each input.
    is_late
        True if the oldest input acts.
    """

    plant: PlantStages
    nx: int
    nq: int
    is_late: bool

    @property
    def period(self) -> float:
        """The period in s."""
        return self.plant.period

    def after(self, t: ca.SX, x: ca.SX, u: ca.SX) -> ca.SX:
        """The states (nx + nq, 1) after a period."""
        if not self.nq:
            return self.plant.after(t, x, u)
        return ca.vertcat(self.plant.after(t, x[: self.nx], self._acting(x, u)), self._queue(x, u))

    def after_with_slopes(self, t: ca.SX, x: ca.SX, u: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
        """The states after a period with their Jacobians by x and u, (nx + nq, nx + nq) and (nx + nq, nu)."""
        if not self.nq:
            return self.plant.after_with_slopes(t, x, u)
        (nx, nq), nu, zeros = (self.nx, self.nq), u.numel(), ca.SX.zeros
        after, A, B = self.plant.after_with_slopes(t, x[:nx], self._acting(x, u))
        by_queue = ca.horzcat(B, zeros(nx, nq - nu)) if self.is_late else zeros(nx, nq)
        shift = ca.vertcat(ca.horzcat(zeros(nq - nu, nu), ca.SX.eye(nq - nu)), zeros(nu, nq))
        wide = ca.vertcat(ca.horzcat(A, by_queue), ca.horzcat(zeros(nq, nx), shift))
        tall = ca.vertcat(zeros(nx, nu) if self.is_late else B, zeros(nq - nu, nu), ca.SX.eye(nu))
        return ca.vertcat(after, self._queue(x, u)), ca.densify(wide), ca.densify(tall)

    def rows(self, names: tuple[str, ...], t: ca.SX, x: ca.SX) -> ca.SX:
        """The states and outputs with some labels at a time and states (nx + nq, 1), (nr, 1)."""
        return limited_rows(self.plant.model, names, t, x[: self.nx])

    def _acting(self, x: ca.SX, u: ca.SX) -> ca.SX:
        return x[self.nx : self.nx + u.numel()] if self.is_late else u

    def _queue(self, x: ca.SX, u: ca.SX) -> ca.SX:
        return ca.vertcat(x[self.nx + u.numel() :], u)
