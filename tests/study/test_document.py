from fractions import Fraction

import numpy as np
import pytest

from workbench.core.notation.formula import symbol
from workbench.report.html_page import html
from workbench.report.table_text import to_csv, to_latex
from workbench.study.document.document import (
    Band,
    BoldCell,
    Code,
    Colophon,
    CrossReference,
    DivergedCell,
    Document,
    Equation,
    Figure,
    Itemize,
    Panel,
    Paragraph,
    ReportTable,
    Section,
    Series,
    TableColumn,
    ValueWithError,
    Verdict,
)
from workbench.study.study import Study

COLOPHON = Colophon("workbench run a1", "0.1.0")


def table(name="rmse", rows=(("PID", 0.5),), **more):
    return ReportTable(name, "RMSE", (TableColumn("law"), TableColumn("RMSE", "rad")), rows, **more)


def document(*blocks, **more):
    words = {"title": "A study", "question": "Why?", "method": "By running it."} | more
    return Document(sections=(Section("Results", blocks),), colophon=COLOPHON, **words)


@pytest.mark.parametrize("name", ["../rmse", "a/b", "", "RMSE", "a.b", "a b", "rmse\n", "a" * 81, None, b"a", 1.0])
def test_a_name_that_could_leave_its_folder_is_refused(name):
    with pytest.raises(ValueError, match=r"becomes the name of a file|`ReportTable\(name=...\)` must be text"):
        table(name)
    with pytest.raises(ValueError, match=r"becomes the name of a file|`Figure\(name=...\)` must be text"):
        Figure(name, "", (Panel("y", (Series("a", [0, 1], [0, 1]),)),))


@pytest.mark.parametrize("cell", [float("nan"), np.float64("nan"), BoldCell(float("nan"))])
def test_a_nan_cell_is_refused_by_table_column_and_row(cell):
    with pytest.raises(ValueError, match=r"'rmse'.*column 'RMSE', row 2.*Diverged.*None"):
        table(rows=(("PID", 0.5), ("SMC", cell)))


@pytest.mark.parametrize(
    "pair", [(float("nan"), 0.1), (0.1, float("nan")), (0.1, float("inf")), (float("inf"), 0.1), (0.1, -0.1)]
)
def test_a_measured_value_without_a_finite_error_is_refused(pair):
    with pytest.raises(ValueError, match="finite"):
        ValueWithError(*pair)


def test_a_row_of_the_wrong_length_is_refused():
    with pytest.raises(ValueError, match="2 columns; its row 1 has 3 cells"):
        table(rows=(("PID", 0.5, 0.6),))


def test_numbers_of_numpy_become_plain_ones():
    row = table(rows=((np.str_("PID"), np.float64(0.5)), ("n", np.int64(3)), ("ok", np.bool_(True)))).rows
    assert [type(cells[1]) for cells in row] == [float, int, bool]


def test_a_reference_to_nothing_is_refused_with_the_nearest_name():
    with pytest.raises(LookupError, match=r"'rsme'.*Did you mean 'rmse'"):
        document(table(), Paragraph(("See ", CrossReference("rsme"), ".")))


def test_a_reference_is_found_wherever_words_stand():
    reference = ("See ", CrossReference("mass"), ".")
    made = document(
        Equation(symbol("M"), "mass", note=reference),
        table(rows=((reference, DivergedCell(3.0)),), notes=(reference,)),
        Verdict("open", reference, reference),
        question=reference,
        method=reference,
    )
    assert made.question == made.method == reference


def test_two_blocks_of_one_name_are_refused():
    with pytest.raises(ValueError, match=r"\['rmse'\] came more than once"):
        document(table(), table())


def test_a_verdict_knows_three_words():
    with pytest.raises(ValueError, match="one of 'holds', 'fails', 'open'; got 'maybe'"):
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


