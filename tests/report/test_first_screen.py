"""What a reader sees of each report without a click, on a screen of 1300 x 900 and with scripts switched off."""

from dataclasses import replace

import pytest

from studies.performance.chromium import open_page
from tests.support.browsers import needs_chromium
from tests.support.documents import document
from tests.support.kept_pages import NONE, PAGES
from workbench.report.html_page import html
from workbench.study.document.document import (
    Figure,
    Finding,
    Panel,
    ReportTable,
    Section,
    Series,
    TableColumn,
    Variation,
)

ANSWER = "Words of an answer of the longest kind that a page may have. " * 4
TITLE = "A title that is as long as titles of reports are, and takes two lines on a screen of this width"


def box_of(page, selector):
    """The top, bottom, left and right of an element in the window, in px; None if there is no such element."""
    return page.value(
        f"(() => {{ const e = document.querySelector('{selector}'); if (!e) return null;"
        " const b = e.getBoundingClientRect(); return [b.top, b.bottom, b.left, b.right]; })()"
    )


def without_scripts(page, path):
    page.call("Emulation.setScriptExecutionDisabled", value=True)
    page.open(path.resolve().as_uri())


@needs_chromium
@pytest.mark.parametrize("path", PAGES or NONE, ids=lambda path: path.parent.name)
def test_the_answer_of_each_report_is_visible_on_the_first_screen_without_scripts(browser, path, tmp_path):
    (empty := tmp_path / "empty.html").write_text("<p>nothing", "utf-8")  # the report is opened once, without scripts
    with open_page(empty, width=1300, height=900, browser=browser) as page:
        without_scripts(page, path)
        top, bottom, left, right = box_of(page, ".answer")
    assert 0 <= top < bottom <= 900
    assert 0 <= left < right <= 1300


def page_with(tmp_path, **changes):
    path = tmp_path / "index.html"
    path.write_text(html(replace(document(), title=TITLE, answer=ANSWER, **changes)), "utf-8")
    return path


@needs_chromium
def test_the_longest_answer_and_the_first_box_below_it_are_on_the_first_screen(browser, tmp_path):
    first = Finding("first", "The first finding. " * 4, "Why one may believe it. " * 6)
    path = page_with(tmp_path, findings=(first,))
    with open_page(path, width=1300, height=900, browser=browser) as page:
        without_scripts(page, path)
        assert box_of(page, ".finding")[1] <= 900
        assert not page.value("document.querySelector('.finding dl').checkVisibility()")  # folded
    with open_page(path, width=390, height=844, browser=browser) as page:
        without_scripts(page, path)
        assert box_of(page, ".answer")[1] <= 844


@needs_chromium
def test_a_wide_table_scrolls_on_a_phone_and_never_widens_the_page(browser, tmp_path):
    columns = (TableColumn("law"), *(TableColumn(f"quantity {k}", "rad/s", digits=4) for k in range(9)))
    rows = tuple((f"law {i}", *(float(i + k / 7) for k in range(9))) for i in range(3))
    table = ReportTable("wide", "Wide.", columns, rows)
    path = page_with(tmp_path, sections=(Section("All", (table,)), *document().sections))
    with open_page(path, width=390, height=844, browser=browser) as page:
        page.size(390, 844, touch=True)
        assert page.value("document.documentElement.scrollWidth") == 390
        scroll = "document.querySelector('figure.table .scroll')"
        assert page.value(f"{scroll}.scrollWidth > {scroll}.clientWidth")
        # the shadows at its edges are the hint; those that cover them move with the table
        assert page.value(f"getComputedStyle({scroll}).backgroundAttachment") == "local, local, scroll, scroll"


@needs_chromium
def test_a_figure_on_a_phone_has_the_size_for_which_it_is_drawn_and_scrolls_in_its_own_box(browser, tmp_path):
    figure = Figure("f", "A line.", (Panel("y", (Series("a", [0.0, 1.0], [0.0, 1.0]),)),))
    path = page_with(tmp_path, sections=(Section("All", (figure,)), *document().sections))
    with open_page(path, width=390, height=844, browser=browser) as page:
        page.size(390, 844, touch=True)
        assert page.value("document.documentElement.scrollWidth") == 390
        svg, scroll = (f"document.querySelector('figure.drawing {name}')" for name in ("svg", ".scroll"))
        drawn = page.value(f"parseFloat({svg}.getAttribute('width')) * 96 / 72")  # of points, in px
        assert page.value(f"{svg}.getBoundingClientRect().width") == pytest.approx(drawn, rel=1e-3)
        assert page.value(f"{scroll}.scrollWidth > {scroll}.clientWidth")


@needs_chromium
def test_the_names_of_rows_and_the_next_column_are_seen_on_a_phone_and_the_names_stay_while_a_table_scrolls(
    browser, tmp_path
):
    """The answer stands beside the name of its row, however long both are and however wide the rest is."""
    words = "a long name of a row, of which there are many letters"
    columns = (
        TableColumn("change", width=30),
        TableColumn("answer"),
        *(TableColumn(f"quantity {k}", "rad/s") for k in range(9)),
    )
    rows = tuple((f"{words} {i}", "feedforward + PD", *(float(i + k / 7) for k in range(9))) for i in range(3))
    path = page_with(
        tmp_path, sections=(Section("All", (ReportTable("t", "T.", columns, rows),)), *document().sections)
    )
    with open_page(path, width=390, height=844, browser=browser) as page:
        page.size(390, 844, touch=True)
        _, _, left, right = box_of(page, "figure.table tbody th")
        assert box_of(page, "figure.table tbody td")[3] <= 390
        assert 100 < right - left < 0.5 * 390
        page.value("document.querySelector('figure.table .scroll').scrollLeft = 200")
        assert box_of(page, "figure.table tbody th")[2] == pytest.approx(left, abs=1)
        assert box_of(page, "figure.table thead th")[2] == pytest.approx(left, abs=1)
        assert box_of(page, "figure.table tbody td")[3] < right  # below the names


@needs_chromium
def test_the_variations_of_a_finding_never_widen_the_page_of_a_phone(browser, tmp_path):
    words = "a change of the study that takes some words to say"
    ones = tuple(Variation(f"{words} {i}", "feedforward + PD", "SMC in 1, RISE in 2, undecided in 7") for i in range(9))
    first = Finding("first", "The first finding.", answer="PID", variations=ones)
    path = page_with(tmp_path, findings=(first,))
    with open_page(path, width=390, height=844, browser=browser) as page:
        page.size(390, 844, touch=True)
        page.value("document.querySelector('details').open = true")
        assert page.value("document.documentElement.scrollWidth") == 390
        assert box_of(page, "details td")[3] <= 390
