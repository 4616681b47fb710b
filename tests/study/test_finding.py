"""Findings: what changes an answer is computed over all variations, and stands in the page, the PDF and the JSON."""

import json
import re
from dataclasses import replace

import pytest

import workbench as wb
from workbench.report.folder import write
from workbench.report.html_page import html
from workbench.report.verdict_lines import verdict_lines
from workbench.study.document.document import Document
from workbench.study.document.phrases_and_tables import CrossReference, ReportTable, TableColumn
from workbench.study.study import Results
from workbench.study.writeup import document

MEDIAN = wb.Variation("the median in place of the mean", "SMC", "1.2 against 1.4")
OTHERS = tuple(wb.Variation(f"without scenario {i}", "PID") for i in range(7))
BEST = wb.Finding(
    "best",
    "PID has the least mean cost, 1.2.",
    "In 9 of 10 scenarios no interval of another law reaches it.",
    statistic="Mean cost",
    sample="160 draws in each of 10 scenarios",
    information="the same readings",
    fitted_numbers="the gains of each law, by one budget",
    answer="PID",
    variations=(MEDIAN, *OTHERS),
    limitations="another cost",
    cites=("a6_unstated_choices/row_of_fs",),
)


def page_of(*findings, answer="PID is best."):
    study = wb.Study(
        "s", "T", "Q?", "M.", lambda results: wb.Page(answer, findings, (wb.Section("S", (wb.Paragraph("P."),)),))
    )
    return document(study, Results(), "again")


def test_a_finding_depends_where_a_variation_has_another_answer_and_only_there():
    assert BEST.kind == "depends"
    assert BEST.reversals == (MEDIAN,)
    same = replace(BEST, variations=OTHERS)
    assert same.kind == "found"
    assert same.reversals == ()
    assert replace(BEST, is_decided=False).kind == "open"


def test_the_third_line_says_what_changes_the_answer_and_of_how_many_variations():
    assert BEST.change == (
        "The answer, PID, changes in 1 of 8 variations: to SMC in “the median in place of the mean”."
    )
    same = replace(BEST, variations=OTHERS)
    assert same.change.startswith("The answer, PID, stays the same in each of 7 variations: without scenario 0;")
    assert same.change.endswith("; 4 more.")
    assert replace(BEST, variations=(), answer="").change == "No variation was computed."
    assert (
        replace(BEST, variations=OTHERS[:1]).change
        == "The answer, PID, stays the same in the one variation: without scenario 0."
    )
    assert replace(BEST, variations=(MEDIAN,)).change == (
        "The answer, PID, changes in the one variation: to SMC in “the median in place of the mean”."
    )


def test_variations_that_answer_different_questions_are_counted_apart():
    counted = (replace(MEDIAN, question="that count scenarios"), replace(OTHERS[0], question="that count scenarios"))
    pooled = tuple(replace(one, question="that pool them") for one in OTHERS[1:])
    assert replace(BEST, variations=(*counted, *pooled)).change.startswith(
        "The answer, PID, changes in 1 of 2 variations that count scenarios and in 0 of 6 variations that pool them: "
        "to SMC"
    )


def test_answers_of_many_variations_are_counted_and_those_of_few_named():
    many = tuple(wb.Variation(f"choice {i}", "SMC") for i in range(30))
    some = replace(BEST, variations=(*many, *(wb.Variation(words, "no law") for words in ("another cost", "the sum"))))
    assert some.change == (
        "The answer, PID, changes in all 32 variations: to SMC in 30; to 'no law' in “another cost” and “the sum”."
    )


def test_an_answer_that_all_changes_have_in_common_is_named_once():
    none = tuple(wb.Variation(f"joint {i}", "none") for i in range(6))
    one = replace(BEST, variations=(*none, *OTHERS[:2]))
    assert one.change == "The answer, PID, changes in 6 of 8 variations, always to 'none'."
    few = replace(BEST, variations=(*none[:2], *OTHERS[:2]))
    assert few.change == "The answer, PID, changes in 2 of 4 variations: to 'none' in “joint 0” and “joint 1”."


def test_no_variation_is_left_out_of_the_scope_however_many_there_are():
    """All rows of the table in the fold, in which other answers than that of the box are bold."""
    many = tuple(wb.Variation(f"choice {i}", "SMC" if i % 2 else "PID", f"by {i} %") for i in range(30))
    page = html(page_of(replace(BEST, variations=many)))
    fold = page[page.index("<details>") : page.index("</details>")]
    rows = re.findall(r"<tr><th[^>]*>(choice \d+)</th>\s*<td[^>]*>(.*?)</td><td[^>]*>(.*?)</td></tr>", fold)
    answers = ["<strong>SMC</strong>" if i % 2 else "PID" for i in range(30)]
    assert rows == [(f"choice {i}", answer, f"by {i} %") for i, answer in enumerate(answers)]


