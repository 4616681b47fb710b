"""What a9 assumes of the computer: its instruments, and what counts as realistic, quiet and tracking."""

from fractions import Fraction

import numpy as np

from workbench.notation.formula import Number, Product, Quotient, symbol
from workbench.study.provenance import Card, assumed

CARD = Card(
    (
        assumed("realistic period", 1e-3, "s", "a usual rate of robot controllers, 1 kHz", 2.5e-4, 4e-3),
        assumed("delay", "one period", "", "the torque is computed while the one before acts"),
        assumed("steps of q", 2 * np.pi / 2**16, "rad", "an encoder of 16 bits on each joint", 1e-6, 1e-3),
        assumed("noise of q", 5e-5, "rad", "half a step of the encoder", 1e-6, 1e-3),
        assumed("steps of qd", 1e-3, "rad/s", "a filtered difference, in fixed point", 0.0, 1e-2),
        assumed("noise of qd", 5e-3, "rad/s", "half of the boundary layer; a plain difference has more", 5e-4, 0.1),
    )
)
PERIODS = (1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2)  # s; each divides the 10 ms of (43)
REALISTIC = float(CARD["realistic period"])
LATE = 15.0  # s: from then on the late error of the first scenario is taken
QUIET = 2.0  # times the total variation of the continuous loop, at most
TRACKS = 1.1  # times its RMSE (43), at most
NOISY = 7  # runs with noise, beside the one without: what a vector register or two holds
SEED = 20_09
RULE = Quotient(Product((Number(Fraction(2)), symbol("phi"), symbol("lambda_min"))), symbol("K"))  # of thumb, in s
