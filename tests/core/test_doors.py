"""A door takes what its hints say, makes it Python's own, and names anything else in one short sentence."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Literal, TypeVar

import casadi as ca
import numpy as np
import pandas as pd
import pytest

from workbench.core.validation import refusals as v
from workbench.core.validation.refusals import Array, Integers
from workbench.core.validation.signatures import check_arguments

if TYPE_CHECKING:
    from collections import OrderedDict as SeenByTheTypeChecker

T = TypeVar("T")
CALL = "f(x=...)"


class Mute:
    """Raises whatever it is asked."""

    def _refuse(self, *args, **kwargs):
        raise RuntimeError("no")

    __repr__ = __len__ = __iter__ = __array__ = __getitem__ = __float__ = __index__ = __eq__ = _refuse
    __hash__ = None


class Loud:
    """Prints as a terminal's escape sequence."""

    __name__ = "\x1b[2J\n"

    def __call__(self):
        return None


NO_NUMBERS = [
    None, True, "1", b"1", 1j, 10**400, {1.0}, {"a": 1.0}, Decimal(1), Fraction(1), [1.0, [2.0]], [None], Mute(), float,
    ca.SX.sym("x"), np.longdouble("1e4000"), np.datetime64(0, "s"), (i for i in range(2)), np.array(["1"]),
    np.ma.array([1.0, 2.0], mask=[0, 1]), np.zeros(2, complex), slice(1), Ellipsis,
]  # fmt: skip


@pytest.mark.parametrize("value", NO_NUMBERS, ids=lambda value: type(value).__name__)
@pytest.mark.parametrize(
    "word",
    [
        v.whole, v.seed, v.finite, v.positive, v.seconds, v.matrix, v.numbers,
        lambda call, value: v.vector(call, value, 2, "joints"),
    ],
    ids=lambda word: word.__name__,
)  # fmt: skip
def test_what_is_no_number_is_refused_by_every_word_for_numbers(word, value):
    with pytest.raises(ValueError, match=r"^`f\(x=...\)` must be ") as error:
        word(CALL, value)
    assert str(error.value).isprintable()
    assert len(str(error.value)) < 250


@pytest.mark.parametrize("kind", [int, np.int8, np.uint64, np.int64, lambda n: np.array(n)])
def test_whole_numbers_of_any_kind_become_pythons(kind):
    for clean in (v.whole(CALL, kind(3)), v.seed(CALL, kind(3)), v.whole(CALL, kind(3), 2, 4)):
        assert clean == 3
        assert type(clean) is int


@pytest.mark.parametrize("kind", [float, int, np.float16, np.float32, np.longdouble, np.int8, np.array])
def test_numbers_of_any_kind_become_pythons(kind):
    for clean in (v.finite(CALL, kind(2)), v.positive(CALL, kind(2)), v.seconds(CALL, kind(2))):
        assert clean == 2.0
        assert type(clean) is float


@pytest.mark.parametrize("kind", [list, tuple, np.array, pd.Series, lambda x: np.array(x, np.longdouble)])
def test_numbers_on_axes_become_new_arrays_of_doubles(kind):
    given = kind([1, 2])
    clean = v.vector(CALL, given, 2, "joints")
    assert clean.dtype == np.float64
    assert not np.shares_memory(clean, np.asarray(given))
    assert v.matrix(CALL, [given, given]).shape == (2, 2)


