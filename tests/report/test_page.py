import re
from html.parser import HTMLParser

import numpy as np
import pytest

from tests.support.documents import HOSTILE, document
from workbench.report.html_page import html
from workbench.report.outline import ROWS, provenance
from workbench.report.table_text import to_csv
from workbench.study.document.document import (
    Code,
    Colophon,
    Document,
    Figure,
    Panel,
    ReportTable,
    Section,
    Series,
    TableColumn,
)

VOID = {"meta", "wbr", "br", "use", "path", "rect", "mspace"}


class Reader(HTMLParser):
    """Tags, ids, links and text of a page; refuses a tag that is not closed."""

    def __init__(self, page):
        super().__init__()
        self.tags, self.ids, self.links, self.words, self._open = [], [], [], [], []
        self.feed(page)
        assert self._open == []

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        self.ids += [value for name, value in attrs if name == "id"]
        self.links += [value for name, value in attrs if name in ("href", "src", "xlink:href", "data", "action")]
        if tag not in VOID:
            self._open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self._open.pop()

    def handle_endtag(self, tag):
        if tag not in VOID:
            assert self._open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)


def test_a_hostile_title_and_text_are_inert_and_readable():
    page = html(document(HOSTILE, words=HOSTILE))
    reader = Reader(page)
    assert {tag for tag, _ in reader.tags}.isdisjoint({"script", "img", "iframe", "object", "link", "base"})
    assert not any(name.startswith("on") for _, attrs in reader.tags for name in attrs)
    assert "".join(reader.words).count(HOSTILE) >= 15


def test_the_same_document_gives_the_same_bytes():
    assert html(document()) == html(document())


def test_a_page_needs_nothing_from_outside():
    page = html(document())
    reader = Reader(page)
    assert all(link.startswith("#") for link in reader.links)
    assert "@import" not in page
    assert re.findall(r"url\((?!#|data:font/woff2;base64,)", page) == []
    assert "default-src 'none'" in page


def test_every_link_leads_somewhere_and_no_id_comes_twice():
    reader = Reader(html(document()))
    assert len(set(reader.ids)) == len(reader.ids)
    assert {link[1:] for link in reader.links} <= set(reader.ids)


def test_references_are_printed_as_numbers():
    words = "".join(Reader(html(document())).words)
    assert "see Table\u00a01Equation\u00a0(1)" in words


def test_figures_and_tables_speak_to_those_who_cannot_see_them():
    tags = Reader(html(document())).tags
    assert ("html", {"lang": "en"}) in tags
    assert [a["aria-label"] for t, a in tags if a.get("role") == "img"] == ["Figure\u00a01: textq_1Table\u00a01"]
    assert {a.get("scope") for t, a in tags if t == "th"} == {"col", "row"}


def test_a_verdict_is_a_word_and_not_only_a_colour():
    words = Reader(html(document())).words
    assert {"fails", "holds", "open"} <= set(words)


def test_a_verdict_has_its_sentence_and_its_evidence_in_one_box():
    words = [word.strip() for word in Reader(html(document())).words if word.strip()]
    start = words.index("fails", words.index("fails") + 1) if words.count("fails") > 1 else words.index("fails")
    assert words[start : start + 2] == ["fails", "text"]


def test_provenance_says_how_to_get_the_report_again():
    words = Reader(html(document())).words
    for said in ("3f9a2c1b", "0.1.0", "7", "casadi 3.8", "3.11"):
        assert said in words


@pytest.mark.heavy
def test_a_page_of_sixteen_figures_of_long_chattering_runs_stays_below_3_mb():
    t = np.linspace(0, 10, 20_000)
    rng = np.random.default_rng(1)
    laws = tuple(Series(f"law {k}", t, rng.normal(size=t.size), k) for k in range(6))
    figures = tuple(Figure(f"f{i}", "Noise.", (Panel("torque [N m]", laws),)) for i in range(16))
    assert len(html(document("Long", *figures)).encode()) < 3_000_000


@pytest.mark.parametrize("sections", [(), (Section("Empty", ()),)])
def test_an_empty_document_is_a_page_too(sections):
    page = Reader(html(Document("t", "q", "m", sections, Colophon("c", "0"))))
    assert ("h1", {}) in page.tags


def test_control_characters_do_not_reach_the_page():
    text = ReportTable("t", "a\x00b", (TableColumn("c"),), (("d\x1b[31m\te",),))
    blocks = (text, Figure("f", "\x01", (Panel("y\x02", (Series("", [0, 1], [0, 1]),)),)))
    sections = (Section("s\x03", blocks),)
    doc = Document("a\x00b", "q\x1b", ("m", Code("c\x01")), sections, Colophon("run \ud800 \x7f", "0"))
    assert "d\ufffd[31m e" in to_csv(doc.tables[0])
    assert doc.tables[0].caption == "a\ufffdb"
    page = html(doc)
    assert not re.search("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ud800-\udfff]", page)
    assert "<h1>a\ufffdb</h1>" in page
    page.encode("utf-8")


def test_the_head_of_a_page_says_how_to_run_it_and_digests_stand_at_its_end():
    colophon = Colophon("workbench run it", "0", {"W": "aa11"}, digests={"S: law": "bb22"})
    page = html(Document("t", "q", "m", (Section("Found", ()),), colophon))
    words = [word.strip() for word in Reader(page).words if word.strip()]
    head, end = words[: words.index("Contents")], words[words.index("Provenance") :]
    assert "workbench run it" in head
    assert not {"aa11", "bb22"} & set(head)
    assert {"aa11", "bb22", "fingerprint of W", "digest of S: law"} <= set(end)


def test_fingerprints_that_would_fill_pages_stand_in_one_paragraph_and_none_is_lost():
    def rows(count):
        prints = {f"run_{k}": f"{k // 3:08x}" for k in range(count)}
        return [row for row in provenance(Document("t", "q", "m", (), Colophon("c", "0", prints))) if "fing" in row[0]]

    assert rows(ROWS) == [(f"fingerprint of run_{k}", f"{k // 3:08x}") for k in range(ROWS)]
    ((term, text),) = rows(ROWS + 2)
    groups = dict(part.split(" of ") for part in text.split("; "))
    assert term == "fingerprints"
    assert {name: digest for digest, names in groups.items() for name in names.split(", ")} == {
        f"run_{k}": f"{k // 3:08x}" for k in range(ROWS + 2)
    }
