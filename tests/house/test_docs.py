"""The pages in `docs/`, and the README: every block of Python runs, and the site is built without a warning."""

import ast
import os
import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

from docs.fits import of_logs
from docs.loops import of_arms, of_plans, of_plants
from tests.support.forks import run_all

ROOT = Path(__file__).parents[2]
BLOCK = re.compile(r"^```python\n(.*?)^```$(?:\n```text\n(.*?)^```$)?", re.M | re.S)  # a block, and what it prints
PAGES = sorted(page for page in (ROOT / "docs").rglob("*.md") if BLOCK.search(page.read_text(encoding="utf-8")))
README = re.findall(r"^```python\n(.*?)^```$", (ROOT / "README.md").read_text(encoding="utf-8"), re.M | re.S)
# The first loop, and blocks with a study, run in tests/house/test_readme.py.
BLOCKS = [block for block in README if "wb.Study(" not in block and "first_loop" not in block]
LONG = {  # more than a second of a processor each
    *("declared_work", "digital_loops", "equipment", "filters", "fit", "fmus", "gains", "linear_answers", "live_pages"),
    *("linear_models", "logs", "loop_pictures", "pid", "plan", "read_a_log", "scheduling", "specifications"),
    "structured_tuning",
}
ENDS = "-- the block ends --"
MASSES = "uniform(0.8, 1.2, {})"  # of the README's thousand arms, of which fifty say whether the block runs


def long(is_long):
    """The marks of a page or a block: long ones run with all tests only."""
    return [pytest.mark.heavy] if is_long else []


@pytest.fixture(scope="module")
def done(request, tmp_path_factory):
    """How the programs that are asked for ended, and what they printed: the blocks of a page, or one of the README."""
    programs = {}
    for item in (item for item in request.session.items if item.path == request.path and hasattr(item, "callspec")):
        ((kind, given),) = item.callspec.params.items()
        blocks = BLOCK.findall(given.read_text(encoding="utf-8")) if kind == "page" else [(given, "")]
        text = "\n".join(f"{code}\nprint({ENDS!r})" for code, _ in blocks)
        programs[given] = text.replace(MASSES.format(1000), MASSES.format(50))
    environment = {"PYTHONPATH": str(ROOT), "PYTHONWARNINGS": "error", "PATH": ""}
    environment |= {name: os.environ[name] for name in ("WORKBENCH_CACHE", "OPENBLAS_NUM_THREADS")}
    return run_all(programs, tmp_path_factory.mktemp("pages"), environment)


@pytest.mark.parametrize("page", [pytest.param(page, marks=long(page.stem in LONG), id=page.stem) for page in PAGES])
def test_the_blocks_of_a_page_run_one_after_the_other_and_print_what_stands_below_them(page, done):
    assert done[page].returncode == 0, done[page].stderr
    blocks = BLOCK.findall(page.read_text(encoding="utf-8"))
    for (_, wanted), printed in zip(blocks, done[page].stdout.split(f"{ENDS}\n"), strict=False):
        assert not wanted or printed == wanted


@pytest.mark.parametrize("block", [pytest.param(block, marks=long(block is not BLOCKS[0])) for block in BLOCKS])
def test_a_block_of_the_readme_runs(block, done):
    folder, *ended, stdout, stderr = done[block]
    assert (*ended, stderr) == (0, "")
    for picture in re.findall(r"savefig\('(.*?)'\)", block.replace('"', "'")):
        assert (folder / picture).read_bytes().startswith(b"\x89PNG")
    for printed in re.findall(r"# \[\[(-70.7107 .*?)\]\]", block):  # the gain, beside the line that prints it
        computed = re.findall(r"\[\[(.*?)\]\]", stdout)[0].split()
        assert [f"{float(number):.4f}" for number in computed] == printed.split()


STUDIES = [
    page for page in PAGES if any(code.count("study = wb.Study(") for code, _ in BLOCK.findall(page.read_text("utf-8")))
]


@pytest.mark.heavy
@pytest.mark.parametrize("page", STUDIES, ids=lambda page: page.stem)
def test_the_study_of_a_guide_runs_by_the_command(page, command, tmp_path):
    block = next(code for code, _ in BLOCK.findall(page.read_text("utf-8")) if "study = wb.Study(" in code)
    (tmp_path / "guide.py").write_text(block, encoding="utf-8")
    done = command("run", "guide.py", "--yes")
    assert done.exit_code == 0, done.stderr
    assert list(tmp_path.glob("reports/*/index.html"))


def arguments():
    """The arguments and fields that the source of the workbench declares."""
    for file in (ROOT / "workbench").rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text("utf-8"))):
            if isinstance(node, ast.FunctionDef):
                yield from (one.arg for one in (*node.args.args, *node.args.kwonlyargs))
            if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
                yield node.target.id


OTHERS = {
    "FIT",
    "PYTHON",
    "LOGS",
    "WORKBENCH_CACHE",
    "display_margins",
    "plot_phase",
    "returnall",
}  # of make, of other tools


def test_each_argument_that_a_page_names_is_declared_somewhere():
    declared = {*arguments(), *OTHERS}
    wrong = []
    for page in [ROOT / "README.md", *(ROOT / "docs").glob("howto/*.md"), *(ROOT / "docs").glob("theory/*.md")]:
        for code in re.findall(r"`([^`\n]+)`", page.read_text("utf-8")):
            named = re.findall(r"(?<![\w.=<>!#-])([A-Za-z_]\w*)=(?!=)", code)
            wrong += [f"{page.name}: {name}=" for name in named if name not in declared]
    assert wrong == []


def test_each_object_whose_docstring_a_page_shows_is_there():
    shown = [
        line.split("::")[1].strip()
        for page in (ROOT / "docs").glob("*/*.md")
        for line in page.read_text("utf-8").splitlines()
        if re.match(r"\.\. auto(class|function)::", line)
    ]
    assert shown
    missing = [name for name in shown if not hasattr(import_module(name.rpartition(".")[0]), name.rpartition(".")[2])]
    assert missing == []


def broken_links(site):
    """The links and pictures of a site, page by page, that lead to no file of it."""
    broken = []
    for page in (path for path in site.rglob("*.html") if "_static" not in path.parts):
        for link in re.findall(r'(?:href|src)="([^"#?]+)[^"]*"', page.read_text(encoding="utf-8")):
            if not re.match(r"\w+:", link) and not (page.parent / link).exists():
                broken.append(f"{page.relative_to(site)}: {link}")
    return broken


@pytest.mark.heavy
def test_the_site_is_built_without_a_warning(tmp_path):
    pytest.importorskip("sphinx")
    pytest.importorskip("numpydoc")
    pytest.importorskip("myst_nb")
    line = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html", "-d", tmp_path / "trees"]
    done = subprocess.run([*line, ROOT / "docs", tmp_path / "site"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    gallery = (tmp_path / "site" / "gallery.html").read_text(encoding="utf-8")
    pages = {*re.findall(r'href="(_static/loops/[\w-]+\.html)"', gallery)}
    assert len(pages) == len(of_arms()) + len(of_plants()) + len(of_plans()) + len(of_logs())
    for page in pages:  # each can be turned, and stands beside its picture
        assert 'id="live"' in (tmp_path / "site" / page).read_text(encoding="utf-8")
        assert (tmp_path / "site" / page).with_suffix(".svg").is_file()
    assert broken_links(tmp_path / "site") == []