def test_the_scope_has_a_head_for_each_question_and_no_column_without_a_figure():
    counted = replace(MEDIAN, question="that count scenarios", detail="")
    pooled = wb.Variation("the arithmetic mean", "PID", question="that pool scenarios")
    page = html(page_of(replace(BEST, variations=(pooled, counted))))
    heads = re.findall(r'<th scope="rowgroup" colspan="(\d)" class="left">(.*?)</th>', page)
    assert heads == [("2", "Variations that pool scenarios"), ("2", "Variations that count scenarios")]
    assert "figures</th>" not in page
    assert "rowgroup" not in html(page_of(BEST))


def test_a_finding_with_variations_needs_an_answer_to_compare_them_with():
    with pytest.raises(ValueError, match=r"`Finding\(answer=...\)` must be a text.*got ''"):
        replace(BEST, answer="")
    with pytest.raises(ValueError, match="needs distinct words.*'the median in place of the mean'"):
        replace(BEST, variations=(MEDIAN, MEDIAN))
    with pytest.raises(ValueError, match=r"must be names such as 'folder/name'.*got \('a6',\)|got 'a6'"):
        replace(BEST, cites=("a6",))
    with pytest.raises(ValueError, match=r"`Variation\(answer=...\)` must be a text"):
        wb.Variation("words", " ")


def test_a_sentence_with_a_number_that_was_not_computed_is_refused():
    with pytest.raises(ValueError, match=r"`Finding\(evidence=...\)` must be a sentence without 'nan'.*nan N m"):
        replace(BEST, evidence=f"The median peak is {float('nan'):.3g} N m.")
    with pytest.raises(ValueError, match=r"`Variation\(detail=...\)` must be a sentence without 'nan'"):
        wb.Variation("the median", "SMC", f"{float('nan')} against 1.4")
    assert replace(BEST, evidence="Nandrolone is no number.").kind == "depends"


def test_a_page_has_at_most_five_findings():
    six = tuple(replace(BEST, name=f"n{i}") for i in range(6))
    with pytest.raises(ValueError, match=r"`Page\(findings=...\)` must be at most 5 findings"):
        wb.Page("Yes.", six, ())


def test_the_answer_and_the_boxes_come_before_the_question_and_need_no_script():
    text = html(page_of(BEST))
    assert text.index('<p class="answer">PID is best.</p>') < text.index('id="finding-best"') < text.index("Question")
    assert "<script" not in text
    assert '<a href="../a6_unstated_choices/index.html#finding-row_of_fs">' in text
    assert re.search(r'<p class="legend"><span class="word depends">depends</span> ', text)


def test_a_sentence_may_refer_to_a_finding_by_its_name():
    study = wb.Study("s", "T", "Q?", "M.", lambda results: wb.Page(("See ", CrossReference("best"), "."), (BEST,), ()))
    assert '<a href="#finding-best">Finding\u00a01</a>' in html(document(study, Results(), "again"))
    with pytest.raises(LookupError, match="worst"):
        page_of(BEST, answer=("See ", CrossReference("worst"), "."))


def test_the_command_prints_the_answer_and_then_the_findings():
    assert verdict_lines(page_of(BEST)) == ["PID is best.", "depends: PID has the least mean cost, 1.2."]
    assert verdict_lines(page_of(answer="")) == []


def test_findings_are_written_as_json_beside_the_page_and_the_pdf(tmp_path):
    folder = write(page_of(BEST), tmp_path / "r")
    held = json.loads((folder / "findings.json").read_text("utf-8"))
    assert held["answer"] == "PID is best."
    (one,) = held["findings"]
    assert (one["name"], one["kind"], one["answer"]) == ("best", "depends", "PID")
    assert [v["answer"] for v in one["variations"]] == ["SMC", *["PID"] * 7]
    assert (folder / "report.pdf").read_bytes().startswith(b"%PDF")
    bare = write(page_of(answer=""), tmp_path / "r")
    assert not (bare / "findings.json").exists()


def test_two_blocks_of_a_document_have_no_name_in_common():
    section = wb.Section("S", (ReportTable("best", "C.", (TableColumn("x"),), ((1.0,),)),))
    base = page_of(BEST)
    with pytest.raises(ValueError, match="distinct names"):
        Document("T", "Q", "M", (section,), base.colophon, findings=(BEST,))
