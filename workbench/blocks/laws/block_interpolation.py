"""Interpolation of blocks of one class: at a value between the points, a block whose numbers lie between theirs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import fields
from functools import reduce
from itertools import pairwise
from operator import add
from typing import TypeVar, cast

import casadi as ca
import numpy as np

from workbench.core import Layout
from workbench.core.block import Number, is_block

T = TypeVar("T")


def interpolation_weights(points: ca.SX, at: Number, cubic: bool) -> list[ca.SX]:
    """The weights, one for each of the points (m, 1), with which the values there are summed to give the value `at`.

    They are linear between the points, or cubic with a continuous derivative, and constant beyond the ends. The sum of
    the weights is one, and at a point all weights but its own are zero. For the cubic rule, the slope at a point is
    that of the parabola through it and its neighbours, at an end that of the line to the next point.
    """
    places = ca.vertsplit(points)
    widths = [after - before for before, after in pairwise(places)]
    weights = [ca.SX(float(j == 0)) for j in range(len(places))]
    for i, width in enumerate(widths):
        s = ca.fmin(ca.fmax((at - places[i]) / width, 0.0), 1.0)
        rise = s * s * (3.0 - 2.0 * s) if cubic else s
        weights[i] -= rise
        weights[i + 1] += rise
        if cubic:  # the two Hermite polynomials of the slopes, which are zero at both ends of the interval
            for j, share in _slope(widths, i).items():
                weights[j] += share * width * s * (1.0 - s) * (1.0 - s)
            for j, share in _slope(widths, i + 1).items():
                weights[j] -= share * width * s * s * (1.0 - s)
    return weights


def _slope(widths: list[ca.SX], i: int) -> dict[int, ca.SX]:
    """The factors of the values at the points in the slope at point i, by the places of the points."""
    if i in (0, len(widths)):
        first = min(i, len(widths) - 1)
        return {first: -1.0 / widths[first], first + 1: 1.0 / widths[first]}
    left, right = widths[i - 1], widths[i]
    before, after = right / (left * (left + right)), left / (right * (left + right))
    return {i - 1: -before, i: before - after, i + 1: after}


def interpolated_block(blocks: Sequence[T], weights: Sequence[ca.SX] | Sequence[float]) -> T:
    """The block whose numbers are the sums of those of `blocks`, of one class and form, times the weights."""
    first = blocks[0]
    result = object.__new__(type(first))
    for name, value in vars(first).items():
        object.__setattr__(result, name, value)  # also what is no field, such as the period
    for f in fields(first):  # type: ignore[arg-type]
        values = [getattr(block, f.name) for block in blocks]
        object.__setattr__(result, f.name, _value(values, weights, is_number="quantity" in f.metadata))
    return result


def _value(values: list[object], weights: Sequence[ca.SX] | Sequence[float], is_number: bool) -> object:
    first = values[0]
    if is_number and first is not None:
        numbers = cast(list[ca.SX], values)  # in the twin of a block; else arrays, which have the same arithmetic
        return reduce(
            add, (number * weight for weight, number in zip(cast(Sequence[ca.SX], weights), numbers, strict=True))
        )
    if is_block(first):
        return interpolated_block(values, weights)
    if isinstance(first, tuple) and any(map(is_block, first)):
        tuples = cast(list[tuple[object, ...]], values)
        return tuple(_value(list(parts), weights, False) for parts in zip(*tuples, strict=True))
    return first


def differences(first: object, other: object, path: str = "") -> Iterator[str]:
    """The fields in which two blocks differ other than by their numbers, by their paths."""
    if type(first) is not type(other):
        yield path or type(other).__name__
        return
    for f in fields(first):  # type: ignore[arg-type]
        one, two, name = getattr(first, f.name), getattr(other, f.name), f"{path}{f.name}"
        if "quantity" in f.metadata:
            if np.shape(one) != np.shape(two) or (one is None) is not (two is None):
                yield name
        elif is_block(one):
            yield from differences(one, two, f"{name}.")
        elif isinstance(one, tuple) and any(map(is_block, one)) and isinstance(two, tuple) and len(one) == len(two):
            for i, (part, twin) in enumerate(zip(one, two, strict=True)):
                yield from differences(part, twin, f"{name}[{i}].")
        elif _form(one) != _form(two):
            yield name


def _form(value: object) -> object:
    """The part of a value that both blocks must share: of a layout the names, shapes and units, no initial values."""
    if isinstance(value, Layout):
        return [(entry.name, entry.shape, entry.units) for entry in value.entries]
    return value
