"""Multiple shooting: a log in segments, each from initial states of its own, which a search lets grow together.

A run over a whole log can depend so strongly on its parameters that a search from afar ends in a false minimum.
Segments follow their samples from the start, and the gaps between them are closed from round to round (Bock 1983).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import pairwise

import numpy as np

from workbench.core.validation.refusals import Array, Integers
from workbench.identification.datasets import Dataset
from workbench.identification.datasets.dataset import Marks
from workbench.identification.estimation.least_squares import least_squares
from workbench.identification.estimation.output_model import OutputModel
from workbench.identification.estimation.unknown_numbers import UnknownNumber
from workbench.identification.estimation.weighed_data import WeighedData, finite_or_infinite

GAP_WEIGHTS = (1.0, 10.0, 100.0, 1e3)  # of the gaps, in units of the spread of each state, from round to round
SEGMENTS = 12  # of an experiment
LEAST_ROWS = 4  # of a segment
ROUGH, ROUNDS = 1e-4, 12  # tolerance and number of the runs of a round, as a search over whole runs follows


@dataclass(frozen=True, eq=False)
class Segments:
    """The samples of a fit in segments: a model each of whose experiments is a segment of one of the data's."""

    data: WeighedData
    sigma: Array  # (ny,), by which errors are divided

    @cached_property
    def cuts(self) -> list[Integers]:
        """The first rows of the segments of each experiment, and its last row."""
        lengths = [len(experiment) for experiment in self.data.model.dataset]
        counts = [max(1, min(SEGMENTS, (rows - 1) // LEAST_ROWS)) for rows in lengths]
        return [np.round(np.linspace(0, n - 1, c + 1)).astype(int) for n, c in zip(lengths, counts, strict=True)]

    def pieces(self) -> Iterator[tuple[int, int, int, int]]:
        """Experiment, place in it, first row and last row of each segment."""
        for e, cuts in enumerate(self.cuts):
            for i, (first, last) in enumerate(pairwise(cuts)):
                yield e, i, int(first), int(last)

    @cached_property
    def model(self) -> OutputModel:
        """The model whose outputs are those that are measured, and behind them all states."""
        model, experiments, numbers, x0, begins, h = self.data.model, [], [], [], [], []
        for e, i, first, last in self.pieces():
            own = model.dataset.experiments[e]
            name = f"{own.name}, segment {i}"
            experiments.append(replace(own.rows(first, last + 1), name=name))
            x0.append(self._states(e, i, first))
            begins.append(model.begins[e] + float(own.t[first] - own.t[0]))
            h.append(model.h[e])
            numbers += self._initial_numbers(own.name, name, i, x0[-1])
        shared = [number for number in model.numbers if number.kind != "initial state"]
        outputs = (*model.outputs, *((f"state {label}", label) for label in model.ode.states.labels))
        return replace(
            model,
            dataset=Dataset(tuple(experiments)),
            outputs=outputs,
            numbers=(*shared, *numbers),
            x0=np.array(x0),
            h=tuple(h),
            begins=tuple(begins),
        )

    def _states(self, e: int, i: int, row: int) -> Array:
        """The states at the begin of a segment: where a state is measured the sample, else as the run begins."""
        model = self.data.model
        states: Array = model.x0[e].copy()
        for column, (_, label) in enumerate(model.outputs if i else ()):
            sample = self.data.samples[e][row, column]
            if label in model.ode.states.labels and np.isfinite(sample):
                states[model.ode.states.labels.index(label)] = sample
        return states

    def _initial_numbers(self, experiment: str, name: str, i: int, states: Array) -> list[UnknownNumber]:
        model = self.data.model
        if i == 0:
            own = [one for one in model.numbers if one.kind == "initial state" and one.experiment == experiment]
            return [replace(one, experiment=name, name=f"{one.label}(0) of {name}") for one in own]
        labels = model.ode.states.labels
        inf = np.inf
        return [
            UnknownNumber(f"{label}(0) of {name}", "initial state", label, name, float(value), -inf, inf, "")
            for label, value in zip(labels, states, strict=True)
        ]

    @cached_property
    def masks(self) -> list[Marks]:
        """The samples (N, ny) of each segment that count; one between two segments counts once."""
        masks = []
        for e, i, first, last in self.pieces():
            mask = self.data.weighs[e][first : last + 1].copy()
            mask[-1] &= i == len(self.cuts[e]) - 2
            masks.append(mask)
        return masks

    @cached_property
    def joints(self) -> list[tuple[int, Integers]]:
        """Each segment that another follows, and the places in z of the states at which that one begins."""
        joints, names = [], self.model.dataset.names
        numbers = self.model.numbers
        for place, (_, i, _, _) in enumerate(self.pieces()):
            if i:
                own = [k for k, one in enumerate(numbers) if one.experiment == names[place]]
                joints.append((place - 1, np.array(own)))
        return joints

    def linearized(self, z: Array, weights: Array) -> tuple[Array, Array]:
        """Errors and gaps (M,), the gaps times `weights` (nx,), and their derivatives (M, nz)."""
        residuals, slopes, ends = [], [], {}
        ny = len(self.data.model.outputs)
        for place, (e, _, first, last) in enumerate(self.pieces()):
            y, J = self.model.derivatives(z, place)
            error, mask = y[:, :ny] - self.data.samples[e][first : last + 1], self.masks[place]
            residuals.append((error / self.sigma)[mask])
            slopes.append((J[:, :ny] / self.sigma[:, np.newaxis])[mask])
            ends[place] = y[-1, ny:], J[-1, ny:]
        for place, begins in self.joints:
            x, J = ends[place]
            gap = J.copy()
            gap[np.arange(len(begins)), begins] -= 1.0
            residuals.append(weights * (x - z[begins]))
            slopes.append(weights[:, np.newaxis] * gap)
        return np.concatenate(residuals), np.concatenate(slopes)

    def residuals(self, z: Array, weights: Array) -> Array:
        """The errors and gaps alone; infinite where a run diverges."""
        residuals, ends, ny = [], {}, len(self.data.model.outputs)
        for place, (e, _, first, last) in enumerate(self.pieces()):
            y = self.model.values(z[np.newaxis], place)[0]
            error = (y[:, :ny] - self.data.samples[e][first : last + 1]) / self.sigma
            residuals.append(error[self.masks[place]])
            ends[place] = y[-1, ny:]
        residuals += [weights * (ends[place] - z[begins]) for place, begins in self.joints]
        r = np.concatenate(residuals)
        return finite_or_infinite(r)

    def spread(self, z: Array) -> Array:
        """(nx,), how far each state goes from segment to segment."""
        states = np.array([z[begins] for _, begins in self.joints])
        return np.asarray(np.maximum(np.ptp(states, axis=0), 1e-9 * (1 + np.abs(states).max(axis=0))))


def shoot_in_segments(data: WeighedData, start: Array, sigma: Array) -> Array | None:
    """The numbers z (nz,) of `data.model` at which segments with ever smaller gaps end; None if a segment diverges."""
    segments = Segments(data, sigma)
    if not segments.joints:
        return None
    model, first = segments.model, data.model
    shared = [i for i, number in enumerate(first.numbers) if number.kind != "initial state"]
    initial = [i for i in range(len(first.numbers)) if i not in shared]
    z = model.starts.copy()
    z[: len(shared)] = start[shared]
    low, high = (np.array([getattr(number, end) for number in model.numbers]) for end in ("low", "high"))
    for weight in GAP_WEIGHTS:
        weights = weight / segments.spread(z)
        residuals = partial(segments.residuals, weights=weights)
        linearized = partial(segments.linearized, weights=weights)
        minimum = least_squares(residuals, linearized, z, low, high, ROUGH, ROUNDS)
        if minimum is None:
            return None
        z = minimum.z
    answer = start.copy()
    answer[shared] = z[: len(shared)]
    for i in initial:
        own = first.numbers[i]
        names = [one.name for one in model.numbers]
        answer[i] = z[names.index(f"{own.label}(0) of {own.experiment}, segment 0")]
    return answer
