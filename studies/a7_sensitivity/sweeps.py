"""The runs of a7: of each law a screening, those behind its Sobol indices, and random ones for bands."""

from studies.a7_sensitivity.factors import factors
from studies.paper.laws import RIVALS, proposed_repaired, rival
from workbench.loop import ClosedLoop
from workbench.metrics import AbstractMetric, effort, ise, late_error, observer_error, rmse, total_variation
from workbench.study.contract import Run
from workbench.study.sweep import Sweep
from workbench.study.uncertainty import MonteCarlo, MorrisDesign, OneAtATime, SobolDesign
from workbench.study.uncertainty.designs import AbstractDesign
from workbench.study.uncertainty.factors import Factor

PROPOSED = "AOSMC-RGS"
LAWS = (PROPOSED, *RIVALS)
SCENARIO = "FS"
UNTIL, EVERY, LATE, SAMPLE = 5.0, 0.25, 3.0, 1e-3  # s: horizon, windows, when the start is over, grid of the TV
SEED = 7
OF_LATE = f"The late error is the largest |e| from {LATE:g} to {UNTIL:g} s."
METRICS = (rmse(), late_error(LATE), total_variation(SAMPLE), effort())
OBSERVER = observer_error("q_error")

# Steps in s, so short that the largest gains that grow within the ranges stay within the limit of stability.
STEPS = {
    PROPOSED: 1e-3 / 16,
    "PID": 1e-3,
    "SMC": 1e-3 / 2,
    "ASMC": 1e-3 / 20,
    "Fuzzy-ASMC": 1e-3 / 20,
    "RBF-ASMC": 1e-3 / 16,
    "super-twisting": 1e-3,
}
TRAJECTORIES = {"ASMC": 24, "Fuzzy-ASMC": 24, "RBF-ASMC": 24}  # and 50 elsewhere
# Of the Sobol design, and 1024 elsewhere: what brings the intervals that decide a sentence below `NARROW`.
BASE = {PROPOSED: 512, "ASMC": 256, "Fuzzy-ASMC": 256, "RBF-ASMC": 256}
NARROW = 0.1  # of a variance, the whole width of an interval: a sentence that rests on a wider one stays open
RANDOM = 256
HALVED = 32  # one run in so many is run again at half of the step
# What the screening finds of little weight, and the Sobol indices so leave at its value: see `CLEARED`.
CLEARED = 0.2  # of the largest mu* of an output
HELD = {
    PROPOSED: ("phi", "K(0)", "P(0)", "l", "D"),
    "PID": ("D",),
    "SMC": ("phi", "D"),
    "ASMC": ("D",),
    "Fuzzy-ASMC": ("K(0)", "width of |s|", "width of the trend", "D"),
    "RBF-ASMC": ("Gamma", "sigma", "centres", "D"),
    "super-twisting": (),
}


def loop(law: str) -> ClosedLoop:
    return proposed_repaired(SCENARIO) if law == PROPOSED else rival(SCENARIO, law)


def metrics(law: str) -> tuple[AbstractMetric, ...]:
    """The metrics of a law, with the error of its observer where it has one."""
    return (*METRICS, OBSERVER) if law == PROPOSED else METRICS


def free(law: str) -> tuple[Factor, ...]:
    return tuple(factor for factor in factors(law) if factor.name not in HELD[law])


def called(law: str, kind: str) -> str:
    return f"{law.lower().replace('-', '_')}_{kind}"


def sweeps(law: str) -> dict[str, Sweep]:
    """The sweeps of a law by their kind, the bands over time; only the proposed one has a tornado."""
    every, some, ours = factors(law), free(law), law == PROPOSED
    of: dict[str, tuple[tuple[Factor, ...], AbstractDesign]] = {
        "screening": (every, MorrisDesign(len(every), TRAJECTORIES.get(law, 50), seed=SEED)),
        "indices": (some, SobolDesign(len(some), BASE.get(law, 1024), ours, seed=SEED)),
        "bands": (every, MonteCarlo(len(every), RANDOM, SEED)),
    }
    if ours:
        of["tornado"] = (every, OneAtATime(len(every), levels=(0.0, 1.0)))
    made = {}
    for kind, (moved, design) in of.items():
        measured, times = ((*metrics(law), ise()), EVERY) if kind == "bands" else (metrics(law), None)
        run = Run(loop(law), measured, UNTIL, times, STEPS[law], seed=SEED)
        made[kind] = Sweep(called(law, kind), run, moved, design, halved=HALVED)
    return made
