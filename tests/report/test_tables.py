import csv
import io
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.core.notation.formula import symbol
from workbench.report.number_text import number_text, number_text_with_error, paddings
from workbench.report.outline import notes
from workbench.report.table_text import BRACKETS, alignments, grid, to_csv, to_latex
from workbench.study.document.document import (
    BoldCell,
    Code,
    Colophon,
    DivergedCell,
    Document,
    ReportTable,
    Section,
    TableColumn,
    ValueWithError,
)
from workbench.study.run_tables import spreadsheet_text

LAW_AND_RMSE = (TableColumn("law"), TableColumn("RMSE", "rad"))
PLAIN = TableColumn("x")


def table(*rows, columns=LAW_AND_RMSE, **more):
    return ReportTable("t", "A caption", columns, rows, **more)


def cells(*values, column=PLAIN):
    shown = grid(ReportTable("t", "", (column,), tuple((value,) for value in values)))
    return [str(row[0].content) for row in shown]


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (0.35321, 0.0002, "0.3532(2)"),
        (0.35321, 0.00012, "0.35321(12)"),
        (12.34, 0.26, "12.3(3)"),
        (480.4, 30.0, "480(30)"),
        (16320.0, 800.0, "16300(800)"),
        (1234.5, 12.0, "1234(12)"),
        (-0.5, 0.1, "−0.50(10)"),
        (0.0003, 0.002, "0.000(2)"),
        (2.345e-5, 1.2e-7, "2.345(12)e-5"),
        (1.5e7, 2e4, "1.500(2)e7"),
        (0.5, 0.0, "0.50000"),
        (0.3532, 1e-12, "0.35320"),
        (0.0, 0.0, "0"),
        (9.9996, 0.0004, "9.9996(4)"),
        (99.96, 0.96, "100.0(10)"),
    ],
)
def test_the_digits_shown_are_those_that_the_error_supports(value, error, text):
    assert str(number_text_with_error(value, error)) == text


@given(st.floats(-1e8, 1e8), st.floats(1e-9, 1e8))
def test_what_is_printed_lies_within_the_error_that_is_printed(value, error):
    """Half a unit of the last digit is at most half the printed error's unit, so value and error survive printing."""
    number = number_text_with_error(value, error)
    scale = 10.0 ** int(number.power.replace("−", "-") or 0)
    tail, _, bracket = number.tail.partition("(")
    shown = float(f"{number.sign}{number.whole}{tail}".replace("−", "-")) * scale
    if not bracket:  # the error is below the last of five digits
        assert shown == pytest.approx(value, rel=5.1e-5)
        return
    decimals = len(tail.removeprefix("."))
    unit = float(bracket.rstrip(")")) * 10.0**-decimals * scale
    assert 0.75 * error <= unit <= 1.35 * error + 10.0**-decimals * scale
    assert abs(shown - value) <= 0.6 * unit


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.5, "0.5"),
        (9.81, "9.81"),
        (1.0, "1"),
        (0.123456, "0.1235"),
        (0.44598, "0.4460"),
        (12345.6, "12346"),
        (1.5e-7, "1.5e-7"),
        (2e5, "2e5"),
        (0.0, "0"),
        (-0.0, "0"),
        (math.inf, "∞"),
        (-math.inf, "−∞"),
        (65536, "65\u2009536"),
        (-17, "−17"),
    ],
)
def test_a_plain_number_has_four_digits_or_fewer_if_they_are_exact(value, text):
    assert str(number_text(value)) == text


def test_a_column_may_ask_for_its_digits():
    assert cells(0.233, 0.5, column=TableColumn("x", digits=4)) == ["0.2330", "0.5000"]


@given(st.lists(st.tuples(st.floats(-1e9, 1e9), st.floats(0, 1e3)), min_size=1, max_size=8))
def test_every_number_of_a_column_fills_the_same_frame(pairs):
    """Glyph class by glyph class: what stands before the decimal point, and what stands behind it."""
    numbers = [number_text_with_error(value, error) for value, error in pairs]

    def classes(text):
        return sorted("0" if c.isdigit() else c for c in text)

    frames = paddings(numbers)
    before = [classes(p.before + n.sign + n.whole) for n, p in zip(numbers, frames, strict=True)]
    behind = [classes(n.tail + p.behind) for n, p in zip(numbers, frames, strict=True)]
    powers = [len(n.power + p.power) for n, p in zip(numbers, frames, strict=True)]
    assert all(b == before[0] for b in before)
    assert all(b == behind[0] for b in behind)
    assert len(set(powers)) == 1


def test_cells_read_as_a_person_says_them():
    assert cells(None, True, False, DivergedCell(3.14159), DivergedCell(12.0), "never") == [
        "—",
        "yes",
        "no",
        "diverged at 3.14 s",
        "diverged at 12 s",
        "never",
    ]


def test_numbers_that_came_as_text_keep_their_digits_and_are_aligned():
    shown = grid(table(("a", "0.2330"), ("b", "+12.5"), ("c", None)))
    assert str(shown[0][1].content) == "0.2330"
    assert shown[0][1].padding.before == "+1"
    assert shown[1][1].padding.behind == "000"


def test_words_stand_left_and_numbers_are_centred():
    assert alignments(table(("a", 1.0), ("b", DivergedCell(2.0)))) == ["left", "center"]


