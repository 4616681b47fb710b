"""The ledger's last lines: what the paper says of its rivals, and what laws and observers promise of themselves."""

from dataclasses import replace

import claims_paper as paper
from claims_checks import HORIZONS, Check, numbers, searched, sought
from claims_hunts import hunt
from paper_card import LAWS
from paper_comparison import MARGIN, PROPOSED

from workbench.core import Claim
from workbench.core.claim import Declared
from workbench.study.comparison import order
from workbench.study.study import Results
from workbench.verify.claims import Finding
from workbench.verify.falsify import Found

SCENARIOS = ("FS", "SS")
GIVEN = f"{numbers('Q', 'R', 'l', 'SS: a1, a2', 'SS: f')}, {HORIZONS}"
METRICS: tuple[tuple[Claim, str], ...] = (
    (paper.TRACKING, "RMSE (43)"),
    (paper.STEADY, "late error"),
    (paper.AMPLITUDE, "peak torque"),
    (paper.CHATTERING, "TV"),
    (paper.OVERSHOOT, "overshoot"),
    (paper.SETTLING, "settling time"),
)
# A search of `claims_hunts`: the block that makes the promise, the unit of its margin, what the paper leaves open.
PROMISES = {
    "smc": ("SlidingMode", "rad^2/s", ""),
    "asmc": ("AdaptiveSlidingMode", "N m", ""),
    "super_twisting": ("SuperTwisting", "rad/s^3", ""),
    "oracle_filter": ("OracleFilter", "N^2 m^2/s", "l"),
    "printed_filter": ("PrintedFilter", "N^2 m^2/s", "l"),
    "momentum": ("MomentumObserver", "N^2 m^2/s", "l"),
    "nonlinear": ("NonlinearDisturbanceObserver", "N^2 m^2/s", "l"),
}


def ranked(results: Results, metric: str) -> Check:
    """The proposed law, repaired, beside each rival by one metric, at each joint and in each scenario."""

    def check() -> Finding:
        stands: list[tuple[str, str]] = []
        for scenario in SCENARIOS:
            ours = results[scenario, PROPOSED]
            if metric not in ours.measurement.scores:
                continue
            unit = ours.measurement.scores[metric].metric.unit
            for law in LAWS:
                for joint in (0, 1) if law != PROPOSED else ():
                    a, b = ours.score(metric, joint), results[scenario, law].score(metric, joint)
                    stood, place = order(a, b, MARGIN), f"({scenario}, joint {joint + 1})"
                    stands.append((stood, f"{law} {b[0]:.4g} {unit}, AOSMC-RGS {a[0]:.4g} {unit} {place}"))
        lost = [words for stood, words in stands if stood == "above"]
        below = sum(stood == "below" for stood, _ in stands)
        tally = f"With {GIVEN}: below the rival in {below} of {len(stands)} comparisons, above it in {len(lost)}"
        tally += f", too close to call in {len(stands) - below - len(lost)}"
        if lost:
            return Finding("refuted", f"{tally}. The first: {lost[0]}.", f'beside("{metric}")')
        return Finding("not refuted", f"{tally}.", f'beside("{metric}")', samples=len(stands))

    return check


def promise(name: str) -> tuple[Claim, Check]:
    """What a block declares, and the search for a run that breaks it."""
    target = hunt(name).target
    assert isinstance(target, Declared)
    block, unit, open_ = PROMISES[name]
    claim, given = replace(target.claim, name=block), f"With {numbers(open_)}, of" if open_ else "Of"

    def sentence(result: Found) -> str:
        assert result.worst is not None
        worst = (
            f"its margin is broken by {result.worst.value:.4g} {unit}"
            if result.kind == "refuted"
            else "no run breaks it"
        )
        return f"{given} {sought(name)}, {worst}."

    return claim, searched(name, sentence)


def checks(results: Results) -> tuple[tuple[Claim, Check], ...]:
    """The comparisons, then the promises."""
    compared = tuple((claim, ranked(results, metric)) for claim, metric in METRICS)
    return (*compared, *(promise(name) for name in PROMISES))
