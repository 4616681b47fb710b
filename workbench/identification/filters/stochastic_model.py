"""StochasticModel: equations with the covariances of their noises and of their first state, as a filter needs them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from workbench.core import Layout, Ode, SampledSystem
from workbench.core.step import StepMap
from workbench.core.validation.refusals import Array, vector
from workbench.core.validation.signatures import check_arguments
from workbench.identification.filters.discrete_model import DiscreteModel
from workbench.identification.filters.filter_input import covariance, initial_mean
from workbench.identification.filters.parameter_walk import ParameterWalk, with_walks

Equations = Ode | SampledSystem | StepMap | DiscreteModel


@dataclass(frozen=True, eq=False)
@check_arguments
class StochasticModel:
    """Equations with noises: x' = f(t, x, u) + w of an `Ode`, else x+ = f(k, x, u) + w, and y = h(t, x, u) + v.

    Parameters
    ----------
    equations
        An `Ode`, as of `wb.open_loop`; a loop with its computer; a step of either; or a `DiscreteModel`. The random
        numbers of a step are noise of its states, besides Q.
    Q
        (nx, nx), of an `Ode` the intensity of the white noise w, E w(t) w(s)' = Q delta(t - s), else the covariance of
        w. Positive semidefinite.
    R
        (q, q), the covariance of v, in the order of the outputs that are read. Positive definite.
    x0, P0
        (nx,) and (nx, nx), mean and covariance of the state before the first sample. They must be given.
    p
        (np,), the parameters; by default those of the equations.
    walks
        Parameters of an `Ode` that are estimated with the state, by name. They are states behind the other ones.

    Raises
    ------
    LookupError
        If there is no such parameter.
    ValueError
        If a shape does not fit, Q or P0 is not positive semidefinite, R is not positive definite, or x0 or P0 is not
        given.

    Examples
    --------
    >>> motor = wb.open_loop(wb.DCMotor())
    >>> walks = {"b": wb.filters.ParameterWalk(variance=0.03**2)}
    >>> model = wb.filters.StochasticModel(motor, 1e-4 * np.eye(2), [[1e-4]], [0, 0], np.eye(2), walks=walks)
    >>> model.states.names
    ('omega', 'i', 'b')
    """

    equations: Equations
    Q: Array
    R: Array
    x0: Array | None = None
    P0: Array | None = None
    p: Array | None = None
    walks: Mapping[str, ParameterWalk] = field(default_factory=dict)

    def __post_init__(self) -> None:
        call, n = "StochasticModel", self.equations.states.size
        covariance(call, "Q", self.Q, n)
        covariance(call, "R", self.R, len(self.R) if self.R.ndim else 1, definite=True)
        initial_mean(call, self.x0, n)
        covariance(call, "P0", self.P0, n)
        if self.p is not None:
            size = self.parameters.size
            object.__setattr__(self, "p", vector(f"{call}(p=...)", self.p, size, "parameters"))
        if self.walks and not isinstance(self.equations, Ode):
            raise ValueError(
                f"`{call}(walks=...)` needs an `Ode`, whose parameters are known by name; make them states of the "
                "model."
            )
        if isinstance(self.equations, Ode):
            with_walks(self.equations, list(self.walks))

    @property
    def parameters(self) -> Layout:
        """Names and units of the parameters; of a `DiscreteModel`, of its inputs."""
        equations = self.equations
        return equations.inputs if isinstance(equations, DiscreteModel) else equations.parameters

    @property
    def states(self) -> Layout:
        """Names and units of the states, and of the parameters that are estimated with them."""
        equations = self.equations
        return with_walks(equations, list(self.walks)).states if isinstance(equations, Ode) else equations.states

    def __repr__(self) -> str:
        return f"<StochasticModel of {', '.join(self.states.names)}, {len(self.R)} sensors>"
