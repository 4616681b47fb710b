"""Signals of a dataset as records at one period for a linear model: checked, and less their offsets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.core import Entry, Layout
from workbench.core.validation.refusals import Array, known_name, one_of
from workbench.identification.datasets import Dataset, Experiment
from workbench.identification.linear_models.prediction_errors import Record, record_of

JITTER = 0.01  # of the period: the largest distance of a sample from its place
SAME = 1e-6  # relative: two periods that differ by less are one
OFFSETS = ("mean", "estimate", "none")


@dataclass(frozen=True, eq=False)
class LinearSignals:
    """Inputs u and outputs y of a dataset: for each experiment (N, nu) and (N, ny), and the period in s.

    A sample of an output that is missing or marked is NaN, if the model takes such ones.
    """

    period: float
    inputs: Layout
    outputs: Layout
    u: tuple[Array, ...]
    y: tuple[Array, ...]

    @property
    def samples(self) -> int:
        """The number of samples of all experiments at which every output counts."""
        return sum(int(np.isfinite(y).all(axis=1).sum()) for y in self.y)

    def means(self) -> tuple[Array, Array]:
        """The means (nu,) and (ny,) over all samples that count."""
        y = np.concatenate(self.y)
        return np.concatenate(self.u).mean(axis=0), (np.nanmean if np.isnan(y).any() else np.mean)(y, axis=0)

    def records(self, u0: Array, y0: Array) -> tuple[Record, ...]:
        """A record of the first output for each experiment, as deviations from u0 (nu,) and y0 (ny,)."""
        pairs = zip(self.u, self.y, strict=True)
        return tuple(record_of(y[:, 0] - y0[0], np.ascontiguousarray((u - u0).T)) for u, y in pairs)

    def offsets(self, offsets: str) -> tuple[Array, Array]:
        """The numbers that are taken off before a fit: the means, or zeros if offsets are 'none'."""
        u0, y0 = self.means()
        return (u0, y0) if offsets != "none" else (np.zeros_like(u0), np.zeros_like(y0))


def signals_of(
    call: str,
    data: Dataset,
    inputs: str | Sequence[str],
    outputs: str | Sequence[str],
    least: int = 2,
    gaps: bool = False,
) -> LinearSignals:
    """The signals of a dataset at one constant period; what a linear model cannot take is refused by name.

    With `gaps`, samples of outputs may be missing or marked; samples of inputs never.

    Raises
    ------
    ValueError
        If times are not at one constant period, samples are missing or marked, a signal is constant or both an input
        and an output, or an experiment has fewer than `least` samples.
    LookupError
        If there is no such signal.
    """
    ports = [_port(data, (names,) if isinstance(names, str) else tuple(names)) for names in (inputs, outputs)]
    both = set(ports[0].labels) & set(ports[1].labels)
    if both or not ports[0].size or not ports[1].size:
        what = f"'{min(both)}' is both an input and an output" if both else "there is no input or no output"
        raise ValueError(f"`{call}` must have inputs and outputs that are different signals; {what}.")
    columns = [[data.signals.labels.index(label) for label in port.labels] for port in ports]
    period = _period(call, data)
    for experiment in data:
        if len(experiment) < least:
            raise ValueError(
                f"`{call}` needs at least {least} samples in each experiment for this model; '{experiment.name}' has "
                f"{len(experiment)}: log for longer, or take lower orders."
            )
        places = columns[0] if gaps else columns[0] + columns[1]
        _refuse_gaps(call, experiment, [data.signals.labels[place] for place in places], places)
    u, y = (tuple(experiment.values[:, held] for experiment in data) for held in columns)
    if gaps:
        weighed = (experiment.is_weighed[:, columns[1]] for experiment in data)
        y = tuple(np.where(good, part, np.nan) for part, good in zip(y, weighed, strict=True))
    for port, parts in zip(ports, (u, y), strict=True):
        whole = np.concatenate(parts)
        if np.isnan(whole).all(axis=0).any():
            raise ValueError(f"`{call}` needs samples of '{port.labels[0]}'; all are missing or marked.")
        still = np.nanmax(whole, axis=0) == np.nanmin(whole, axis=0)
        if still.any():
            label = port.labels[int(np.argmax(still))]
            raise ValueError(f"`{call}` needs signals that move; '{label}' is constant in this dataset.")
    return LinearSignals(period, ports[0], ports[1], u, y)


def _port(data: Dataset, labels: tuple[str, ...]) -> Layout:
    """The layout of some signals, whole ones by name and single numbers by label, as q[0]."""
    entries = []
    for label in labels:
        known = dict.fromkeys((*data.signals.names, *data.signals.labels))
        known_name(label, known, "signals of this dataset")
        numbers = [(one, entry) for entry in data.signals.entries for one in entry.labels()]
        units = [unit for entry in data.signals.entries for unit in entry.units]
        for (one, entry), unit in zip(numbers, units, strict=True):
            if label in (one, entry.name):
                entries.append(Entry(one, np.zeros(()), unit))
    return Layout(tuple(entries))


def _period(call: str, data: Dataset) -> float:
    periods = []
    for experiment in data:
        t = experiment.t
        if len(t) < 2 or not np.isfinite(t).all() or not (np.diff(t) > 0).all():
            raise ValueError(
                f"`{call}` needs times that rise from sample to sample; those of '{experiment.name}' do not."
            )
        h = float(t[-1] - t[0]) / (len(t) - 1)
        away = np.abs(t - t[0] - h * np.arange(len(t))) / h
        if away.max() > JITTER:
            k = int(np.argmax(away))
            raise ValueError(
                f"`{call}` needs a constant period; sample {k} of '{experiment.name}', at {t[k]:.6g} s, lies "
                f"{away[k]:.3g} periods from its place: resample the log, or take an experiment for each side of a gap."
            )
        periods.append(h)
    if max(periods) > (1 + max(SAME, 2 * JITTER / max(map(len, data)))) * min(periods):
        raise ValueError(
            f"`{call}` needs one period for all experiments; they have {min(periods):.6g} to {max(periods):.6g} s: "
            "resample them to one."
        )
    # the last digits are those of printed times
    h = periods[0]
    rounded = float(f"{h:.9g}")
    return rounded if abs(rounded - h) < 1e-8 * h else h


def _refuse_gaps(call: str, experiment: Experiment, labels: list[str], columns: list[int]) -> None:
    good = experiment.is_weighed[:, columns]
    if good.all():
        return
    k, column = map(int, np.argwhere(~good)[0])
    bad = int((~good[:, column]).sum())
    what = "marked" if np.isfinite(experiment.values[k, columns[column]]) else "missing"
    raise ValueError(
        f"`{call}` needs each sample; {bad} of '{labels[column]}' in '{experiment.name}' are missing or marked, the "
        f"first ({what}) at {experiment.t[k]:.6g} s: take experiments from between the gaps."
    )


def checked_offsets(call: str, offsets: str) -> str:
    """One of the treatments of offsets."""
    return one_of(f"{call}(offsets=...)", offsets, OFFSETS)
