"""The face: names that load when they are asked for, the same to an editor, each with an example that runs."""

import ast
import doctest
import inspect
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import workbench as wb

HEAVY = ("casadi", "control", "matplotlib", "numpy", "pandas", "scipy", "workbench.core")
LONGEST = 0.1  # s of the processor, beyond the start of Python


def test_the_face_is_there_at_once_and_loads_nothing():
    code = (
        "import sys, time; start = time.process_time(); import workbench; took = time.process_time() - start; "
        f"print(took < {LONGEST}, [name for name in {HEAVY} if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "True []"


def test_editors_and_mypy_see_the_names_of_the_face_and_no_others():
    stub = ast.parse((Path(wb.__file__).parent / "__init__.pyi").read_text(encoding="utf-8"))
    seen = {}
    for node in stub.body:
        if isinstance(node, ast.ImportFrom):
            seen |= {alias.asname or alias.name: (node.module, alias.name) for alias in node.names}
        elif isinstance(node, ast.Assign):
            assert ast.literal_eval(node.value) == sorted(wb.__all__)
    assert seen.keys() == set(wb.__all__)
    for name, (room, there) in seen.items():
        assert getattr(wb, name) is getattr(import_module(room), there)


def test_a_misspelt_name_is_answered_with_the_nearest():
    with pytest.raises(AttributeError, match="no attribute 'ClosedLop'. Did you mean 'ClosedLoop'?"):
        _ = wb.ClosedLop


def test_dir_lists_the_face():
    assert set(wb.__all__) <= set(dir(wb))


PENDULUM = """<robot name="pendulum">
  <link name="base"/>
  <link name="rod"><inertial><origin xyz="0 0 -0.5"/><mass value="1.5"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="hinge" type="continuous"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/></joint>
</robot>"""


@pytest.mark.parametrize("name", wb.__all__)
def test_the_example_that_help_shows_runs(name, tmp_path, monkeypatch):
    (tmp_path / "pendulum.urdf").write_text(PENDULUM, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    text = inspect.getdoc(getattr(wb, name))
    example = doctest.DocTestParser().get_doctest(text, {"wb": wb, "np": np, "__name__": "example"}, name, None, None)
    assert example.examples, "no example"
    said = []
    doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(example, out=said.append)
    assert not said, "".join(said)
