"""Where each number comes from."""

import numpy as np
import pytest

from workbench.report.table_text import unit_of_column
from workbench.study.document.document import TableColumn
from workbench.study.provenance import Card, CardEntry, assumed_entry, derived_entry, stated_entry, value_text


def card() -> Card:
    return Card(
        (
            stated_entry("phi", 0.01, "rad/s", "section 5"),
            derived_entry("M", np.diag([3.0, 1.0]), "kg m^2", "average over q2"),
            assumed_entry("gamma", 5.0, "N m/rad", "not stated", 1.0, 100.0),
            assumed_entry("derivative", "zero", "", "a jump has none"),
        )
    )


def test_a_card_answers_a_name_with_its_value():
    assert card()["phi"] == 0.01


def test_a_misspelt_name_is_answered_with_the_nearest():
    with pytest.raises(LookupError, match="no 'gama' among the 4 numbers on this card. Did you mean 'gamma'"):
        card()["gama"]


def test_a_number_stands_on_a_card_once():
    with pytest.raises(ValueError, match=r"\['phi'\] came more than once"):
        Card((stated_entry("phi", 1.0, "", "a"), stated_entry("phi", 2.0, "", "b")))


def test_an_assumed_number_needs_a_range():
    with pytest.raises(ValueError, match="'gamma'.*needs the range"):
        assumed_entry("gamma", 5.0, "N m/rad", "not stated")


def test_every_number_says_where_it_comes_from():
    with pytest.raises(ValueError, match="must say where"):
        stated_entry("phi", 0.01, "rad/s", "")


def test_there_is_a_table_for_each_origin_and_assumed_numbers_show_their_range():
    assert card().table("stated", "numbers", "All.").rows == (("phi", "0.01", "rad/s", "section 5"),)
    rows = card().table("assumed", "numbers", "All.").rows
    assert rows[0] == ("gamma", "5", "N m/rad", "1 to 100", "not stated")
    assert rows[1] == ("derivative", "zero", None, None, "a jump has none")


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.01, "0.01"),
        ((0.5, 0.4), "(0.5, 0.4)"),
        (np.diag([6.0, 6.0]), "diag(6, 6)"),
        (((1.0, 2.0), (3.0, 4.0)), "(1, 2; 3, 4)"),
        ("zero", "zero"),
    ],
)
def test_a_value_is_written_as_a_person_writes_it(value, text):
    assert value_text(value) == text


@pytest.mark.parametrize(
    ("unit", "printed"),
    [
        ("m^1", "m¹"),
        ("m^-1", "m⁻¹"),
        ("m^(-2)", "m⁻²"),
        ("m^4", "m⁴"),
        ("m^10", "m¹⁰"),
        ("kg m^2/s^2", "kg m²/s²"),
        ("(rad/s^3)^(1/2)", "(rad/s³)^(1/2)"),
        ("s^0.5", "s^0.5"),
        ("N*m", "N·m"),
    ],
)
def test_a_unit_is_the_same_on_a_card_and_at_the_head_of_a_column(unit, printed):
    assert Card((stated_entry("a", 1.0, unit, "here"),)).table("stated", "numbers", "All.").rows[0][2] == printed
    assert unit_of_column(TableColumn("a", unit)) == f"[{printed}]"


@pytest.mark.parametrize("value", [None, float("nan"), float("inf"), [1.0, np.nan], object()])
def test_a_number_that_is_none_does_not_come_on_a_card(value):
    with pytest.raises(ValueError, match=r"`CardEntry\('phi', value=...\)` must be a finite number"):
        stated_entry("phi", value, "rad/s", "section 5")


@pytest.mark.parametrize(
    ("low", "high", "said"),
    [
        (2.0, 1.0, "a range, low <= high"),
        (float("nan"), 1.0, "a finite number"),
        ("a", 1.0, "a number or None; got 'a'"),
    ],
)
def test_a_range_that_is_none_is_refused(low, high, said):
    with pytest.raises(ValueError, match=said):
        assumed_entry("gamma", 1.5, "", "not stated", low, high)


def test_an_unknown_mark_is_refused():
    with pytest.raises(ValueError, match="one of .*'stated', 'derived', 'assumed'.*; got 'guessed'"):
        CardEntry("phi", 1.0, "", "guessed", "section 5")
