import numpy as np
import pytest

from workbench.notation.formula import symbol
from workbench.study.document import (
    Band,
    Code,
    Colophon,
    Column,
    Diverged,
    Document,
    Emphasis,
    Equation,
    Figure,
    Itemize,
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


@pytest.mark.parametrize("wrong", [{"ylim": (0, 1)}, {"hlines": (-1.0,)}])
def test_a_logarithmic_axis_refuses_limits_and_lines_without_a_logarithm(wrong):
    with pytest.raises(ValueError, match=r"Panel\(yscale='log'\).*limits and lines > 0"):
        Panel("y", (Series("a", [0, 1], [1, 2]),), yscale="log", **wrong)


@pytest.mark.parametrize("style", [8, -1, np.int64(8)])
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


def test_a_text_among_the_blocks_of_a_section_is_refused_and_not_lost():
    with pytest.raises(ValueError, match=r"`Section\('Tracking', blocks\)`.*got str: wrap text in `Paragraph"):
        Section("Tracking", (table(), "The stiffer law wins."))


def test_a_block_alone_is_refused_with_its_comma():
    with pytest.raises(ValueError, match=r"tuple of blocks; got Table.*written `\(block,\)`"):
        Section("T", table())


def test_a_list_serves_where_a_tuple_is_asked_for():
    section = Section("T", [table(), Itemize(["a", symbol("q")])])
    assert isinstance(section.blocks, tuple)
    assert section.blocks[1].items == ("a", symbol("q"))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Paragraph(3), r"`Paragraph\(text\)` must be text.*got int 3"),
        (lambda: Paragraph(("a", ["b"])), r"`Paragraph\(text\)` must be text.*got list"),
        (lambda: Itemize("ab"), r"`Itemize\(items\)` must be a tuple of texts; got str 'ab'"),
        (lambda: Code(3), r"`Code\(text\)` must be text; got int 3"),
        (lambda: Column("a", digits=0), r"`Column\(digits=...\)` counts significant digits.*got 0"),
        (lambda: Column("a", digits=2.0), "counts significant digits"),
        (lambda: Column("a", align="middle"), "'middle'"),
        (lambda: table(rows=(("PID", 1 + 2j),)), r"column 'RMSE', row 1.*got complex"),
        (lambda: table(rows=(("PID", [1.0]),)), r"column 'RMSE', row 1.*got list"),
        (lambda: table(rows=(("PID", np.zeros(2)),)), r"column 'RMSE', row 1.*got ndarray"),
        (lambda: table(notes="one"), r"notes=...\)` must be a tuple of texts"),
        (lambda: Measured("a", 0.1), "finite value"),
        (lambda: Diverged(None), "`Diverged"),
        (lambda: Verdict("open", None), r"`Verdict\(statement\)` must be text.*got None"),
        (lambda: Equation("M = 1"), r"`Equation\(formulas\)`.*'M = 1'"),
        (lambda: Series(3, [0], [0]), r"`Series\(label=...\)` must be text or a `Number`"),
        (lambda: Panel("y", Series("a", [0], [0])), r"got a `Series`: one alone is written `\(...,\)`"),
        (lambda: Figure("f", "", Panel("y", (Series("a", [0], [0]),))), r"one panel alone is written `\(panel,\)`"),
        (lambda: document(title=None), r"`Document\(title=...\)` must be text; got None"),
        (lambda: document(title=3), r"`Document\(title=...\)` must be text; got int 3"),
        (lambda: document(authors="me"), "list of texts"),
    ],
)
def test_what_cannot_be_printed_is_refused_where_it_is_said(make, words):
    with pytest.raises(ValueError, match=words):
        make()
