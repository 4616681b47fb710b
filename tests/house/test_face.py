"""The face: names that load when they are asked for, the same to an editor, each with an example that runs."""

import ast
import doctest
import inspect
import re
import subprocess
import sys
from importlib import import_module
from operator import attrgetter
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


def test_a_name_of_another_toolbox_is_answered_with_ours():
    with pytest.raises(AttributeError, match=r"In place of 'dlqr' .*, use wb\.lqr\(\.\.\., discrete=True\);"):
        _ = wb.dlqr
    with pytest.raises(AttributeError, match=r"use wb\.step_info; the how-to"):
        _ = wb.stepinfo


def test_an_earlier_name_is_answered_with_the_new_one():
    with pytest.raises(AttributeError, match="no attribute 'Regulator'. It is called 'StateFeedback' now"):
        _ = wb.Regulator
    assert set(wb._RENAMED.values()) <= set(wb.__all__)
    assert not set(wb._RENAMED) & set(wb.__all__)


def test_what_answers_a_name_of_another_toolbox_is_there_and_the_name_is_not_ours():
    for names, ours in wb._OTHER_TOOLBOXES.items():
        assert not {*names.split()} & {*wb.__all__}
        answers = re.findall(r"wb\.((?:\w+\.)?\w+)", ours)
        assert answers
        for answer in answers:
            attrgetter(answer)(wb)


def test_each_name_of_another_toolbox_has_one_answer():
    names = [name for row in wb._OTHER_TOOLBOXES for name in row.split()]
    assert len(names) == len(set(names))


def test_dir_lists_the_face_and_nothing_else():
    import_module("workbench.engine")  # a room that is loaded is an attribute, and no name of the face
    assert set(wb.__all__) == {name for name in dir(wb) if not name.startswith("__")}


ROOMS = [name for name in wb.__all__ if isinstance(getattr(wb, name), ModuleType)]
OF_ROOMS = {f"{room}.{name}": getattr(getattr(wb, room), name) for room in ROOMS for name in getattr(wb, room).__all__}
HINTS = {"Array"}  # the type of a hint has the help of NumPy


@pytest.mark.parametrize("name", sorted(set(wb.__all__) - HINTS))
def test_help_shows_an_example(name):  # that it runs is tested in tests/house/test_fuzz.py
    assert doctest.DocTestParser().get_examples(inspect.getdoc(getattr(wb, name))), "no example"


@pytest.mark.parametrize("room", [*ROOMS])
def test_the_example_in_the_help_of_a_room_runs(room, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shown = {"wb": wb, "np": np, "__name__": "example"}
    example = doctest.DocTestParser().get_doctest(inspect.getdoc(getattr(wb, room)), shown, room, None, None)
    said = []
    doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(example, out=said.append)
    assert not said, "".join(said)


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
