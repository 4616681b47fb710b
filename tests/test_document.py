import numpy as np
import pytest

from workbench.notation.formula import symbol
from workbench.study.document import (
    Band,
    Colophon,
    Column,
    Diverged,
    Document,
    Emphasis,
    Equation,
    Figure,
    Measured,
    Panel,
    Paragraph,
    Reference,
    Section,
    Series,
    Table,
    Verdict,
)

COLOPHON = Colophon("workbench run a1", "0.1.0")


def table(name="rmse", rows=(("PID", 0.5),), **more):
    return Table(name, "RMSE", (Column("law"), Column("RMSE", "rad")), rows, **more)


def document(*blocks, **more):
    words = {"title": "A study", "question": "Why?", "method": "By running it."} | more
    return Document(sections=(Section("Results", blocks),), colophon=COLOPHON, **words)


@pytest.mark.parametrize("name", ["../rmse", "a/b", "", "RMSE", "a.b", "a b", "rmse\n"])
def test_a_name_that_could_leave_its_folder_is_refused(name):
    with pytest.raises(ValueError, match="becomes the name of a file"):
        table(name)
    with pytest.raises(ValueError, match="becomes the name of a file"):
        Figure(name, "", (Panel("y", (Series("a", [0, 1], [0, 1]),)),))


@pytest.mark.parametrize("cell", [float("nan"), np.float64("nan"), Emphasis(float("nan"))])
def test_a_nan_cell_is_refused_by_table_column_and_row(cell):
    with pytest.raises(ValueError, match=r"'rmse'.*column 'RMSE', row 2.*Diverged.*None"):
        table(rows=(("PID", 0.5), ("SMC", cell)))


@pytest.mark.parametrize(
    "pair", [(float("nan"), 0.1), (0.1, float("nan")), (0.1, float("inf")), (float("inf"), 0.1), (0.1, -0.1)]
)
def test_a_measured_value_without_a_finite_error_is_refused(pair):
    with pytest.raises(ValueError, match="finite"):
        Measured(*pair)


def test_a_row_of_the_wrong_length_is_refused():
    with pytest.raises(ValueError, match="2 columns; its row 1 has 3 cells"):
        table(rows=(("PID", 0.5, 0.6),))


def test_numbers_of_numpy_become_plain_ones():
    row = table(rows=((np.str_("PID"), np.float64(0.5)), ("n", np.int64(3)), ("ok", np.bool_(True)))).rows
    assert [type(cells[1]) for cells in row] == [float, int, bool]


def test_a_reference_to_nothing_is_refused_with_the_nearest_name():
    with pytest.raises(LookupError, match=r"'rsme'.*Did you mean 'rmse'"):
        document(table(), Paragraph(("See ", Reference("rsme"), ".")))


def test_a_reference_is_found_wherever_words_stand():
    reference = ("See ", Reference("mass"), ".")
    document(
        Equation(symbol("M"), "mass", note=reference),
        table(rows=((reference, Diverged(3.0)),), notes=(reference,)),
        Verdict("open", reference, reference),
        question=reference,
        method=reference,
    )


def test_two_blocks_of_one_name_are_refused():
    with pytest.raises(ValueError, match=r"\['rmse'\] came more than once"):
        document(table(), table())


def test_a_verdict_knows_three_words():
    with pytest.raises(ValueError, match="'holds', 'fails' or 'open'"):
        Verdict("maybe", "It works.")


@pytest.mark.parametrize(
    ("x", "y"), [([0, 1], [0]), ([], []), ([0, np.nan], [0, 1]), ([0, 1], [0, np.inf]), ([[0, 1]], [[0, 1]])]
)
def test_a_series_that_is_no_curve_is_refused(x, y):
    with pytest.raises(ValueError, match="Series"):
        Series("a", x, y)


def test_a_gap_is_allowed_in_a_series_but_not_in_a_band():
    Series("a", [0, 1, 2], [0, np.nan, 1])
    with pytest.raises(ValueError, match="finite"):
        Band("a", [0, 1, 2], [0, np.nan, 1], [1, 1, 1])


def test_a_series_keeps_its_numbers_when_the_callers_array_changes():
    y = np.zeros(3)
    series = Series("a", [0, 1, 2], y)
    y[:] = 7
    assert np.asarray(series.y).max() == 0


def test_a_logarithmic_axis_refuses_numbers_without_a_logarithm():
    with pytest.raises(ValueError, match="> 0"):
        Panel("y", (Series("a", [0, 1], [1, 0]),), yscale="log")


@pytest.mark.parametrize("style", [8, -1, "solid"])
def test_an_unknown_style_is_refused(style):
    with pytest.raises(ValueError, match="0 to 7"):
        Series("a", [0], [0], style)


def test_empty_panels_and_reversed_limits_are_refused():
    with pytest.raises(ValueError, match="at least one series"):
        Panel("y", ())
    with pytest.raises(ValueError, match="low < high"):
        Panel("y", (Series("a", [0], [0]),), xlim=(1, 0))
    with pytest.raises(ValueError, match="at least one panel"):
        Figure("f", "", ())
