"""The digest of a definition: all that it calls counts, by its contents, in every process the same."""

import functools
import os
import re
import subprocess
import sys
from importlib import import_module, reload
from pathlib import Path

import numpy as np
import pytest

import workbench as wb
from workbench.study.definition_text import DigestError
from workbench.study.definitions import Definitions

ROOT = Path(__file__).parents[2]
HELPERS = """
from dataclasses import dataclass
from functools import cache, partial
import numpy as np
import workbench as wb
import {parts} as parts
from {parts} import TABLE

@dataclass(frozen=True)
class Setting:
    gain: float = 1.0

    def __post_init__(self):
        assert self.gain < 100.0

    @property
    def double(self):
        return 2.0 * self.gain

@wb.block
class Tank(wb.Plant):
    k: float = wb.parameter(default=1.0, unit="m/s", low=0)
    h: float = wb.initial(default=1.0, unit="m")
    inputs, outputs = wb.layout(v="V"), wb.layout(h="m")

    def rate(self, t, x, u):
        return {{"h": -self.k * x.h}}

@cache
def level(item):
    return parts.offset(item) + TABLE["a"][0]

def scaled(item, by=3.0):
    return by * item

triple = partial(scaled, by=4.0)

def work(item):
    '''The work.'''
    inner = lambda x: x + 5.0
    return inner(level(item)) + triple(item) + Setting(item).double + wb.open_loop(Tank()).states.size
"""
PARTS = """
TABLE = {"a": (1.5, "text"), "b": None}

def offset(item):
    return item + deeper(item)

def deeper(item):
    return 0.25 if item > 1.0 else 0.5
"""


@pytest.fixture
def digest(tmp_path, monkeypatch):
    """The digest of `work` after changes of the text of its module and of the one that it imports."""
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    helpers, parts = (f"{name}_{os.getpid()}_{id(tmp_path)}" for name in ("helpers", "parts"))

    def of(*change, function="work", **options):
        if change and change[0] in PARTS:
            texts = HELPERS.format(parts=parts), PARTS.replace(*change)
        else:
            text = HELPERS.format(parts=parts)
            assert not change or change[0] in text
            texts = (text.replace(*change) if change else text), PARTS
        for name, text in zip((helpers, parts), texts, strict=True):
            (tmp_path / f"{name}.py").write_text(text, encoding="utf-8")
            reload(import_module(name)) if name in sys.modules else None
        module = reload(import_module(helpers))
        reload(sys.modules[parts])
        module = reload(module)
        return Definitions().digest(getattr(module, function), *options.get("items", (1.0,)))

    yield of
    for name in (helpers, parts):
        sys.modules.pop(name, None)


CHANGES = [
    ("x + 5.0", "x + 6.0"),
    ("x + 5.0", "x - 5.0"),
    ("by=4.0", "by=4.5"),
    ("by=3.0", "by=3.5"),
    ("2.0 * self.gain", "2.5 * self.gain"),
    ("gain: float = 1.0", "gain: float = 1.5"),
    ("self.gain < 100.0", "self.gain < 200.0"),
    ("-self.k * x.h", "-2 * self.k * x.h"),
    ('default=1.0, unit="m/s"', 'default=2.0, unit="m/s"'),
    ('TABLE["a"][0]', 'TABLE["a"][0] + 1'),
    ('(1.5, "text")', '(1.75, "text")'),
    ('"b": None', '"b": False'),
    ("0.25 if item", "0.125 if item"),
    ("item > 1.0", "item >= 1.0"),
    ("item + deeper", "item - deeper"),
]


@pytest.mark.parametrize("change", CHANGES, ids=" -> ".join)
def test_each_change_of_what_is_called_changes_the_digest(digest, change):
    assert digest() != digest(*change)


QUIET = [
    ("'''The work.'''", "'''The work, in other words.'''"),
    ("def scaled", "# A comment.\n\n\ndef scaled"),
    ("@cache\ndef level", "def unused(item):\n    return open(item)\n\n@cache\ndef level"),
]


@pytest.mark.parametrize("change", QUIET, ids=["docstring", "comment", "unused"])
def test_what_changes_nothing_that_is_computed_leaves_the_digest(digest, change):
    assert digest() == digest(*change)