REFUSED = [
    (lambda: v.whole(CALL, 0), "`f(x=...)` must be a positive whole number; got 0."),
    (lambda: v.whole(CALL, 1, 2, of=" of runs"), "must be a whole number of runs, at least 2; got 1."),
    (lambda: v.whole(CALL, 13, 2, 12), "must be a whole number from 2 to 12; got 13."),
    (lambda: v.whole(CALL, 2**53 + 1), "must be a whole number from 1 to 2^53; got 9007199254740993."),
    (lambda: v.whole(CALL, 2.0), "must be a positive whole number; got 2.0."),
    (lambda: v.seed(CALL, -1), "must be a whole number from 0 to 2^64 - 1, the key of a generator; got -1."),
    (lambda: v.finite(CALL, np.inf, " of rad"), "must be a finite number of rad; got inf."),
    (lambda: v.finite(CALL, 2, low=0, high=1), "must be a finite number, at least 0, at most 1; got 2."),
    (lambda: v.positive(CALL, 5e-324), "got 5e-324, which a float does not hold to full accuracy."),
    (lambda: v.seconds("Run(h=...)", "x"), "`Run(h=...)` must be a positive, finite number of seconds; got 'x'."),
    (lambda: v.multiple(CALL, 1.7e308, 0.01, "`h`"), "must be at most 2^53 times `h` 0.01 s, to be counted"),
    (lambda: v.multiple(CALL, 1.0, 0.3, "`h`"), "must be a multiple of `h` 0.3 s; got 1 s."),
    (lambda: v.numbers(CALL, [1.0], 0), "must be a single number; got [1.0]."),
    (lambda: v.vector(CALL, [1.0], 2, "joints"), "must have shape (2,), one number for each of the joints; got (1,)."),
    (lambda: v.matrix(CALL, np.eye(2), columns=3), "must have shape (any, 3); got (2, 2)."),
    (lambda: v.matrix(CALL, [[np.nan]]), "must be a matrix of finite numbers; got nan at [0, 0]."),
    (lambda: v.text(CALL, " "), "must be text that says something, in characters that can be written; got ' '."),
    (lambda: v.text(CALL, "\ud800"), "in characters that can be written; got '\\ud800'."),
    (lambda: v.one_of(CALL, "dwon", ["up", "down"]), "is one of 'up', 'down'; got 'dwon'. Did you mean 'down'?"),
    (
        lambda: v.several(CALL, 1, int),
        "must be a tuple of `int`; got 1: one alone is written `(...,)`, with its comma.",
    ),
    (lambda: v.several(CALL, [1, "a"], int), "must be a tuple of `int`; got 'a' at [1]."),
    (lambda: v.several(CALL, (), int, 1), "must be a tuple of at least 1 `int`; got none."),
    (lambda: v.require(CALL, Mute(), Loud), "must be a `Loud`; got a `Mute`."),
    (lambda: v.require(CALL, Mute, Mute), "got the class `Mute` itself: make one with `Mute(...)`."),
]


@pytest.mark.parametrize(("call", "says"), REFUSED, ids=[says[:40] for _, says in REFUSED])
def test_each_word_says_what_it_must_be_and_what_came(call, says):
    with pytest.raises(ValueError) as error:
        call()
    assert says in str(error.value)


def test_a_name_is_refused_with_the_nearest_or_with_all():
    assert v.known_name("q", ["q", "qd"], "states") == "q"
    with pytest.raises(LookupError, match=r"^There is no 'qq' among the 2 states. Did you mean 'q'\?$"):
        v.known_name("qq", ["q", "x"], "states")
    with pytest.raises(LookupError, match="They are: q, x.$"):
        v.known_name("velocity", ["q", "x"], "states")
    with pytest.raises(LookupError, match="The states go by names, which are text; got 3."):
        v.known_name(3, ["q"], "states")
    with pytest.raises(LookupError, match="They are: 1.$"):
        v.known_name("q", {1: "x"}, "states")


ODD = [
    "x" * 10**6,
    list(range(10**6)),
    {i: Mute() for i in range(100)},
    Mute(),
    Loud(),
    10**5000,
    "\x1b[2J",
    b"x" * 999,
]


@pytest.mark.parametrize("value", ODD, ids=lambda value: type(value).__name__)
def test_a_value_is_shown_short_and_without_control_characters(value):
    assert len(v.describe(value)) < 250
    assert v.describe(value).isprintable()


@check_arguments
def taken(
    count: int = 1,
    on: bool = True,
    size: float = 1.0,
    name: str = "x",
    part: Mute | None = None,
    row: Sequence[int] = (),
    pair: tuple[int, str] = (1, "a"),
    either: float | Array = 0.0,
    values: Array | None = None,
    places: Integers | None = None,
    named: Mapping[str, float] | None = None,
    margin: Callable[[float], float] = abs,
    choice: Literal["up", "down"] = "up",
    hidden: SeenByTheTypeChecker[str, int] | None = None,
    any_of: T | None = None,
    many: Iterable[float] = (),
    *rest: int,
    expression: ca.SX | None = None,
    **options: Any,
) -> dict[str, Any]:
    """All that came."""
    return dict(locals())


MADE = [
    ("count", np.int8(3), 3), ("on", np.True_, True), ("size", np.float16(2), 2.0), ("size", 3, 3.0),
    ("size", np.longdouble(2), 2.0), ("name", np.str_("a"), "a"), ("row", [np.int64(1)], (1,)),
    ("row", np.arange(2), (0, 1)), ("pair", [np.int8(1), "b"], (1, "b")), ("either", 2, 2.0),
    ("named", {"a": np.int8(1)}, {"a": 1.0}), ("many", (i for i in range(2)), (0.0, 1.0)), ("part", None, None),
]  # fmt: skip


