"""The linear models of one equation at a family of operating points."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from workbench.core import Ode
from workbench.core.validation.notebook_display import show
from workbench.core.validation.number_types import Numbers, Values
from workbench.core.validation.refusals import Array, as_array, describe
from workbench.core.validation.signatures import check_arguments
from workbench.design.linear.linearization import linearize
from workbench.design.linear.operating_point import inputs_of, operating_point
from workbench.design.matrices import DesignError

if TYPE_CHECKING:
    from workbench.design.linear.pointed_systems import PointedSpace

CALL = "operating_family"


@dataclass(frozen=True, eq=False)
@show
class OperatingFamily:
    """The operating points of an equation at m values of k states or inputs, and the linear model at each.

    `names` are the k states and inputs whose `values` (m, k) were given. `x` (m, nx) and `u` (m, nu) are the states and
    the inputs at the points, and `models` the linear systems there, each of which carries its point.
    """

    names: tuple[str, ...]
    values: Array
    x: Array
    u: Array
    models: tuple[PointedSpace, ...]

    def __len__(self) -> int:
        return len(self.models)


@check_arguments
def operating_family(ode: Ode, targets: Values, p: Numbers | None = None, u: Numbers | None = None) -> OperatingFamily:
    """The rest points of x' = f(x, p, u) at given values of some states or inputs, and the linear model at each.

    At each point, `wb.linear.operating_point` solves for the inputs and states that have no target. The search starts
    from the inputs at the previous point, so the points belong to one branch if they are close enough.

    Parameters
    ----------
    ode
        The equation, for example `wb.open_loop(plant)`.
    targets
        The values (m,) of single states or inputs, by name. All must have the same length m; a single number holds for
        all points.
    p
        The parameters (np,); the default is those of `ode`.
    u
        The inputs (nu,) from which the search at the first point starts.

    Raises
    ------
    ValueError
        If no target has several values, or the targets have different numbers of them.
    LookupError
        If a name is neither that of a state nor that of an input.
    DesignError
        If no rest point is found at one of the values, which is named.

    References
    ----------
    Rugh and Shamma (2000), Research on gain scheduling, Automatica 36, section 3.

    Examples
    --------
    >>> family = wb.scheduling.operating_family(wb.open_loop(wb.StirredTank()), {"T": [320.0, 335.0, 350.0]})
    >>> family.u.round(1).ravel()
    array([296.9, 303.2, 300. ])
    """
    columns = _columns(targets)
    count = len(next(iter(columns.values())))
    states, inputs, models = [], [], []
    start = u
    for i in range(count):
        wanted = {name: float(values[i]) for name, values in columns.items()}
        try:
            point = operating_point(ode, wanted, p, u=start)
        except DesignError as refused:
            at = ", ".join(f"{name} = {value:g}" for name, value in wanted.items())
            raise DesignError(f"`{CALL}(...)` has no point at {at}: {refused}") from None
        models.append(linearize(ode, 0.0, point.x, p, point.u))
        states.append(point.x)
        inputs.append(point.u)
        start = point.u if inputs_of(ode).size else None
    table = np.column_stack(list(columns.values()))
    return OperatingFamily(tuple(columns), table, np.array(states), np.array(inputs), tuple(models))


def _columns(targets: Values) -> dict[str, Array]:
    """The value of each target at each point."""
    arrays = {name: as_array(value) for name, value in targets.items()}
    for name, array in arrays.items():
        if array is None or array.ndim > 1 or not array.size or not np.isfinite(array).all():
            raise ValueError(
                f"`{CALL}(targets=...)`: '{name}' must be finite numbers (m,), one for each point; got "
                f"{describe(targets[name])}."
            )
    lengths = {name: array.size for name, array in arrays.items() if array is not None and array.ndim == 1}
    if not lengths or len(set(lengths.values())) > 1:
        came = ", ".join(f"{name}: {size}" for name, size in lengths.items()) or "none with several values"
        raise ValueError(
            f"`{CALL}(targets=...)` must have the same number of values for each name that has several; got {came}."
        )
    count = next(iter(lengths.values()))
    return {name: np.broadcast_to(array, (count,)) for name, array in arrays.items() if array is not None}
