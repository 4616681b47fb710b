"""Names of a room that load when they are asked for."""

import subprocess
import sys

import pytest

import workbench as wb
from workbench.core.lazy_names import lazy_names


def test_a_name_comes_from_its_file_and_a_module_of_the_room_by_its_own_name():
    names, load, _ = lazy_names("workbench.design", {"": "riccati", "linear": "place"})
    assert names == ["place", "riccati"]
    assert load("place") is wb.place
    assert load("riccati") is wb.riccati


def test_a_name_that_the_room_does_not_have_is_an_attribute_error_with_the_room():
    _, load, _ = lazy_names("workbench.design", {"linear": "place"})
    with pytest.raises(AttributeError, match=r"'workbench\.design' has no attribute 'plaice'"):
        load("plaice")


@pytest.mark.parametrize(("room", "heavy"), [("arms", "workbench.arms.laws"), ("proofs", "workbench.engine.batch")])
def test_a_room_loads_none_of_its_files_before_one_is_used(room, heavy):
    code = f"import sys, workbench.{room}; print({heavy!r} in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "False\n"


@pytest.mark.parametrize("room", [wb.arms, wb.proofs, wb.handover, wb.study], ids=lambda room: room.__name__)
def test_dir_lists_the_names_of_a_room_before_they_are_loaded(room):
    assert set(room.__all__) <= set(dir(room))
