"""Names to slices of a flat vector, and back."""

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.core import Entry, Layout, Signals
from workbench.core.numbers import Bounds

FINITE = st.floats(-1e6, 1e6)
SHAPES = st.sampled_from([(), (1,), (3,), (2, 2), (2, 3), (1, 4)])


@st.composite
def layouts(draw):
    shapes = draw(st.lists(SHAPES, min_size=1, max_size=4))
    return Layout(tuple(Entry(f"part{i}.a", np.full(shape, draw(FINITE))) for i, shape in enumerate(shapes)))


def gains() -> Layout:
    return Layout(
        (
            Entry("controller.gamma", np.array(2.0), "1/s", Bounds(0, 10, strict=True)),
            Entry("K", np.array([[1.0, 2.0], [3.0, 4.0]]), "N m"),
            Entry("plant.q", np.zeros(3), "rad", symbol="q"),
        )
    )


@given(layouts(), st.integers(1, 4), st.randoms())
def test_unpack_undoes_pack_for_any_shapes_and_batches(layout, runs, random):
    values = {
        e.name: np.array([random.uniform(-9, 9) for _ in range(runs * e.size)]).reshape(runs, *e.shape)
        for e in layout.entries
    }
    rows = layout.pack(values)
    assert rows.shape == (runs, layout.size)
    for name, value in layout.unpack(rows).items():
        np.testing.assert_array_equal(value, values[name])


@given(layouts())
def test_nothing_named_gives_the_defaults(layout):
    np.testing.assert_array_equal(layout.pack(), layout.default[None])
    assert len(layout.labels) == layout.size


def test_matrices_lie_column_by_column_as_in_casadi():
    layout = gains()
    assert layout.labels[1:5] == ("K[0,0]", "K[1,0]", "K[0,1]", "K[1,1]")
    np.testing.assert_array_equal(layout.default[layout.slice("K")], [1, 3, 2, 4])
    view = layout.view(ca.DM(layout.default))
    np.testing.assert_array_equal(np.array(view["K"]), layout["K"].default)


def test_the_view_and_flatten_of_symbols_undo_each_other():
    layout = gains()
    x = layout.symbols()
    assert ca.is_equal(layout.flatten(layout.view(x)), x, 1)
    assert [x[i].name() for i in range(layout.size)] == list(layout.labels)


def test_one_number_of_a_matrix_can_be_set_by_name():
    rows = gains().pack({"K[0,1]": [7.0, 8.0]})
    np.testing.assert_array_equal(gains().unpack(rows)["K"][:, 0, 1], [7, 8])
    np.testing.assert_array_equal(gains().unpack(rows)["K"][:, 1, 0], [3, 3])


def test_what_is_named_once_is_the_same_in_every_run_of_the_batch():
    rows = gains().pack({"controller.gamma": [1.0, 2.0, 3.0], "plant.q": [1.0, 2.0, 3.0]})
    assert rows.shape == (3, gains().size)
    np.testing.assert_array_equal(gains().unpack(rows)["plant.q"], np.tile([1.0, 2.0, 3.0], (3, 1)))


@pytest.mark.parametrize(
    ("values", "error", "says"),
    [
        ({"controller.gama": 1.0}, LookupError, "Did you mean 'controller.gamma'?"),
        ({"K[0,2]": 1.0}, LookupError, r"'K' has shape \(2, 2\): there is no 'K\[0,2\]'"),
        ({"controller.gamma": 0.0}, ValueError, r"0 < value < 10 \[1/s\]; got 0"),
        ({"controller.gamma": [1.0, 11.0]}, ValueError, "got 11 in run 1"),
        ({"plant.q": [0.0, np.nan, 0.0]}, ValueError, r"'plant.q\[1\]' must be finite \[rad\]; got nan"),
        ({"plant.q": [0.0, np.inf, 0.0]}, ValueError, "got inf"),
        ({"controller.gamma": "fast"}, ValueError, "must be a number or an array; got 'fast'"),
        ({"controller.gamma": [[1.0, 2.0]]}, ValueError, "must have shape"),
        ({"plant.q": [1.0, 2.0]}, ValueError, r"must have shape \(3,\)"),
        ({"plant.q": np.zeros((0, 3))}, ValueError, "must have shape"),
        ({"K": np.zeros((2, 2, 3))}, ValueError, "must have shape"),
        ({"controller.gamma": [1.0, 2.0], "plant.q": np.zeros((3, 3))}, ValueError, "columns of \\[2, 3\\] runs"),
        ({"controller.gamma": None}, ValueError, "must be a number or an array; got None"),
        ({"controller.gamma": "2.0"}, ValueError, "got .2.0."),
    ],
)
def test_what_cannot_be_packed_is_refused_by_name(values, error, says):
    with pytest.raises(error, match=says):
        gains().pack(values)


