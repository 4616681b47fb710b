"""No edit delivers an old number: what a study says of its runs is what it says in a folder that has none."""

import sys
from textwrap import dedent

import pytest

from workbench.cli import script
from workbench.study import execution
from workbench.study.run_options import StudyOptions

STUDY = """
import casadi as ca
import numpy as np
from workbench.core import Entry, Layout, Ode
from workbench.engine.metrics import ise
from workbench.engine.metrics.contract import Integral
from workbench.engine.metrics.step_metrics import Peak
from workbench.engine.distributions import Uniform
from workbench.engine.factors import Factor
from workbench.study.run_and_sweep import Run
from workbench.study.uncertainty import MonteCarlo
from workbench.study.study import Study
from workbench.study.run_and_sweep import Sweep

PUSH = START = FACTOR = 1.0
STEP = 0.01

class Decay:
    def ode(self, name="loop"):
        states, parameters = Layout((Entry("x", np.array([START])),)), Layout((Entry("rate", np.array(1.0)),))
        t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
        return Ode.of(name, states, parameters, (t, x, p), {"x": PUSH - p * x}, {"e": x})

def square(t, y):
    return y["e"] ** 2

def mean(integral, horizon):
    return integral / horizon

%s
study = Study(
    name="stale", title="Stale", question="?", method=".", sections=lambda results: (),
    sweeps=(Sweep("decay", Run(Decay(), (METRIC,), 0.2, h=STEP),
        (Factor("rate", ("rate",), Uniform(0.5, 2.0 + FACTOR)),), MonteCarlo(1, 4, seed=3), runs_of_chunk=2),),
)
"""

FINISH = "METRIC = Integral('my', '', '', square, finish)"
# By what is edited: the code of the study, and of files beside it, in each of which 1.0 becomes 2.0.
EDITS = {
    "a number": ["def finish(i, T): return 1.0 * i", FINISH],
    "a global": ["SCALE = 1.0", "def finish(i, T): return SCALE * i", FINISH],
    "a global dict": ["SCALES = {'a': 1.0}", "def finish(i, T): return SCALES['a'] * i", FINISH],
    "a global list": ["SCALES = [[1.0]]", "def finish(i, T): return SCALES[0][0] * i", FINISH],
    "a closure": [
        "def scaled(by):",
        "    def finish(i, T): return by * i",
        "    return finish",
        "finish = scaled(1.0)",
        FINISH,
    ],
    "a default": ["def finish(i, T, by=1.0): return by * i", FINISH],
    "a partial": [
        "from functools import partial",
        "def scale(by, i, T): return by * i",
        "finish = partial(scale, 1.0)",
        FINISH,
    ],
    "an array": ["SCALE = np.array([1.0])", "def finish(i, T): return SCALE * i", FINISH],
    "an attribute of an object": [
        "from types import SimpleNamespace",
        "it = SimpleNamespace(by=1.0)",
        "def finish(i, T): return it.by * i",
        FINISH,
    ],
    "a method of an object": [
        "class It:",
        "    def scale(self, i): return 1.0 * i",
        "it = It()",
        "def finish(i, T): return it.scale(i)",
        FINISH,
    ],
    "an object that is called": [
        "class It:",
        "    def __call__(self, i, T): return 1.0 * i",
        "finish = It()",
        FINISH,
    ],
    "a property": [
        "class It:",
        "    @property",
        "    def by(self): return 1.0",
        "def finish(i, T): return It().by * i",
        FINISH,
    ],
    "a class attribute": ["class It:", "    by = 1.0", "def finish(i, T): return It.by * i", FINISH],
    "an enumeration": [
        "from enum import Enum",
        "class By(Enum):",
        "    a = 1.0",
        "def finish(i, T): return By.a.value * i",
        FINISH,
    ],
    "a field of a dataclass": [
        "from dataclasses import dataclass",
        "@dataclass",
        "class It:",
        "    by: float = 1.0",
        "def finish(i, T): return It().by * i",
        FINISH,
    ],
    "a helper of a helper": [
        "def inner(i): return 1.0 * i",
        "def outer(i): return inner(i)",
        "def finish(i, T): return outer(i)",
        FINISH,
    ],
    "a decorator": [
        "def scaled(f): return lambda i, T: 1.0 * f(i, T)",
        "@scaled",
        "def finish(i, T): return i",
        FINISH,
    ],
    "a kept result": [
        "from functools import lru_cache",
        "@lru_cache",
        "def by(): return 1.0",
        "def finish(i, T): return by() * i",
        FINISH,
    ],
    "a text": ["BY = '1.0'", "def finish(i, T): return float(BY) * i", FINISH],
    "a name that is looked up": ["BY = 1.0", "def finish(i, T): return globals()['B' + 'Y'] * i", FINISH],
    "a generator": ["def finish(i, T): return sum(x * i for x in (1.0, 3.0))", FINISH],
    "a function of a module": {
        "study": ["import beside", "def finish(i, T): return beside.scale(i)", FINISH],
        "beside": ["def scale(i): return 1.0 * i"],
    },
    "a number of a module": {
        "study": ["from beside import *", "def finish(i, T): return BY * i", FINISH],
        "beside": ["BY = 1.0"],
    },
    "a module of a module": {
        "study": ["import beside", "def finish(i, T): return beside.scale(i)", FINISH],
        "beside": ["import below", "def scale(i): return below.BY * i"],
        "below": ["BY = 1.0"],
    },
    "a file that is read": {
        "study": [
            "from pathlib import Path",
            "def finish(i, T): return float(Path(HERE, 'by.txt').read_text()) * i",
            FINISH,
        ],
        "by.txt": ["1.0"],
    },
    "a metric's class": [
        "class My(Integral):",
        "    def value(self, integral, z, horizon): return 1.0 * integral",
        "METRIC = My('my', '', '', square, mean)",
    ],
    "a global of a metric's class": [
        "BY = 1.0",
        "class My(Integral):",
        "    def value(self, integral, z, horizon): return BY * integral",
        "METRIC = My('my', '', '', square, mean)",
    ],
    "a helper of a metric's class": [
        "def scale(i): return 1.0 * i",
        "class My(Integral):",
        "    def value(self, integral, z, horizon): return scale(integral)",
        "METRIC = My('my', '', '', square, mean)",
    ],
    "the base of a metric's class": [
        "class Base(Integral):",
        "    def value(self, integral, z, horizon): return 1.0 * integral",
        "class My(Base): pass",
        "METRIC = My('my', '', '', square, mean)",
    ],
    "a number of the integrand": ["BY = 1.0", "METRIC = Integral('my', '', '', lambda t, y: BY * y['e'] ** 2, mean)"],
    "a helper of the integrand": [
        "def scale(e): return 1.0 * e",
        "METRIC = Integral('my', '', '', lambda t, y: scale(y['e']), mean)",
    ],
    "what a metric keeps in mind": [
        "def scale(e): return 1.0 * e",
        "class My(Peak):",
        "    def update(self, k, h, z, y): return {'peak': ca.fmax(z['peak'], scale(ca.fabs(y['e'])))}",
        "METRIC = My('my', '', '', 'e')",
    ],
    "where a memory begins": [
        "class My(Peak):",
        "    def memory(self, joints): return Layout((Entry('peak', np.full(joints, 1.0)),))",
        "METRIC = My('my', '', '', 'e')",
    ],
    "the equation": ["PUSH = 1.0", "METRIC = ise()"],
    "the initial state": ["START = 1.0", "METRIC = ise()"],
    "the range of a factor": ["FACTOR = 1.0", "METRIC = ise()"],
    "the step": ["STEP = 1.0 / 50", "METRIC = ise()"],
}


