"""The door for a new user: the opening of the page on loop pictures, run cell by cell as a notebook runs it."""

import ast
import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "howto" / "loop_pictures.md").read_text(encoding="utf-8")
OPENING = re.search(r"^```python\n(.*?)^```$", PAGE, re.M | re.S)[1]


def cell(source, names):
    """What a notebook displays below a cell: the HTML of its last expression, if it has any, else its line of text."""
    tree = ast.parse(source)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, "cell", "exec"), names)
    if last is None:
        return None
    value = eval(compile(ast.Expression(last.value), "cell", "eval"), names)
    return value._repr_html_() if hasattr(value, "_repr_html_") else repr(value)


def test_six_lines_lead_from_a_plant_of_ones_own_to_bode_margins_and_poles():
    assert len(ast.parse(OPENING).body) == 6
    shown = cell(OPENING, {})
    assert shown.startswith("<figure><svg")
    assert "phase margin 61.4 degrees" in shown.partition("<figcaption>")[2]


def test_the_margins_of_the_opening_are_those_of_python_control(tmp_path, monkeypatch):
    import control
    import numpy as np

    monkeypatch.chdir(tmp_path)
    names = {}
    cell(OPENING, names)
    (found,) = names["linear"].margins().values()
    _, phase, _, _ = control.margin(names["linear"].L)
    np.testing.assert_allclose(found.margins.phase_margin.value, phase, rtol=1e-6)
    assert cell("linear.plot('poles').savefig('poles.png')", names).endswith("poles.png')")
    assert (tmp_path / "poles.png").read_bytes().startswith(b"\x89PNG")


def test_a_cell_that_ends_with_the_loop_shows_its_line():
    names = {}
    cell(OPENING, names)
    assert cell("linear", names).startswith("<LinearLoop 'loop' cut at a: 4 states")
    assert cell("linear.plot", names).startswith("<bound method")
