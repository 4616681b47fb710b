"""The certificate of a fit: how accurate its computation is."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class FitCertificate:
    """The accuracy of the computation: the largest figure of all estimates.

    Parameters
    ----------
    to_minimum
        The next step of Newton's method, in standard errors; relative to the estimate for a log without noise.
    by_half_step
        The change of an estimate by half the integration step, in the same unit.
    limit
        The largest figure of both that is passed.
    condition
        The ratio of the largest to the least singular value of the derivatives, each column of length one.
    reason
        Why the search ended, in a clause.
    """

    to_minimum: float
    by_half_step: float
    limit: float
    condition: float
    reason: str

    def __repr__(self) -> str:
        return f"<FitCertificate: {self.to_minimum:.1e} to the minimum, {self.by_half_step:.1e} by half the step>"

    @property
    def is_passed(self) -> bool:
        """True if the estimates are the minimum to 1 % of a standard error, or to 1e-6 for a log without noise."""
        return self.to_minimum <= self.limit and self.by_half_step <= self.limit

    @property
    def refusal(self) -> str:
        """The sentence on a computation that did not reach its limit."""
        return (
            f"The estimates are not computed to {self.limit:g} of their unit: they are {self.to_minimum:.2g} from the "
            f"minimum, and half the step moves them by {self.by_half_step:.2g}."
        )