@pytest.mark.heavy
def test_the_digest_is_the_same_in_processes_with_other_seeds_of_hashes():
    code = (
        "import workbench as wb; from workbench.study.definitions import Definitions; "
        "law = wb.SlidingMode(wb.paper_arm(), Lambda=6.0, phi=0.5, K=5.0); "
        "print(Definitions().digest(law, wb.simulate, {'a', 'b', 'c'}, frozenset('xyz')))"
    )
    law = wb.SlidingMode(wb.paper_arm(), Lambda=6.0, phi=0.5, K=5.0)
    here = Definitions().digest(law, wb.simulate, {"a", "b", "c"}, frozenset("xyz"))
    seed = "2" if os.environ.get("PYTHONHASHSEED") == "1" else "1"
    there = {**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": str(ROOT)}
    words = [sys.executable, "-c", code]
    assert subprocess.run(words, env=there, capture_output=True, text=True, check=True).stdout == f"{here}\n"


def digest_of(*values):
    return Definitions().digest(*values)


MOTOR = wb.open_loop(wb.DCMotor())
DIFFERENT = [
    (1, 1.0),
    (0.0, -0.0),
    (True, 1),
    ("1", 1),
    ((1, 2), [1, 2]),
    ((1, (2, 3)), ((1, 2), 3)),
    ({"a": 1, "b": 2}, {"b": 2, "a": 1}),
    (np.zeros(3), np.zeros((3, 1))),
    (np.zeros(3), np.zeros(3, dtype=int)),
    (np.array([1.0, 2.0]), np.array([1.0, 2.0 + 2e-16 * 2])),
    (wb.DCMotor(), wb.DCMotor(b=0.2)),
    (MOTOR, wb.open_loop(wb.DCMotor(b=0.2))),
    (MOTOR, wb.open_loop(wb.DCMotor(measurement="position"))),
    (wb.rk4(MOTOR, 1e-3), wb.rk4(MOTOR, 2e-3)),
    (np.sin, np.cos),
    (re.compile("a"), re.compile("a", re.DOTALL)),
    (functools.partial(max, 1), functools.partial(max, 2)),
    (wb.rmse("omega"), wb.rmse("i")),
]


@pytest.mark.parametrize("pair", DIFFERENT, ids=str)
def test_different_items_have_different_digests(pair):
    first, second = map(digest_of, pair)
    assert first != second
    assert first == digest_of(pair[0])


UNSEEN = [
    (object(), "a `object`"),
    (np.array([object()], dtype=object), "an array of objects"),
    (sys.modules[__name__], "a module of the study as a whole"),
    (np.random.default_rng(1), "a `Generator`"),
    (iter("a"), "a `str_ascii_iterator`"),
]


@pytest.mark.parametrize(("value", "kind"), UNSEEN, ids=[kind for _, kind in UNSEEN])
def test_what_cannot_be_seen_is_refused_by_name(value, kind):
    with pytest.raises(DigestError, match=f"{re.escape(kind)}.* cannot be seen"):
        digest_of((1, value))


def test_a_value_that_holds_itself_is_refused():
    ring = []
    ring.append(ring)
    with pytest.raises(DigestError, match="holds itself"):
        digest_of(ring)


def changes_a_global(item):
    global COUNT
    COUNT = item


def imports_inside(item):
    from tests.house import sources

    return sources.sources(item)


HANDLE = object()


def uses_a_handle(item):
    return HANDLE, item


@pytest.mark.parametrize(
    ("function", "said"),
    [
        (changes_a_global, "`COUNT`, which is changed there"),
        (imports_inside, "`import tests.house`, which stands inside of the function"),
        (uses_a_handle, "It is reached by `HANDLE`"),
    ],
)
def test_a_function_that_does_what_no_digest_sees_is_refused_by_name(function, said):
    with pytest.raises(DigestError, match=re.escape(said)):
        digest_of(function)


def even(n):
    return n == 0 or odd(n - 1)


def odd(n):
    return n != 0 and even(n - 1)


def test_functions_that_call_each_other_have_digests():
    assert digest_of(even) != digest_of(odd)
    assert digest_of(even) == digest_of(even)
