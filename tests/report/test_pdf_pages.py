"""How full the pages of the PDFs are, measured on their pictures by poppler."""

import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest

from tests.support.documents import document
from tests.support.kept_pages import NONE, PDFS
from workbench.report.pdf import pdf
from workbench.study.document.document import Figure, Paragraph, ReportTable, Section, TableColumn
from workbench.study.document.figure import Bars, Panel, Series

LONG = 500_000  # bytes of a report that runs with all tests only
HEADER, FOOT = 0.1, 0.92  # of the height of a page: where its text begins and ends
T = np.linspace(0.0, 1.0, 50)
needs_poppler = pytest.mark.skipif(shutil.which("pdftoppm") is None, reason="pdftoppm is not installed")


def blanks(file, folder):
    """The longest blank stretch of each page, as a share of the room that a page has for text."""
    subprocess.run(["pdftoppm", "-r", "24", "-gray", str(file), str(folder / "page")], capture_output=True, check=True)
    found = []
    for picture in sorted(folder.glob("page-*.pgm")):
        head, size, _, pixels = picture.read_bytes().split(b"\n", 3)
        width, height = map(int, size.split())
        assert head == b"P5"
        ink = (np.frombuffer(pixels, np.uint8).reshape(height, width) < 245).any(axis=1)
        text = ink[int(HEADER * height) : int(FOOT * height)]
        ends = np.flatnonzero(np.concatenate([[True], text, [True]]))
        found.append((np.diff(ends).max() - 1) / len(text))
    return found


def curves(name, rows):
    """A figure of some rows of panels, each about 44 mm high."""
    return Figure(name, f"{name} in {rows} rows.", tuple(Panel("y", (Series("a", T, T),)) for _ in range(rows)))


def bars(name, count):
    """A figure of many named rows, up to a page high."""
    rows = np.arange(float(count))
    panel = Panel("", (Bars("a", rows, rows + 1, 0 * rows),), "x", ynames=tuple(f"row {k}" for k in range(count)))
    return Figure(name, "Many rows.", (panel,))


def table(name, rows, text):
    return ReportTable(
        name, "A table.", (TableColumn("one"), TableColumn("two")), tuple((f"row {k}", text) for k in range(rows))
    )


@needs_poppler
@pytest.mark.parametrize("start", [0, *(pytest.param(k, marks=pytest.mark.heavy) for k in (6, 12, 18, 24, 30))])
def test_no_page_is_more_than_half_blank_wherever_figures_and_tables_begin(tmp_path, start):
    lines = tuple(Paragraph(f"Line {k}.") for k in range(start + 1))
    words = Paragraph("Words that fill some lines of a page, again and again. " * 12)
    blocks = (
        (*lines, curves("a", 3), words, curves("b", 1), words),
        (bars("c", 24), curves("d", 2), table("e", 12, "word " * 40), words),
        (curves("f", 2), curves("g", 2)),
        (curves("h", 3),),
        (words, table("i", 11, "word " * 60), bars("j", 30), words),
    )
    doc = replace(document(), sections=tuple(Section(f"Part {k}", part) for k, part in enumerate(blocks)))
    (tmp_path / "report.pdf").write_bytes(pdf(doc))
    *pages, _ = blanks(tmp_path / "report.pdf", tmp_path)
    assert len(pages) > 4
    assert max(pages) <= 0.5


@needs_poppler
def test_figures_keep_their_order_and_their_captions(tmp_path):
    words = Paragraph("Words that fill some lines of a page, again and again. " * 12)
    figures = [curves(f"f{k}", rows) for k, rows in enumerate((1, 3, 1, 1, 3, 2, 1))]
    blocks = [block for figure in figures for block in ((figure, words) if figure.name != "f2" else (figure,))]
    doc = replace(document(), sections=(Section("Part", tuple(blocks)),))
    (tmp_path / "report.pdf").write_bytes(pdf(doc))
    run = subprocess.run(["pdftotext", "report.pdf", "-"], cwd=tmp_path, capture_output=True, check=True)
    text = run.stdout.decode()
    places = [text.index(f" f{k} in ") for k in range(7)]
    pages = [text.count("\f", 0, place) for place in places]
    assert pages == sorted(pages)


@needs_poppler
@pytest.mark.parametrize(
    "path",
    [pytest.param(path, marks=[pytest.mark.heavy] * (path.stat().st_size > LONG), id=path.parent.name) for path in PDFS]
    or NONE,
)
def test_no_page_of_a_report_but_the_last_is_more_than_half_blank(tmp_path, path):
    *pages, _ = blanks(path, tmp_path)
    assert max(pages, default=0.0) <= 0.5


@needs_poppler
@pytest.mark.parametrize("path", PDFS or NONE, ids=lambda path: path.parent.name)
def test_poppler_has_no_complaint_about_a_report(path):
    run = subprocess.run(["pdfinfo", str(path)], capture_output=True, check=True)
    assert run.stderr == b""
