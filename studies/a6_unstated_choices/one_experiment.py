"""One experiment for the second scenario: one square wave and one horizon for all six laws, found by hand.

By hand, outside this study, 32 square waves, each with gains for every law, evolved for 194 generations (seed 0) to
a1 = 0.8162 rad, a2 = 0.3741 rad, f = 0.7278 Hz. Then the amplitudes were moved by hand, by half a percent.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from studies.a6_unstated_choices import fits
from studies.a6_unstated_choices.draws import RMSE, slug
from studies.a6_unstated_choices.loops import MEASURED, PROPOSED, SQUARE, STEPS, factors_of, in_words, loop, relayed
from studies.paper.card import LAWS
from workbench.loop import ClosedLoop
from workbench.study.contract import Run, Sweep
from workbench.study.study import Results
from workbench.study.tuning import Trial, Tuned, Tuning
from workbench.study.uncertainty import Listed
from workbench.study.uncertainty.factors import Factor

BY_HAND = 0.8162, 0.3741  # rad: the amplitudes of the search by hand
AMPLITUDES, FREQUENCY = (0.82, 0.373), 0.7278  # rad, Hz
HORIZON = 9.0  # s, there
INSIDE = 1.0  # the rivals that switch are measured by (10)
UNTIL = 10.0  # s
MEMBERS = fits.POPULATION // 2  # of a search: fewer at once, as there is less to find
AGAIN = 8  # points that are run again at the fine step
OUR_STEP = 1e-3 / 4  # s: at the gains of this experiment a step of 1 ms errs by more than 1 %


def own(law: str) -> tuple[Factor, ...]:
    """The open numbers of a law beside the experiment."""
    return tuple(factor for factor in factors_of(law, "SS") if factor not in (*SQUARE, MEASURED))


def shared_loop(law: str) -> ClosedLoop:
    """A law in the one experiment."""
    one = loop(law, "SS")
    square = replace(one.reference.square, amplitude=np.array(AMPLITUDES), frequency=FREQUENCY)
    seen = INSIDE if MEASURED in factors_of(law, "SS") else one.observer.inside
    reference, observer = replace(one.reference, square=square), replace(one.observer, inside=seen)
    return replace(one, reference=reference, observer=observer)


def shared_search(law: str) -> Tuning:
    """The search for the numbers and readings of a law in the one experiment."""
    h = OUR_STEP if law == PROPOSED else STEPS[law]
    trial = Trial("ss", Run(relayed(law, shared_loop(law)), (RMSE,), UNTIL, fits.EVERY["SS"], h / 2))
    objective = fits.OneRow(law, "SS", HORIZON)
    return Tuning(slug("shared", law), (trial,), own(law), objective, fits.EVALUATIONS, MEMBERS, (fits.SEED,))


def shared_check(law: str, tuned: Tuned) -> Sweep:
    """The nearest points again, with the boundary layer of the paper, at a fine step and at half of it."""
    design = Listed(tuned.points[np.argsort(tuned.objectives, kind="stable")[:AGAIN]])
    run = Run(shared_loop(law), (RMSE,), UNTIL, fits.FINE_TIMES, fits.FINE)
    return Sweep(slug("shared_check", law), run, own(law), design, halved=1)


@dataclass(frozen=True, eq=False)
class Shared:
    """The runs of the one experiment at the fine step.

    Attributes
    ----------
    horizon
        The one at which the worst row of all laws is nearest, in s.
    miss
        By law, the larger miss of its two cells there, with the change to half the step added.
    numbers
        By law, its open numbers in words.
    """

    horizon: float
    miss: Mapping[str, float]
    numbers: Mapping[str, str]


def shared(results: Results) -> Shared:
    """The nearest to the rows of all six laws at once, from runs at the fine step."""
    samples = {law: results.sample(slug("shared_check", law)) for law in LAWS}
    every = {law: fits.checked_misses(law, "SS", sample) for law, sample in samples.items()}
    at = int(np.argmin(np.max([size.min(axis=0) for size in every.values()], axis=0)))
    best = {law: int(np.argmin(size[:, at])) for law, size in every.items()}
    return Shared(
        float(samples[PROPOSED].t[at]),
        {law: float(size[best[law], at]) for law, size in every.items()},
        {law: in_words(own(law), sample.drawn[best[law]]) for law, sample in samples.items()},
    )
