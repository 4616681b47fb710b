"""The numbers of a block: their declarations, the refusal of bad ones, and blocks with other numbers."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from typing import TYPE_CHECKING, TypeVar, cast

import numpy as np

from workbench.core.block import is_block, quantities
from workbench.core.numbers import Quantity
from workbench.core.validation.refusals import Array, describe
from workbench.testing.failure_sentences import LONGEST, fail, name_of_block

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Own = TypeVar("Own", bound="DataclassInstance")
STEP = re.compile(r"([^.\[\]]+)|\[(\d+)\]")  # of a path, as in `model.links[0].mass`


def demand_declared_numbers(block: object) -> None:
    """Fail for a class that is no block, and for a number among its fields that is declared by nothing."""
    name = name_of_block(block)
    if not is_block(block) or not is_dataclass(block):
        fail(name, "be a class with `@wb.block` above it", "it is another one", "write `@wb.block` above `class`")
    declared = {f.name for f, _ in quantities(block)}
    for f in fields(block):
        value = getattr(block, f.name)
        is_number = isinstance(value, float | np.ndarray) and f.name != "period"
        if is_number and f.name not in declared:
            fail(
                f"{name}.{f.name}",
                "be declared with its unit, so that it can be varied, derived and exported",
                f"it is the bare number {describe(value)}",
                f"write `{f.name}: float = wb.parameter(unit=...)`, or `wb.initial(unit=...)` for a start",
            )


def demand_refusals(block: DataclassInstance) -> None:
    """Fail for a number of a block that takes a bad value, or refuses it in another way than by name in a sentence."""
    for f, quantity in quantities(block):
        value = getattr(block, f.name)
        if value is None:
            continue
        for bad, rule in bad_values(np.asarray(value, dtype=float), quantity):
            _demand_refusal(block, f.name, bad, rule)


def bad_values(value: Array, quantity: Quantity) -> list[tuple[object, str]]:
    """Values that a number must refuse, each with the words of its rule, or none where the words are free.

    They are text, numbers that are not finite, too many axes, numbers beyond and at each bound, and matrices that are
    not symmetric or not definite.
    """
    bounds, bad = quantity.bounds, list[tuple[object, str]]()
    bad += [("much", ""), (np.full(value.shape, np.nan), "finite"), (np.full(value.shape, np.inf), "finite")]
    if "*" not in quantity.shape:
        bad.append((np.zeros((2, *value.shape, 2)), ""))
    for end, sign in ((bounds.low, -1.0), (bounds.high, 1.0)):
        if np.isfinite(end):
            beyond = [end + sign * max(1.0, abs(end)), *([end] if bounds.strict else [])]
            bad += [(np.full(value.shape, number), str(bounds)) for number in beyond]
    if bounds.symmetric and value.shape[0] > 1:
        bad.append((value + np.triu(np.ones(value.shape), 1), "symmetric"))
    if bounds.definite:
        bad.append((-np.eye(len(value)), f"positive {'semidefinite' if bounds.definite == 'semi' else 'definite'}"))
    if bounds.definite == "positive":
        bad.append((np.zeros(value.shape), "positive definite"))
    return bad


def _demand_refusal(block: DataclassInstance, field: str, bad: object, rule: str) -> None:
    call, came = f"{name_of_block(block)}({field}=...)", describe(bad)
    remedy = "declare it with `wb.parameter(unit=..., low=..., high=...)` and check in `__post_init__` what remains"
    try:
        replace(block, **{field: bad})
    except ValueError as error:
        said = str(error)
        if call not in said or rule not in said or not said.isprintable() or len(said) > LONGEST or said[-1:] != ".":
            must = f"refuse a bad value in one sentence with this name{f' and {rule!r}' if rule else ''}"
            fail(call, must, f"for {came} it said '{said}'", remedy)
    except Exception as error:
        fail(call, "refuse a bad value with a `ValueError`", f"for {came} it raised {error!r}", remedy)
    else:
        fail(call, "refuse a bad value", f"it took {came}", remedy)


def scaled_twin(block: Own, numbers: Mapping[str, Array]) -> tuple[Own, dict[str, Array]]:
    """The block with these numbers, by path, 3 % larger or smaller, as far as it takes them; and the numbers."""
    twin, moved = block, {}
    for path, value in numbers.items():
        for factor in (1.03, 0.97):
            try:
                twin = replace_number(twin, path, value * factor)
            except (ValueError, TypeError, AttributeError):  # a bound, or a number of an equation within
                continue
            moved[path] = value * factor
            break
    return twin, moved


def replace_number(block: Own, path: str, value: Array) -> Own:
    """The block with another number at a path, as in `model.links[0].mass`."""
    steps = [int(index) if index else name for name, index in STEP.findall(path)]
    return cast(Own, _put(block, steps, value if value.ndim else float(value)))


def _put(thing: object, steps: list[int | str], value: object) -> object:
    if not steps:
        return value
    first, *rest = steps
    if isinstance(first, int):
        assert isinstance(thing, tuple)
        return (*thing[:first], _put(thing[first], rest, value), *thing[first + 1 :])
    return replace(cast("DataclassInstance", thing), **{first: _put(getattr(thing, first), rest, value)})
