"""The answer of a regression of torques, with all that speaks against it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy import stats

from workbench.arms.log_regression.prepared_motion import PreparedMotion
from workbench.arms.log_regression.regressed_joints import JointTerms
from workbench.arms.log_regression.regression import Regression, moving_samples
from workbench.arms.log_regression.rigid_bodies import RigidBodies
from workbench.arms.mechanics.parameter_reduction import BaseParameters
from workbench.core.validation.notebook_display import table_to_html
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments

if TYPE_CHECKING:
    import pandas as pd

CONDITION = 100.0  # of unit columns: Gautier and Khalil (1992) ask for as much of an exciting motion
NEAR = 0.1  # standard errors from rigid bodies that are none
DOUBT = 0.999  # the probability beyond which a distance is no chance
SHARE = 0.2  # of a direction: an entry above it is named


@dataclass(frozen=True, eq=False)
class InverseDynamicsFit:
    """Base parameters, frictions and drives of an arm from the torques of a log.

    `wb.fit_inverse_dynamics` makes one.

    Attributes
    ----------
    base
        The base parameters of the bodies, drives and frictions: names, units, sums and their regressor.
    terms
        The frictions and drives that were asked for.
    regression
        The estimate `theta` (b,), its `covariance` (b, b), and the residuals `sigma` (n,) of the filtered torques.
    bodies
        The nearest rigid bodies; None if they were not asked for.
    is_imposed
        True if `theta` are the base parameters of rigid bodies instead of the estimate of least squares.
    motions, held_out
        The experiments of the fit, and those that it did not see.
    """

    base: BaseParameters
    terms: JointTerms
    regression: Regression
    bodies: RigidBodies | None
    is_imposed: bool
    motions: tuple[PreparedMotion, ...]
    held_out: tuple[PreparedMotion, ...]

    @property
    def theta(self) -> Array:
        """(b,), the estimates."""
        return self.bodies.base if self.is_imposed and self.bodies else self.regression.theta

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the base parameters."""
        return self.base.names

    @property
    def values(self) -> dict[str, float]:
        """The estimates by name."""
        return dict(zip(self.names, self.theta.tolist(), strict=True))

    @property
    def standard_errors(self) -> dict[str, float]:
        """The standard errors by name, of the estimate of least squares."""
        return dict(zip(self.names, np.sqrt(np.diag(self.regression.covariance)).tolist(), strict=True))

    @property
    def condition(self) -> float:
        """The ratio of the largest to the least singular value of the weighed columns, each of length one."""
        values = self.regression.singular_values
        return float(values[0] / values[-1]) if values[-1] > 0 else np.inf

    @property
    def ambiguous_names(self) -> tuple[str, ...]:
        """The names in the directions that these data do not tell; empty if the condition is low enough."""
        values, rows = self.regression.singular_values, self.regression.directions
        weak = rows[values * CONDITION < values[0]]
        return tuple(name for name, part in zip(self.names, weak.T, strict=True) if (np.abs(part) > SHARE).any())

    @check_arguments
    def torque(self, motion: PreparedMotion) -> Array:
        """The torques (N, n) of the model along a motion."""
        rows = self.base.at(motion.q, motion.qd, motion.qdd) @ self.theta
        return np.asarray(rows.reshape(len(motion.t), -1))

    @check_arguments
    def errors(self, motion: PreparedMotion, is_filtered: bool = False) -> Array:
        """(n,). The root mean square by joint of the model less the measured torque, where the filter has settled."""
        measured = motion.filtered_tau if is_filtered else motion.tau
        return np.asarray(np.sqrt(np.mean((self.torque(motion) - measured)[motion.weighs] ** 2, axis=0)))

    @property
    def root_mean_squares(self) -> dict[str, Array]:
        """The errors (n,) of the measured torques by experiment, those that were held out too."""
        return {one.name: self.errors(one) for one in (*self.motions, *self.held_out)}

    @property
    def explained_shares(self) -> dict[str, Array]:
        """By experiment that was held out, the share (n,) of the filtered torque that the model explains.

        It is 1 less the mean square of the error over the variance, of the samples that move fast enough for `terms`;
        NaN where the torque is constant.
        """
        return {one.name: self._explained_share(one) for one in self.held_out}

    def _explained_share(self, motion: PreparedMotion) -> Array:
        error, counts = self.torque(motion) - motion.filtered_tau, moving_samples(motion, self.terms)
        shares = []
        for j in range(error.shape[1]):
            rows = counts[:, j]
            spread = float(np.var(motion.filtered_tau[rows, j])) if rows.any() else 0.0
            shares.append(1 - float(np.mean(error[rows, j] ** 2)) / spread if spread > 0 else np.nan)
        return np.array(shares)

    @property
    def reasons_to_refuse(self) -> tuple[str, ...]:
        """Sentences on what makes the estimates worthless; empty if nothing does."""
        said = []
        if ambiguous := self.ambiguous_names:
            said.append(
                f"These data cannot tell {', '.join(ambiguous)} apart: the condition is {self.condition:.3g}, above "
                f"{CONDITION:g}; excite these, or leave a term of the joints out."
            )
        if self.bodies and not self.is_imposed:
            limit = float(np.sqrt(stats.chi2.ppf(DOUBT, len(self.names))))
            if self.bodies.distance > limit:
                said.append(
                    f"No rigid body has these numbers: {', '.join(self.moved_names)} lie {self.bodies.distance:.3g} "
                    f"standard errors off the nearest that has, above {limit:.3g}."
                )
        for name, shares in self.explained_shares.items():
            poor = [str(i + 1) for i, share in enumerate(shares) if share <= 0]
            if poor:
                said.append(
                    f"On '{name}', which was held out, the model explains less than a constant does of the torque of "
                    f"joint {', '.join(poor)}: the share is {np.nanmin(shares):.2g}."
                )
        return tuple(said)

    @property
    def moved_names(self) -> tuple[str, ...]:
        """The names of the numbers that the nearest rigid bodies have otherwise, by a standard error or most of all."""
        if self.bodies is None:
            return ()
        moved = np.abs(self.bodies.base - self.regression.theta) / np.sqrt(np.diag(self.regression.covariance))
        return tuple(name for name, part in zip(self.names, moved, strict=True) if part >= min(1.0, moved.max()))

    @property
    def warnings(self) -> tuple[str, ...]:
        """Sentences that speak against the fit, what refuses it first."""
        said = list(self.reasons_to_refuse)
        if self.bodies and not self.is_imposed and self.bodies.distance > NEAR and not any("rigid" in s for s in said):
            said.append(
                f"No rigid body has these numbers, though some has others {self.bodies.distance:.2g} standard errors "
                f"away ({', '.join(self.moved_names)}): `physical='impose'` takes those."
            )
        if not self.bodies:
            said.append("Whether rigid bodies have these numbers was not asked.")
        for one in self.motions:
            unused = 1 - moving_samples(one, self.terms)[one.weighs].mean(axis=0)
            slow = [f"{100 * share:.2g} % of joint {i + 1}" for i, share in enumerate(unused) if share > 0]
            if slow:
                said.append(
                    f"Slower than {self.terms.least_speed:g} and not weighed in '{one.name}': {', '.join(slow)}."
                )
        return tuple(said)

    def to_frame(self) -> pd.DataFrame:
        """A table of the estimates with their sums, units and standard errors."""
        import pandas as pd

        errors = tuple(self.standard_errors.values())
        rows = list(zip(self.base.combinations, self.base.units, self.theta, errors, strict=True))
        return pd.DataFrame(
            rows, index=pd.Index(self.names, name="number"), columns=["sum", "unit", "estimate", "standard error"]
        )

    def __repr__(self) -> str:
        least = min((float(np.nanmin(share)) for share in self.explained_shares.values()), default=np.nan)
        said = len(self.warnings)
        notes = f"; {said} warning{'' if said == 1 else 's'}" if said else ""
        return (
            f"<InverseDynamicsFit: {len(self.names)} numbers, condition {self.condition:.3g}, "
            f"{100 * least:.4g} % of the hold-out explained{notes}>"
        )

    def _repr_html_(self) -> str:
        frame = self.to_frame().reset_index()
        title = f"Inverse dynamics; {' '.join(self.warnings)}"
        return table_to_html(title, tuple(frame.columns), frame.to_numpy().tolist())
