"""What a declared work refuses, and the kinds of answers that it gives back as they were."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pytest

import workbench as wb
from workbench.study.ledger.chunk import parse_chunk
from workbench.study.study_results import Results
from workbench.study.study_works import Work, WorkError, compile_work

if TYPE_CHECKING:
    from decimal import Decimal as NotThere


class Point(NamedTuple):
    x: float
    y: float


@dataclass(frozen=True, eq=False)
class Curve:
    points: tuple[Point, ...]
    values: np.ndarray
    length: float = field(init=False)

    def __post_init__(self):
        object.__setattr__(self, "length", float(len(self.points)))


@dataclass
class Loose:
    x: float


@dataclass(frozen=True)
class Parent:
    curve: Curve | None
    parts: dict[str, list[Point]]


@dataclass(frozen=True)
class Stranger:
    x: float = 1.0


def parent(item: int) -> Parent | None:
    return Parent(Curve((Point(1.0, float("nan")),), np.arange(3.0)), {"a": [Point(0.1, -0.0)]}) if item else None


def nothing(item):
    return None


def loose(item) -> Loose:
    return Loose(1.0)


def stranger(item) -> Parent:
    return Stranger()


def by_number(item):
    return {1: item}


def unresolved(item) -> NotThere:
    return item


def fails(item):
    raise ZeroDivisionError("by 0.")


def read_back(work, k=0):
    """The answer to an item, computed and read from its record."""
    one = compile_work(work)
    records = {name: parse_chunk(bytes(one.chunk(i, i + 1))) for i, name in enumerate(one.names)}
    return one.answers(records.__getitem__)[k]


def test_nested_dataclasses_and_named_tuples_come_back_in_their_classes():
    found = read_back(Work("w", parent, (1, 0)))
    assert type(found) is Parent
    assert type(found.curve) is Curve
    assert found.curve.points[0] == Point(1.0, found.curve.points[0].y)
    assert np.isnan(found.curve.points[0].y)
    assert (found.curve.length, found.parts) == (1.0, {"a": [Point(0.1, -0.0)]})
    np.testing.assert_array_equal(found.curve.values, np.arange(3.0))
    assert read_back(Work("w", parent, (1, 0)), 1) is None


def test_the_type_of_an_answer_can_be_given_beside_the_function():
    assert read_back(Work("w", stranger, (1,), answer=Stranger)) == Stranger()


REFUSED = [
    (loose, "must give plain data, and at 1 the answer is a `Loose`, a dataclass that is not frozen"),
    (stranger, r"the answer is a `Stranger`, which the hint of the result does not name: write `-> Stranger`"),
    (by_number, "the answer has the key 1, and a dict of plain data has text for keys"),
    (fails, r"^The work 'w' fails at 1: ZeroDivisionError: by 0\.$"),
]


@pytest.mark.parametrize(("function", "said"), REFUSED, ids=[function.__name__ for function, _ in REFUSED])
def test_an_answer_that_is_no_plain_data_is_refused_with_work_and_item(function, said):
    with pytest.raises(WorkError, match=said):
        read_back(Work("w", function, (1,)))


def test_a_hint_that_is_not_there_at_run_time_is_refused_when_the_work_is_declared():
    with pytest.raises(LookupError, match="name 'NotThere', which is not there when it runs"):
        Work("w", unresolved, (1,))
    assert Work("w", unresolved, (1,), answer=float).classes == {}


@pytest.mark.parametrize("function", [3, max, np.sin, Stranger, "nothing"])
def test_a_work_needs_a_function_of_a_module(function):
    with pytest.raises(ValueError, match=r"`Work\("):
        Work("w", function, (1,))


def test_a_work_needs_a_name_of_a_file_and_a_positive_time():
    with pytest.raises(ValueError, match="made of a-z"):
        Work("A work", nothing, (1,))
    with pytest.raises(ValueError, match="seconds"):
        Work("w", nothing, (1,), seconds=0.0)


def test_names_of_works_are_distinct_and_differ_from_those_of_sweeps():
    run = wb.Run(wb.open_loop(wb.DCMotor()), (wb.effort("omega"),), until=0.1, h=0.01)
    factor = wb.Factor("b", ("b",), wb.Uniform(0.1, 0.2))
    sweep = wb.Sweep("one", run, (factor,), wb.SobolDesign(1, 8))
    for works, sweeps in (((Work("one", nothing, (1,)),), (sweep,)), (2 * (Work("two", nothing, (1,)),), ())):
        with pytest.raises(ValueError, match="distinct sweeps, trials and works"):
            wb.Study("s", "T", "Q?", "M.", lambda results: [], works=works, sweeps=sweeps)


def test_an_answer_that_is_not_there_is_refused_with_the_nearest_name():
    with pytest.raises(LookupError, match="Did you mean 'gains'"):
        Results(works={"gains": (1,)}).work("gain")
