"""The gains L1, L2 of a state observer: what they promise, proved; and better ones.

gains.py       L1 and L2, checked
region.py      where arm and estimate may be
mismatch.py    the exact Jacobian that drives the error, as a polynomial in speeds and torques
frozen.py      poles at states of a region and along a path: seen
lipschitz.py   constants of the mismatch (14), (15): proved by intervals
inequality.py  a matrix inequality for all states of a region: proved by intervals
certificate.py a quadratic form that falls at a rate, and the errors it admits: P exactly, the rest by intervals
exactly.py     definiteness of matrices of doubles, by rational arithmetic
response.py    noise, peaking, and the mismatch that gains tolerate: exactly
proposals.py   where P and gains come from: linear matrix inequalities, which prove nothing here
synthesis.py   gains by poles, high gain, Kalman's filter, one inequality
audit.py       all of it, in one object
"""

from workbench.design.observer_gains.audit import Audit, audit
from workbench.design.observer_gains.certificate import RateCertificate, Reach, check
from workbench.design.observer_gains.frozen import Frozen, along, frozen_poles, over
from workbench.design.observer_gains.gains import Gains
from workbench.design.observer_gains.lipschitz import Bound, Lipschitz, lipschitz
from workbench.design.observer_gains.mismatch import Mismatch
from workbench.design.observer_gains.region import Region
from workbench.design.observer_gains.response import Noise, noise, peaking, tolerated
from workbench.design.observer_gains.synthesis import by_lmi, by_poles, certify, high_gain, kalman, least_double_pole

__all__ = [
    "Audit",
    "Bound",
    "Frozen",
    "Gains",
    "Lipschitz",
    "Mismatch",
    "Noise",
    "RateCertificate",
    "Reach",
    "Region",
    "along",
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
    "over",
    "peaking",
    "tolerated",
]