def test_two_entries_of_one_name_are_refused():
    with pytest.raises(ValueError, match="distinct names"):
        Layout((Entry("a", np.array(0.0)), Entry("a", np.array(1.0))))


def test_a_vector_of_the_wrong_length_is_refused():
    with pytest.raises(ValueError, match=r"vectors of 8 numbers; got shape \(2, 7\)"):
        gains().unpack(np.zeros((2, 7)))


def test_flatten_refuses_missing_and_misshapen_parts():
    layout = gains()
    parts = layout.view(layout.symbols())
    with pytest.raises(LookupError, match="plant.q"):
        layout.flatten({name: part for name, part in parts.items() if name != "plant.q"})
    with pytest.raises(ValueError, match=r"'K' must have shape \(2, 2\)"):
        layout.flatten({**parts, "K": ca.SX(2, 1)})


def test_an_unknown_name_far_from_all_lists_what_there_is():
    with pytest.raises(LookupError, match="They are: controller.gamma, K, plant.q"):
        gains().slice("zzzzzz")


def test_numbers_are_printed_with_the_indices_of_a_book():
    assert gains().printed_names()["K[0,1]"] == "K_12"
    assert gains().printed_names()["plant.q[2]"] == "q_3"
    assert gains().printed_names()["controller.gamma"] == "gamma"


def test_layouts_join_and_take_prefixes():
    both = gains() + Layout((Entry("t", np.array(0.0)),)).with_prefix("clock.")
    assert both.names[-1] == "clock.t"
    assert both.indices("clock.t") == [8]
    assert "clock.t" in both
    assert "t" not in both


def test_an_empty_layout_is_a_vector_of_no_numbers():
    assert Layout().size == 0
    assert Layout().pack().shape == (1, 0)
    assert Layout().symbols().shape == (0, 1)


def test_a_symmetric_matrix_is_refused_when_only_one_of_a_pair_is_set():
    layout = Layout((Entry("R", np.eye(2), bounds=Bounds(symmetric=True)),))
    with pytest.raises(ValueError, match=r"'R' must be symmetric; got 0.5 at \[0,1\] and 0 at \[1,0\]: set both"):
        layout.pack({"R[0,1]": 0.5})
    rows = layout.pack({"R[0,1]": [0.1, 0.2], "R[1,0]": [0.1, 0.2]})
    np.testing.assert_array_equal(layout.unpack(rows)["R"][1], [[1, 0.2], [0.2, 1]])


@pytest.mark.parametrize("default", [None, "1.0", np.zeros((2, 2, 2)), [[1.0], [2.0, 3.0]]])
def test_a_default_that_is_no_number_vector_or_matrix_is_refused(default):
    with pytest.raises(
        ValueError,
        match=r"`Entry\(default=...\)` must be .*; got",
    ):
        Entry("a", default)


def test_an_entry_keeps_a_frozen_copy_of_its_default():
    mine = np.zeros(2)
    entry = Entry("a", mine)
    mine[0] = 9.0
    np.testing.assert_array_equal(entry.default, [0.0, 0.0])
    with pytest.raises(ValueError, match="read-only"):
        entry.default[0] = 9.0


@pytest.mark.parametrize("look", [lambda at: at[0], lambda at: at.slice(["K"]), lambda at: at.pack({1: 2})])
def test_a_name_that_is_no_text_is_refused(look):
    with pytest.raises(LookupError, match="The entries of this layout go by names, which are text; got"):
        look(gains())
    assert 0 not in gains()
    assert ["K"] not in gains()


def test_values_without_names_are_refused():
    with pytest.raises(
        ValueError,
        match=r"`pack\(values=...\)` must be a mapping from names to numbers, .*; got .1.0",
    ):
        gains().pack([1.0, 2.0])


def test_definiteness_is_asked_of_symmetric_matrices_only():
    with pytest.raises(ValueError, match=r"`Bounds\(definite='semi'\)` is for `symmetric` matrices"):
        Bounds(definite="semi")
    with pytest.raises(ValueError, match="got 'negative'"):
        Bounds(symmetric=True, definite="negative")


def test_signals_say_which_names_they_have():
    signals = Signals(q=ca.SX(1))
    assert "q" in signals
    assert "d" not in signals
