"""The motion of a log as a regression needs it: positions, speeds, accelerations and torques through one filter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array, finite, positive, refusal, seconds
from workbench.core.validation.signatures import check_arguments
from workbench.identification import Dataset, Experiment
from workbench.identification.datasets.experiment import Marks

ENDS = 2.0  # periods of the cutoff at either end of a record, in which the filter has not settled
POINTS, DEGREE = 5, 2  # of the local polynomials behind the filter, which has smoothed the samples before


@dataclass(frozen=True, eq=False)
@show
class PreparedMotion:
    """One experiment at even times: N samples of n joints.

    Parameters
    ----------
    name, t
        The name of the experiment and the times (N,) in s.
    q, qd, qdd
        (N, n). Filtered positions in rad or m, and their derivatives.
    tau, filtered_tau
        (N, n). The torques as measured, and through the filter of the positions, in N m or N.
    weighs
        (N,). False near the ends, where the filter has not settled.
    """

    name: str
    t: Array
    q: Array
    qd: Array
    qdd: Array
    tau: Array
    filtered_tau: Array
    weighs: Marks

    @property
    def period(self) -> float:
        """The time between two samples in s."""
        return float(np.median(np.diff(self.t)))


@check_arguments
def prepare_motion(
    dataset: Dataset,
    positions: Sequence[str],
    torques: Sequence[str],
    cutoff: float,
    *,
    period: float | None = None,
    delay: float = 0.0,
) -> tuple[PreparedMotion, ...]:
    """The motions of a dataset, one for each experiment, for a regression of torques.

    Rows with the time of the row before them are merged, samples are brought to even times by straight lines, and
    positions and torques go forward and backward through one Butterworth filter of fourth order, so that both sides of
    tau = Y theta are filtered alike. Speeds and accelerations come from local polynomials of the filtered positions.

    Parameters
    ----------
    dataset, positions, torques
        The log, and the labels of the positions and torques in it, joint by joint.
    cutoff
        The cutoff of the filter in Hz, where the gain is 1/2.
    period
        The period of the even times in s; the default is the median of each experiment.
    delay
        The time in s by which the motion comes behind the torque that is logged with it.

    Raises
    ------
    ValueError
        If there are not as many torques as positions, a sample is missing, or an experiment is too short.
    LookupError
        If there is no such signal.

    References
    ----------
    Gautier (1997), Dynamic identification of robots with power model, ICRA, 1922-1927 (the parallel filter).

    Examples
    --------
    >>> t = np.arange(0.0, 5.0, 0.002)
    >>> log = wb.Dataset.of(t, {"q": np.sin(t), "tau": np.cos(t)}, {"q": "rad", "tau": "N m"})
    >>> motion = wb.arms.log_regression.prepare_motion(log, ["q"], ["tau"], cutoff=20.0)[0]
    >>> bool(abs(motion.qdd[1000, 0] + np.sin(t[1000])) < 1e-4)
    True
    """
    if not positions or len(positions) != len(torques):
        raise refusal("prepare_motion(torques=...)", f"{len(positions)} labels, as there are positions", torques)
    positive("prepare_motion(cutoff=...)", cutoff, " of Hz")
    late = finite("prepare_motion(delay=...)", delay)
    if period is not None:
        seconds("prepare_motion(period=...)", period)
    labels = (*positions, *torques)
    return tuple(_prepare(dataset, one, labels, cutoff, period, late) for one in dataset.names)


def _prepare(
    dataset: Dataset, name: str, labels: tuple[str, ...], cutoff: float, period: float | None, delay: float
) -> PreparedMotion:
    log = dataset.of_experiments([name])
    if not (np.diff(log.experiments[0].t) > 0).all():
        log = log.merge_repeated()
    even = log.resample(period or log.experiments[0].period)
    smooth, n = even.filter(cutoff, labels), len(labels) // 2
    window = POINTS * smooth.experiments[0].period * (1 - 1e-9)
    for i, label in enumerate(labels[:n]):
        for order, word in enumerate(("speed", "acceleration"), 1):
            smooth = smooth.differentiate(label, f"{word} {i}", window, DEGREE, order)
    one, t = smooth.experiments[0], smooth.experiments[0].t
    q, qd, qdd = (
        _later(t, _columns(one, names), delay)
        for names in (labels[:n], [f"speed {i}" for i in range(n)], [f"acceleration {i}" for i in range(n)])
    )
    edge = ENDS / cutoff + abs(delay)
    weighs = (t >= t[0] + edge) & (t <= t[-1] - edge)
    if weighs.sum() < 2:
        raise ValueError(
            f"`prepare_motion(cutoff=...)` leaves no sample of '{name}', which lasts {np.ptp(t):.4g} s: the filter "
            f"needs {edge:.4g} s at either end; give a higher cutoff."
        )
    raw = _columns(even.experiments[0], labels[n:])
    return PreparedMotion(name, t, q, qd, qdd, raw, _columns(one, labels[n:]), weighs)


def _columns(experiment: Experiment, labels: Sequence[str]) -> Array:
    return np.column_stack([np.asarray(experiment[label]).reshape(len(experiment)) for label in labels])


def _later(t: Array, samples: Array, delay: float) -> Array:
    """The samples at times that are later by a delay."""
    if not delay:
        return samples
    return np.column_stack([np.interp(t + delay, t, column) for column in samples.T])
