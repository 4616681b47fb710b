"""No line of a page or PDF ends between a number and its unit; the data keep the spaces that were typed."""

import json

import pytest

from tests.support.documents import document
from workbench.report.findings_json import findings_json
from workbench.report.html_page import html
from workbench.report.number_text import join_units
from workbench.report.pdf import data, pdf
from workbench.study.document.document import (
    Colophon,
    Document,
    Finding,
    Paragraph,
    ReportTable,
    Section,
    Strong,
    TableColumn,
)

NBSP = "\u00a0"


@pytest.mark.parametrize(
    "text",
    [
        "by 1.8~%.",
        "+0.97 to +12.2~% and -31.4~%",
        "0.3532(2)~rad, 4.6~±~0.9~%",
        "5~N~m, 10~N~m/rad and 2~kN~m/s",
        "at 6~1/s for 50~ms with 16.6~µrad",
        "3~m/s², 3~m/s^2 and 0.7~N~m/(rad~s)",
        "168~MHz and 3,640~bytes",
    ],
)
def test_a_number_keeps_its_unit_and_error(text):
    assert join_units(text.replace("~", " ")) == text.replace("~", NBSP)


@pytest.mark.parametrize(
    "text",
    [
        "7 laws in 2 scenarios",
        "the first 5 minutes",
        "Q = R = I",
        "24 of 60 pairs",
        "rad and N m alone",
        "5 mean values",
    ],
)
def test_other_spaces_may_break(text):
    assert join_units(text) == text


def told():
    """A document with a number and its unit in each place that has words."""
    words = "by 1.8 % at 5 N m/rad"
    finding = Finding("f", words, words, answer="none")
    table = ReportTable("t", words, (TableColumn("a"),), ((words,),), (words,))
    sections = (Section(words, (Paragraph((words, Strong(words))), table)),)
    return Document(f"On {words}", words, words, sections, Colophon("c", "0"), answer=words, findings=(finding,))


def test_the_page_and_the_pdf_have_spaces_that_do_not_break_and_the_data_have_not():
    page = html(told()).partition("</title>")[2]
    assert page.count(f"1.8{NBSP}% at 5{NBSP}N{NBSP}m/rad") > 8
    assert "1.8 %" not in page
    assert "5 N" not in page
    tree = json.loads(data(told()))
    del tree["running"]  # the title on one line
    assert "1.8 %" not in json.dumps(tree, ensure_ascii=False)
    found = findings_json(told())
    assert "1.8 % at 5 N m/rad" in found
    assert NBSP not in found


def test_a_document_with_such_spaces_is_set():
    assert pdf(told()).startswith(b"%PDF")
    assert NBSP in html(document(words="a pole at 2 rad/s"))
