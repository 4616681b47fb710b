"""The pages in `docs/`: every block of Python runs, page by page, and the site is built without a warning."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from docs.loops import of_arms, of_plants
from tests.support.forks import run_all

ROOT = Path(__file__).parents[2]
BLOCK = re.compile(r"^```python\n(.*?)^```$(?:\n```text\n(.*?)^```$)?", re.M | re.S)  # a block, and what it prints
PAGES = sorted(page for page in (ROOT / "docs").rglob("*.md") if BLOCK.search(page.read_text(encoding="utf-8")))
LONG = {"digital_loops", "loop_pictures", "specifications"}  # more than a second of a processor each
ENDS = "-- the block ends --"


def marks_of(page):
    """Long pages run with all tests only."""
    return [pytest.mark.heavy] if page.stem in LONG else []


@pytest.fixture(scope="module")
def done(request, tmp_path_factory):
    """How the blocks of each page that is asked for ended, and what they printed."""
    here = [item for item in request.session.items if item.path == request.path and hasattr(item, "callspec")]
    programs = {
        page: "\n".join(f"{code}\nprint({ENDS!r})" for code, _ in BLOCK.findall(page.read_text(encoding="utf-8")))
        for page in (item.callspec.params["page"] for item in here)
    }
    environment = {"PYTHONPATH": str(ROOT), "PYTHONWARNINGS": "error", "PATH": ""}
    environment |= {name: os.environ[name] for name in ("WORKBENCH_CACHE", "OPENBLAS_NUM_THREADS")}
    return run_all(programs, tmp_path_factory.mktemp("pages"), environment)


@pytest.mark.parametrize("page", [pytest.param(page, marks=marks_of(page), id=page.stem) for page in PAGES])
def test_the_blocks_of_a_page_run_one_after_the_other_and_print_what_stands_below_them(page, done):
    assert done[page].returncode == 0, done[page].stderr
    blocks = BLOCK.findall(page.read_text(encoding="utf-8"))
    for (_, wanted), printed in zip(blocks, done[page].stdout.split(f"{ENDS}\n"), strict=False):
        assert not wanted or printed == wanted


@pytest.mark.heavy
def test_the_site_is_built_without_a_warning(tmp_path):
    pytest.importorskip("sphinx")
    pytest.importorskip("numpydoc")
    line = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html", "-d", tmp_path / "trees"]
    done = subprocess.run([*line, ROOT / "docs", tmp_path / "site"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    gallery = (tmp_path / "site" / "gallery.html").read_text(encoding="utf-8")
    pages = re.findall(r'href="(_static/loops/[\w-]+\.html)"', gallery)
    assert len(pages) == len({*pages}) == len(of_arms()) + len(of_plants())
    for page in pages:  # each can be turned, and stands beside its picture
        assert 'id="live"' in (tmp_path / "site" / page).read_text(encoding="utf-8")
        assert (tmp_path / "site" / page).with_suffix(".svg").is_file()
