"""Fair comparison: twelve laws with the same measurements, tuned alike, and judged where none was tuned.

Runs in about ten minutes on two cores.
"""

from collections.abc import Mapping

import workbench as wb
from studies.a8_fair_comparison.ablations import NEW, as_tuned
from studies.a8_fair_comparison.evidence import DRAW_SEED, name_of, sweep, works
from studies.a8_fair_comparison.other_numbers import AGAIN, run_again
from studies.a8_fair_comparison.pages import sections
from studies.paper.citation import introduction
from studies.paper.costs import OTHERS, PRIMARY
from studies.paper.entrants import ALL, BOTH, ENTRANTS, PROPOSAL, Entrant
from studies.paper.fitted_arm import with_fit
from studies.paper.fitted_page import fitted_study
from studies.paper.rest import REST, UNTIL
from studies.paper.scenarios import HELD_OUT, HORIZON, PERIOD, TRAINING, metrics, objective

EVALUATIONS, SEEDS = 160, (1, 2, 3)  # for each number that is tuned, at most; one search each
LEAST_SEARCH_SHARE = 0.4  # of its evaluations, from which on a search that has settled ends
CURVE_INTERVAL = 0.01  # s, between two points of a curve
TRAINING_SEED = 80  # of the noise of the first training scenario: no law is judged by noise that it was tuned for


def trials(entrant: Entrant) -> tuple[wb.tuning.Trial, ...]:
    """A law in the training scenarios."""
    return tuple(
        wb.tuning.Trial(s.name, wb.Run(with_fit(entrant.loop(s)), metrics(s), HORIZON, h=PERIOD, seed=seed))
        for seed, s in enumerate(TRAINING, start=TRAINING_SEED)
    )


def tunings() -> tuple[wb.tuning.Tuning, ...]:
    """Every law behind all that it is given, and AOSMC-RGS without each of its parts."""
    tuned = (*ALL, *NEW)
    return wb.tuning.equal_budget(
        {one.key: (trials(one), tuple(number.factor for number in one.tuned_numbers)) for one in tuned},
        objective,
        evaluations_per_number=EVALUATIONS,
        seeds=SEEDS,
        starts={one.key: {number.name: (number.low, number.high) for number in one.tuned_numbers} for one in tuned},
        physical={
            one.key: {
                (number.name, end): number.why for number in one.tuned_numbers if number.ends for end in ("low", "high")
            }
            for one in tuned
        },
        settle=LEAST_SEARCH_SHARE,
    )


def sweeps(tuning_results: Mapping[str, wb.tuning.TuningResult]) -> tuple[wb.Sweep, ...]:
    """Every law behind all that it is given in every scenario, some with other numbers, and AOSMC-RGS without its "
    "parts.
    """
    made = []
    for scenario in HELD_OUT:
        loops = {one.key: with_fit(one.loop(scenario, tuning_results[one.key].best)) for one in (*ALL, *NEW)}
        for one in run_again(tuning_results):
            loops |= {
                one.key + kind: with_fit(one.loop(scenario, best(tuning_results[one.key])))
                for kind, (_, best) in AGAIN.items()
            }
        loops |= as_tuned(scenario, tuning_results[PROPOSAL.key].best)
        made += [sweep(name_of(scenario, key), loop, scenario) for key, loop in loops.items()]
    return tuple(made)


def cases(tuning_results: Mapping[str, wb.tuning.TuningResult]) -> tuple[wb.Case, ...]:
    """Each law behind what BOTH gives it, as it was tuned, in the first held-out scenario, for the page to turn.

    The last case holds the proposed law still, for its linear pictures.
    """
    scenario = HELD_OUT[0]
    tracking = tuple(
        wb.Case(
            scenario.name,
            one.name,
            wb.Run(
                with_fit(one.loop(scenario, tuning_results[one.key].best)),
                metrics(scenario),
                HORIZON,
                CURVE_INTERVAL,
                PERIOD / 2,
                seed=DRAW_SEED,
            ),
            style=i,
        )
        for i, one in enumerate(ENTRANTS[BOTH.key])
    )
    still = with_fit(PROPOSAL.loop(scenario.at_rest, tuning_results[PROPOSAL.key].best))
    return (
        *tracking,
        wb.Case(REST, PROPOSAL.name, wb.Run(still, (wb.rmse(),), UNTIL, CURVE_INTERVAL, PERIOD / 2, seed=DRAW_SEED)),
    )


study = wb.Study(
    name="a8_fair_comparison",
    title="Which law is best: twelve laws with the same measurements and the same tuning",
    question=(
        "Which law has the lowest cost, by how much, and how sure is that? Does the answer depend on the statistic, "
        "the measurements, the tuning search or its budget? What is each part of AOSMC-RGS worth?"
    ),
    method=(
        f"{introduction(10, 24, 33, 34)} Twelve laws run on a computer with the same noisy readings, the same torque "
        "limit and the same wrong model. They are compared with four kinds of measurements: raw readings; a filtered "
        "velocity; observer (10) of the state; and both observers, (10) and an observer of the disturbance. With each "
        "kind, every law is tuned for one cost in two scenarios, by three searches with the same budget for each "
        "parameter. Then it is judged in ten other scenarios over random draws of the arm, the disturbance and the "
        "start, which are the same for all laws. Only laws with the same measurements are compared. The mean cost "
        "decides, as costs add up over the runs. An answer is marked 'depends' if another statistic, search, budget, "
        "weight or choice of scenarios changes it. Intervals hold for all pairs of laws in all scenarios at once."
    ),
    tunings=tunings(),
    cases=cases,
    sweeps=sweeps,
    least_samples=wb.evidence.least_draws((PRIMARY, *OTHERS)),
    works=works,
    sections=sections,
    seed=DRAW_SEED,
)
study = fitted_study(study)
