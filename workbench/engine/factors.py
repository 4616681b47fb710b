"""Factors: the numbers of a loop that are varied, with their distributions and where their ranges come from."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np

from workbench.core.layout import Layout
from workbench.core.validation.refusals import Array, Integers, finite, matrix, nearest, numbers
from workbench.core.validation.signatures import check_arguments
from workbench.engine.distributions import AbstractDistribution

Mark = Literal["stated", "derived", "assumed"]  # of a number: where it comes from


@dataclass(frozen=True)
@check_arguments
class FactorDirection:
    """A direction in which a factor moves several numbers together, by different amounts.

    A number is its centre, plus its change times the value of the factor, plus the changes of all other factors that
    move it along directions of their own. Independent factors thus give numbers that are correlated.

    Raises
    ------
    ValueError
        If there is no number, a number is not finite, there are more centres than changes, or no number moves.

    Examples
    --------
    >>> way = wb.uncertainty.FactorDirection(centres=(0.01, 1.0), changes=(0.001, -0.05))
    >>> wb.Factor("direction 1", ("J", "R"), wb.uncertainty.Normal(0.0, 1.0, -4.0, 4.0), direction=way).paths
    ('J', 'R')
    """

    centres: tuple[float, ...]
    changes: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.centres) != len(self.changes) or not any(self.changes):
            raise ValueError(
                "`FactorDirection(centres=..., changes=...)` must have a centre and a change for each path, and "
                f"move at least one; got {len(self.centres)} centres and the changes {self.changes}."
            )
        for name in ("centres", "changes"):
            for value in getattr(self, name):
                finite(f"FactorDirection({name}=...)", value)


@dataclass(frozen=True)
@check_arguments
class Factor:
    """One number that is varied: one or several paths of a loop, which move together, and how they are spread.

    `paths` name parameters or initial states, or single numbers of them, as `controller.K[0,1]`; a vector takes the
    same value at each of its places. `origin` is where the distribution comes from. With `share` the distribution is
    for a factor by which the numbers of the loop are multiplied: several paths, and all places of a matrix, keep their
    proportions. With a `direction` each path is a single number, which moves by an amount of its own.

    Raises
    ------
    ValueError
        If there is no name or no path, a path comes twice, `distribution` or `origin` is not one, or a direction has
        not as many numbers as there are paths or is a share.

    Examples
    --------
    >>> wb.Factor("inertia", ("plant.J",), wb.Uniform(0.005, 0.02)).paths
    ('plant.J',)
    """

    name: str
    paths: tuple[str, ...]
    distribution: AbstractDistribution
    origin: Mark = "assumed"
    share: bool = False
    direction: FactorDirection | None = None

    def __post_init__(self) -> None:
        if (way := self.direction) is not None and (self.share or len(way.changes) != len(self.paths)):
            raise ValueError(
                f"`Factor({self.name!r}, direction=...)` must have a change for each of the {len(self.paths)} paths, "
                f"and be no share; got {len(way.changes)} changes{' of a share' if self.share else ''}."
            )
        if not self.name or not self.paths or len(set(self.paths)) < len(self.paths):
            raise ValueError(
                f"`Factor({self.name!r}, paths=...)` needs a name, and at least one path, each once; got {self.paths}."
            )


@dataclass(frozen=True, eq=False)
@check_arguments
class Space:
    """Factors of a loop with its layouts: it maps points of the unit cube to parameters and initial states.

    Without a factor each row has the default numbers of the loop.

    Raises
    ------
    ValueError
        If two factors have one name or move one number, except by directions with one centre, a distribution reaches
        beyond the bounds of a number, a share is taken of zero, or a matrix is given one value for all its places.
    LookupError
        If a path is neither that of a parameter nor that of a state; the message names the nearest.

    Examples
    --------
    >>> loop = wb.open_loop(wb.DCMotor())
    >>> factor = wb.Factor("R", ("R",), wb.Uniform(1.0, 2.0))
    >>> len(wb.uncertainty.Space((factor,), loop.parameters).factors)
    1
    """

    factors: tuple[Factor, ...]
    parameters: Layout
    states: Layout = field(default_factory=Layout)

    def __post_init__(self) -> None:
        names = [factor.name for factor in self.factors]
        if len(set(names)) < len(names):
            raise ValueError(f"`Space(factors=...)` needs factors, each of another name; got {names}.")
        self._check_owners()
        for factor, places in zip(self.factors, self.places, strict=True):
            if factor.share and not self._default[places].any():
                raise ValueError(
                    f"`Factor({factor.name!r}, share=True)` needs numbers that are not zero, as any share of zero is "
                    "zero: give the values themselves."
                )
            self._check_reach(factor, places)

    def _check_owners(self) -> None:
        """Refuse a number that two factors move, unless both do so along directions from the same centre."""
        owners: dict[int, tuple[str, float | None]] = {}
        for factor, places in zip(self.factors, self.places, strict=True):
            way = factor.direction
            for i, place in enumerate(places):
                centre = None if way is None else way.centres[i]
                other, at = owners.setdefault(int(place), (factor.name, centre))
                if other != factor.name and (at is None or at != centre):
                    raise ValueError(
                        f"`Space(factors=...)` takes each number once; '{other}' and '{factor.name}' both move "
                        f"'{self._labels[place]}'{'' if at is None or centre is None else ', from different centres'}."
                    )

    def rows(self, points: Array) -> tuple[Array, Array]:
        """Parameters (B, np) and initial states (B, nx) of the runs at points (B, d) of the unit cube.

        Raises
        ------
        ValueError
            If the points are not (B, d) in the unit cube, or if a row is not allowed.
        """
        values = self.values(points)
        for factor, column in zip(self.factors, values.T, strict=True):
            if not np.isfinite(column).all():
                raise ValueError(
                    f"`rows(points)` needs a bounded distribution where a design goes to its ends; that of "
                    f"'{factor.name}' has none: cut it off by `low` and `high`."
                )
        return self.rows_at(values)

    def rows_at(self, values: Array) -> tuple[Array, Array]:
        """Parameters (B, np) and initial states (B, nx) of the runs at values (B, d) of the factors themselves.

        Raises
        ------
        ValueError
            If the values are not (B, d) finite numbers, or if a row is not allowed.
        """
        columns = matrix("rows_at(values)", values, columns=len(self.factors))
        rows = np.tile(self._central, (len(columns), 1))
        for factor, places, own in zip(self.factors, self.places, columns.T, strict=True):
            held = own[:, np.newaxis]
            if factor.direction is not None:
                rows[:, places] += held * np.array(factor.direction.changes)
            else:
                rows[:, places] = held * self._default[places] if factor.share else held
        split = self.parameters.size
        try:
            self._check(rows)
        except ValueError as refusal:
            if not any(factor.direction for factor in self.factors):
                raise
            raise ValueError(
                f"`rows(points)`: the directions of the factors lead together too far: {refusal} Cut their "
                "distributions off nearer to the centre."
            ) from None
        return rows[:, :split], rows[:, split:]

    def values(self, points: Array) -> Array:
        """The values (B, d) of the factors themselves at points (B, d) of the unit cube: numbers, or shares."""
        points = self._cube("values", points)
        columns = zip(self.factors, points.T, strict=True)
        held = (factor.distribution.quantile(u)[:, np.newaxis] for factor, u in columns)
        return np.hstack([np.empty((len(points), 0)), *held])

    def _cube(self, call: str, coordinates: Array) -> Array:
        """Points (B, d) of the unit cube."""
        points, d = numbers(f"{call}(points)", coordinates), len(self.factors)
        if points.shape[1:] != (d,) or not ((points >= 0) & (points <= 1)).all():
            raise ValueError(
                f"`{call}(points)` takes points (B, {d}) of the unit cube, one column a factor; got shape "
                f"{points.shape}{'' if points.shape[1:] != (d,) else ' with points beyond it'}."
            )
        return points

    def _check(self, rows: Array) -> None:
        split = self.parameters.size
        self.parameters.check(rows[:, :split])
        self.states.check(rows[:, split:])

    def _check_reach(self, factor: Factor, places: Integers) -> None:
        """Refuse a factor whose range leads beyond the bounds of a number."""
        if factor.direction is not None:
            return  # only together with others does it lead anywhere, which `rows` checks
        rows = np.tile(self._default, (2, 1))
        reach = np.array(factor.distribution.reach())[:, np.newaxis]
        rows[:, places] = reach * self._default[places] if factor.share else reach
        try:
            self._check(rows)
        except ValueError as refusal:
            ends = f"from {reach[0, 0]:g} to {reach[1, 0]:g}{' of its own value' if factor.share else ''}"
            raise ValueError(f"`Space(factors=...)`: '{factor.name}' goes {ends}, too far: {refusal}") from None

    @cached_property
    def _central(self) -> Array:
        """The default numbers, and the centres of those that directions move."""
        row = self._default.copy()
        for factor, places in zip(self.factors, self.places, strict=True):
            if factor.direction is not None:
                row[places] = factor.direction.centres
        return row

    @cached_property
    def _default(self) -> Array:
        return np.concatenate([self.parameters.default, self.states.default])

    @cached_property
    def _labels(self) -> tuple[str, ...]:
        return self.parameters.labels + self.states.labels

    @cached_property
    def places(self) -> tuple[Integers, ...]:
        """The places of each factor's numbers in a row of parameters and initial states."""
        return tuple(np.array([i for path in f.paths for i in self._find(f, path)]) for f in self.factors)

    def _find(self, factor: Factor, path: str) -> list[int]:
        for layout, offset in ((self.parameters, 0), (self.states, self.parameters.size)):
            if path in layout or path in layout.labels:
                places = [offset + i for i in layout.indices(path)]
                if factor.direction is not None and len(places) > 1:
                    raise ValueError(
                        f"`Factor({factor.name!r}, direction=...)` moves single numbers, and '{path}' has "
                        f"{len(places)}: name each, such as '{layout[path].labels()[0]}'."
                    )
                if path in layout and len(layout[path].shape) == 2 and not factor.share and len(places) > 1:
                    raise ValueError(
                        f"`Factor({factor.name!r}, paths=...)` would give all {len(places)} numbers of the matrix "
                        f"'{path}' one value: name single ones, such as '{layout[path].labels()[0]}', or vary a share."
                    )
                return places
        known = (*self.parameters.names, *self.states.names, *self._labels)
        raise LookupError(
            f"There is no '{path}', which '{factor.name}' varies, among the {len(self.parameters.names)} parameters "
            f"and {len(self.states.names)} states of this loop.{nearest(path, known)}"
        )
