import json
import shutil
import subprocess
from dataclasses import replace
from importlib.resources import files

import pytest
import typst

from tests.support.documents import HOSTILE, document
from workbench.core.notation.formula import Relation, Sum, System, symbol
from workbench.report import pdf as module
from workbench.report.figures.figure_sheet import draw
from workbench.report.outline import labels, notes
from workbench.report.pdf import LONGEST, REST, data, pdf
from workbench.study.document.document import (
    Code,
    Colophon,
    Document,
    Equation,
    Finding,
    Paragraph,
    ReportTable,
    Section,
    TableColumn,
    ValueWithError,
    Variation,
    Verdict,
)


def compiled(doc):
    """The PDF and the warnings that typst would have printed."""
    source = (files("workbench.report") / "templates" / "report.typ").read_bytes()
    tree = module._Writer(labels(doc), {f.name: draw(f) for f in doc.figures}, notes(doc)).document(doc)
    return typst.compile_with_warnings(source, sys_inputs={"document": json.dumps(tree)}, ignore_system_fonts=True)


def text_of(content, tmp_path):
    if shutil.which("pdftotext") is None:
        pytest.skip("pdftotext is not installed")
    (tmp_path / "report.pdf").write_bytes(content)
    run = subprocess.run(["pdftotext", "-layout", "report.pdf", "-"], cwd=tmp_path, capture_output=True, check=True)
    return run.stdout.decode()


def boxes_of(content, tmp_path):
    """(page width, left and right ends of each word), in points."""
    if shutil.which("pdftotext") is None:
        pytest.skip("pdftotext is not installed")
    (tmp_path / "report.pdf").write_bytes(content)
    run = subprocess.run(["pdftotext", "-bbox", "report.pdf", "-"], cwd=tmp_path, capture_output=True, check=True)
    words = [line.split('"') for line in run.stdout.decode().splitlines() if "<word" in line]
    return [(float(w[1]), float(w[5])) for w in words], [float(w[7]) for w in words]


def with_blocks(*blocks):
    doc = document()
    return replace(doc, sections=(*doc.sections, Section("More", blocks)))


def test_a_hostile_title_and_text_are_inert_and_readable(tmp_path):
    text = text_of(pdf(document(HOSTILE, words=HOSTILE)), tmp_path)
    joined = "".join(text.split())
    for piece in ("<script>alert(1)</script>", '#eval("1")', "$x$", "*b*", "_i_", "@mass", "//", "<lab>"):
        assert joined.count(piece) >= 10


def test_a_verdict_has_its_sentence_and_its_evidence_in_one_box(tmp_path):
    text = text_of(pdf(with_blocks(Verdict("fails", "S.", "E."))), tmp_path)
    lines = [" ".join(line.split()) for line in text.split("More")[-1].splitlines() if line.strip()]
    assert lines[:2] == ["FAILS S.", "E."]


def test_the_same_document_gives_the_same_bytes_and_no_date():
    first = pdf(document())
    assert first == pdf(document())
    assert b"CreationDate" not in first


def test_typst_has_nothing_to_warn_of():
    _, warnings = compiled(document())
    assert warnings == []


def test_references_provenance_and_running_title_are_there(tmp_path):
    text = " ".join(text_of(pdf(document()), tmp_path).split())
    for said in ("Table 1.", "Figure 1.", "Equation (1)", "diverged at 3.14 s", "0.5847(2)", "3f9a2c1b"):
        assert said in text
    assert text.startswith("Study report 1")


def test_the_digests_of_a_pdf_stand_in_its_provenance_and_on_no_other_page(tmp_path):
    colophon = replace(document().colophon, fingerprints={"W": "aa11"}, digests={"S: law": "bb22"}, command="run it")
    before, _, after = text_of(pdf(replace(document(), colophon=colophon)), tmp_path).rpartition("Provenance")
    assert "run it" in before
    for digest in ("aa11", "bb22"):
        assert digest in after
        assert digest not in before