@pytest.mark.parametrize(("name", "given", "made"), MADE)
def test_an_argument_is_made_to_be_of_its_kind(name, given, made):
    clean = taken(**{name: given})[name]
    assert clean == made
    assert type(clean) is type(made)
    items = clean if isinstance(clean, tuple) else ()
    assert all(type(item) is type(other) for item, other in zip(items, made, strict=True)) if items else True


def test_numbers_on_axes_become_arrays_of_their_kind():
    assert taken(values=[[1, 2]])["values"].dtype == np.float64
    assert taken(either=[1, 2])["either"].shape == (2,)
    assert taken(places=[1.0, 2.0])["places"].dtype.kind == "i"
    assert taken(expression=[1.0, 2.0])["expression"].shape == (2, 1)
    assert taken(1, True, 1.0, "x", None, (), (1, "a"), 0.0, None, None, None, abs, "up", None, 3, (), 4,
                 np.int8(5))["rest"] == (4, 5)  # fmt: skip


NOT_MADE = [
    ("count", 1.5, "`taken(count=...)` must be a whole number; got 1.5."),
    ("count", True, "must be a whole number; got True."),
    ("on", 1, "must be True or False; got 1."),
    ("size", "x", "must be a number; got 'x'."),
    ("size", 10**400, "must be a number; got 1000"),
    ("name", 3, "must be text; got 3."),
    ("name", "\ud800", "must be text; got '\\ud800'."),
    ("part", 3, "must be a `Mute` or None; got 3."),
    ("row", "abc", "must be a tuple of `int`; got 'abc'."),
    ("row", [1, None], "must be a tuple of `int`; got None at [1]."),
    ("row", 3, "must be a tuple of `int`; got 3: one alone is written `(...,)`, with its comma."),
    ("row", Mute(), "must be a tuple of `int`; got a `Mute`."),
    ("row", {1, 2}, "must be a tuple of `int`; got {1, 2}."),
    ("pair", (1,), "must be a tuple of `int` or `str`; got 1 of them."),
    ("either", None, "must be a number or numbers, in an array or lists; got None."),
    ("values", ["a"], "must be numbers, in an array or lists or None; got ['a']."),
    ("places", [1.0, np.inf], "must be whole numbers, in an array or lists or None; got [1.0, inf]."),
    ("places", [1.5], "must be whole numbers, in an array or lists or None; got [1.5]."),
    ("named", {"a": "b"}, "must be a mapping from `str` to `float`, as a dict is or None; got 'b' at ['a']."),
    ("named", [1.0], "got [1.0]."),
    ("margin", 3, "must be a function; got 3."),
    ("choice", "left", "must be one of 'up', 'down'; got 'left'."),
    ("many", [1.0, "a"], "got 'a' at [1]."),
    ("expression", "x", "must be a `SX` or None; got 'x'."),
]


@pytest.mark.parametrize(("name", "value", "says"), NOT_MADE)
def test_an_argument_of_another_kind_is_refused_by_name(name, value, says):
    with pytest.raises(ValueError) as error:
        taken(**{name: value})
    assert says in str(error.value)


def test_a_door_fits_anything_to_what_is_out_of_its_sight():
    assert taken(hidden=3)["hidden"] == 3
    assert taken(any_of="anything", more=5)["options"] == {"more": 5}


def test_a_door_keeps_name_signature_and_words_and_leaves_the_count_of_arguments_to_python():
    assert taken.__name__ == "taken"
    assert taken.__doc__ == "All that came."
    assert "count" in inspect.signature(taken).parameters
    with pytest.raises(TypeError, match="multiple values"):
        taken(1, count=2)


@dataclass(frozen=True)
@check_arguments
class Held:
    """A dataclass with a door and a check of its own."""

    count: int
    parts: tuple[Mute, ...] = ()
    size: float = 1.0

    def __post_init__(self) -> None:
        v.positive("Held(size=...)", self.size)


def test_a_dataclass_has_the_same_door_before_its_own_checks():
    assert type(Held(np.int8(2)).count) is int
    assert Held(1, [mute := Mute()]).parts[0] is mute
    with pytest.raises(ValueError, match=r"^`Held\(parts=...\)` must be a tuple of `Mute`; got 3 at \[0\].$"):
        Held(1, (3,))
    with pytest.raises(ValueError, match=r"^`Held\(size=...\)` must be a number; got 'x'.$"):
        Held(1, size="x")
    with pytest.raises(ValueError, match="must be a positive, finite number; got -1.0."):
        Held(1, size=-1)
