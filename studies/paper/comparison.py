"""The comparison of the paper: its law as repaired, its five rivals and a seventh law, in both scenarios."""

import workbench as wb
from studies.paper.card import CARD, LAWS, PROPOSED_LAW
from studies.paper.laws import RIVALS, proposed_repaired, rival

LATE = 5.0  # s, from when on an error counts as late
PRINTED_METRIC = wb.metrics.sampled_rmse(CARD["sample time of (43)"])
BOTH = (
    PRINTED_METRIC,
    wb.metrics.rmse(),
    wb.metrics.rmse("e_hat", name="RMSE of e_hat"),
    *(wb.metrics.iae(), wb.metrics.ise(), wb.metrics.itae(), wb.metrics.peak_error()),
    *(wb.metrics.effort(), wb.metrics.energy(), wb.arms.peak_torque(), wb.metrics.total_variation(sample=1e-3)),
)
METRICS = {
    "FS": (*BOTH, wb.metrics.late_error(LATE)),
    "SS": (*BOTH, wb.metrics.overshoot(), wb.metrics.settling_time(band=0.05)),
}

# Steps in s, each below the limit of stability; values are taken at half of them.
PROPOSED_STEP = 1e-3 / 12
STEPS = {"PID": 5e-4, "SMC": 5e-4, "super-twisting": 5e-4, "ASMC": 1e-4, "Fuzzy-ASMC": 1e-3 / 12, "RBF-ASMC": 1e-4}
STYLES = {law: i for i, law in enumerate((*LAWS, "super-twisting"))}


def comparison(scenario: str) -> tuple[wb.Case, ...]:
    """The proposed law as repaired, its five rivals, and a seventh law."""
    loops = {PROPOSED_LAW: proposed_repaired(scenario)} | {law: rival(scenario, law) for law in RIVALS}
    steps = {PROPOSED_LAW: PROPOSED_STEP} | STEPS
    return tuple(
        wb.Case(
            scenario,
            law,
            wb.Run(loop, METRICS[scenario], CARD[f"{scenario}: horizon"], 0.01, steps[law] / 2),
            style=STYLES[law],
            remark="repaired" if law == PROPOSED_LAW else "",
        )
        for law, loop in loops.items()
    )
