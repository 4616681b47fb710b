"""Statements taken apart: names, places, and what is not read because it could mean two things."""

import pytest

from workbench.printed.statements import statements
from workbench.printed.tokens import FormulaError

REFUSED = {
    "C(2,1) = q_1": "line 1, column 2: in round brackets stand arguments; for an entry write C[2,1].",
    "G(1) = q_1": "line 1, column 2: in round brackets stand arguments; for an entry write G[1].",
}


@pytest.mark.parametrize("said", REFUSED)
def test_what_could_mean_two_things_is_refused_with_what_to_write(said):
    with pytest.raises(FormulaError) as refusal:
        statements(said, "latex" if "\\" in said else "text")
    assert str(refusal.value) == REFUSED[said]


def test_braces_around_a_name_change_nothing():
    (braced,), (bare,) = (statements(f"{name} = m_1", "latex") for name in (r"{{C}_{21}}", "C_{21}"))
    assert (braced.name.text, braced.name.index, braced.place) == (bare.name.text, bare.name.index, bare.place)


def test_arguments_of_a_matrix_are_no_place():
    (statement,) = statements("C(q, qd) = m_1", "text")
    assert (statement.name.text, statement.place) == ("C", ())
