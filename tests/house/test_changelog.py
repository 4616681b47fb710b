"""The changelog: a closed section, fragments of known kinds, and one section that they make at a release."""

import re
import shutil
import subprocess
import sys
import tomllib

import pytest

from tests.house.sources import ROOT

CHANGES = ROOT / "docs" / "changes"
CHANGELOG = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
SETTINGS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["towncrier"]
KINDS = {kind["directory"]: kind["name"] for kind in SETTINGS["type"]}
FRAGMENTS = sorted(path for path in CHANGES.iterdir() if path.name != "README.md")


def test_numbers_that_changed_come_first_and_keep_their_head():
    assert next(iter(KINDS.values())) == "Numbers that changed"
    assert "### Numbers that changed\n" in CHANGELOG


def test_the_page_of_the_changes_names_each_kind_with_its_head():
    rows = re.findall(r"(?m)^\| `(\w+)` \| (.+?) \|", (CHANGES / "README.md").read_text(encoding="utf-8"))
    assert dict(rows) == KINDS


def test_the_changelog_has_the_place_of_the_next_section_above_all_sections():
    assert CHANGELOG.count(SETTINGS["start_string"]) == 1
    assert CHANGELOG.index(SETTINGS["start_string"]) < CHANGELOG.index("\n## ")
    assert not re.search(r"(?im)^## unreleased", CHANGELOG)


@pytest.mark.parametrize("fragment", FRAGMENTS, ids=lambda path: path.name)
def test_a_change_has_a_kind_and_whole_sentences(fragment):
    assert re.fullmatch(rf"\+\w+\.({'|'.join(KINDS)})\.md", fragment.name)
    text = fragment.read_text(encoding="utf-8").strip()
    assert text.endswith(".")
    assert not re.search(r"(?m)^(#|- )", text), "a head or a list: towncrier makes these"


def test_a_release_joins_changes_of_each_kind_in_their_order(tmp_path):
    pytest.importorskip("towncrier")
    for name in ("pyproject.toml", "CHANGELOG.md"):
        shutil.copy(ROOT / name, tmp_path)
    folder = tmp_path / SETTINGS["directory"]
    folder.mkdir(parents=True)
    shutil.copy(CHANGES / "README.md", folder)
    for kind in KINDS:
        (folder / f"+one.{kind}.md").write_text(f"A change that is {kind}.\n", encoding="utf-8")
    line = [sys.executable, "-m", "towncrier", "build", "--yes", "--version", "9.9.9", "--date", "2030-01-02"]
    done = subprocess.run(line, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    new = (tmp_path / "CHANGELOG.md").read_text(encoding="utf-8")
    section, old = new.split("\n## 0.1.0", 1)
    section = section[section.index("\n## 9.9.9 (2030-01-02)") :]
    assert re.findall(r"(?m)^### (.*)$", section) == list(KINDS.values())
    assert re.findall(r"(?m)^- A change that is (\w+)\.$", section) == list(KINDS)
    assert old == CHANGELOG.split("\n## 0.1.0", 1)[1]
