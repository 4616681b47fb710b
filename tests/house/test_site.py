"""The pages that the site makes of the code: the reference by purposes, and the gallery."""

import re
from collections import Counter
from pathlib import Path

import pytest

import workbench as wb
from docs import fits
from docs.gallery_entries import LAWS, LINES, NOTEBOOKS, Notebook, fit_card, notebook_card
from docs.loops import of_arms
from docs.reference_groups import GROUPS
from docs.reference_page import anchor, example, in_html

ROOT = Path(__file__).parents[2]
ENTRIES = [(name, line) for group in GROUPS for name, line in group.names.items()]


def test_each_name_of_the_face_stands_in_exactly_one_group_of_the_reference():
    assert Counter(name for name, _ in ENTRIES) == Counter(wb.__all__)


@pytest.mark.parametrize(("name", "line"), ENTRIES)
def test_the_purpose_of_a_name_is_one_short_line(name, line):
    assert line[0].isupper()
    assert line.endswith(".")
    assert 2 <= len(line.split()) <= 16


def test_the_groups_of_the_reference_have_addresses_of_their_own():
    anchors = [anchor(group) for group in GROUPS]
    assert len({*anchors}) == len(anchors)


def test_an_example_of_the_reference_is_that_of_the_docstring():
    assert "feedback" not in example("rk4")
    assert re.sub(r"<.*?>", "", example("Step")).startswith("&gt;&gt;&gt; wb.Step(")
    assert "\n\n" not in "".join(example(name) for name, _ in ENTRIES)  # it would end the block of HTML


def test_code_in_a_purpose_is_marked_and_the_rest_is_escaped():
    assert in_html("a < b of `Ode`") == "a &lt; b of <code>Ode</code>"


def test_each_report_and_each_law_of_the_gallery_has_a_line():
    assert {place.parent.name for place in (ROOT / "reports").glob("*/index.html")} <= LINES.keys()
    assert LAWS.keys() == of_arms().keys()


def missing(notebook):
    """What a notebook of the gallery names and the project has not."""
    files = [path for path in (notebook.thumbnail, notebook.file) if not (ROOT / path).is_file()]
    return files + ([] if any((ROOT / "docs").glob(f"{notebook.page}.*")) else [notebook.page])


def test_the_files_of_each_notebook_are_there():
    assert missing(Notebook("", "", "docs/none.png", "none", "none.ipynb")) == ["docs/none.png", "none.ipynb", "none"]
    assert [name for notebook in NOTEBOOKS for name in missing(notebook)] == []


def test_a_fit_has_a_card_with_its_live_page_and_its_picture(tmp_path, monkeypatch):
    monkeypatch.setattr("docs.gallery_entries.LOOPS", tmp_path)
    (one,) = fits.of_logs()
    text = fit_card(one)
    assert one.fit.warnings == ()
    assert 'id="live"' in (tmp_path / "a-dc-motor-from-its-log.html").read_text(encoding="utf-8")
    assert (tmp_path / "a-dc-motor-from-its-log.svg").read_text(encoding="utf-8").startswith("<svg")
    assert "_static/loops/a-dc-motor-from-its-log.html" in text


def test_a_notebook_has_a_card_with_its_page_and_its_file(tmp_path, monkeypatch):
    for name in ("THUMBNAILS", "FILES"):
        (tmp_path / name).mkdir()
        monkeypatch.setattr(f"docs.gallery_entries.{name}", tmp_path / name)
    one = Notebook("A loop", "It runs.", "docs/pictures/live.png", "notebooks/loop", "studies/first.py")
    links = re.findall(r'href="(.*?)"', notebook_card(one))
    assert links == ["notebooks/loop.html", "notebooks/loop.html", "_static/files/first.py"]
    assert (tmp_path / "FILES" / "first.py").read_bytes() == (ROOT / "studies" / "first.py").read_bytes()
    assert (tmp_path / "THUMBNAILS" / "live.png").is_file()
