"""The face: names that load when they are asked for, the same to an editor, each with an example that runs."""

import ast
import doctest
import inspect
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

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
        held = getattr(wb, name)
        assert held is (
            import_module(held.__name__) if isinstance(held, ModuleType) else getattr(import_module(room), there)
        )
        assert not isinstance(held, ModuleType) or held.__name__ == f"{room}.{there}"


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


ROOMS = [name for name in wb.__all__ if isinstance(getattr(wb, name), ModuleType)]
OF_ROOMS = {f"{room}.{name}": getattr(getattr(wb, room), name) for room in ROOMS for name in getattr(wb, room).__all__}
HINTS = {"Array"}  # the type of a hint has the help of NumPy


def said_of(name, text):
    """What is wrong with the example in a docstring, and how many lines of it ran."""
    example = doctest.DocTestParser().get_doctest(text, {"wb": wb, "np": np, "__name__": "example"}, name, None, None)
    said = []
    doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(example, out=said.append)
    return "".join(said), len(example.examples)


@pytest.mark.parametrize("name", sorted(set(wb.__all__) - HINTS))
def test_the_example_that_help_shows_runs(name, tmp_path, monkeypatch):
    (tmp_path / "pendulum.urdf").write_text(PENDULUM, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    said, lines = said_of(name, inspect.getdoc(getattr(wb, name)))
    assert not said, said
    assert lines, "no example"


def test_the_examples_of_the_names_in_a_room_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    texts = {
        name: inspect.getdoc(thing) or ""
        for name, thing in OF_ROOMS.items()
        if inspect.isclass(thing) or inspect.isfunction(thing)
    }
    wrong = {name: said for name, text in texts.items() if ">>>" in text and (said := said_of(name, text)[0])}
    assert not wrong, wrong


def test_each_name_in_a_room_is_explained():
    bare = [name for name, thing in OF_ROOMS.items() if inspect.isfunction(thing) and not thing.__doc__]
    assert not bare


@pytest.mark.parametrize("room", sorted(path.parent.name for path in Path(wb.__file__).parent.glob("*/__init__.pyi")))
def test_editors_and_mypy_see_the_names_of_a_room_that_loads_them_late(room):
    held = import_module(f"workbench.{room}")
    stub = ast.parse((Path(held.__file__).with_suffix(".pyi")).read_text(encoding="utf-8"))
    seen = {}
    for node in stub.body:
        if isinstance(node, ast.ImportFrom):
            seen |= {alias.asname or alias.name: (node.module, alias.name) for alias in node.names}
        elif isinstance(node, ast.Assign):
            assert ast.literal_eval(node.value) == sorted(held.__all__)
    assert seen.keys() == set(held.__all__)
    for name, (home, there) in seen.items():
        module = import_module(home)
        assert getattr(held, name) is (getattr(module, there, None) or import_module(f"{home}.{there}"))