@pytest.mark.parametrize("style", [12, -1, np.int64(12)])
def test_an_unknown_style_is_refused(style):
    with pytest.raises(ValueError, match="0 to 11"):
        Series("a", [0], [0], style)


def test_empty_panels_and_reversed_limits_are_refused():
    with pytest.raises(ValueError, match="at least one series"):
        Panel("y", ())
    with pytest.raises(ValueError, match="low < high"):
        Panel("y", (Series("a", [0], [0]),), xlim=(1, 0))
    with pytest.raises(ValueError, match="at least one panel"):
        Figure("f", "", ())


def test_a_text_among_the_blocks_of_a_section_is_refused_and_not_lost():
    with pytest.raises(
        ValueError, match=r"`Section\(blocks=...\)`.*got 'The stiffer law wins.': wrap text in `Paragraph"
    ):
        Section("Tracking", (table(), "The stiffer law wins."))


def test_a_block_alone_is_refused_with_its_comma():
    with pytest.raises(ValueError, match=r"got a `ReportTable`: one alone is written `\(...,\)`"):
        Section("T", table())


def test_a_list_serves_where_a_tuple_is_asked_for():
    section = Section("T", [table(), Itemize(["a", symbol("q")])])
    assert isinstance(section.blocks, tuple)
    assert section.blocks[1].items == ("a", symbol("q"))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (
            lambda: TableColumn("a", digits=0),
            r"`TableColumn\(digits=...\)` must be a whole number of significant digits.*got 0",
        ),
        (lambda: TableColumn("a", digits=2.0), r"`TableColumn\(digits=...\)` must be a whole number"),
        (
            lambda: TableColumn("a", width=0),
            r"`TableColumn\(width=...\)` must be a whole number of letters in a line.*got 0",
        ),
        (lambda: TableColumn("a", align="middle"), "'middle'"),
        (lambda: table(rows=(("PID", 1 + 2j),)), r"`ReportTable\(rows=...\)`.*got \(1\+2j\) at \[0\]\[1\]"),
        (lambda: table(rows=(("PID", [1.0]),)), r"`ReportTable\(rows=...\)`.*at \[0\]\[1\]"),
        (lambda: table(rows=(("PID", np.zeros(2)),)), r"`ReportTable\(rows=...\)`.*at \[0\]\[1\]"),
        (lambda: table(rows=(("PID", 10**400),)), "a number beyond 1.8e308 in column 'RMSE', row 1"),
        (lambda: DivergedCell(None), "`Diverged"),
        (lambda: Equation("M = 1"), r"`Equation\(formulas=...\)`.*'M = 1'"),
        (lambda: Panel("y", Series("a", [0], [0])), r"got a `Series`: one alone is written `\(...,\)`"),
        (lambda: Figure("f", "", Panel("y", (Series("a", [0], [0]),))), r"one alone is written `\(...,\)`"),
    ],
)
def test_what_cannot_be_printed_is_refused_where_it_is_said(make, words):
    with pytest.raises(ValueError, match=words):
        make()


class Nameless:
    """An object that cannot be printed, compared or asked whether it is true."""

    def __repr__(self):
        raise RuntimeError("no name")

    def __eq__(self, other):
        raise RuntimeError("no equal")

    def __bool__(self):
        raise RuntimeError("no truth")

    __hash__ = None


class Endless(list):
    def __iter__(self):
        raise ZeroDivisionError("no items")


