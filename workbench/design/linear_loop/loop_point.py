"""The point about which a loop is linear, and its models there, closed and cut."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.linear.switching_functions import Sides
from workbench.design.linear_loop.loop_equations import LoopEquations, labels_of, rows_by_name
from workbench.design.linear_loop.loop_model import LoopModel
from workbench.design.linear_loop.point_model import Instant, PointModel, point_model
from workbench.design.linear_loop.row_models import RowModels


@dataclass(frozen=True, eq=False)
class LoopPoint:
    """A state x (nx,) and parameters p (np,) of the closed loop at an instant, at rest or not.

    `side` is the one of a corner that was asked for, and `substeps` are those of a run, see `linear_loop`.
    `kept_states` are the places of the states that were named, and `arguments` are the others of the call, as it was
    written.
    """

    equations: LoopEquations
    instant: Instant
    x: Array
    p: Array
    at_rest: bool = True
    side: Sides = None
    substeps: int | None = None
    kept_states: tuple[int, ...] = ()
    arguments: str = ""

    @cached_property
    def row_models(self) -> tuple[RowModels, RowModels | None]:
        """The equations, closed and cut, as the compiled kernel has them; made once, and used by all rows."""
        closed, opened = self.equations.closed_loop, self.equations.open_loop
        cut = None if opened is None else RowModels(opened, self.instant, self.substeps)
        return RowModels(closed, self.instant, self.substeps), cut


def point_models(call: str, point: LoopPoint, x: Array, p: Array) -> tuple[PointModel, PointModel | None]:
    """The models, closed and cut, as of a point but at a state (nx,) and parameters (np,) of the closed loop."""
    equations, how = point.equations, (point.equations.ports, point.side, point.substeps)
    closed = point_model(call, equations.closed_loop, point.instant, x, p, *how)
    if equations.open_loop is None:
        return closed, None
    row = opened_rows(equations, p[np.newaxis], closed.output[np.newaxis])[0]
    return closed, point_model(call, equations.open_loop, point.instant, x, row, *how)


def opened_rows(equations: LoopEquations, p: Array, output: Array) -> Array:
    """The parameters (N, np) of the loop that is cut; its drives are the outputs (N, ny) of the closed loop there."""
    assert equations.open_loop is not None
    rows = rows_by_name(equations.closed_loop.parameters, equations.open_loop.parameters, p)
    labels = labels_of(equations.closed_loop.outputs)
    rows[:, equations.open_loop.parameters.slice("drive")] = output[
        :, [labels.index(label) for label in equations.drive]
    ]
    return rows


def without_corners(model: LoopModel, corner_signals: tuple[str, ...]) -> LoopModel:
    """The model without some outputs, and without the states that nothing reads."""
    outputs = [i for i, label in enumerate(model.outputs) if label not in corner_signals]
    return model.part(outputs, range(len(model.inputs))).reduce()
