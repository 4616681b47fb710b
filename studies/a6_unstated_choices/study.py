"""The unstated numbers and readings of the AOSMC-RGS paper: which give its tables, and which decide who wins.

Runs in about two minutes on two cores.
"""

from collections.abc import Mapping

from studies.a6_unstated_choices.draws import PRIORS, RANDOM, draws, slug
from studies.a6_unstated_choices.fits import check, common_search, search, shared_check, shared_search
from studies.a6_unstated_choices.loops import SCENARIOS
from studies.a6_unstated_choices.pages import headlines, sections
from studies.paper.card import LAWS
from workbench.study.study import Study
from workbench.study.sweep import Sweep
from workbench.study.tuning import Tuned


def sweeps(tuned: Mapping[str, Tuned]) -> tuple[Sweep, ...]:
    """The checks of the searches, and all draws."""
    places = [(law, scenario) for law in LAWS for scenario in SCENARIOS]
    checks = [check(law, tuned[slug("search", law)], scenario) for law, scenario in places]
    shared = [shared_check(law, tuned[slug("shared", law)]) for law in LAWS]
    random = {
        one.name: one for prior in PRIORS.values() for place in places for one in [draws("random", *place, prior)]
    }
    paired = (draws("paired", *place) for place in places)
    return (*checks, *shared, *random.values(), *paired)


study = Study(
    name="a6_unstated_choices",
    title="AOSMC-RGS: what is not stated, and what it decides",
    question=(
        "Which unstated numbers and readings give the published RMSE, how many different ones do, and does the "
        "published ranking hold whatever they are?"
    ),
    method=(
        "Every unstated number over the range of the card, every reading as likely as the others. Independent draws of "
        "everything at once give the probabilities, under four priors; a Sobol design the indices. For each law a "
        "search by differential evolution, one set of gains for both scenarios, any horizon; what comes nearest is run "
        "again with the boundary layer of the paper at 1/12 ms and at half of it. For one experiment in the whole "
        "second scenario a square wave that was found by hand, and a search for the gains of each law at it."
    ),
    tunings=(*map(search, LAWS), *map(common_search, LAWS), *map(shared_search, LAWS)),
    sweeps=sweeps,
    sections=sections,
    headlines=headlines,
    seed=RANDOM.seed,
)
