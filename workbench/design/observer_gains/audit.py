"""Everything that this room says of one set of gains, in one object: a row of a comparison."""

from __future__ import annotations

from dataclasses import dataclass

from workbench.core import Dynamics
from workbench.design.certificates import Refused
from workbench.design.observer_gains.certificate import RateCertificate, Reach, check
from workbench.design.observer_gains.frozen import Frozen, over
from workbench.design.observer_gains.gains import Gains
from workbench.design.observer_gains.mismatch import Mismatch
from workbench.design.observer_gains.proposals import lyapunov_matrix
from workbench.design.observer_gains.region import Region
from workbench.design.observer_gains.response import Noise, noise, peaking, tolerated
from workbench.validation.refusals import positive
from workbench.validation.signatures import door
from workbench.validation.views import show

# How often the share of a region with a P is halved, and the fractions of it of which the first to be proved counts.
HALVINGS, SURE = 6, (1.0, 0.9, 0.8, 0.6)


@dataclass(frozen=True, eq=False)
@show
class Audit:
    """What is seen and what is proved of gains in a region.

    Parameters
    ----------
    frozen
        The poles with state and torque frozen: seen.
    certificate
        A proof of a decay at the asked rate, in the region with its speeds and torques times `share`.
    share
        1 where the whole region is certified; None, with no certificate, where nothing was, and `why` says so.
    reach
        Which initial errors are admitted while the arm keeps the inner region, of the same share.
    tolerated
        The largest rho such that every Delta with |Delta| <= rho |x~| is proved to let the error decay.
    noise, peaking
        Where the model adds nothing.
    """

    gains: Gains
    frozen: Frozen
    certificate: RateCertificate | None
    share: float | None
    reach: Reach | None
    tolerated: float
    noise: Noise
    peaking: float
    why: str


@door
def audit(
    dynamics: Dynamics, gains: Gains, region: Region, inner: float, rate: float, known: RateCertificate | None = None
) -> Audit:
    """Judge the gains L1, L2 of an observer of this arm in a region.

    Parameters
    ----------
    inner
        The share of the region's speeds that the arm itself keeps; the rest is room for the estimate's error.
    rate
        The decay in 1/s that is to be proved, in the whole region or else in as large a share of it as can be.
    known
        The certificate of these gains in the whole region, if there is one; else one is sought (extra `lmi`). Its P is
        proved again for this arm.

    Raises
    ------
    ValueError
        If sizes differ, the rate is not positive, `inner` does not lie between 0 and 1, or `known` is the certificate
        of something else.
    Refused
        If the P of `known` is not proved here.
    """
    positive("audit(rate=...)", rate, " of 1/s")
    if not 0 < positive("audit(inner=...)", inner) < 1:
        raise ValueError(f"`audit(inner=...)` is a share, so it lies between 0 and 1; got {inner}.")
    if known is not None and (known.gains is not gains or known.region is not region or known.rate != rate):
        raise ValueError("`audit(known=...)` must be the certificate of these gains, in this region, of this rate.")
    mismatch = Mismatch.of(dynamics)
    seen = over(mismatch, gains, region)
    certificate, share, why = (
        (check(mismatch, gains, region, known.P, rate), 1.0, "") if known else _certified(mismatch, gains, region, rate)
    )
    reach = None
    if certificate is not None and share is not None:
        reach = certificate.reach(_slower(certificate.region, inner))
    return Audit(gains, seen, certificate, share, reach, tolerated(gains)[0], noise(gains), peaking(gains), why)


def _slower(region: Region, share: float) -> Region:
    return Region(share * region.speed, region.torque, region.low, region.high)


def _certified(
    mismatch: Mismatch, gains: Gains, region: Region, rate: float
) -> tuple[RateCertificate | None, float | None, str]:
    """A certificate in the whole region, or in the largest share of it that halving finds."""
    try:
        return check(mismatch, gains, region, lyapunov_matrix(mismatch, gains, region, rate), rate), 1.0, ""
    except Refused as none:
        why = str(none)
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        share = (low + high) / 2 if low else high / 4
        try:
            lyapunov_matrix(mismatch, gains, region.scaled(share), rate)
        except Refused:
            high = share
        else:
            low = share
    for part in SURE if low else ():
        smaller = region.scaled(part * low)
        try:
            found = check(mismatch, gains, smaller, lyapunov_matrix(mismatch, gains, smaller, rate), rate)
        except Refused as none:
            why = str(none)
        else:
            return found, part * low, ""
    return None, None, why
