"""Blocks refuse what their equations cannot take, and say so."""

import dataclasses

import numpy as np
import pytest

from workbench.core import block, initial, lift, option, parameter
from workbench.core.block import is_block, quantities


@block
class Gain:
    """A block with one field of each kind."""

    K: np.ndarray = parameter(unit="N m", low=0, shape=("n", "n"))
    Lambda: np.ndarray = parameter(unit="1/s", low=0, strict=True, shape=("n",))
    phi: float = parameter(0.1, unit="rad/s", low=0, high=1)
    limit: float | None = parameter(None, unit="N m", low=0)
    start: np.ndarray = initial(0.0, unit="rad", shape=("n",))
    reading: str = option({"outer": "P s sign(s)^T", "diagonal": "diag((P s) o sign(s))"}, default="outer")

    @property
    def dof(self) -> int:
        return 2


def gain(**changes):
    return Gain(**{"K": np.eye(2), "Lambda": [6.0, 6.0], **changes})


def test_a_block_holds_plain_read_only_numbers():
    made = gain()
    assert isinstance(made.phi, float)
    assert made.limit is None
    with pytest.raises(ValueError, match="read-only"):
        made.K[0, 0] = 3.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        made.phi = 0.2


def test_the_block_keeps_a_copy_so_that_its_user_cannot_change_it():
    K = np.eye(2)
    made = gain(K=K)
    K[0, 0] = 9.0
    assert made.K[0, 0] == 1.0


def test_one_number_stands_for_a_vector_of_equal_ones():
    np.testing.assert_array_equal(gain(Lambda=3).Lambda, [3.0, 3.0])
    np.testing.assert_array_equal(gain().start, [0.0, 0.0])


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"Lambda": [6.0, 0.0]}, r"`Gain\(Lambda=...\)` must be finite, with 0 < value \[1/s\]; got \[6., 0.\]"),
        ({"Lambda": [6.0, np.nan]}, "must be finite"),
        ({"phi": 1.5}, r"0 <= value <= 1 \[rad/s\]; got 1.5"),
        ({"phi": np.inf}, "must be finite"),
        ({"phi": "soft"}, "must be a number or an array of numbers; got 'soft'"),
        ({"phi": None}, "must be a number or an array of numbers; got None"),
        ({"phi": "1.0"}, "got .1.0."),
        ({"phi": [0.1, 0.2]}, r"must be a single number; got shape \(2,\)"),
        ({"K": 1.0}, r"an array of shape \(n = 2, n = 2\); got shape \(\)"),
        ({"K": np.ones((2, 3))}, r"got shape \(2, 3\)"),
        ({"Lambda": [1.0, 2.0, 3.0]}, r"an array of shape \(n = 2\); got shape \(3,\)"),
        ({"Lambda": [[1.0], [2.0, 3.0]]}, "must be a number or an array of numbers"),
        ({"limit": -1.0}, r"0 <= value \[N m\]; got -1"),
        ({"reading": "inner"}, "one of 'outer', 'diagonal'; got 'inner'"),
        ({"reading": "diagonl"}, "Did you mean 'diagonal'?"),
    ],
)
def test_a_number_that_the_equations_cannot_take_is_refused(changes, says):
    with pytest.raises(ValueError, match=says):
        gain(**changes)


def test_the_sizes_of_vectors_must_agree_among_the_fields_where_no_dof_is_known():
    @block
    class Pair:
        a: np.ndarray = parameter(unit="", shape=("n",))
        b: np.ndarray = parameter(unit="", shape=("n",))

    assert Pair([1.0, 2.0], [3.0, 4.0]).a.shape == (2,)
    with pytest.raises(ValueError, match=r"`Pair\(b=...\)` must be an array of shape \(n = 2\)"):
        Pair([1.0, 2.0], [3.0, 4.0, 5.0])


def test_a_block_can_check_its_fields_together_once_they_are_numbers():
    @block
    class Range:
        low: float = parameter(unit="m")
        high: float = parameter(unit="m")

        def __post_init__(self) -> None:
            if not self.low < self.high:
                raise ValueError("`Range(...)` needs low < high.")

    assert Range(0, 1).high == 1.0
    with pytest.raises(ValueError, match="low < high"):
        Range(1, 0)


def test_quantities_have_units():
    units = {f.name: q.unit for f, q in quantities(gain())}
    assert units == {"K": "N m", "Lambda": "1/s", "phi": "rad/s", "limit": "N m", "start": "rad"}
    assert is_block(gain())
    assert not is_block(Gain)
    assert not is_block(3.0)


@block
class Limit:
    """A block whose numbers are one for all of its signal or one for each."""

    unit: str
    low: object = parameter(unit="{unit}", shape=("*",))
    rate: object = parameter(unit="{unit}/s", shape=("*",))
    time: float = parameter(1.0, unit="s")


def test_a_number_of_any_shape_is_one_or_a_vector_as_long_as_the_others():
    mixed = lift(Limit("V", -1.0, [2.0, 3.0])).layout
    assert [entry.shape for entry in mixed.entries] == [(), (2,), ()]
    with pytest.raises(ValueError, match=r"`Limit\(rate=...\)` must be a number or a vector of 2 numbers; got shape"):
        Limit("V", [1.0, 2.0], [1.0, 2.0, 3.0])
    with pytest.raises(ValueError, match=r"`Limit\(low=...\)` must be a number or a vector of numbers; got shape"):
        Limit("V", np.eye(2), 1.0)


@pytest.mark.parametrize(
    ("unit", "rate"),
    [("V", "V/s"), ("rad/s", "rad/s^2"), ("", "1/s"), ("m, rad", "m/s, rad/s"), ("m, rad, m", "m/s, rad/s, m/s")],
)
def test_a_unit_that_names_that_of_a_signal_follows_each_of_its_units(unit, rate):
    layout = lift(Limit(unit, -1.0, 2.0)).layout
    assert [entry.unit for entry in layout.entries] == [unit, rate, "s"]


def test_the_help_of_a_block_names_three_axes_and_calls_no_factory_of_a_user():
    def refuse():
        raise AssertionError("called before an object is made")

    @block
    class Cube:
        """A block of stiffnesses."""

        T: object = parameter(unit="N/m", shape=("n", "n", "n"))
        I: object = parameter(default=(1.0, 2.0), unit="kg", shape=("2",))
        other: object = dataclasses.field(default_factory=refuse)

    assert Cube.__doc__.splitlines()[-3:] == [
        "T : array (n, n, n) [N/m]",
        "I : vector (2,) [kg], default (1.0, 2.0)",
        "other : object, optional",
    ]
