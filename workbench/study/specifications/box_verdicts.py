"""Verdicts over a box: the worst draws of a search, with proved bounds, and proofs of what they leave open."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from workbench.design.linear_loop import LinearLoop
from workbench.design.linear_loop.loop_equations import flow_of
from workbench.design.loop_boxes import (
    BoxProof,
    DampingAbove,
    DecayAbove,
    GainBelow,
    LoopFamily,
    ParameterBox,
    prove_over_box,
)
from workbench.design.loop_boxes.quadratic_conditions import AbstractCondition
from workbench.proofs.bounds import by_intervals
from workbench.proofs.interval import NoBound
from workbench.study.specifications.box_search import BoxSearch, at_draw, search_box
from workbench.study.specifications.limit_verdicts import LimitVerdict, VerdictKind, figure_clause
from workbench.study.specifications.limits import FigureLimit
from workbench.study.specifications.loop_systems import LoopSystems, noise_signals
from workbench.study.specifications.point_figures import LoopFigure, point_figure

PROVABLE = ("Ms", "Mt", "disk_margin", "noise_gain", "damping", "decay")
SEARCH_EVIDENCE = "No proof over a box is known of this figure."
SAME, LOOKED_AT = 1e-6, np.array([0.3, 1.0, 3.0])  # of T, by its two ways, at multiples of the fastest frequency


@dataclass(frozen=True, eq=False)
class BoxCheck:
    """The check of limits over a box of parameters of a linear loop, by so many draws and at most so many parts."""

    systems: LoopSystems
    box: ParameterBox
    limits: Sequence[FigureLimit]
    draws: int
    seed: int
    parts: int

    @property
    def linear(self) -> LinearLoop:
        """The loop at its nominal point."""
        loop = self.systems.loop
        assert isinstance(loop, LinearLoop)
        return loop

    @cached_property
    def search(self) -> BoxSearch:
        """The draws."""
        return search_box(self.linear, self.box, self.limits, self.systems.answer, self.draws, self.seed)

    def verdicts(self) -> tuple[LimitVerdict, ...]:
        """The verdict on each limit."""
        return tuple(replace(self._verdict(limit), arguments=self.linear.point.arguments) for limit in self.limits)

    def _verdict(self, limit: FigureLimit) -> LimitVerdict:
        place = self.search.worst[limit.kind.name]
        values, loop = self._draw(place)
        worst, count = LoopSystems(loop, self.systems.answer), len(self.search)
        if not worst.stable:
            why = f"There the loop is not stable: {worst.unstable_words}"
            return LimitVerdict(limit, "refuted", LoopFigure(None, why=why), why, values, count)
        figure = point_figure(limit.kind.name, worst)
        if figure.value is None:
            reason = f"At the worst of {count:,} draws there is no figure: {figure.why}"
            return LimitVerdict(limit, "not checkable", figure, reason, values, count)
        judged = limit.judge(figure.value)
        seen = f"At the worst of {count:,} draws {figure_clause(limit.kind, figure)}"
        if judged != "holds":
            kind: VerdictKind = "refuted" if judged == "fails" else "undecided"
            return LimitVerdict(limit, kind, figure, f"{seen}. {self._lost}".strip(), values, count)
        proof = self._proof(limit)
        if proof.is_proved:
            evidence = f"{seen}. Proved{by_intervals(proof.boxes).removeprefix(',')}."
            return LimitVerdict(limit, "proved", figure, evidence, values, count)
        why = f"Not proved: {proof.why}." if limit.kind.name in PROVABLE else SEARCH_EVIDENCE
        return LimitVerdict(limit, "not refuted", figure, f"{seen}. {why} {self._lost}".strip(), values, count)

    @property
    def _lost(self) -> str:
        """The sentence on draws that have no answer."""
        search = self.search
        return f"{search.lost_draws} draws have no answer: {search.reason}" if search.lost_draws else ""

    def _draw(self, place: int) -> tuple[Mapping[str, float], LinearLoop]:
        """A draw as values that `linear_loop` takes, those included in which the loop is not at its defaults."""
        loop, given = at_draw(self.linear, self.search, place), self.linear.parameters
        kept = {self.linear.states.labels[i]: float(self.linear.x0[i]) for i in self.linear.point.kept_states}
        own = {n: float(v) for n, v, d in zip(given.labels, self.linear.p0, given.default, strict=True) if v != d}
        return kept | own | self.box.values(self.search.theta[place]), loop

    def _proof(self, limit: FigureLimit) -> BoxProof:
        if limit.kind.name not in PROVABLE:
            return BoxProof(False, 0, SEARCH_EVIDENCE)
        if self.search.lost_draws:
            return BoxProof(False, 0, "some draws have no answer")
        try:
            family, condition = self._family, self._condition(limit)
            return prove_over_box(family, condition, self.box, (self.search.theta, self.search.x), self.parts)
        except NoBound as none:
            return BoxProof(False, 0, str(none).rstrip("."))

    @cached_property
    def _family(self) -> LoopFamily:
        """The matrices of the closed loop, from what is added at the cut and to readings, to what is cut and drives.

        Raises
        ------
        NoBound
            If there are none that a proof can enclose, or their T is not the one of the cut.
        """
        added, cut = self._cut
        noises, drives = noise_signals(self.linear)
        noisy = any(limit.kind.name == "noise_gain" for limit in self.limits)
        inputs = dict.fromkeys((*added, *(noises if noisy else ())))
        outputs = dict.fromkeys((*cut, *(drives if noisy else ())))
        family = LoopFamily.of(self.linear, self.box.labels, tuple(inputs), tuple(outputs))
        omega = np.sort(LOOKED_AT * max((pole.frequency for pole in self.linear.poles), default=1.0))
        T = self.linear.response(omega, "T").values
        seen = -self.linear.response(omega, "closed", added, cut).values
        if not (np.abs(T - seen) <= SAME * (1 + np.abs(T))).all():
            raise NoBound("the loop is cut where no signal that is added from outside acts")
        return family

    @property
    def _cut(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """The signals that are added at the channels of the cut, and those that are cut."""
        flow = flow_of(self.linear.point.equations.closed_loop)
        added = []
        for channel in self.linear.channels:
            name, bracket, rest = channel.partition("[")
            kind = "load" if name in flow.drives else "noise"
            added.append(f"{name}_{kind}{bracket}{rest}")
        kinds = {name.partition("[")[0].rpartition("_")[2] for name in added}
        if len(kinds) != 1 or not set(added) <= set(self.linear.inputs):
            raise NoBound("the loop is cut at inputs and at outputs of its plant at once, or nowhere")
        return tuple(added), self.linear.channels

    def _condition(self, limit: FigureLimit) -> AbstractCondition:
        name = limit.kind.name
        if name == "damping":
            return DampingAbove(limit.low)
        if name == "decay":
            return DecayAbove(limit.low)
        if name == "noise_gain":
            return GainBelow(limit.high, *noise_signals(self.linear))
        if name == "disk_margin":
            return GainBelow(math.nextafter(1 / limit.low, 0.0), *self._cut, 0.5)
        return GainBelow(limit.high, *self._cut, 1.0 if name == "Ms" else 0.0)
