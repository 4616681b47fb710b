"""The templates that a reader fills in, and the blocks that one wrote who had read README only, pass their tests."""

import ast
import importlib.util
import os
import runpy
import subprocess
import sys
from pathlib import Path

import pytest

import workbench as wb
from tests.support.house_blocks import LONG_TESTS

ROOT = Path(__file__).parents[2]
TEMPLATES = sorted((ROOT / "docs" / "templates").glob("*.py"))
WRITTEN = sorted((ROOT / "tests" / "testing" / "blocks_of_a_reader").glob("*.py"))  # as they passed at the first try
PLANTS = {"own_plant": "Ball", "own_study": "Tank"}
LONGEST = 40  # lines of code of a law with its tests


def kit_in(file):
    """The classes of tests in a template."""
    spec = importlib.util.spec_from_file_location(f"template_{file.stem}", file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return [held for name, held in vars(module).items() if name.startswith("Test")]


def lines_of_code(file):
    """The lines of a file but comments, docstrings and empty ones."""
    text = file.read_text(encoding="utf-8")
    docs = [node.body[0] for node in ast.walk(ast.parse(text)) if hasattr(node, "body") and ast.get_docstring(node)]
    told = {line for doc in docs for line in range(doc.lineno, doc.end_lineno + 1)}
    lines = enumerate(text.splitlines(), 1)
    return [line for number, line in lines if number not in told and line.split("#")[0].strip()]


@pytest.mark.parametrize("file", TEMPLATES + WRITTEN, ids=lambda file: f"{file.parent.stem}-{file.stem}")
def test_a_template_passes_its_tests_and_is_short(file):
    (tests,) = kit_in(file)
    names = [name for name in dir(tests) if name.startswith("test_") and name not in LONG_TESTS]
    assert len(names) > 4
    for name in names:
        getattr(tests(), name)()
    assert len(lines_of_code(file)) <= LONGEST


@pytest.mark.parametrize("name", PLANTS)
def test_a_plant_that_readme_shows_passes_the_tests_of_plants(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # the file draws a picture
    made = runpy.run_path(str(ROOT / "studies" / f"{name}.py"))[PLANTS[name]]
    tests = type("Tests", (wb.testing.PlantTests,), {"plant": lambda _: made()})
    for test in (test for test in dir(tests) if test.startswith("test_") and test not in LONG_TESTS):
        getattr(tests(), test)()


@pytest.mark.heavy
def test_pytest_collects_the_templates_as_they_stand(tmp_path):
    """Their tests pass above; here pytest finds them where they stand."""
    options = "-q", "--collect-only", "-p", "no:cacheprovider", "-c", "/dev/null"
    line = [sys.executable, "-m", "pytest", *options, *map(str, TEMPLATES)]
    done = subprocess.run(
        line, cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(ROOT)}, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout
    for template in TEMPLATES:
        assert f"{template.name}::" in done.stdout
