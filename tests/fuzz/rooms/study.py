from __future__ import annotations

from dataclasses import replace
from functools import cache, partial
from typing import Any

import casadi as ca

from workbench import study
from workbench.core import Entry, Layout, Ode
from workbench.engine.distributions import LogUniform, Uniform
from workbench.engine.factors import Factor, Space
from workbench.engine.metrics import iae, ise
from workbench.study import case_runs, provenance, tuning, writeup
from workbench.study.compiled import compile_sweep
from workbench.study.contract import Run, Sweep
from workbench.study.document import document
from workbench.study.evidence import law_tables
from workbench.study.study import Case, Results, Study
from workbench.study.uncertainty import Listed, MonteCarlo, factor_table, local
from workbench.study.work import Work

MODULES = ("workbench.study", "workbench.study.tuning")
# of these the other rooms hold a call
IMPORTED = ("Panel", "least_base", "morris", "quantiles", "sobol", "tornado")


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
SWEEP = Sweep("decay", RUN, (FACTOR,), MonteCarlo(1, 24), halved=8)
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
    space = partial(Space, (FACTOR,), Layout((Entry("k", 2.0),)), Layout((Entry("x", 1.0),)))
    given = provenance.assumed("k", 1.0, "1/s", "nobody says", 0.5, 2.0)
    published = law_tables.Published("table 1", "IAE", 0, {"law": 0.4}, 2)
    return {
        **{name: getattr(study, name) for name in IMPORTED},
        **{name: getattr(study, name) for name in ("Figure", "Itemize", "Paragraph", "Section", "Table", "Verdict")},
        "AbstractDesign": MonteCarlo(1, 24),
        "one_core": study.one_core,
        "testbed": study.testbed,
        "Column": partial(study.Column, "RMSE", "rad", "right", 3),
        "Case": partial(Case, "S", "law", RUN, 0, ""),
        "Factor": partial(Factor, "k", ("k",), Uniform(0.5, 4.0), "stated", True),
        "Finding": partial(
            study.Finding,
            "best",
            "PID has the least mean cost, 1.2.",
            "SMC has 1.4.",
            answer="PID",
            variations=(study.Variation("the median in place of the mean", "SMC", "1.2 against 1.4"),),
            cites=("a8_fair_comparison/best",),
        ),
        "Given.factor": partial(given.factor, ("k",), True),
        "factor_table": partial(factor_table, space(), "drawn", "What is drawn."),
        "Given": partial(provenance.Given, "k", 1.0, "1/s", "assumed", "nobody says", 0.5, 2.0, "k"),
        "Card": partial(provenance.Card, (given,)),
        "Knob": partial(study.Knob, "k", ("k",), 0.5, 4.0, True, "stated", False),
        "LatinHypercube": partial(study.LatinHypercube, 2, 24, 3),
        "Listed": partial(Listed, [[0.5, 0.25], [0.0, 1.0]]),
        "LocalSensitivities": partial(local.local_sensitivities, LOOP.ode(), METRICS, ["k"], until=1.0, h=0.1),
        "LogNormal": partial(study.LogNormal, 1.0, 0.5, 0.1, 9.0),
        "LogUniform": partial(study.LogUniform, 0.1, 1.0),
        "MonteCarlo": partial(study.MonteCarlo, 2, 24, 3),
        "MorrisDesign": partial(study.MorrisDesign, 2, 8, 4, 3),
        "Normal": partial(study.Normal, 1.0, 0.5, 0.0, 2.0),
        "Objective": tuning.Objective,
        "OneAtATime": partial(study.OneAtATime, 2, (0.05, 0.95), 0.5),
        "Page": partial(study.Page, "PID leads.", (study.Finding("best", "PID leads."),), sections(None)),
        "Published": partial(law_tables.Published, "table 1", "IAE", 0, {"law": 0.4}, 2),
        "Results": partial(Results, outcomes(), (sample(),), (tuned(),), {"doubled": (2, 4.0)}),
        "SobolDesign": partial(study.SobolDesign, 2, 16, True, 3),
        "Space": space,
        "Study": partial(
            Study,
            "small",
            "T",
            "Q?",
            "M.",
            sections,
            lambda results: ["It runs."],
            (CASE,),
            {"arm": "1"},
            True,
            1,
            (SWEEP,),
            (TUNING,),
            (study.Knob("k", "k", 0.5, 4.0),),
            (WORK,),
        ),
        "Run": partial(Run, LOOP, METRICS, 1.0, 0.5, 0.05, 0.1, 1),
        "Work": partial(Work, "doubled", doubled, (1, 2.0), float, 1.0),
        "Sweep": partial(Sweep, "decay", RUN, (FACTOR,), MonteCarlo(1, 24), True, 8, 16),
        "Trial": partial(tuning.Trial, "step", RUN),
        "Triangular": partial(study.Triangular, 0.0, 0.5, 2.0),
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
        "Uniform": partial(study.Uniform, 0.0, 2.0),
        "Variation": partial(study.Variation, "the median", "SMC", "1.2 against 1.4"),
        "against_published": partial(law_tables.against_published, "t", "c", published, {"law": outcomes()[0]}),
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
        "ranking": partial(law_tables.ranking, published, {"law": outcomes()[0]}, 0.02),
        "run": partial(case_runs.run, STUDY, workers=1),
        "Sample": partial(sample),
        "bars": partial(study.bars, "ours", outcomes(), "IAE", 0, [0.5], 1, 0.35),
        "cell": partial(study.cell, outcomes()[0], "IAE", "e", 1e3, "ms"),
        "points": partial(study.points, "", outcomes(), "IAE", "ISE", 0, ("law",), 1),
        "side_by_side": partial(study.side_by_side, "t", "c", outcomes(), ["IAE"], 0, ["a note"], 0.02),
        "tune": partial(tuning.tune, TUNING),
        **functions(),
    }


def functions() -> dict[str, Any]:
    """Calls of what a study's author gives: loops and functions."""
    return {
        "cases": partial(lambda cases: replace(STUDY, cases=cases).resolved({}), lambda tuned: (CASE,)),
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
        "Results.tuned.name": lambda thing: "pd",
        "Tuned.best_of.seed": lambda thing: 1,
        "Tuned.best_within.evaluations": lambda thing: 8,
        "Results.scenario.name": lambda thing: "S",
        "Study.resolved.tuned": lambda thing: {"pd": tuned()},
        "LocalSensitivities.linear_shares.deviations": lambda thing: [0.1],
        "Ranking.sentence.winner": lambda thing: "law",
    }
