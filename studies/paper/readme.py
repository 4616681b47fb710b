"""The findings of README: the answer lines of the reports on the paper, copied from their `findings.json`.

`python -m studies.paper.readme` writes them into README.md, between the marks.
"""

from __future__ import annotations

import json
import re
import textwrap
from pathlib import Path

ROOT = Path(__file__).parents[2]
REPORTS = (
    "a1_paper_tables",
    "a2_claims",
    "a3_riccati_gains",
    "a4_observer_gains",
    "a6_unstated_choices",
    "a7_sensitivity",
    "a8_fair_comparison",
    "a9_sampling",
    "b4_handover",
    "c0_identify_arm",
    "c1_real_logs",
    "d0_frequency",
    "d1_benchmarks",
    "d2_planning",
)
FIRST, LAST = "<!-- answers of the reports -->\n", "<!-- end of the answers -->\n"
WIDTH = 118
BOUND = "\N{NO-BREAK SPACE}"  # between a number and its sign, where no line ends


def answer_line(report: str) -> str:
    """The answer of a report as a point of a list, with a link to its page."""
    held = json.loads((ROOT / "reports" / report / "findings.json").read_text("utf-8"))
    words = re.sub(r"([*_`<>|\\\[\]])", r"\\\1", held["answer"]).replace(" %", f"{BOUND}%")
    link = f"([{report.partition('_')[0]}](reports/{report}/index.html))"
    lines = textwrap.wrap(f"- {words} {link}", WIDTH, subsequent_indent="  ", break_on_hyphens=False)
    return "\n".join(lines).replace(BOUND, " ") + "\n"


def with_answers(readme: str) -> str:
    """README with the answers of the reports between its marks."""
    before, _, rest = readme.partition(FIRST)
    _, _, after = rest.partition(LAST)
    if not rest or not after:
        raise ValueError(f"`with_answers(readme)` needs the marks {FIRST.strip()!r} and {LAST.strip()!r} in README.md.")
    return before + FIRST + "\n" + "".join(map(answer_line, REPORTS)) + "\n" + LAST + after


if __name__ == "__main__":
    place = ROOT / "README.md"
    place.write_text(with_answers(place.read_text("utf-8")), "utf-8")
