"""The cells of a live table in a browser: coarse and fine numbers, their widths and their words."""

from __future__ import annotations

import json
import subprocess

import pytest

from tests.support.browsers import CHROMIUM
from tests.support.table_script import LIVE, SCRIPT
from workbench.report.number_text import NumberText, number_text_with_error

PAGE = """<!DOCTYPE html><html><head><meta charset="utf-8"><style>%s</style></head><body><table><tbody>
<tr><th>law</th><td class="ALIGN" data-cell="0">
<span class="number"><span class="pad" data-pad="1"></span>1.234(5)</span></td>
<td class="ALIGN" data-cell="1"><span class="number">0.12(1)</span></td><td>7</td></tr>
<tr><th>law</th><td class="ALIGN" data-cell="2">
<span class="number">11.2(1)<span class="pad" data-pad="00"></span></span></td>
<td class="ALIGN" data-cell="3"><span class="number">3(1)<span class="pad" data-pad=".00"></span></span></td>
<td data-cell="99">8</td></tr>
</tbody></table><pre id="seen"></pre><script>%s
const data = {
  cells: [0, 1, 2, 3].map((i) => {
    return { table: "t", column: 1 + i %% 2, loop: i >> 1, metric: i %% 2, number: 0, scale: 1 };
  }),
  loops: [
    { label: "a", scores: [[[1.234, 0.005]], [[0.12, 0.01]]] },
    { label: "b", scores: [[[11.2, 0.1]], [[NaN, NaN]]] },
  ],
};
const cells = () => [...document.querySelectorAll("td")];
const before = cells().map((cell) => cell.innerHTML);
const tables = openTables(document, data), seen = [];
const texts = () => cells().map((cell) => {
  const live = cell.querySelector(".live-number");
  return live ? [live.className, live.getAttribute("aria-live"), live.textContent] : cell.textContent.trim();
});
const widths = () => cells().map((cell) => cell.getBoundingClientRect().width);
const ends = (element) => {
  const range = document.createRange();
  range.selectNodeContents(element);
  const { left, right } = range.getBoundingClientRect();
  return [left, right];
};
const pairs = () => cells().filter((cell) => cell.querySelector(".live-number:not(.words)"))
  .map((cell) => [ends(cell.querySelector(".number")), ends(cell.querySelector(".live-number"))]);
const look = () => seen.push({ texts: texts(), widths: widths(), pairs: pairs() });
look();
tables.show(0, [[[1.3512, null]], [[0.5, null]]]); look();
tables.show(0, [[[1.3512, 0.0014]], [[0.5, 0.1]]]); look();
tables.show(1, [[[NaN, null]], null], 3.208); look();
tables.show(1, [[[2e-7, 1e-9]], null]); look();
tables.show(0, [[[-1.5, 0.1]], [[0.5, 0.1]]]); look();
tables.show(0, [[[1.3, 0.1]], [[0.5, 0.1]]]); look();
tables.show(0, null); look();
tables.clear(); look();
seen.push({ same: cells().every((cell, i) => cell.innerHTML === before[i]) });
document.getElementById("seen").textContent = JSON.stringify(seen);
</script></body></html>"""


@pytest.fixture(scope="session", params=["center", pytest.param("right", marks=pytest.mark.heavy)])
def seen(tmp_path_factory, request):
    """The cells of a small page after each call, and the widths of their columns, in Chromium."""
    if CHROMIUM is None:
        pytest.skip("this machine has no Chromium")
    folder = tmp_path_factory.mktemp("chromium")
    style = (LIVE.parent / "style.css").read_text("utf-8") + (LIVE / "tables.css").read_text("utf-8")
    (folder / "page.html").write_text(PAGE.replace("ALIGN", request.param) % (style, SCRIPT), "utf-8")
    flags = ["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", f"--user-data-dir={folder / 'profile'}"]
    call = [CHROMIUM, *flags, "--dump-dom", (folder / "page.html").as_uri()]
    page = subprocess.run(call, capture_output=True, text=True, timeout=120).stdout
    return json.loads(page.partition('<pre id="seen">')[2].partition("</pre>")[0])


def test_a_coarse_number_has_three_digits_and_is_marked(seen):
    assert seen[1]["texts"] == [
        ["live-number coarse", "off", "1.35"],
        ["live-number coarse", "off", "0.500"],
        *("7", "11.2(1)", "3(1)", "8"),
    ]


def test_a_fine_number_has_its_error_in_brackets(seen):
    assert seen[2]["texts"][:2] == [["live-number", "off", "1.3512(14)"], ["live-number", "off", "0.50(10)"]]


def test_a_run_that_diverged_says_when_in_each_of_its_cells(seen):
    words = ["live-number words", "off", "diverged at 3.21 s"]
    assert seen[3]["texts"][3:] == [words, words, "8"]


def test_a_metric_without_a_program_stays_as_printed(seen):
    assert seen[4]["texts"][3:] == [["live-number", "off", "2.000(10)\u2009×\u200910−7"], "3(1)", "8"]


def test_what_is_cleared_is_as_printed(seen):
    assert seen[7]["texts"][:3] == ["1.234(5)", "0.12(1)", "7"]
    assert seen[8] == seen[0]
    assert seen[9]["same"]


def test_a_column_keeps_its_width_from_the_coarse_number_to_the_fine_one_and_beside_words(seen):
    for look in seen[2:4]:
        assert look["widths"] == pytest.approx(seen[1]["widths"], abs=0.1)
    # a power of ten and a sign have widened the column, which then stays
    assert seen[6]["widths"] == pytest.approx(seen[5]["widths"], abs=0.1)


def test_a_live_number_stands_in_the_frame_of_the_printed_one_so_that_their_points_are_aligned(seen):
    pairs = [pair for look in seen[:9] for pair in look["pairs"]]
    assert len(pairs) == 16
    for number, live in pairs:
        assert live == pytest.approx(number, abs=1.0)  # px


def test_the_printed_numbers_of_these_tests_are_printed_as_the_page_does():
    assert number_text_with_error(1.3512, 0.0014) == NumberText("", "1", ".3512(14)")
    assert number_text_with_error(2e-7, 1e-9) == NumberText("", "2", ".000(10)", "−7")
