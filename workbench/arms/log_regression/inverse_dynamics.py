"""`fit_inverse_dynamics`: the base parameters, frictions and drives of an arm from the torques of a log.

References
----------
Khalil and Dombre (2002), Modeling, Identification and Control of Robots, chapter 12.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from workbench.arms.log_regression.inverse_dynamics_fit import InverseDynamicsFit
from workbench.arms.log_regression.prepared_motion import PreparedMotion, prepare_motion
from workbench.arms.log_regression.regressed_joints import JointTerms, regressor_with_joints
from workbench.arms.log_regression.regression import columns_apart, equations_of, solve
from workbench.arms.log_regression.rigid_bodies import nearest_rigid_bodies
from workbench.arms.mechanics.parameter_reduction import BaseParameters, reduce_regressor
from workbench.arms.mechanics.planar_arm import PlanarArm
from workbench.arms.mechanics.spatial import SpatialArm
from workbench.core.validation.refusals import finite, known_name, one_of, refusal
from workbench.core.validation.signatures import check_arguments
from workbench.identification import Dataset

PHYSICAL = ("check", "impose", "ignore")
DEFAULT = JointTerms()


@check_arguments
def fit_inverse_dynamics(
    arm: PlanarArm | SpatialArm,
    dataset: Dataset,
    positions: Sequence[str],
    torques: Sequence[str],
    *,
    cutoff: float,
    terms: JointTerms = DEFAULT,
    hold_out: Sequence[str] = (),
    share: float = 0.2,
    period: float | None = None,
    delay: float = 0.0,
    physical: str = "check",
    even_if_refused: bool = False,
) -> InverseDynamicsFit:
    """Estimate the numbers of an arm from its torques, which are linear in them: tau = Y(q, qd, qdd) theta.

    Only the shape and gravity of `arm` count. The equations of each joint are weighed by its residuals in two rounds;
    standard errors allow for correlated residuals. Noise of the positions makes estimates too small: vary the cutoff.

    Parameters
    ----------
    arm, dataset, positions, torques, cutoff, period, delay
        The arm, and what `wb.arms.log_regression.prepare_motion` needs of its log.
    terms
        The frictions, drives and offsets of the joints.
    hold_out, share
        The experiments that the fit does not see; if none is named, the last `share` of each.
    physical, even_if_refused
        "check" whether rigid bodies have the estimate (extra `lmi`), "impose" that they do, or "ignore" it. And True
        to have the answer though it is worthless, with `reasons_to_refuse`.

    Raises
    ------
    ValueError
        If the data do not tell the numbers apart, rigid bodies cannot have them, or the hold-out speaks against them.
    DesignError
        If no rigid bodies were computed that pass the check of their eigenvalues.
    LookupError
        If there is no such signal or experiment.

    Examples
    --------
    >>> arm, t = wb.robot("planar-1r"), np.arange(0.0, 5.0, 0.002)
    >>> q, qdd = np.sin(3 * t) + 0.5 * np.sin(7 * t), -9 * np.sin(3 * t) - 24.5 * np.sin(7 * t)
    >>> Y = wb.regressor(arm)
    >>> tau = Y.at(q[:, None], 0 * q[:, None], qdd[:, None]) @ Y.theta
    >>> log = wb.Dataset.of(t, {"q": q, "tau": tau}, {"q": "rad", "tau": "N m"})
    >>> terms = wb.arms.log_regression.JointTerms(drive=False, coulomb=False)
    >>> fit = wb.fit_inverse_dynamics(arm, log, ["q"], ["tau"], cutoff=50.0, terms=terms)
    >>> bodies, motion = fit.bodies, fit.motions[0]
    >>> {name: round(fit.values[name], 3) for name in ("link1.mc_x", "link1.I_zz")}
    {'link1.mc_x': 0.5, 'link1.I_zz': 0.333}
    """
    one_of("fit_inverse_dynamics(physical=...)", physical, PHYSICAL)
    if len(positions) != arm.dof:
        raise refusal("fit_inverse_dynamics(positions=...)", f"{arm.dof} labels, one a joint", positions)
    motions = prepare_motion(dataset, positions, torques, cutoff, period=period, delay=delay)
    parts = _parted(motions, tuple(hold_out), finite("fit_inverse_dynamics(share=...)", share))
    fit = _fit_of(reduce_regressor(regressor_with_joints(arm, terms), 0), terms, parts, physical)
    if fit.reasons_to_refuse and not even_if_refused:
        raise ValueError(f"`fit_inverse_dynamics(...)` refuses this log. {' '.join(fit.reasons_to_refuse)}")
    return fit


def _fit_of(
    base: BaseParameters,
    terms: JointTerms,
    parts: tuple[tuple[PreparedMotion, ...], tuple[PreparedMotion, ...]],
    physical: str,
) -> InverseDynamicsFit:
    """The answer for the motions of the fit and those that are held out."""
    answer = solve([equations_of(base, motion, terms) for motion in parts[0]])
    bodies = None
    if physical != "ignore" and columns_apart(answer.singular_values):
        bodies = nearest_rigid_bodies(base, answer.theta, answer.covariance + np.diag(answer.least_errors**2))
    return InverseDynamicsFit(base, terms, answer, bodies, physical == "impose", *parts)


def _parted(
    motions: tuple[PreparedMotion, ...], names: tuple[str, ...], share: float
) -> tuple[tuple[PreparedMotion, ...], tuple[PreparedMotion, ...]]:
    """The motions of the fit, and those that are held out."""
    known = [motion.name for motion in motions]
    for name in names:
        known_name(name, known, "experiments of this dataset")
    if names and len(set(names)) < len(known):
        return (
            tuple(motion for motion in motions if motion.name not in names),
            tuple(motion for motion in motions if motion.name in names),
        )
    if names:
        raise refusal("fit_inverse_dynamics(hold_out=...)", "experiments that leave one for the fit", names)
    if not 0 < share < 1:
        raise refusal("fit_inverse_dynamics(share=...)", "between 0 and 1, as each fit is tried on a hold-out", share)
    return tuple(_part(one, 1 - share, False) for one in motions), tuple(_part(one, 1 - share, True) for one in motions)


def _part(motion: PreparedMotion, share: float, is_late: bool) -> PreparedMotion:
    rows = np.flatnonzero(motion.weighs)
    late = np.arange(len(motion.t)) >= rows[0] + round(share * rows.size)
    return replace(motion, weighs=motion.weighs & (late if is_late else ~late))