def test_brackets_are_explained_where_they_are_printed_first():
    tables = (
        ReportTable("plain", "", (PLAIN,), ((1.0,),), ("a note",)),
        ReportTable("first", "", (PLAIN,), ((BoldCell(ValueWithError(1.0, 0.1)),),), ("a note",)),
        ReportTable("second", "", (PLAIN,), ((ValueWithError(1.0, 0.1),),)),
    )
    found = notes(Document("t", "q", "m", (Section("s", tables),), Colophon("c", "0")))
    assert found == {"plain": ("a note",), "first": (BRACKETS, "a note"), "second": ()}


def test_csv_reads_back_with_every_digit():
    value, error = 0.1 + 0.2, 1e-17
    columns = (TableColumn("law, or rule"), TableColumn((symbol("q_1"), " error"), "m/s^2"), TableColumn("n"))
    text = to_csv(
        table(
            ('say "six"', ValueWithError(value, error), 3),
            ("line break", DivergedCell(3.125), None),
            (Code("a.b"), None, True),
            columns=columns,
        )
    )
    head, *rows = list(csv.reader(io.StringIO(text, newline=""), strict=True))
    assert [h.replace("_", "") for h in head] == ["law, or rule", "q1 error [m/s²]", "q1 error (error) [m/s²]", "n"]
    assert float(rows[0][1]) == value
    assert float(rows[0][2]) == error
    assert rows[0][0] == 'say "six"'
    assert rows[1] == ["line break", "diverged at 3.125 s", "", ""]
    assert rows[2] == ["a.b", "", "", "yes"]
    assert text.count("\r\n") == 4


RUN = [
    "=1+1",
    "+cmd|' /C calc'!A0",
    "-2+3",
    "@SUM(A1)",
    " =1",
    "\u00a0=1",
    "\u200b=1",
    "＝1+1",
    "－1",
    "-",
    "--1",
]
NUMBERS = ["-0.233", "+12.5", "-.5", "-1e-5", "0.2330"]


def columns_of(text):
    return list(zip(*csv.reader(io.StringIO(text, newline=""), strict=True), strict=True))


@pytest.mark.parametrize("text", ["-10 to 10", "-0.14 ± 0.40", "-1e-3 to +2", "-3", "+9.42 % (+3.43 to +11.6)"])
def test_what_is_made_of_plain_numbers_stays_as_it_is(text):
    assert spreadsheet_text(text) == text


@pytest.mark.parametrize("text", ["-10 to A1", "-1 to 2+3", "-1 ± 2|cmd", "-1 % SUM(1)", "-10 to 10\n=1", "-(1) to 2"])
def test_what_only_looks_like_a_range_comes_after_an_apostrophe(text):
    assert spreadsheet_text(text) == f"'{text}"


def test_texts_that_spreadsheets_run_come_after_an_apostrophe_and_numbers_stay_numbers():
    """Behind blanks and unseen signs no text begins with = + - @, also in full width, unless it is a number."""
    typed = [*RUN, *NUMBERS, "a=b", "1-2", "−1", ""]
    ((head, *cells),) = columns_of(to_csv(table(*((cell,) for cell in typed), columns=(TableColumn("=a", "rad"),))))
    assert head == "'=a [rad]"
    assert cells == [f"'{cell}" for cell in RUN] + [*NUMBERS, "a=b", "1-2", "−1", ""]
    pair = to_csv(table((-1.5, ValueWithError(-0.25, 0.5)), (-7, BoldCell("=1")), (-math.inf, ("=", symbol("q")))))
    assert columns_of(pair) == [
        ("law", "-1.5", "-7", "-inf"),
        ("RMSE [rad]", "-0.25", "'=1", "'=q"),
        ("RMSE (error) [rad]", "0.5", "", ""),
    ]


def test_a_line_break_or_tab_before_a_text_does_not_hide_what_it_begins_with():
    for hidden in ("\t=1", "\r=1", "\n=1", "\tword", "\x00=1", "\ufeff@x"):
        assert spreadsheet_text(hidden) == f"'{hidden}"


@given(st.text(max_size=6) | st.text("=+-@＝ \t\n1a.", max_size=6))
def test_no_text_of_a_table_is_run_and_none_is_changed_but_for_its_apostrophe(typed):
    (clean,) = Document("t", "q", "m", (Section("s", (table((typed,), columns=(PLAIN,)),)),), Colophon("c", "0")).tables
    cell = columns_of(to_csv(clean))[0][1]
    assert cell.removeprefix("'") == str(clean.rows[0][0]).removeprefix("'")
    runs = cell.strip()[:1] in tuple("=+-@＝＋－＠")
    assert not runs or math.isfinite(float(cell))


def test_latex_leaves_nothing_of_the_text_to_be_read_as_commands():
    hostile = r"50 % of $x_1$ & \input{secret} # ~ ^ { } <b> 3–4 — −1"
    text = to_latex(table((hostile, 1.0), ("[a]", ValueWithError(-0.5, 0.1))))
    assert r"50 \% of \$x\_1\$ \& \textbackslash{}input\{secret\} \# \textasciitilde{} \textasciicircum{}" in text
    assert r"{}[a]" in text
    assert r"$-0.50(10)$" in text


def test_latex_has_the_rules_and_the_label_of_a_booktabs_table():
    text = to_latex(table(("PID", BoldCell(2.5e-7)), ("SMC", 12.0)))
    for piece in (r"\toprule", r"\midrule", r"\bottomrule", r"\label{t}", r"\caption{A caption}"):
        assert piece in text
    assert r"$\phantom{1}\mathbf{2.5{}\times10^{-7}}$" in text
    assert r"law & RMSE [rad] \\" in text
