"""The findings that the command line prints are the verdicts of the page, where a study names no others."""

import pytest

from workbench.core.notation.formula import symbol
from workbench.report.verdict_lines import verdict_lines
from workbench.study.document.document import Paragraph, Section, Verdict
from workbench.study.study import Results, Study
from workbench.study.writeup import document

JUDGED = """
import workbench as wb
from workbench.study.document.document import Verdict

def sections(results):
    print("sections")
    return [wb.Section("First", (Verdict("holds", "It is stable."), wb.Paragraph("How."))),
            wb.Section("Second", (Verdict("open", "It is fast."),))]

study = wb.Study("judged", "Judged", "?", "By hand.", sections{headlines})
"""


@pytest.mark.parametrize(
    ("headlines", "findings"),
    [
        ("", ["holds: It is stable.", "open: It is fast."]),
        (", headlines=lambda results: ['It runs.']", ["It runs."]),
    ],
)
def test_the_command_prints_the_verdicts_of_the_page_unless_the_study_has_headlines(
    command, tmp_path, headlines, findings
):
    (tmp_path / "judged.py").write_text(JUDGED.format(headlines=headlines), encoding="utf-8")
    done = command("run", "judged.py", "--out", "out")
    assert done.exit_code == 0, done.output
    assert done.stdout.splitlines()[:-1] == ["sections", *findings]


def test_a_statement_with_symbols_is_plain_text_on_one_line():
    verdict = Verdict("fails", ("The torque ", symbol("tau"), "\nis bounded."))
    study = Study("s", "T", "Q?", "M.", lambda results: [Section("Found", (Paragraph("Text."), verdict))])
    assert verdict_lines(document(study, Results(), "again")) == ["fails: The torque tau is bounded."]