ODD = [
    None, True, float("nan"), float("inf"), 5e-324, 10**400, 10**5000, -1, 2.0, np.int8(3), np.int64(2),
    np.float32(0.5), np.array([1, 2]), np.datetime64("2020-01-01"), b"x", int, ReportTable,
    [], (), {}, [[1], [2]], "x" * 999,
    "a\x00\x1b\n",
    "\ud800", "", Nameless(), Endless([1]), Fraction(1, 3), 1j, symbol("q"), ValueWithError(1, 2), Code("c"), ("a", ()),
    CrossReference("t"), "-1",
]  # fmt: skip
PANELS = (Panel("y", (Series("a", [0, 1], [0, 1]),)),)
ONE = (TableColumn("a"),)
MAKERS = [
    Code, CrossReference, DivergedCell, Paragraph, Itemize, Equation,
    lambda x: ValueWithError(x, 0.1), lambda x: ValueWithError(1.0, x), lambda x: ReportTable("t", "", ONE,
    ((BoldCell(x),),)), TableColumn, lambda x: TableColumn("a", x), lambda x: TableColumn("a", align=x), lambda x:
    TableColumn("a", digits=x), lambda x: ReportTable(x, "", ONE, ((1,),)), lambda x: ReportTable("t", x, ONE, ((1,),)),
    lambda x: ReportTable("t",
    "", x, ((1,),)), lambda x: ReportTable("t", "", ONE, x), lambda x: ReportTable("t", "", ONE, (x,)), lambda x:
    ReportTable("t", "", ONE, ((x,),)), lambda x: ReportTable("t", "", ONE, ((1,),), x), lambda x: Figure(x, "",
    PANELS), lambda x: Figure("f", x, PANELS), lambda x: Figure("f", "", x), lambda x: Figure("f", "", PANELS, x),
    lambda x: Figure("f",
    "", PANELS, 1, x), lambda x: Itemize((x,)), lambda x: Equation(symbol("q"), x), lambda x: Equation(symbol("q"), "e",
    x), lambda x: Verdict(x, "s"), lambda x: Verdict("open", x), lambda x: Section(x, ()), lambda x: Section("s", x),
    lambda x: Section("s", (x,)),
]  # fmt: skip


def printed(made):
    """The page and the files of tables that hold what was made."""
    if isinstance(made, (Code, CrossReference)):
        made = Paragraph(made)
    if isinstance(made, (ValueWithError, DivergedCell)):
        made = ReportTable("t", "", ONE, ((made,),))
    if isinstance(made, TableColumn):
        made = ReportTable("t", "", (made,), ((1.25,), ("w",)))
    if not isinstance(made, (Document, Section)):
        blocks = (made,) if getattr(made, "name", "") == "t" else (made, ReportTable("t", "", ONE, ((1,),)))
        made = Section("s", blocks)
    made = made if isinstance(made, Document) else Document("t", "q", "m", (made,), COLOPHON)
    return [html(made), *(write(table) for table in made.tables for write in (to_csv, to_latex))]


@pytest.mark.parametrize("number", range(len(ODD)))
def test_whatever_comes_is_refused_in_one_sentence_or_printed(number):
    said = []
    for maker in MAKERS:
        try:
            said += [text.encode() for text in printed(maker(ODD[number]))]
        except (ValueError, LookupError) as refusal:
            said.append(refusal)
    refusals = [refusal for refusal in said if not isinstance(refusal, bytes)]
    assert {type(refusal) for refusal in refusals} <= {ValueError, LookupError}
    assert all(str(refusal).startswith(("`", "There is no")) and len(str(refusal)) < 700 for refusal in refusals)
    assert len(said) >= len(MAKERS)


def test_whole_numbers_of_numpy_count_digits_and_columns():
    assert type(TableColumn("a", digits=np.int64(3)).digits) is int
    assert type(Figure("f", "", PANELS, np.int8(2)).columns) is int
    with pytest.raises(ValueError, match="1 to 3 columns"):
        Figure("f", "", PANELS, 4)


@pytest.mark.parametrize(
    "make",
    [lambda name: Study(name, "t", "q", "m", lambda results: []), table, lambda name: Figure(name, "", PANELS)],
)
def test_one_rule_for_names_says_how_long_they_may_be(make):
    make("a" * 80)
    with pytest.raises(ValueError, match=r"\(name\)` must be made of a-z, 0-9 and _, 1 to 80.*of 300 letters"):
        make("a" * 300)
