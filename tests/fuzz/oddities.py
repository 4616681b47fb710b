"""Values that nobody should give a call, and plain ones that somebody might, each made anew."""

from __future__ import annotations

import datetime
import os
import pathlib
from collections import OrderedDict
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from typing import Any

import casadi as ca
import numpy as np
import pandas as pd


def _raises(*names: str) -> type:
    def refuse(self: Any, *args: Any, **kwargs: Any) -> Any:
        raise RuntimeError("this object refuses")

    return type("Raises_" + "_".join(name.strip("_") for name in names), (), dict.fromkeys(names, refuse))


class Loud:
    """Writes escape sequences and lines of its own into a message."""

    def __repr__(self) -> str:
        return "\x1b[2J\n" * 1000

    __str__ = __repr__


ARRAY = OrderedDict(  # kinds of arrays
    empty=lambda: np.zeros(0),
    scalar=lambda: np.array(0.5),
    one=lambda: np.ones(1),
    two=lambda: np.array([0.1, 0.2]),
    three=lambda: np.ones(3),
    square=lambda: np.eye(2),
    row=lambda: np.ones((1, 2)),
    cube=lambda: np.ones((2, 2, 2)),
    no_rows=lambda: np.zeros((0, 2)),
    nan=lambda: np.array([np.nan, 0.0]),
    huge=lambda: np.array([1.7e308, -1.7e308]),
    integers=lambda: np.array([1, 2]),
    truths=lambda: np.array([True, False]),
    complex=lambda: np.array([1j, 2.0]),
    text=lambda: np.array(["a", "b"]),
    objects=lambda: np.array([None, "x"], dtype=object),
    long=lambda: np.array([1, 2], dtype=np.longdouble),
    half=lambda: np.array([1, 2], dtype=np.float16),
    dates=lambda: np.array(["2020-01-01"], dtype="datetime64[D]"),
    masked=lambda: np.ma.array([1.0, 2.0], mask=[True, False]),
    record=lambda: np.zeros(2, dtype=[("a", float)]),
    many_axes=lambda: np.zeros((1,) * 32),
    large=lambda: np.zeros(100_000),
    reverse=lambda: np.array([0.1, 0.2])[::-1],
)

ODD: dict[str, Callable[[], Any]] = {
    "None": lambda: None,
    "True": lambda: True,
    "np.True_": lambda: np.True_,
    "''": lambda: "",
    "'x'": lambda: "x",
    "'x' * 10**5": lambda: "x" * 10**5,
    "'\\ud800'": lambda: "\ud800",
    "'\\x1b[2J\\n'": lambda: "\x1b[2J\n",
    "'\\0'": lambda: "\0",
    "'{}%s'": lambda: "{}%s",
    "b'x'": lambda: b"x",
    "nan": lambda: float("nan"),
    "inf": lambda: float("inf"),
    "-inf": lambda: -float("inf"),
    "-0.0": lambda: -0.0,
    "-1": lambda: -1,
    "-1.5": lambda: -1.5,
    "0": lambda: 0,
    "2**31": lambda: 2**31,
    "2**63": lambda: 2**63,
    "10**400": lambda: 10**400,
    "1.7e308": lambda: 1.7e308,
    "5e-324": lambda: 5e-324,
    "1e-300": lambda: 1e-300,
    "np.int8(2)": lambda: np.int8(2),
    "np.int64(2)": lambda: np.int64(2),
    "np.uint64(2**63)": lambda: np.uint64(2**63),
    "np.float16(1)": lambda: np.float16(1),
    "np.longdouble(1)": lambda: np.longdouble(1),
    "np.longdouble('1e4000')": lambda: np.longdouble("1e4000"),
    "1j": lambda: 1j,
    "Decimal(1)": lambda: Decimal(1),
    "Fraction(1, 2)": lambda: Fraction(1, 2),
    "datetime": lambda: datetime.datetime(2020, 1, 1),
    "[]": list,
    "()": tuple,
    "{}": dict,
    "set()": set,
    "[1.0, 'x']": lambda: [1.0, "x"],
    "[[1.0], [1.0, 2.0]]": lambda: [[1.0], [1.0, 2.0]],
    "[None]": lambda: [None],
    "['x', 'x']": lambda: ["x", "x"],
    "('x', 3)": lambda: ("x", 3),
    "{'x': 1.0}": lambda: {"x": 1.0},
    "{1: 'x'}": lambda: {1: "x"},
    "{'x': None}": lambda: {"x": None},
    "{1.0, 2.0}": lambda: {1.0, 2.0},
    "generator": lambda: (i for i in range(2)),
    "range(3)": lambda: range(3),
    "range(10**9)": lambda: range(10**9),
    "slice(2)": lambda: slice(2),
    "Ellipsis": lambda: Ellipsis,
    "NotImplemented": lambda: NotImplemented,
    "pd.Series": lambda: pd.Series([1.0, 2.0]),
    "pd.Series of text": lambda: pd.Series(["a", None]),
    "pd.DataFrame": lambda: pd.DataFrame({"a": [1.0, 2.0]}),
    "pd.NA": lambda: pd.NA,
    "ca.SX.sym('a')": lambda: ca.SX.sym("a"),
    "ca.SX.sym('a', 3)": lambda: ca.SX.sym("a", 3),
    "ca.SX(1)": lambda: ca.SX(1),
    "ca.SX(2, 2)": lambda: ca.SX(2, 2),
    "ca.SX(0, 1)": lambda: ca.SX(0, 1),
    "ca.SX.sym('a') / 0": lambda: ca.SX.sym("a") / 0,
    "ca.MX.sym('a', 2)": lambda: ca.MX.sym("a", 2),
    "ca.DM([1, 2])": lambda: ca.DM([1, 2]),
    "ca.Function": lambda: ca.Function("f", [ca.SX.sym("a")], [ca.SX(1)]),
    "Path('.')": lambda: pathlib.Path("."),
    "Path('/dev/zero')": lambda: pathlib.Path("/dev/zero"),
    "os.environ": lambda: os.environ,
    "float": lambda: float,
    "object": lambda: object,
    "object()": lambda: object(),
    "len": lambda: len,
    "lambda: None": lambda: lambda: None,
    "lambda *a: 'x'": lambda: lambda *a, **k: "x",
    "numpy": lambda: np,
    "ValueError('x')": lambda: ValueError("x"),
    "Loud()": Loud,
    "1000 lists": lambda: _nested(1000),
    **{
        f"an object without {name}": _raises(name)
        for name in ("__len__", "__repr__", "__eq__", "__array__", "__bool__")
    },
    "an object that refuses all": _raises(
        "__len__", "__iter__", "__getitem__", "__array__", "__repr__", "__float__", "__index__", "__bool__", "__call__"
    ),
    **{f"array {name}": make for name, make in ARRAY.items()},
}

PLAIN: dict[str, Callable[[], Any]] = {
    "1": lambda: 1,
    "2": lambda: 2,
    "0.5": lambda: 0.5,
    "'q'": lambda: "q",
    "[0.1, 0.2]": lambda: [0.1, 0.2],
    "ca.SX.sym('q', 2)": lambda: ca.SX.sym("q", 2),
}


def _nested(depth: int) -> list[Any]:
    inner: list[Any] = []
    for _ in range(depth):
        inner = [inner]
    return inner
