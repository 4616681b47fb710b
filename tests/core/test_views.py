"""Every object that a user meets shows itself in one line, and as a table in a notebook."""

from dataclasses import dataclass
from xml.etree import ElementTree

import casadi as ca
import numpy as np
import pytest

from tests.support.motors import PI, Level, Motor
from workbench.arms.dynamics import Dynamics
from workbench.arms.mechanics import paper_arm
from workbench.blocks.loop import ClosedLoop, open_loop
from workbench.core import Entry, Layout, LinearSystem, Signals, block, layout, parameter, rk4
from workbench.core.validation.notebook_display import brief, short_list, show
from workbench.design import linearize
from workbench.design.linear import equilibria
from workbench.engine.metrics import measure, peak, rmse


@dataclass(frozen=True)
@show
class Parts:
    """Some parts, and a matrix."""

    parts: tuple[int, ...]
    matrix: np.ndarray


def _parsed(html):
    """The text of markup, which must be well formed."""
    return "".join(ElementTree.fromstring(f"<div>{html}</div>").itertext())


LOOP = ClosedLoop(Motor(), controller=PI(), reference=Level())


@pytest.mark.parametrize(
    ("thing", "line"),
    [
        (layout(omega="rad/s", q=("rad", [0.0, 0.0])), "<Layout omega [rad/s], q [rad] x 2>"),
        (
            LOOP.ode().parameters,
            "<Layout plant.R [ohm], plant.L [H], plant.K [N m/A], plant.J [kg m^2], plant.b [N m s/rad], ... 8 in all>",
        ),
        (Motor(), "Motor(R=1, L=0.5, K=0.01, J=0.01, b=0.1, i=0, omega=0)"),
        (
            LOOP,
            "ClosedLoop(plant=Motor(...), observer=Readings(...), controller=PI(...), reference=Level(level=1))",
        ),
        (LOOP.ode(), "<Ode 'loop': 3 states, 8 parameters, 7 outputs>"),
        (LOOP.digital(0.01), "<Sampled 'loop': every 0.01 s, 5 states, 8 parameters, 7 outputs>"),
        (rk4(LOOP.ode(), 1e-3), "<Step of 'loop': h = 0.001 s, 3 states>"),
        (
            LinearSystem.of(linearize(open_loop(Motor()), t=0.0, x=[0.0, 0.0], at_rest=True)),
            "<LinearSystem from v to omega: 2 states>",
        ),
        (Dynamics.of(paper_arm()), "<Dynamics of 'PlanarArm': 2 joints, 5 parameters>"),
        (
            measure(LOOP.ode(), [rmse(), peak("v")], until=1.0, h=1e-2),
            "<Measurement of 1 runs: RMSE, peak of v>",
        ),
    ],
    ids=lambda thing: type(thing).__name__,
)
def test_the_line_says_what_matters(thing, line):
    assert repr(thing) == line


def test_a_large_array_shows_its_shape_and_a_long_text_its_beginning():
    assert brief(np.zeros((20, 3))) == "<20 x 3>"
    assert brief([1.0, np.float64(2.5), True, None]) == "[1, 2.5, True, None]"
    assert brief("x" * 100) == f"'{'x' * 37}'..."
    assert brief(tuple(range(100))) == "(0, ... 100 in all)"
    assert len(short_list([f"name{i}" for i in range(1000)])) < 120


def test_a_table_has_a_line_for_each_part():
    found = equilibria(open_loop(Motor()), {"i": (-1.0, 1.0), "omega": (-1.0, 1.0)}, starts=4, boxes=0)
    assert "points" in _parsed(found._repr_html_())
    assert repr(found.points[0]) in _parsed(found._repr_html_())
    assert "... 40 in all" in _parsed(Parts(tuple(range(40)), np.eye(8))._repr_html_())
    assert "[0. 1. 0. 0. 0. 0. 0. 0.]" in _parsed(Parts((), np.eye(8))._repr_html_())


def test_views_show_names_as_text():
    @block
    class Odd:
        """A number in an odd unit, at an odd choice."""

        mass: float = parameter(1.0, unit="<b>kg</b>")
        name: str = "<script>"

    shown = Odd()._repr_html_() + Layout((Entry("a", 1.0, unit="<b>"),))._repr_html_()
    assert "<b>" not in shown
    assert "<script>" not in shown


def test_a_measurement_is_shown_as_values_with_their_errors():
    runs = measure(LOOP.ode(), [rmse(), peak("v")], until=1.0, h=1e-2)
    table = _parsed(runs._repr_html_())
    for word in ("RMSE", "omega", "rad/s", "peak of v", f"{runs.score('peak of v').value[0]:.6g}"):
        assert word in table
    assert "plant.omega" in _parsed(runs.trajectories._repr_html_())


def test_signals_are_shown_by_name():
    assert "omega(2.*z)" in _parsed(Signals(omega=2 * ca.SX.sym("z"))._repr_html_())


def test_runs_that_are_all_lost_are_shown_too():
    ode = LOOP.ode()
    p = ode.parameters.pack({"controller.kp": [-1e6, -2e6]})
    runs = measure(ode, [rmse()], p, until=100.0, h=1e-2)
    assert runs.trajectories.has_diverged.all()
    assert "nan" in _parsed(runs._repr_html_())
    assert _parsed(runs.trajectories._repr_html_())
