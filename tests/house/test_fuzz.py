"""Odd arguments for every public name, in a small run; `python -m tests.fuzz` makes many more by hand."""

import functools
import importlib
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.fuzz.calls import Aims, Target, call_of, public_names, room_files
from tests.fuzz.judgement import raw
from workbench.core import Layout, rk4

ROOT = Path(__file__).parents[2]


HINTS = {"Flags", "Integers", "Memory", "Scalar", "Vector", "Way"}  # callable, but no calls of an engineer


@functools.cache
def called():
    """The names with a call in any room: a name has one home, and may be shown in several rooms."""
    return HINTS.union(*(room.calls() for room in room_files()))


@pytest.mark.parametrize("room", room_files(), ids=lambda room: room.__name__.rpartition(".")[2])
def test_every_public_name_of_a_room_has_a_valid_call(room, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # where a call may write a file
    calls = room.calls()
    for module in room.MODULES:
        held = importlib.import_module(module)
        assert not {name for name in public_names(module) if callable(getattr(held, name))} - called(), module
    for call in calls.values():
        if isinstance(call, functools.partial):
            call()


def test_no_error_is_raw(tmp_path):  # where an odd path may be written to
    words = [sys.executable, "-m", "tests.fuzz", "--calls", "1000", "--seed", "14"]
    there = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(words, cwd=tmp_path, env=there, capture_output=True, text=True, check=False, timeout=600)
    assert done.returncode == 0, done.stdout + done.stderr
    assert " 0 raw" in done.stdout


def test_a_call_follows_from_seed_and_number_alone():
    aims = Aims([Target("rk4", rk4, {"ode": 1, "h": 0.1}), Target("Layout", Layout, {"entries": ()})], {})
    texts = [call_of(aims, 1, number).text for number in range(50)]
    assert texts == [call_of(aims, 1, number).text for number in range(50)]
    assert len(set(texts)) > 25
    assert texts != [call_of(aims, 2, number).text for number in range(50)]


def _raised(call):
    with pytest.raises(BaseException) as error:
        call()
    return error.value


def test_what_a_library_says_is_raw_and_what_the_workbench_says_is_not():
    assert raw(_raised(lambda: rk4("x", 0.1))) is None
    assert raw(_raised(lambda: Layout()["x"])) is None
    assert raw(_raised(rk4)) is None  # a wrong count of arguments is Python's to say
    assert raw(_raised(lambda: Layout().entries.x)).startswith("AttributeError")
    assert raw(_raised(lambda: int("x"))).startswith("ValueError")


FAULTS = """
import functools, os, sys, time, warnings
from tests.fuzz import workers
from tests.fuzz.calls import Aims, Target
workers.SECONDS = 1
faults = {"crash": os.abort, "hang": lambda: time.sleep(60), "warning": lambda: warnings.warn("odd"),
          "memory": lambda: bytearray(2**34), "error": lambda: {}["x"]}
for kind, fault in faults.items():
    for outcome in workers.outcomes(Aims([Target("fault", lambda x: fault(), {"x": 1})], {}), 1, range(3)):
        print(kind, outcome.kind, outcome.place)
"""
SAYS = {
    "crash": "the process ended by SIGABRT in fault",
    "hang": "more than 1 s in fault",
    "warning": "UserWarning",
    "memory": "MemoryError",
    "error": "KeyError",
}


def test_every_kind_of_fault_is_named_and_the_next_call_is_made():
    words = [sys.executable, "-c", FAULTS]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True, timeout=120)
    lines = done.stdout.splitlines()
    assert len(lines) == 3 * len(SAYS)
    for fault, says in SAYS.items():
        named = [line for line in lines if line.startswith(f"{fault} raw") and says in line]
        assert len(named) == 3, fault
