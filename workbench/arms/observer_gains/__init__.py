"""The gains L1, L2 of a state observer: proofs of the decay of its error, and the design of better gains.

This package uses the equations of an arm, gains and regions, and no observer. Read `gains.py` and `mismatch.py`
first, then `decay_certificate.py`; `audit` in `error_dynamics.py` gathers all that is seen and proved of gains.
"""

from workbench.arms.observer_gains.decay_certificate import (
    AdmittedErrors,
    RateCertificate,
    by_lmi,
    certify,
    check,
    least_double_pole,
)
from workbench.arms.observer_gains.error_dynamics import (
    Audit,
    FrozenPoles,
    Noise,
    audit,
    frozen_poles,
    frozen_poles_along,
    frozen_poles_over,
    kalman,
    noise,
    peaking,
    tolerated_mismatch,
)
from workbench.arms.observer_gains.gains import Gains, Region, by_poles, high_gain
from workbench.arms.observer_gains.inequality import Lipschitz, LipschitzBound, lipschitz
from workbench.arms.observer_gains.mismatch import Mismatch

__all__ = [
    "Audit",
    "LipschitzBound",
    "FrozenPoles",
    "Gains",
    "Lipschitz",
    "Mismatch",
    "Noise",
    "RateCertificate",
    "AdmittedErrors",
    "Region",
    "frozen_poles_along",
    "audit",
    "by_lmi",
    "by_poles",
    "certify",
    "check",
    "frozen_poles",
    "high_gain",
    "kalman",
    "least_double_pole",
    "lipschitz",
    "noise",
    "frozen_poles_over",
    "peaking",
    "tolerated_mismatch",
]
