"""The states of coloured noises of a plant or of its instruments, under names that tell them apart."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import count

import casadi as ca
import numpy as np

from workbench.blocks.loop.coloured_noise import AbstractNoise
from workbench.blocks.loop.signal_units import fit_element
from workbench.core import Entry, Layout, Signals
from workbench.core.block import quantities
from workbench.core.validation.refusals import Array

Parts = Mapping[str, ca.SX]


def noise_of(field: str, noise: AbstractNoise, port: Layout, of: str) -> AbstractNoise:
    """A noise in the unit of its signal of a port, with one number for each element of the signal."""
    fitting = fit_element(field, noise, port, of)
    shape = port[noise.signal].shape
    for f, quantity in quantities(fitting):
        if quantity.shape == ("*",):
            object.__setattr__(fitting, f.name, _numbers(getattr(fitting, f.name), shape))
    return fitting


def _numbers(value: Array | float, shape: tuple[int, ...]) -> Array | float:
    return np.broadcast_to(value, shape).copy() if shape else value


@dataclass(frozen=True)
class NoiseStates:
    """The states of noises by name: 'v.noise', and 'v.noise_2' for a second noise of v."""

    noises: tuple[AbstractNoise, ...]

    @property
    def layout(self) -> Layout:
        """The states, zero before the first instant."""
        entries = (
            _entry(here, noise.size, unit)
            for noise, names in self._names()
            for here, (_, unit) in zip(names, noise.states, strict=True)
        )
        return Layout(tuple(entries))

    @property
    def signals(self) -> Layout:
        """The signals that have a noise."""
        return Layout(tuple({each.signal: _entry(each.signal, each.size, each.unit) for each in self.noises}.values()))

    def after(self, k: ca.SX, z: Parts, w: ca.SX, period: float) -> dict[str, ca.SX]:
        """The states at the instant k, with standard normal w, (size of the layout, 1)."""
        draws, moved = self.layout.view(w), dict[str, ca.SX]()
        for noise, names in self._names():
            own = [draws[name] for name in names]
            pairs = zip(noise.start(own), noise.after([z[name] for name in names], own, period), strict=True)
            moved |= {n: ca.if_else(k == 0, first, later) for n, (first, later) in zip(names, pairs, strict=True)}
        return moved

    def signal_noise(self, z: Parts) -> Signals:
        """The sum of the noises of each signal."""
        sums = dict[str, ca.SX]()
        for noise, (name, *_) in self._names():
            sums[noise.signal] = sums[noise.signal] + z[name] if noise.signal in sums else z[name]
        return Signals(sums)

    def _names(self) -> Iterator[tuple[AbstractNoise, list[str]]]:
        taken = set[str]()
        for noise in self.noises:
            for i in count(1):
                names = [f"{noise.signal}.{own}{'' if i == 1 else f'_{i}'}" for own, _ in noise.states]
                if taken.isdisjoint(names):
                    break
            taken |= set(names)
            yield noise, names


def _entry(name: str, size: int, unit: str) -> Entry:
    return Entry(name, np.zeros(() if size == 1 else size), unit)
