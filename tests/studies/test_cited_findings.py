"""What is said of a report elsewhere is what the report says: README's answers, and findings that cite each other."""

import json
from pathlib import Path

import pytest

from studies.paper import readme
from studies.paper.readme import FIRST, LAST, REPORTS, with_answers
from tests.support.kept_pages import needs_pages

ROOT = Path(__file__).parents[2]
PAGES = {place.parent.name: json.loads(place.read_text("utf-8")) for place in ROOT.glob("reports/*/findings.json")}
CITES = [
    (report, one["name"], cited) for report, page in PAGES.items() for one in page["findings"] for cited in one["cites"]
]


@needs_pages
def test_every_report_has_its_findings():
    assert {place.parent.name for place in ROOT.glob("reports/*/index.html")} == set(PAGES)


def test_the_findings_of_the_readme_are_the_answers_of_the_reports():
    text = (ROOT / "README.md").read_text("utf-8")
    assert with_answers(text) == text, "run `python -m studies.paper.readme` after the reports were printed"


def test_the_answers_stand_between_the_marks_of_the_readme(tmp_path, monkeypatch):
    for report in REPORTS:
        (tmp_path / "reports" / report).mkdir(parents=True)
        (tmp_path / "reports" / report / "findings.json").write_text('{"answer": "5 * 5 is < 26."}', "utf-8")
    monkeypatch.setattr(readme, "ROOT", tmp_path)
    filled = with_answers(f"a\n{FIRST}old\n{LAST}b\n")
    assert filled.startswith(f"a\n{FIRST}\n- 5 \\* 5 is \\< 26. ([a1](reports/a1_paper_tables/index.html))\n")
    assert filled.endswith(f"{LAST}b\n")
    assert "old" not in filled
    assert filled.count("\n- ") == len(REPORTS)


def test_a_readme_without_the_marks_is_refused():
    with pytest.raises(ValueError, match="needs the marks"):
        with_answers("# A page\n")


@pytest.mark.parametrize("report", sorted(PAGES))
def test_each_report_answers_in_one_line_of_at_most_forty_words(report):
    answer = PAGES[report]["answer"]
    assert answer
    assert len(answer.split()) <= 40, answer


@pytest.mark.parametrize(("report", "name", "cited"), CITES)
def test_a_finding_that_cites_another_has_its_answer(report, name, cited):
    folder, _, other = cited.partition("/")
    assert (ROOT / "reports" / folder).is_dir(), f"{report}: {name} cites {folder}, which is no report"
    found = {one["name"]: one for one in PAGES[folder]["findings"]}
    assert other in found, f"{report}: {name} cites {cited}; {folder} has {sorted(found)}"
    (own,) = (one for one in PAGES[report]["findings"] if one["name"] == name)
    assert own["answer"] == found[other]["answer"]
