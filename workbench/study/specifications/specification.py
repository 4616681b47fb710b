"""A specification: limits on the figures of a loop, which are checked as claims."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields

from workbench.core.validation.refusals import refusal, seed, several, whole
from workbench.core.validation.signatures import check_arguments
from workbench.design.control_system import System
from workbench.design.linear_loop import LinearLoop
from workbench.design.loop_boxes import ParameterBox
from workbench.design.matrices import DesignError
from workbench.engine.factors import Factor
from workbench.study.document.gain_bounds import Disk, GainBound
from workbench.study.specifications.box_verdicts import BoxCheck
from workbench.study.specifications.draw_check import CALL, DrawVerdicts, check_draws
from workbench.study.specifications.limit_verdicts import LimitVerdict, SpecificationVerdicts, figure_clause
from workbench.study.specifications.limits import KINDS, FigureLimit
from workbench.study.specifications.loop_systems import LoopSystems
from workbench.study.specifications.point_figures import point_figure
from workbench.study.specifications.specification_regions import disks_of, gain_bounds_of

CHECK = "Specification.check"
DRAWS, PARTS, FEW_DRAWS = 512, 1000, 200


@dataclass(frozen=True)
@check_arguments
class Specification:
    """Limits on the margins, poles and step response of a loop; each may be left out.

    Parameters
    ----------
    Ms, Mt
        The largest peaks of S and T at the cut, as factors; for several channels, of the largest singular value.
    bandwidth
        (low, high) in rad/s for the frequency at which the gain has fallen by 3 dB from its value at zero.
    damping
        The least damping of a pole, below 1: -Re s / |s|.
    gain_margin
        The least factor by which a gain may grow or shrink before the loop is unstable, above 1.
    phase_margin
        The least phase margin, in degrees.
    delay_margin
        The least delay margin, in s.
    disk_margin
        The least size of the disk (2 + d) / (2 - d), |d| < disk_margin, of changes of all channels at once.
    noise_gain
        The largest gain from the noise of the readings to the inputs of the plant, in their units.
    overshoot
        The largest overshoot of a step response, in % of its final value.
    settling_time
        The longest time in s after which a step response stays within 2 % of its final value.
    rise_time
        The longest time in s that a step response takes from 10 % to 90 % of its final value.
    decay
        The slowest decay of a pole, -Re s, in 1/s.

    Raises
    ------
    ValueError
        If there is no limit, or one is out of its range: Ms <= 1, a damping of 1 or more, a reversed bandwidth.

    Examples
    --------
    >>> import control
    >>> verdicts = wb.Specification(Ms=2.0, phase_margin=45.0).check(control.tf([4], [1, 2, 0]))
    >>> [(one.name, one.kind) for one in verdicts]
    [('Ms', 'holds'), ('phase_margin', 'holds')]
    """

    Ms: float | None = None
    Mt: float | None = None
    bandwidth: tuple[float, float] | None = None
    damping: float | None = None
    gain_margin: float | None = None
    phase_margin: float | None = None
    delay_margin: float | None = None
    disk_margin: float | None = None
    noise_gain: float | None = None
    overshoot: float | None = None
    settling_time: float | None = None
    rise_time: float | None = None
    decay: float | None = None

    def __post_init__(self) -> None:
        if not self.limits:
            names = ", ".join(KINDS)
            raise ValueError(f"`Specification(...)` must have at least one limit of {names}; got none.")

    @property
    def limits(self) -> tuple[FigureLimit, ...]:
        """The limits, in the order of the fields."""
        given = ((field.name, getattr(self, field.name)) for field in fields(self))
        return tuple(FigureLimit.of(KINDS[name], value) for name, value in given if value is not None)

    @check_arguments
    def check(
        self,
        loop: LinearLoop | System,
        box: Mapping[str, object] | None = None,
        *,
        inputs: str | None = None,
        outputs: str | None = None,
        draws: int = DRAWS,
        seed: int = 0,
        parts: int = PARTS,
    ) -> SpecificationVerdicts:
        """The verdict on each limit, at the point of a loop or over a box of its parameters.

        Over a box a limit is refuted by the worst point of a search, proved by intervals, or not refuted.

        Parameters
        ----------
        loop
            A `LinearLoop`, or a loop gain L of negative feedback as a system of python-control.
        box
            (low, high) by the path of a parameter: {"plant.m": (0.8, 1.2)}. A box needs a `LinearLoop`.
        inputs, outputs
            The signals between which bandwidth and step response are limited; by default the single reference and the
            output that follows it. For L, or a loop without a reference, T is taken.
        draws, seed, parts
            The size of the Sobol sample in the box (corners and refined points are tried, too); its seed; and the
            largest number of parts into which a proof cuts the box.

        Raises
        ------
        ValueError
            If `loop` is neither of these, a range is beyond the bounds of its parameter, or no point has an answer.
        LookupError
            If a parameter or a signal has another name.
        DesignError
            If the loop at its point is not stable: all limits are for a stable loop.
        """
        systems = LoopSystems.of(f"{CHECK}(loop=...)", loop, inputs, outputs)
        if not systems.stable:
            raise DesignError(f"`{CHECK}(loop=...)` must have a stable loop: {systems.unstable_words}")
        subject = _subject(loop)
        if box is None:
            return SpecificationVerdicts(tuple(_at_point(limit, systems) for limit in self.limits), subject)
        if not isinstance(loop, LinearLoop):
            raise refusal(f"{CHECK}(box=...)", "left out of a system of python-control, which has no parameters", box)
        ranges = ParameterBox.of(f"{CHECK}(box=...)", loop.parameters, box)
        count = whole(f"{CHECK}(draws=...)", draws, 1, 100_000, " of draws")
        most = whole(f"{CHECK}(parts=...)", parts, 0, 100_000, " of parts of a box")
        check = BoxCheck(systems, ranges, self.limits, count, _seed(seed), most)
        return SpecificationVerdicts(check.verdicts(), subject, str(ranges))

    @check_arguments
    def check_draws(
        self,
        loop: LinearLoop,
        factors: tuple[Factor, ...],
        *,
        inputs: str | None = None,
        outputs: str | None = None,
        draws: int = FEW_DRAWS,
        seed: int = 0,
        confidence: float = 0.95,
    ) -> DrawVerdicts:
        """The share of random draws of factors that keep each limit, with the interval of a binomial share.

        At each draw the loop is linear about a rest of its own. Figures of draws near a limit have the bounds of
        `check`; those of the others come from a grid, whose error is seen where both are known. A loop with a delay
        has no grid: all of its figures have bounds.

        Parameters
        ----------
        loop
            The loop; its parameters that are not drawn keep their values.
        factors
            What is drawn, such as `fit.factors(path="plant.")`; paths name parameters of the loop.
        inputs, outputs
            As of `check`.
        draws, seed, confidence
            The number of independent draws, their seed, and the confidence of the intervals of the shares.

        Raises
        ------
        ValueError
            If there is no factor, a range is beyond the bounds of its parameter, or no draw has an answer.
        LookupError
            If a path is that of no parameter, or a signal has another name.
        """
        several(f"{CALL}(factors=...)", factors, Factor, 1)
        systems = LoopSystems.of(f"{CALL}(loop=...)", loop, inputs, outputs)
        return check_draws(systems, self.limits, factors, draws, seed, confidence)

    @check_arguments
    def gain_bounds(self, of: str = "S") -> tuple[GainBound, ...]:
        """The limits as regions of a Bode plot that a gain must not reach.

        `of` names the gain: "S" has the limit on Ms, "T" those on Mt and the bandwidth, and "CS" that on noise_gain.

        Raises
        ------
        ValueError
            If `of` is none of them.
        """
        return gain_bounds_of(self.limits, of)

    @property
    def disks(self) -> tuple[Disk, ...]:
        """The limits as disks of a Nyquist plot that the curve of L must not enter: of Ms, Mt and the disk margin."""
        return disks_of(self.limits)


def _seed(value: int) -> int:
    return seed(f"{CHECK}(seed=...)", value)


def _subject(loop: LinearLoop | System) -> str:
    return f"'{loop.point.equations.closed_loop.name}'" if isinstance(loop, LinearLoop) else f"'{loop.name}'"


def _at_point(limit: FigureLimit, systems: LoopSystems) -> LimitVerdict:
    figure = point_figure(limit.kind.name, systems)
    if figure.value is None:
        return LimitVerdict(limit, "not checkable", figure, f"There is no figure: {figure.why}")
    clause = figure_clause(limit.kind, figure)
    return LimitVerdict(limit, limit.judge(figure.value), figure, f"{clause[0].upper()}{clause[1:]}.")
