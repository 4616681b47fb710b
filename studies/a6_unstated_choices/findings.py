"""The findings of a6 on what fits: the nearest choices, how far they lie apart, and one experiment for all laws."""

from collections.abc import Mapping

import numpy as np

from studies.a6_unstated_choices import fits, loops
from studies.a6_unstated_choices.fits import CLOSE, EVALUATIONS, Fit, Shared, horizons, misses
from studies.a6_unstated_choices.loops import PROPOSED, factors_of, in_words, named, slug
from studies.paper.card import LAWS
from workbench.study.document.document import Verdict
from workbench.study.study import Results
from workbench.validation.refusals import Array

OF_A_FIT = (
    f"The largest miss of the cells, of runs with the boundary layer of the paper at {1e3 * fits.FINE:.3g} ms, their "
    f"error by the step added; searches of {EVALUATIONS} choices, whatever the prior."
)
RANGES = f"A plus in (33), R from {loops.STIFF:g} on, any horizon from {loops.SHORTEST} to {loops.LONGEST} s"
OF_A_WITNESS = "A run of the printed numbers at a finer step that misses by more."
LONGER = "A longer search: what was not found may be there."
FINER = "A finer step for the runs of what is near, or a longer search."


def fit_verdicts(fits_of: Mapping[tuple[str, str], Fit]) -> tuple[Verdict, ...]:
    """The fits of the proposed row, of each cell and of each law; a search may miss what is there all the same."""
    ours = fits_of[PROPOSED, "FS"]
    cells = [fits_of[law, cell].miss for law in LAWS for cell in fits.CELLS]
    draws = [fits_of[law, cell].of_draws for law in LAWS for cell in fits.CELLS]
    both = {law: fits_of[law, "both"].miss for law in LAWS}
    worst = max(both, key=both.__getitem__)
    met, together = sum(miss <= CLOSE for miss in cells), sum(miss <= CLOSE for miss in both.values())
    return (
        Verdict(
            "found" if ours.miss <= CLOSE else "open",
            f"The nearest choice of what is not stated misses the printed row of {PROPOSED} in the first scenario by "
            f"{100 * ours.miss:.2g} %, at the farther of its two cells.",
            f"It is {fit_words(PROPOSED, 'FS', ours.numbers)}, and a horizon of {ours.horizon['FS']:.1f} s.",
            OF_A_FIT,
            f"{RANGES}.",
            OF_A_WITNESS if ours.miss <= CLOSE else LONGER,
        ),
        Verdict(
            "found" if met == len(cells) else "open",
            f"{met} of the {len(cells)} printed cells are met within {100 * CLOSE:g} %, each taken alone.",
            f"The farthest is missed by {100 * max(cells):.2g} %. Of the {loops.RANDOM.runs} draws {min(draws)} to "
            f"{max(draws)} meet a cell within {100 * CLOSE:g} % at some horizon.",
            OF_A_FIT,
            f"{RANGES}; numbers, a square wave and a horizon of its own for each cell.",
            OF_A_WITNESS if met == len(cells) else LONGER,
        ),
        Verdict(
            "found" if together == len(both) else "open",
            f"For {together} of {len(both)} laws one choice meets all four cells of the law within {100 * CLOSE:g} %.",
            f"{worst} misses most, by {100 * both[worst]:.2g} % with the error by the fine step; at the step "
            f"of the search {fits_of[worst, 'both'].of_search} of its choices come within {100 * CLOSE:g} %.",
            OF_A_FIT,
            f"{RANGES}; one set of gains for both scenarios, and a square wave and two horizons of its own for each "
            "law.",
            OF_A_WITNESS if together == len(both) else FINER,
        ),
    )


def fit_words(law: str, target: str, numbers: Array) -> str:
    """The numbers of a fit in words, less those of the square wave where the target is of the first scenario."""
    factors = factors_of(law, "FS" if target.startswith("FS") else "SS")
    return in_words(factors, numbers[: len(factors)])


def horizon_verdict(results: Results) -> Verdict:
    """The laws that one horizon brings near in the first scenario, as one experiment must."""
    least = []
    sets = {("random", prior) for prior in loops.PRIORS.values()} | {("paired", loops.OF_CARD)}
    for law in LAWS:
        runs = [results.sample(named(kind, law, "FS", prior)) for kind, prior in sets]
        runs += [results.tuned(slug(kind, law)).samples["fs"] for kind in ("search", "common")]
        least.append(np.min([misses(law, "FS", horizons(one)[1]).min(axis=0) for one in runs], axis=0))
    worst = np.max(least, axis=0)
    at = int(np.argmin(worst))
    law = LAWS[int(np.argmax([one[at] for one in least]))]
    horizon = horizons(results.sample(named("random", PROPOSED, "FS")))[0][at]
    met = sum(bool(one[at] <= CLOSE) for one in least)
    return Verdict(
        "found" if met == len(LAWS) else "open",
        f"At one horizon for all laws, {horizon:.1f} s, {met} of {len(LAWS)} rows of the first scenario come "
        f"within {100 * CLOSE:g} %.",
        f"{law} is the farthest, within {100 * worst[at]:.2g} %.",
        "The larger miss of the two cells of a law, the least over all runs of draws and searches, at their steps and "
        f"without a run at a finer one; among them a search of {EVALUATIONS // 2} choices for each law at "
        f"{fits.COMMON:g} s (seed {fits.SEED}), where a longer one by hand had found all laws nearest.",
        "The same horizon, and gains of its own for each law.",
        f"{LONGER[:-1]}; runs at a finer step, for rows that are met.",
    )


def shared_verdict(one: Shared) -> Verdict:
    """The rows of the second scenario that one experiment gives."""
    met = sum(miss <= CLOSE for miss in one.miss.values())
    listed = ", ".join(f"{law} {100 * miss:.2g} %" for law, miss in one.miss.items())
    moved = " and ".join(
        f"{100 * (now / then - 1):+.1f} %" for now, then in zip(fits.AMPLITUDES, fits.BY_HAND, strict=True)
    )
    return Verdict(
        "found" if met == len(LAWS) else "open",
        f"With one square wave and one horizon for all laws {met} of {len(LAWS)} rows of the second scenario come "
        f"within {100 * CLOSE:g} %.",
        f"The larger miss of each: {listed}. The square wave was found by hand, not by this study: a search of 32 of "
        "them at once, each with gains for every law, over 194 generations (seed 0) ended at "
        f"a1 = {fits.BY_HAND[0]:g} rad, a2 = {fits.BY_HAND[1]:g} rad, f = {fits.FREQUENCY:g} Hz. Both amplitudes were "
        f"then moved by hand, by {moved}, to a1 = {fits.AMPLITUDES[0]:g} rad, a2 = {fits.AMPLITUDES[1]:g} rad. There, "
        f"and at the horizon of {fits.HORIZON:g} s that the search by hand had used, this study seeks the gains of "
        f"each law; of the runs at the fine step {one.horizon:.1f} s is the best.",
        f"The larger miss of the two cells of a law, the nearest of {fits.SHARED_AGAIN} points of a search of "
        f"{EVALUATIONS} choices for each law (seed {fits.SEED}), run again with the boundary layer at "
        f"{1e3 * fits.FINE:.3g} ms and at half of it, the error added.",
        "One square wave, one horizon, measurement by (10) for the rivals that switch and exact ones for PID; "
        f"{PROPOSED} with its own readings, that of its observer among them; gains of its own for each law, which may "
        "differ from those of the first scenario.",
        "An error of the step beyond the one that is added, for a row that is met. One witness shows that the table "
        "can come about, and leaves open how it did.",
    )