def files_of(edit):
    return edit if isinstance(edit, dict) else {"study": edit}


def written(folder, edit, by):
    """The study and the files beside it, with the number that is edited."""
    for name, lines in files_of(edit).items():
        text = "\n".join(lines).replace("1.0", by)
        if name == "study":
            text = f"HERE = {str(folder)!r}\n" + dedent(STUDY) % text
        (folder / (name if "." in name else f"{name}.py")).write_text(text, encoding="utf-8")
    return folder / "study.py"


def values(monkeypatch, file, out):
    """The values of all runs, by the study as it is now."""
    for name in ("beside", "below"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)  # a file of one second and size is taken for its bytecode
    with execution.execute(script.load(file), out, StudyOptions(file)) as (_, results):
        return results.samples[0].values


@pytest.mark.parametrize("what", EDITS)
def test_an_edit_of(what, monkeypatch, tmp_path):
    edit = EDITS[what]
    before = values(monkeypatch, written(tmp_path, edit, "1.0"), tmp_path / "out")
    again = values(monkeypatch, written(tmp_path, edit, "1.0"), tmp_path / "out")
    after = values(monkeypatch, written(tmp_path, edit, "2.0"), tmp_path / "out")
    fresh = values(monkeypatch, written(tmp_path, edit, "2.0"), tmp_path / "fresh")
    assert again.tobytes() == before.tobytes()
    assert after.tobytes() == fresh.tobytes()
    assert (after != before).any()


def test_words_orphan_no_chunk(monkeypatch, tmp_path):
    done = []
    for words in ("'''Some words.'''", "'''Other words.'''", "# a comment"):
        file = written(tmp_path, [words, "METRIC = ise()"], "1.0")
        monkeypatch.setattr(sys, "path", list(sys.path))
        order = StudyOptions(file, acknowledge=lambda chunk: done.append(chunk.name))
        with execution.execute(script.load(file), tmp_path / "out", order):
            pass
    assert len(done) == 2
