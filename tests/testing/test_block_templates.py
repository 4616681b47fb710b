"""The templates that a reader fills in run and pass their tests as they stand."""

import ast
import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.house_blocks import LONG_TESTS

ROOT = Path(__file__).parents[2]
TEMPLATES = sorted((ROOT / "docs" / "templates").glob("*.py"))
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


@pytest.mark.parametrize("file", TEMPLATES, ids=lambda file: file.stem)
def test_a_template_passes_its_tests_and_is_short(file):
    (tests,) = kit_in(file)
    names = [name for name in dir(tests) if name.startswith("test_") and name not in LONG_TESTS]
    assert len(names) > 4
    for name in names:
        getattr(tests(), name)()
    assert len(lines_of_code(file)) <= LONGEST


@pytest.mark.heavy
def test_pytest_collects_the_templates_as_they_stand(tmp_path):
    line = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *map(str, TEMPLATES), "-c", "/dev/null"]
    done = subprocess.run(
        line, cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(ROOT)}, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout
    assert " passed" in done.stdout
