"""Studies that their authors got wrong: one line on stderr that says where and what, exit status 2, no report."""

import pytest

from tests.support.compilers import SLOW

STUDY = """
import numpy as np
from scipy import stats
from workbench.engine.metrics import iae
from workbench.study import *
from tests.support.sweeps import START, Decay, sweep
from tests.support.tunings import tuning

class Loop:
    def __init__(self, ode):
        self.own = ode

    def ode(self, name="loop"):
        return self.own(name)

def fails(*given):
    raise TypeError("odd")

def quits(*given):
    raise SystemExit(0)

def case(loop=Decay(), until=1.0, h=0.01):
    return Case("S", "law", Run(loop, (iae(),), until, 0.1, h))

def study(**parts):
    sections = parts.pop("sections", lambda results: [Section("An answer", (Paragraph("Yes."),))])
    return Study("broken", "T", "Q?", "M.", sections, **parts)

def searched(objective=lambda runs: runs["step"].score("ISE").value, evaluations=16, population=8, **parts):
    asked = {"evaluations": evaluations, "population": population}
    return study(tunings=(tuning(objective=objective, **asked),), **parts)

def swept(factor):
    return study(sweeps=(sweep(factors=(factor, START)),))

study = """

LOOP = (
    "must be an `Ode`, a `SampledSystem`, or a loop, whose `ode(name)` gives its equations, as a `ClosedLoop` does; got"
)
BROKEN = [
    ("study(cases=(case([1.0]),))", f"`Run(loop=...)` {LOOP} [1.0]."),
    ("study(cases=(case(None),))", f"{LOOP} None."),
    ("study(cases=(case(Decay),))", f"{LOOP} the class `Decay` itself: make one with `Decay(...)`."),
    ("study(sweeps=(sweep(loop=[1.0]),))", f"`Run(loop=...)` {LOOP} [1.0]."),
    ("study(cases=(case(Loop(lambda name: None)),))", "must be the equations of a loop, an `Ode` or a `SampledSystem`"),
    ("study(sweeps=(sweep(loop=Loop(fails)),))", "study.py, line 17: `Loop.ode('decay')` ended with TypeError: 'odd'."),
    (
        "study(sweeps=(sweep(loop=Loop(quits)),))",
        "line 20: `Loop.ode('decay')` ended the study by itself, with status 0",
    ),
    ("study(cases=(case(until=1.7e308),))", "must be at most 2^53 times `h`, 0.01 s, to be counted"),
    ("study(cases=(case(h=5e-324),))", "got 5e-324, which a float does not hold to full accuracy"),
    ("study(sweeps=object)", "is a function of what the tunings found, and this study has none"),
    ("searched(sweeps=object)", "`Study(sweeps=...)(answers)` ended with TypeError: 'object() takes no arguments'."),
    ("searched(sweeps=lambda tuned: sweep())", "must be a tuple of `Sweep`; got a `Sweep`: one alone is written"),
    ("searched(cases=lambda tuned: [1.0])", "`Study(cases=...)(answers)` must be a tuple of `Case`; got 1.0 at [0]."),
    (
        "searched(lambda runs: 1)",
        "`Tuning('pd', objective=...)` must have shape (8,), one number for each of the points",
    ),
    ("searched(lambda runs: None)", "`Tuning('pd', objective=...)` must be a vector of numbers; got None."),
    ("searched(fails)", "study.py, line 17: `Tuning('pd', objective=...)` ended with TypeError: 'odd'."),
    ("searched(quits)", "`Tuning('pd', objective=...)` ended the study by itself, with status 0."),
    (
        "searched(evaluations=10**400)",
        "`Tuning('pd', evaluations=...)` must be a whole number from 1 to 2^53; got 1000",
    ),
    ("searched(evaluations=10**9, population=10**9)", "That is more time than is taken without being asked for"),
    (
        "swept(Factor('r', ('rate',), stats.norm(1, 2)))",
        "must be an `AbstractDistribution`; got a `rv_continuous_frozen`",
    ),
    ("swept(Factor('r', (3,), Uniform(0.5, 1.0)))", "`Factor(paths=...)` must be a tuple of `str`; got 3 at [0]."),
    ("study(cases=(case(),), sections=lambda results: results['S'])", "named by a scenario and a law; got 'S'."),
    ("study(headlines=fails)", "study.py, line 17: `Study(headlines=...)(results)` ended with TypeError: 'odd'."),
]


@pytest.mark.parametrize(("made", "said"), BROKEN, ids=[made for made, _ in BROKEN])
def test_a_study_that_its_author_got_wrong_ends_in_one_line(command, tmp_path, made, said):
    (tmp_path / "study.py").write_text(f"{STUDY}{made}\n", encoding="utf-8")
    done = command("run", "study.py")
    assert done.exit_code == 2, done.output
    *told, last = done.stderr.splitlines(keepends=True)
    assert last.startswith("workbench: ")
    assert said in last
    assert all(line.startswith("broken: ") for line in told if line not in SLOW)  # what the runs were to cost
    assert not list(tmp_path.rglob("index.html"))