def test_a_long_table_goes_on_over_pages_with_its_head_on_each(tmp_path):
    rows = tuple((f"row {i}", ValueWithError(i / 7, 0.001)) for i in range(150))
    text = text_of(
        pdf(with_blocks(ReportTable("long", "Long.", (TableColumn("thelaw"), TableColumn("x")), rows))), tmp_path
    )
    pages = [page for page in text.split("\f") if "row " in page]
    assert len(pages) >= 3
    assert all("thelaw" in page for page in pages)
    assert all(f"row {i} " in text for i in range(150))


def test_nothing_wide_leaves_the_page(tmp_path):
    columns = (TableColumn("law"), *(TableColumn(f"metric {i}", "N m/s") for i in range(24)))
    numbers = tuple(ValueWithError(1234.5678 * (i + 1), 0.01) for i in range(24))
    sentence = "a sentence that is long enough to be broken in any column of a table " * 4
    sum_of_many = Relation(symbol("V"), "=", Sum(tuple(symbol(f"longname_{i}") for i in range(60))))
    words, bottoms = boxes_of(
        pdf(
            with_blocks(
                Paragraph(("Hash ", Code("deadbeef" * 40), " and " + "x" * 300)),
                ReportTable("wide", "Wide.", columns, (("PID", *numbers), ("SMC", *numbers))),
                ReportTable(
                    "wordy", "Wordy.", (TableColumn("a"), TableColumn("b"), TableColumn("c")), ((sentence,) * 3,) * 4
                ),
                ReportTable("hashes", "Hashes.", (TableColumn("a"), TableColumn("b")), ((Code("ab" * 60), "cd" * 60),)),
                Equation(sum_of_many),
                Equation(System((sum_of_many,) * 2)),
            )
        ),
        tmp_path,
    )
    assert min(left for left, _ in words) > 60
    assert max(right for _, right in words) < 595.3 - 60
    assert max(bottoms) < 841.9 - 30


def test_each_part_of_a_wide_table_names_its_rows_by_the_columns_that_tell_them_apart(tmp_path):
    columns = (
        TableColumn("thelaw"),
        TableColumn("joint"),
        *(TableColumn(f"at {k} ms", "rad", "right") for k in range(12)),
    )
    rows = tuple((law, joint, *(["0.1234567 rad"] * 12)) for law in ("PID", "SMC") for joint in ("elbow", "wrist"))
    pages = text_of(compiled(with_blocks(ReportTable("t", "Wide.", columns, rows)))[0], tmp_path)
    assert pages.count("elbow") == 2 * pages.count("thelaw") > 2


def test_the_key_of_a_wide_table_leaves_out_columns_that_are_not_needed_to_tell_rows_apart():
    places = [(P, s, joint) for P in ("mean", "start") for s in ("first", "second") for joint in (1, 2)]
    rows = tuple(
        (w, P, f"{P} of {s}" if P == "mean" else "10", s, j, 0.5) for w in ("I", "0.01 I") for P, s, j in places
    )
    columns = tuple(map(TableColumn, ("weights", "P", "its diagonal", "scenario", "joint", "change")))
    assert module._key(ReportTable("t", "T.", columns, rows)) == [0, 1, 3, 4]
    assert module._key(ReportTable("t", "T.", columns, rows[:8])) == [0, 1, 3, 4]  # the first column names the rows
    assert module._key(ReportTable("t", "T.", columns[:3], (("a", "b", 1), ("a", "b", 2)))) == [0]


def test_a_head_of_words_takes_more_lines_before_a_table_is_parted(tmp_path):
    heads = [TableColumn(f"a head of many words {k}") for k in range(8)]
    rows = tuple((f"row {i}", *("0.1234567 s" for _ in heads[1:])) for i in range(3))
    text = text_of(compiled(with_blocks(ReportTable("t", "Wide.", tuple(heads), rows)))[0], tmp_path)
    assert text.count("row 1") == 1


