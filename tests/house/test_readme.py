"""The walk of the README: its blocks are the files in `studies/`, and all of them run as they stand."""

import re
import runpy
from pathlib import Path

import pytest

import workbench as wb
from studies.paper.readme import FIRST

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
WALK = ("first", "own_plant", "own_law", "own_study")


def walk(name):
    return (ROOT / "studies" / f"{name}.py").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", WALK)
def test_the_readme_shows_each_file_of_the_walk_as_it_stands(name):
    assert walk(name) in BLOCKS
    assert f"studies/{name}.py" in README
    assert len(walk(name).splitlines()) <= (10 if name == "first" else 40)


def test_the_readme_has_the_order_of_a_reader():
    heads = re.findall(r"^## (.*)$", README, re.M)
    walk = ["A plant of your own", "A law of your own", "Gains with certificates", "Designs from specifications"]
    assert heads[:6] == ["Install", "A first loop", *walk]
    assert heads[-2:] == ["What it found about one paper", "Licence"]
    assert README.index("pip install") < README.index("    make paper\n    make test\n")
    assert README.index(FIRST) > README.index(heads[-2])


def test_each_link_of_the_readme_leads_to_a_file():
    links = re.findall(r"\]\((?!https?:)(.+?)\)", README)
    assert links
    assert [link for link in links if not (ROOT / link).is_file()] == []


@pytest.mark.parametrize("folder", ["howto", "theory"])
def test_the_readme_leads_to_each_guide_or_to_a_guide_that_does(folder):
    pages = sorted((ROOT / "docs" / folder).glob("*.md"))
    linked = README + "".join(page.read_text(encoding="utf-8") for page in pages)
    assert [page.name for page in pages if f"{page.name})" not in linked] == []


def test_the_first_picture_is_small_and_there():
    first = re.search(r"!\[(.+?)\]\((.+?)\)", README)
    assert README.index(first[0]) < README.index("make paper")
    assert first[2] == "docs/pictures/live.png"
    assert (ROOT / first[2]).stat().st_size < 150_000


def test_the_first_loop_has_the_bode_plot_and_the_margins_that_the_walk_shows(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    loop = runpy.run_path(str(ROOT / "studies" / "first.py"))["loop"]
    assert (tmp_path / "first_loop.png").read_bytes().startswith(b"\x89PNG")
    margins = wb.linear_loop(loop).margins()["v"].margins
    assert f"a phase margin of {margins.phase_margin.value:.1f} degrees" in " ".join(README.split())
    assert f"Ms = {margins.Ms.gain.value:.2f}," in README


@pytest.mark.parametrize("name", ["first_loop", "first_live"])
def test_the_pictures_of_the_first_walk_are_small_and_there(name):
    place = f"docs/pictures/{name}.png"
    assert README.index("## A first loop") < README.index(place) < README.index("## A plant of your own")
    assert (ROOT / place).stat().st_size < 150_000


def test_the_first_loop_has_a_live_page_as_the_walk_says(command, tmp_path):
    (tmp_path / "first.py").write_text(walk("first"), encoding="utf-8")
    done = command("live", "first.py")
    assert (done.exit_code, done.stderr) == (0, "'loop' until 2 s, at steps of 0.001 s.\n")
    assert 'id="live"' in (tmp_path / "first.html").read_text(encoding="utf-8")


def test_the_laws_of_the_walk_stand_side_by_side(command, tmp_path):
    (tmp_path / "own_law.py").write_text(walk("own_law"), encoding="utf-8")
    done = command("run", "own_law.py")
    assert (done.exit_code, done.stderr) == (0, "")
    table = (tmp_path / "reports" / "own_law" / "tables" / "metrics.csv").read_text(encoding="utf-8")
    assert [line.split(",")[0] for line in table.splitlines()] == ["law", "PI", "lead"]
    errors = [f"{float(line.split(',')[1]):.3f} rad/s" for line in table.splitlines()[1:]]
    tutorial = (ROOT / "docs" / "tutorial" / "own_law.md").read_text(encoding="utf-8")
    assert f"{errors[1]} against {errors[0]}" in tutorial


def test_the_study_of_the_readers_own_runs(command, tmp_path):
    (tmp_path / "own_study.py").write_text(walk("own_study"), encoding="utf-8")
    done = command("run", "own_study.py")
    assert done.exit_code == 0
    assert "1,280 runs" in (tmp_path / "reports" / "own_study" / "index.html").read_text(encoding="utf-8")
