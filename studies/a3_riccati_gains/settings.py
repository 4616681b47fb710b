"""The choices of P that a3 compares, the weights of (34), and the names of the runs."""

from typing import Any

from studies.a3_riccati_gains.path import Setting
from studies.paper.card import CARD, SCENARIOS

FORWARD, ALGEBRAIC, MEAN, AT_START, NONE = "(34)", "algebraic", "P = its mean", "P = P(0)", "no adaptation"
ASMC_WITH_OBSERVER = "ASMC, same observer"
FROZEN: dict[str, Any] = {"riccati": "frozen", "Q": None, "R": None}
# By name: Q and R of (34), as shares of the unit matrix in N m/(rad s); the first are those of a1.
WEIGHTS = {
    "the assumed Q and R": (float(CARD["Q"][0, 0]), float(CARD["R"][0, 0])),
    "Q = R = I": (1.0, 1.0),
    "Q = 0.01 I, R = 1000 I": (0.01, 1000.0),
}
ASSUMED_WEIGHTS, *OTHERS = WEIGHTS
SETTINGS = {(s, name): Setting(s, *weights) for name, weights in WEIGHTS.items() for s in SCENARIOS}
TABLE_METRICS = ("sampled RMSE", "RMSE", "IAE", "peak error", "effort", "peak torque", "TV")
PLACES = [(scenario, joint) for scenario in SCENARIOS for joint in (0, 1)]


def scenario_of(scenario: str, weights: str) -> str:
    """The name of a scenario with other weights."""
    return scenario if weights == ASSUMED_WEIGHTS else f"{scenario}, {weights}"