def test_a_formula_that_typst_cannot_read_is_named_as_the_cause(monkeypatch):
    monkeypatch.setattr(module.typst_math, "emit", lambda formula, **more: "frac(1")
    with pytest.raises(ValueError, match=r"`pdf\(document\)` could not set 'Six laws on one arm'.*formulas"):
        pdf(document())


@pytest.mark.parametrize(
    "text",
    [pytest.param("x" * 10**6, id="a word", marks=pytest.mark.heavy), pytest.param("word " * 200_000, id="words")],
)
def test_a_million_letters_are_set_as_far_as_they_are_printed(text):
    """Without the cut, and where their width was measured, typst took many minutes for each."""
    held = ReportTable("t", text, (TableColumn("a"),), ((text,),), (text,))
    long = Document("T", "q", "m", (Section("s", (Paragraph(text), held)),), Colophon("c", "0"))
    (paragraph, table) = json.loads(data(long))["chapters"][0]["blocks"]
    assert paragraph["text"] == [{"kind": "text", "text": text[:LONGEST]}, {"kind": "text", "text": REST}]
    assert table["caption"] == table["rows"][0][0]["phrase"] == table["notes"][0] == paragraph["text"]
    assert pdf(long).startswith(b"%PDF")


def test_the_pdf_is_tagged_and_opens_without_a_complaint(tmp_path):
    content = pdf(document())
    assert b"/Marked true" in content  # for readers aloud
    assert b"/Suspects" not in content  # which poppler up to 25.11 misreads
    if shutil.which("pdfinfo") is None:
        pytest.skip("pdfinfo is not installed")
    (tmp_path / "report.pdf").write_bytes(content)
    run = subprocess.run(["pdfinfo", "report.pdf"], cwd=tmp_path, capture_output=True, check=True)
    assert run.stderr == b""
    assert b"Tagged:          yes" in run.stdout


def test_only_the_entry_of_the_catalogue_is_blanked_and_no_byte_moves():
    doc = replace(document(), title="On /Suspects false")
    content = pdf(doc)
    source = (files("workbench.report") / "templates" / "report.typ").read_bytes()
    given = typst.compile(source, sys_inputs={"document": data(doc)}, ignore_system_fonts=True)
    changed = [i for i, (a, b) in enumerate(zip(given, content, strict=True)) if a != b]
    assert given.count(b"/Suspects false") >= 2  # the title's own is left alone
    assert content.count(b"/Suspects false") == given.count(b"/Suspects false") - 1
    assert changed[0] > given.rindex(b"/Catalog")
    assert changed[-1] - changed[0] < len(b"/Suspects false")


@pytest.mark.parametrize("width", [None, 40])
def test_a_column_that_says_so_has_room_for_so_many_letters_beside_longer_texts(tmp_path, width):
    """Each line of the first column holds as many of its words as fit; without a width fewer do."""
    first, second = "four words stand here " * 2, "many words stand in the other column " * 20
    columns = (TableColumn("first", width=width), TableColumn("second"))
    text = text_of(pdf(with_blocks(ReportTable("t", "T.", columns, ((first, second),) * 3))), tmp_path)
    whole = any("four words stand here four words" in line for line in text.splitlines())
    assert whole is (width is not None)


def test_the_variations_of_a_finding_are_a_table_behind_the_chapters_with_other_answers_in_bold(tmp_path):
    ones = (
        Variation("the median in place of the mean", "SMC", "1.2 against 1.4", "that count scenarios"),
        Variation("the sum over all scenarios", "PID", "", "that pool scenarios"),
    )
    finding = Finding("best", "PID is best.", answer="PID", variations=ones)
    content = pdf(replace(document(), findings=(finding,)))
    lines = [" ".join(line.split()) for line in text_of(content, tmp_path).splitlines()]
    place = lines.index("variation answer details")
    assert lines[place + 1 : place + 5] == [
        "Variations that count scenarios",
        "the median in place of the mean SMC 1.2 against 1.4",
        "Variations that pool scenarios",
        "the sum over all scenarios PID",
    ]
    assert "Bold: an answer other than the one in the box." in lines
