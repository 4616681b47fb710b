"""Fair comparison: twelve laws given the same, tuned alike, and judged where none was tuned.

Runs in about six minutes on two cores.
"""

from collections.abc import Mapping

from studies.a8_fair_comparison.conditions import HELD_OUT, HORIZON, PERIOD, TRAINING, metrics, objective
from studies.a8_fair_comparison.entrants import ALL, BOTH, ENTRANTS, PROPOSAL, Entrant
from studies.a8_fair_comparison.evidence import ABLATED, AGAIN, ASKED, DRAWN, OTHERS, contenders, name_of, sweep, works
from studies.a8_fair_comparison.pages import sections
from workbench.study.contract import Run, Sweep
from workbench.study.evidence import least_draws
from workbench.study.study import Case, Study
from workbench.study.tuning import Trial, Tuned, Tuning, equal_budget

EVALUATIONS, SEEDS = 160, (1, 2, 3)  # for each number that is tuned, at most; one search each
SETTLED = 0.4  # of its evaluations, from which on a search that has settled ends
SHOWN = 0.01  # s, between two points of a curve
TRAINING_SEED = 80  # of the noise of the first training scenario: no law is judged by noise that it was tuned for


def trials(entrant: Entrant) -> tuple[Trial, ...]:
    """A law in the training scenarios."""
    return tuple(
        Trial(s.name, Run(entrant.loop(s), metrics(s), HORIZON, h=PERIOD, seed=seed))
        for seed, s in enumerate(TRAINING, start=TRAINING_SEED)
    )


def tunings() -> tuple[Tuning, ...]:
    return equal_budget(
        {one.key: (trials(one), tuple(number.factor for number in one.tuned)) for one in ALL},
        objective,
        evaluations_per_number=EVALUATIONS,
        seeds=SEEDS,
        starts={one.key: {number.name: (number.low, number.high) for number in one.tuned} for one in ALL},
        physical={
            one.key: {(number.name, end): number.why for number in one.tuned if number.ends for end in ("low", "high")}
            for one in ALL
        },
        settle=SETTLED,
    )


def sweeps(tuned: Mapping[str, Tuned]) -> tuple[Sweep, ...]:
    """Every law behind all that it is given in every scenario; and what is asked of some of them beside."""
    made = []
    for scenario in HELD_OUT:
        loops = {one.key: one.loop(scenario, tuned[one.key].best) for one in ALL}
        for entrants in ENTRANTS.values():
            for one in contenders(entrants, tuned):
                loops |= {one.key + kind: one.loop(scenario, best(tuned[one.key])) for kind, (_, best) in AGAIN.items()}
        if scenario.name in ABLATED:
            loops |= loops[PROPOSAL.key].ablations()
        made += [sweep(name_of(scenario, key), loop, scenario) for key, loop in loops.items()]
    return tuple(made)


def cases(tuned: Mapping[str, Tuned]) -> tuple[Case, ...]:
    """Each law behind what BOTH gives it, as it was tuned, in the first held-out scenario, for the page to turn."""
    scenario = HELD_OUT[0]
    return tuple(
        Case(
            scenario.name,
            one.name,
            Run(one.loop(scenario, tuned[one.key].best), metrics(scenario), HORIZON, SHOWN, PERIOD / 2, seed=DRAWN),
            style=i,
        )
        for i, one in enumerate(ENTRANTS[BOTH.key])
    )


study = Study(
    name="a8_fair_comparison",
    title="Who really wins: all laws given the same, tuned alike, and judged where none was tuned",
    question=(
        "Who really wins, by how much, and how sure is that? What does it depend on: what is asked, what a law is "
        "given, the search, the budget? Which part of AOSMC-RGS makes the difference?"
    ),
    method=(
        "Twelve laws run on a computer with the same noisy readings, torque limit and wrong model, each behind each of "
        "four: raw readings, a filter, observer (10), and that with an observer of the disturbance. Each pair is tuned "
        "for one cost in two training scenarios, by three searches of one budget a number, and judged in ten others "
        "over the same draws of arm, disturbance and start. Laws are compared where they are given the same. The mean "
        "cost is asked, as costs add up; what another statistic, search or budget turns round depends. Intervals hold "
        "for all pairs and all scenarios at once."
    ),
    tunings=tunings(),
    cases=cases,
    sweeps=sweeps,
    least=least_draws((ASKED, *OTHERS)),
    works=works,
    sections=sections,
    seed=DRAWN,
)
