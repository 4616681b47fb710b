"""Odd arguments for every public name, in a small run; `python -m tests.fuzz` makes many more by hand."""

import inspect
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

from tests.fuzz.__main__ import report
from tests.fuzz.calls import Aims, Target, aims, call_of, parameters_of, room_files, use
from tests.fuzz.examples import public_names
from tests.fuzz.judgement import raw
from workbench.cli.script import load
from workbench.core import Layout, rk4

ROOT = Path(__file__).parents[2]


# What one has from another public name alone, or inherits from.
UNSHOWN = {"CalledTarget", "PeriodPoles", "DesignError", "Verdict"}
# Objects that show their whole text.
LONG = {"BodeData", "Citation", "DefinitenessVerdict", "LimitVerdict", "PropertyVerdict", "Sheet"}
# Formulas and verdicts have texts of their own.
OTHERS = ("tests", "workbench.core.notation", "workbench.proofs", "workbench.engine.reference")


def _parsed(html):
    """The text of markup, which must be well formed."""
    return "".join(ElementTree.fromstring(f"<div>{html}</div>").itertext())


@pytest.fixture(scope="module")
def held(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("examples"))  # where an example may write a file
        yield aims()


def test_the_examples_of_all_docstrings_answer_as_they_show(held):
    assert not held.misfits, "".join(held.misfits)


def test_an_example_or_a_room_calls_every_public_name(held):
    names = public_names()
    called = {target.function for target in held.targets} | {type(thing) for thing in held.things}
    called |= {thing for thing in names.values() if not isinstance(thing, type) and not parameters_of(thing)}
    left = {name for name, thing in names.items() if not inspect.isabstract(thing) and thing not in called}
    left = {last for name in left if not (last := name.rpartition(".")[2]).startswith("Abstract")}
    assert left <= UNSHOWN, "write an example in the docstring"


def test_no_room_repeats_what_an_example_shows(held):
    shown = {id(target.function) for target in held.targets if "." in target.name} & set(
        map(id, public_names().values())
    )
    for file in room_files():
        for name, call in file.calls().items():
            assert id(call.func) not in shown or " " in name, f"{file.__name__}: {name} has an example"


def test_the_properties_of_what_examples_make_can_be_read(held):
    for thing in held.things:
        use(thing)


def test_every_object_that_an_example_makes_has_one_short_line_and_a_view(held):
    ours = [
        thing
        for thing in held.things
        if not type(thing).__module__.startswith(OTHERS) and type(thing).__name__ not in LONG
    ]
    assert len(ours) > 200
    for thing in ours:
        line = repr(thing)
        assert "\n" not in line
        assert 2 < len(line) < 160, line
        assert " at 0x" not in line
        if hasattr(thing, "_repr_html_"):
            assert _parsed(thing._repr_html_()) or "<iframe" in thing._repr_html_()


def test_the_fuzz_varies_no_fewer_arguments_than_ever(held):
    assert len(held.targets) >= 1100
    assert held.arguments >= 3700


def test_no_error_is_raw(held):
    text = report(held, seed=14, calls=1000)
    assert " 0 raw" in text, text


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
    assert raw(_raised(lambda: compile("(", "script", "exec"))).startswith("SyntaxError")


def test_a_script_that_is_no_python_is_passed_on_as_python_says_it(tmp_path):
    (tmp_path / "study.py").write_text("(")
    assert raw(_raised(lambda: load(tmp_path))) is None


FAULTS = """
import functools, os, sys, time, warnings
from tests.fuzz import workers
from tests.fuzz.__main__ import report
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
