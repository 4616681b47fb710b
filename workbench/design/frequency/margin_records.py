"""The margins of a loop with one channel as numbers, each with its bounds."""

from __future__ import annotations

from dataclasses import dataclass

from workbench.core.validation.notebook_display import show
from workbench.design.frequency.certified_values import CertifiedPeak, CertifiedValue
from workbench.design.matrices import DesignError


@dataclass(frozen=True)
@show
class Crossover:
    """A `frequency` in rad/s at which |L| = 1 or L < 0, and the `margin`: a phase in degrees, or a factor of gain."""

    frequency: CertifiedValue
    margin: CertifiedValue


@dataclass(frozen=True)
@show
class StableMargins:
    """The margins of a stable loop: how far it is from instability.

    Gains between `gain_low` and `gain_high`, as factors, keep it stable, and so do losses of phase below
    `phase_margin` in degrees, delays below `delay_margin` in s, and factors (2 + d) / (2 - d) with complex
    |d| < `disk_margin`; the disk is touched at `disk_frequency` in rad/s. `Ms` and `Mt` are the peaks of
    S = 1 / (1 + L) and T = L / (1 + L).
    """

    gain_low: CertifiedValue
    gain_high: CertifiedValue
    phase_margin: CertifiedValue
    delay_margin: CertifiedValue
    Ms: CertifiedPeak
    Mt: CertifiedPeak
    disk_margin: CertifiedValue
    disk_frequency: float


@dataclass(frozen=True)
@show
class StabilityMargins:
    """The crossovers of a loop L and, if the closed loop is `stable`, its margins, each by its name.

    `gain_crossovers` are all frequencies with |L| = 1, with the phase margin there in degrees, in (-180, 180].
    `phase_crossovers` are those where L is real and negative, zero, infinity and Nyquist's included, with the gain
    margin -1 / L; a touch counts once. `remarks` says if |L| is one, or L is real, at every frequency; then only the
    ends of the axis are listed. `margins` has all margins of a stable loop in one record. It is None for an unstable
    loop, for which `phase_margin` and the other properties are refused.
    """

    stable: bool
    gain_crossovers: tuple[Crossover, ...]
    phase_crossovers: tuple[Crossover, ...]
    margins: StableMargins | None
    remarks: tuple[str, ...] = ()

    @property
    def gain_low(self) -> CertifiedValue:
        """The factor of gain below one down to which the closed loop stays stable."""
        return self._margins_for("gain_low").gain_low

    @property
    def gain_high(self) -> CertifiedValue:
        """The factor of gain above one up to which the closed loop stays stable."""
        return self._margins_for("gain_high").gain_high

    @property
    def phase_margin(self) -> CertifiedValue:
        """The loss of phase in degrees up to which the closed loop stays stable."""
        return self._margins_for("phase_margin").phase_margin

    @property
    def delay_margin(self) -> CertifiedValue:
        """The delay in s up to which the closed loop stays stable."""
        return self._margins_for("delay_margin").delay_margin

    @property
    def Ms(self) -> CertifiedPeak:
        """The peak of S = 1 / (1 + L)."""
        return self._margins_for("Ms").Ms

    @property
    def Mt(self) -> CertifiedPeak:
        """The peak of T = L / (1 + L)."""
        return self._margins_for("Mt").Mt

    @property
    def disk_margin(self) -> CertifiedValue:
        """The size of complex d up to which factors (2 + d) / (2 - d) keep the closed loop stable."""
        return self._margins_for("disk_margin").disk_margin

    @property
    def disk_frequency(self) -> float:
        """The frequency in rad/s at which the disk is touched."""
        return self._margins_for("disk_frequency").disk_frequency

    def _margins_for(self, name: str) -> StableMargins:
        if self.margins is None:
            raise DesignError(
                f"`StabilityMargins.{name}` is the distance of a stable loop from instability, and this closed loop is "
                "not stable; ask `stable` first, or read the crossovers, which it has too."
            )
        return self.margins
