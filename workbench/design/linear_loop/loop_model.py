"""The matrices of a linear loop, of one or of many rows, over one period or over several that are lifted."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.frequency import row_responses
from workbench.design.frequency.response_kernel import FrequencyAnswers
from workbench.design.linear.loop_cuts import closure
from workbench.design.matrices import EPS, Complex

if TYPE_CHECKING:
    import control


@dataclass(frozen=True, eq=False)
class LoopModel:
    """A (N, n, n), B (N, n, q nu), Cy (N, q ny, n) and D (N, q ny, q nu) of N rows, with the names of their signals.

    In continuous time the `period` is None and q is 1. In a computer q is the `count` of periods after which its blocks
    run alike again; the inputs and outputs of the q instants follow one another.
    """

    A: Array
    B: Array
    Cy: Array
    D: Array
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    period: float | None = None
    count: int = 1

    def part(self, outputs: Sequence[int], inputs: Sequence[int]) -> LoopModel:
        """The same model with some outputs and inputs alone, by their places."""
        rows = [k * len(self.outputs) + i for k in range(self.count) for i in outputs]
        columns = [k * len(self.inputs) + i for k in range(self.count) for i in inputs]
        return replace(
            self,
            B=self.B[:, :, columns],
            Cy=self.Cy[:, rows],
            D=self.D[:, rows][:, :, columns],
            inputs=tuple(self.inputs[i] for i in inputs),
            outputs=tuple(self.outputs[i] for i in outputs),
        )

    def negative(self) -> LoopModel:
        """The model with the sign of its outputs turned."""
        return replace(self, Cy=-self.Cy, D=-self.D)

    def row(self, i: int) -> LoopModel:
        """The model of one row."""
        return replace(self, A=self.A[[i]], B=self.B[[i]], Cy=self.Cy[[i]], D=self.D[[i]])

    def closed_at(self, places: Sequence[int]) -> LoopModel:
        """The model whose inputs at some places are its outputs at the same places, which are well-posed as such."""
        if not places:
            return self
        rest = [i for i in range(len(self.inputs)) if i not in places]
        own = self.part(places, places)
        from_rest, to_all = self.part(places, rest), self.part(range(len(self.outputs)), places)
        E = np.linalg.inv(np.eye(own.D.shape[-1]) - own.D)
        kept = self.part(range(len(self.outputs)), rest)
        return replace(
            kept,
            A=self.A + own.B @ E @ own.Cy,
            B=kept.B + own.B @ E @ from_rest.D,
            Cy=self.Cy + to_all.D @ E @ own.Cy,
            D=kept.D + to_all.D @ E @ from_rest.D,
        )

    def reduce(self) -> LoopModel:
        """The model of a computer without the states that nothing reads, as what is computed anew each period."""
        if self.period is None:
            return self
        read = np.any([(np.nan_to_num(M) != 0).any(axis=(0, 1)) for M in (self.A, self.Cy)], axis=0)
        keep = np.flatnonzero(read)
        return replace(
            self,
            A=self.A[:, keep][:, :, keep],
            B=self.B[:, keep],
            Cy=self.Cy[:, :, keep],
            states=tuple(self.states[i] for i in keep),
        )

    def response(self, omega: Array) -> Complex:
        """The values of `answers`."""
        return self.answers(omega).values

    def answers(self, omega: Array) -> FrequencyAnswers:
        """The answers (N, m, ny, nu) at frequencies (m,) in rad/s; NaN at a pole and in rows that are not finite.

        Over lifted periods it is the part at the frequency itself of the answer to a signal of that frequency.
        """
        if self.count == 1 or self.period is None:
            return self._answers(omega, self.period)
        q, turn = self.count, omega * self.period
        folded = (turn * q + math.pi) % (2 * math.pi) - math.pi
        order = np.argsort(np.abs(folded), kind="stable")
        length = q * self.period
        ahead = self._answers(np.minimum(np.abs(folded)[order] / length, math.pi / length), length)
        waves = np.exp(1j * np.multiply.outer(turn, np.arange(q)))  # (m, q)

        def blocks(part: Array | Complex) -> Complex:
            own = np.empty_like(part)
            own[:, order] = part
            own = np.where((folded < 0)[:, np.newaxis, np.newaxis], own.conj(), own)
            return np.asarray(own.reshape(*own.shape[:2], q, len(self.outputs), q, len(self.inputs)))

        values = np.asarray(np.einsum("mi,Nmiykv,mk->Nmyv", waves.conj(), blocks(ahead.values), waves) / q)
        sizes = (
            np.abs(blocks(part)).sum(axis=(2, 4)) / q for part in (ahead.values, ahead.errors, ahead.sensitivities)
        )
        terms, errors, sensitivities = sizes
        return FrequencyAnswers(values, errors + 4 * (q + 2) * EPS * terms, sensitivities)

    def _answers(self, omega: Array, period: float | None) -> FrequencyAnswers:
        """C (z I - A)^-1 B + D, by the states alone that lie between an input and the outputs."""
        steps = (np.nan_to_num(self.A) != 0).any(axis=0)
        reach = closure(steps | np.eye(len(steps), dtype=bool))  # reach[i, j]: j reaches i
        seen = reach[(np.nan_to_num(self.Cy) != 0).any(axis=(0, 1))].any(axis=0)
        groups = dict[tuple[int, ...], list[int]]()  # inputs by the states between
        for j in range(self.B.shape[-1]):
            moved = reach[:, (np.nan_to_num(self.B[:, :, j]) != 0).any(axis=0)].any(axis=1)
            groups.setdefault(tuple(np.flatnonzero(moved & seen).tolist()), []).append(j)
        shape = (len(self.A), len(omega), self.D.shape[1], self.D.shape[2])
        made = FrequencyAnswers(np.empty(shape, complex), np.empty(shape), np.empty(shape))  # of no inputs, it stays so
        for states, inputs in groups.items():
            keep = list(states)
            matrices = (self.A[:, keep][:, :, keep], self.B[:, keep][:, :, inputs], self.Cy[:, :, keep])
            found = row_responses(*matrices, self.D[:, :, inputs], omega, period)
            if len(groups) == 1:
                return FrequencyAnswers(found.values, found.errors, found.sensitivities)
            made.values[..., inputs], made.errors[..., inputs] = found.values, found.errors
            made.sensitivities[..., inputs] = found.sensitivities
        return made

    def system(self, name: str = "loop") -> control.StateSpace:
        """The one row as a `StateSpace` of python-control; of lifted periods with a name for each instant."""
        import control

        dt = 0 if self.period is None else self.period * self.count
        names = {"inputs": self._lifted_labels(self.inputs), "outputs": self._lifted_labels(self.outputs)}
        matrices = (self.A[0], self.B[0], self.Cy[0], self.D[0])
        return control.ss(*matrices, dt, name=name, states=list(self.states), remove_useless_states=False, **names)

    def _lifted_labels(self, labels: tuple[str, ...]) -> list[str]:
        if self.count == 1:
            return list(labels)
        return [f"{label} at instant {k}" for k in range(self.count) for label in labels]


def lift_maps(maps: Sequence[tuple[Array, Array, Array, Array]]) -> tuple[Array, Array, Array, Array]:
    """The matrices over several periods, each (N, ...), from those of each period in turn."""
    if len(maps) == 1:
        return maps[0]
    N, n = maps[0][0].shape[:2]
    nu, ny, q = maps[0][1].shape[-1], maps[0][2].shape[-2], len(maps)
    reach = np.zeros((N, n, n + q * nu))  # the state at an instant by the first state and all inputs
    reach[:, :, :n] = np.eye(n)
    rows = []
    for k, (A, B, Cy, D) in enumerate(maps):
        own = slice(n + k * nu, n + (k + 1) * nu)
        seen = Cy @ reach
        seen[:, :, own] += D
        rows.append(seen)
        reach = A @ reach
        reach[:, :, own] += B
    outputs = np.concatenate(rows, axis=1)
    assert outputs.shape[1] == q * ny
    return reach[:, :, :n], reach[:, :, n:], outputs[:, :, :n], outputs[:, :, n:]
