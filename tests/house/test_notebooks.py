"""The notebooks of the site are the files of the walk, cut into cells, and Jupyter reads them."""

import ast
import json
import re
import warnings

import pytest

from docs.notebook_outputs import pictures, run
from docs.walk_notebooks import DOWNLOADS, INLINE, NOTEBOOKS, Cell, Notebook
from tests.house.sources import ROOT

EACH = pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda one: one.name)


def code_of(document):
    return [cell["source"] for cell in document["cells"] if cell["cell_type"] == "code"]


def without_saving(code):
    """The code in which each picture is made and not saved."""
    return re.sub(r'\.savefig\("[^"]*"\)$', "", code, flags=re.M)


def test_each_file_that_the_readme_shows_has_a_notebook():
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.S)
    walk = [path for path in (ROOT / "studies").glob("*.py") if path.read_text(encoding="utf-8") in blocks]
    assert walk
    assert {f"studies/{path.name}" for path in walk} <= {one.source for one in NOTEBOOKS}


@EACH
def test_the_code_of_a_notebook_is_that_of_its_file_and_shows_what_the_file_saves(notebook):
    first, *cells = code_of(notebook.document())
    assert first == INLINE
    code = []
    for cell, source in zip(notebook.cells, cells, strict=True):
        code.append(source.removesuffix(cell.shows).rstrip())
    whole = (ROOT / notebook.source).read_text(encoding="utf-8")
    assert ast.dump(ast.parse("\n".join(code))) == ast.dump(
        ast.Module(ast.parse(without_saving(whole)).body[1:], [])
    )  # less its docstring
    comments = [line.strip() for line in whole.splitlines() if "#" in line]
    assert [line for line in comments if line not in "\n".join(code)] == []
    for cell in code:  # a notebook shows the value of the last expression of a cell alone
        assert not any(isinstance(one, ast.Expr) for one in ast.parse(cell).body[:-1])


@EACH
def test_a_notebook_is_one_for_jupyter_without_outputs(notebook):
    document = json.loads(json.dumps(notebook.document(download=True)))
    assert all(cell["outputs"] == [] for cell in document["cells"] if cell["cell_type"] == "code")
    assert len({cell["id"] for cell in document["cells"]}) == len(document["cells"])
    nbformat = pytest.importorskip("nbformat")
    nbformat.validate(nbformat.from_dict(document))


@EACH
def test_the_sentences_of_a_notebook_are_short(notebook):
    for cell in notebook.cells:
        assert cell.text.endswith(".")
        for sentence in re.split(r"(?<=[.:]) ", cell.text):
            assert len(sentence.split()) <= 25, sentence


@EACH
def test_a_page_gives_its_notebook_without_the_link_to_itself(notebook):
    page, given = notebook.document(download=True), notebook.document()
    assert f"{{download}}`Download this notebook <{DOWNLOADS}/{notebook.name}.ipynb>`" in page["cells"][0]["source"]
    assert "{download}" not in json.dumps(given)
    assert page["cells"][1:] == given["cells"][1:]


@pytest.mark.heavy
def test_a_notebook_that_is_run_shows_its_pictures():
    pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of Jupyter's own
        document = run(NOTEBOOKS[0].document())
    kinds = [kind for kind, _ in pictures(document)]
    assert kinds == ["png", "svg"]
    assert [cell["execution_count"] for cell in document["cells"] if cell["cell_type"] == "code"] == [1, 2, 3, 4, 5, 6]


@pytest.mark.parametrize(
    ("cells", "why"),
    [
        ((Cell("motor = ", "Late."), Cell("loop = ", "Later.")), "leave none out"),
        ((Cell("import", "First."), Cell("nothing = ", "None.")), "0 lines"),
        ((Cell("import", "First."), Cell("runs = ", "Later."), Cell("motor = ", "Earlier.")), "in the order"),
    ],
)
def test_cells_that_do_not_fit_their_file_are_refused(cells, why):
    with pytest.raises(ValueError, match=why):
        Notebook("studies/first.py", "A first loop", cells).document()
