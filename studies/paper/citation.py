"""The sentences with which each page about the paper names it, its laws and its equations.

Author, journal and pages: the page of the article, https://doi.org/10.54939/1859-1043.j.mst.107.2025.13-23.
"""

from __future__ import annotations

PAPER = (
    'The paper is "Adaptive observer-based sliding mode control with time-varying learning using Riccati gain '
    'synthesis for robotic manipulators" by Hoang Duc Long (Journal of Military Science and Technology 107, 2025, '
    "pp. 13-23)."
)
LAW = "Its law AOSMC-RGS is adaptive observer-based sliding mode control with Riccati gain synthesis."
RIVALS = (
    "Its rivals are PID, sliding mode control (SMC), adaptive SMC (ASMC), and ASMC with fuzzy rules (Fuzzy-ASMC) or "
    "with a network of radial basis functions (RBF-ASMC)."
)
EQUATIONS = {
    2: "the inertia matrix M",
    3: "the Coriolis matrix C",
    4: "the gravity vector G",
    10: "the observer of positions and velocities",
    24: "the observer of the disturbance D",
    28: "the equivalent torque",
    31: "a linear model of s",
    32: "a quadratic cost",
    33: "the rate of the gain K",
    34: "the Riccati equation of P",
    35: "the equation of motion of the estimates",
    42: "the bound on the time to reach s = 0",
    43: "the RMSE",
}


def introduction(*numbers: int, rivals: bool = True) -> str:
    """The paper and its law in full, the rivals unless a page has none, and the equations of some numbers in words."""
    equations = "; ".join(f"({number}) is {EQUATIONS[number]}" for number in numbers)
    return " ".join(
        (PAPER, LAW, *([RIVALS] if rivals else []), *([f"Of its equations, {equations}."] if numbers else []))
    )
