"""The laws of the house on names: none is a bare participle, no two public classes share one; each law can fail."""

import pytest

from tests.house import rules_of_names as names
from tests.house.sources import sources

HOUSE = sources("workbench", "studies")


def test_no_public_name_is_a_bare_participle():
    assert names.bare_participles(HOUSE) == []


def test_no_two_public_classes_share_a_name():
    assert names.classes_of_one_name(HOUSE) == []


def test_two_classes_of_one_name_are_found_wherever_they_are():
    text = "class Piece: ...\nclass _Own: ..."
    (breach,) = names.classes_of_one_name({"workbench/a/x.py": text, "workbench/b/y.py": text, "tests/z.py": text})
    assert breach.startswith("workbench/a/x.py:1: the class `Piece` is also in workbench/b/y.py:1")


@pytest.mark.parametrize(
    "name", ["sampled_loop", "ClosedLoop", "speed", "damping", "settling_time", "qdd", "ed", "set"]
)
def test_an_adjective_before_a_noun_and_the_nouns_of_the_field_are_free(name):
    assert not names.is_participle(name)


@pytest.mark.parametrize(
    ("path", "text", "words"),
    [
        ("workbench/core/kept.py", "", "the file `kept`"),
        ("workbench/arms/printed/__init__.py", "", "the folder `printed`"),
        ("workbench/a.py", "class Sampled: ...", "the class `Sampled`"),
        ("workbench/a.py", "class A:\n    found: int", "a.py:2: the field `found`"),
        ("studies/a.py", "class A:\n    def settled(self): ...", "the function `settled`"),
        ("workbench/a.py", "def f(a, *, given): ...", "the argument `given`"),
        ("workbench/a.py", "class A:\n    def __init__(self, told): ...", "the argument `told`"),
    ],
)
def test_each_kind_of_name_is_held_to_the_law(path, text, words):
    (breach,) = names.bare_participles({path: text})
    assert words in breach
