"""`plot`, which draws any object that has a picture: runs over time, the linear answers of a loop, and rows of them."""

from __future__ import annotations

from typing import Any

from workbench.core.plot_registry import PLOTTERS, draw
from workbench.core.validation.signatures import check_arguments
from workbench.design.linear_loop import LinearLoop, LinearRows
from workbench.engine import Trajectories
from workbench.identification.estimation.fit import Fit
from workbench.planning.trajectories.trajectory_plan import Plan
from workbench.report.figures.trajectory_figure import plot_runs
from workbench.report.linear_loop_plots import draw_loops
from workbench.report.linear_row_plots import draw_rows
from workbench.report.pictures.fit_pictures import draw_fit
from workbench.report.pictures.plan_pictures import draw_plan

PLOTTERS |= {Trajectories: plot_runs, LinearLoop: draw_loops, LinearRows: draw_rows, Fit: draw_fit, Plan: draw_plan}


@check_arguments
def plot(thing: object, *names: str, **options: object) -> Any:
    """The picture of an object, or of several of one class by their names, as the `.plot()` of the object makes it.

    Parameters
    ----------
    thing
        `Trajectories`, a `LinearLoop`, `LinearRows`, a `Fit`, a `Plan`, or a mapping from names to several of a class.
    names
        For runs, the signals to draw over time, one panel each, see `Trajectories.plot`. For a loop, the kind of
        picture, such as "bode", see `LinearLoop.plot`; for its rows, see `LinearRows.plot`.
    options
        Options of the kind, by name. For runs, `run` is the number of the run that is drawn.

    Raises
    ------
    ValueError
        If the object has no picture, or an option does not fit.
    LookupError
        If there is no such signal.

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> figure = wb.plot(wb.simulate(wb.open_loop(motor), until=1.0), "omega")
    >>> len(figure.axes)
    1
    >>> law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0)
    >>> linear = wb.linear_loop(wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0)))
    >>> wb.plot({"PI": linear}, "bode").caption.split(", ")[0]
    'Phase margin 38.7 degrees'
    """
    return draw(thing, *names, **options)
