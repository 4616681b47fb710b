from __future__ import annotations

from dataclasses import replace
from functools import cache, partial
from typing import Any

import casadi as ca

from workbench import study
from workbench.core import Entry, Layout, Ode
from workbench.engine.distributions import LogUniform
from workbench.engine.factors import Factor
from workbench.engine.metrics import iae, ise
from workbench.study import case_runs, provenance, tuning, writeup
from workbench.study.compiled_sweep import compile_sweep
from workbench.study.document import document
from workbench.study.run_and_sweep import Run, Sweep
from workbench.study.study import Case, Results, Study
from workbench.study.study_works import Work
from workbench.study.uncertainty import MonteCarlo

# of these the other rooms hold a call


class Decay:
    """A loop: x' = -k x, whose error is x."""

    def ode(self, name: str = "loop") -> Ode:
        states, parameters = Layout((Entry("x", [1.0]),)), Layout((Entry("k", 2.0),))
        t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
        return Ode.of(name, states, parameters, (t, x, p), {"x": -p * x}, {"e": x})


LOOP = Decay()
FACTOR = Factor("k", ("k",), LogUniform(0.5, 4.0))
METRICS = (iae(), ise())
RUN = Run(LOOP, METRICS, 1.0, 0.5, 0.05, tolerance=0.1)
CASE = Case("S", "law", RUN)
SWEEP = Sweep("decay", RUN, (FACTOR,), MonteCarlo(1, 24), half_step_every=8)
TRIAL = tuning.Trial("step", RUN)


def objective(runs: Any) -> Any:
    return runs["step"].score("IAE").value


TUNING = tuning.Tuning("pd", (TRIAL,), (FACTOR,), objective, 16, 8, (0, 1))


class Says:
    """A loop whose equations are whatever it is given."""

    def __init__(self, given: Any) -> None:
        self.given = given

    def ode(self, name: str = "loop") -> Any:
        return self.given


def doubled(item: Any) -> Any:
    return 2 * item


WORK = Work("doubled", doubled, (1, 2.0))


def sections(results: Any) -> Any:
    return [document.Section("An answer", (document.Paragraph("Yes."),))]


def saying(given: Any) -> Run:
    """The run of a loop that gives this for its equations."""
    return replace(RUN, loop=Says(given))


STUDY = Study("small", "T", "Q?", "M.", sections, cases=(CASE,), sweeps=(SWEEP,), tunings=(TUNING,), works=(WORK,))


@cache
def sample() -> Any:
    """The runs of the sweep."""
    made = compile_sweep(SWEEP)
    return made.sample([made.chunk(0, SWEEP.design.size)])


@cache
def tuned() -> Any:
    """What the tuning finds."""
    return tuning.tune(TUNING)


@cache
def outcomes() -> Any:
    """The outcomes of the case."""
    return case_runs.run(STUDY, workers=1).outcomes


def calls() -> dict[str, Any]:
    given = provenance.assumed_entry("k", 1.0, "1/s", "nobody says", 0.5, 2.0)
    return {
        "CardEntry.factor": partial(given.factor, ("k",), True),
        "Given": partial(provenance.CardEntry, "k", 1.0, "1/s", "assumed", "nobody says", 0.5, 2.0, "k"),
        "Card": partial(provenance.Card, (given,)),
        "Trial": partial(tuning.Trial, "step", RUN),
        "Tuned": partial(tuned),
        "Tuning": partial(
            tuning.Tuning,
            "pd",
            (TRIAL,),
            (FACTOR,),
            objective,
            16,
            8,
            (0, 1),
            {"k": (0.6, 2.0)},
            {("k", "low"): "stop"},
            0.5,
        ),
        "equal_budget": partial(
            tuning.equal_budget, {"pd": ((TRIAL,), (FACTOR,))}, objective, evaluations=16, population=8, seeds=(0,)
        ),
        "equal_budget per number": partial(
            tuning.equal_budget,
            {"pd": ((TRIAL,), (FACTOR,))},
            objective,
            evaluations_per_number=16.0,
            starts={"pd": {"k": (0.6, 2.0)}},
            physical={"pd": {("k", "low"): "a stop"}},
            settle=0.5,
        ),
        "Outcome": partial(lambda: outcomes()[0]),
        "Sample": partial(sample),
        "bars": partial(study.bars, "ours", outcomes(), "IAE", 0, [0.5], 1, 0.35),
        "points": partial(study.points, "", outcomes(), "IAE", "ISE", 0, ("law",), 1),
        "tune": partial(tuning.tune, TUNING),
        **functions(),
    }


def functions() -> dict[str, Any]:
    """Calls of what a study's author gives: loops and functions."""
    return {
        "cases": partial(lambda cases: replace(STUDY, cases=cases).resolve({}), lambda tuned: (CASE,)),
        "document": partial(lambda found: writeup.document(replace(STUDY, sections=found), Results(), "run"), sections),
        "headlines": partial(
            lambda found: writeup.headlines(replace(STUDY, headlines=found), Results()), lambda results: ["Yes."]
        ),
        "ode of a case": partial(
            lambda given: case_runs.run(replace(STUDY, cases=(replace(CASE, run=saying(given)),))),
            LOOP.ode(),
        ),
        "ode of a sweep": partial(lambda given: compile_sweep(replace(SWEEP, run=saying(given))).run.times, LOOP.ode()),
        "objective": partial(lambda found: tuning.tune(replace(TUNING, objective=found)), objective),
    }


def arguments() -> dict[str, Any]:
    return {
        "metric": lambda thing: "IAE",
        "joint": lambda thing: 0,
        "name": lambda thing: "decay",
        "caption": lambda thing: "c",
        "mark": lambda thing: "assumed",
        "points": lambda thing: [[0.5], [0.25]],
        "runs": lambda thing: [0, 2],
        "loop": lambda thing: LOOP,
        "measure": lambda thing: objective,
        "Outcome.signal.name": lambda thing: "e",
        "Results.tuning.name": lambda thing: "pd",
        "TuningResult.best_of.seed": lambda thing: 1,
        "TuningResult.best_within.evaluations": lambda thing: 8,
        "Results.scenario.name": lambda thing: "S",
        "Study.resolve.answers": lambda thing: {"pd": tuned()},
        "LocalSensitivities.linear_shares.deviations": lambda thing: [0.1],
        "Ranking.sentence.winner": lambda thing: "law",
    }
