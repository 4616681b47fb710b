"""Trajectories as tables and as figures."""

import subprocess
import sys

import casadi as ca
import numpy as np
import pytest

import workbench
from tests.support.equations import decay, oscillator
from workbench.core import Entry, Layout, Ode, rk4
from workbench.engine import simulate


def pair() -> Ode:
    """A cart and its angle, of two units in one vector, a matrix and a number."""
    P = Entry("P", np.array([[1.0, 2.0], [3.0, 4.0]]), "s")
    states = Layout((Entry("x", np.array([1.0, 2.0]), "m, rad"), P, Entry("i", np.array(0.5), "A")))
    t, x = ca.SX.sym("t"), states.symbols()
    rates = {"x": -x[:2], "P": ca.SX(2, 2), "i": ca.SX(0)}
    return Ode.of("pair", states, Layout(), (t, x, ca.SX(0, 1)), rates, {"x": 2 * x[:2], "y": x[0], "y_ref": t})


def runs(count=1, ode=None):
    ode = ode or pair()
    return simulate(rk4(ode, 0.01), x0=np.tile(ode.states.default, (count, 1)), until=1.0, every=0.5)


def test_a_table_names_each_number_with_its_unit_and_is_indexed_by_time():
    frame = runs().to_frame()
    assert frame.index.name == "t [s]"
    heads = ["x[0] [m]", "x[1] [rad]", "P[0,0] [s]", "P[1,0] [s]", "P[0,1] [s]", "P[1,1] [s]", "i [A]"]
    assert list(frame.columns) == [*heads, "y", "y_ref"]
    np.testing.assert_array_equal(frame.iloc[0, :7], [1.0, 2.0, 1.0, 3.0, 2.0, 4.0, 0.5])


def test_what_is_a_state_and_an_output_is_the_state_in_a_table():
    np.testing.assert_allclose(runs().to_frame()["x[1] [rad]"], 2 * np.exp([0.0, -0.5, -1.0]), rtol=1e-9)  # RK4


def test_several_runs_are_one_table_by_run_and_time_and_one_is_one():
    rates = np.array([[1.0], [2.0], [3.0]])
    held = simulate(rk4(decay(), 0.01), rates, until=1.0, every=0.5)
    frame = held.to_frame()
    assert frame.index.names == ["run", "t [s]"]
    np.testing.assert_allclose(frame.loc[2, 1.0]["e"], np.exp(-3), rtol=1e-7)  # RK4 of 10 ms
    assert held.to_frame(2).equals(frame.loc[2])


def test_a_figure_has_a_panel_a_signal_with_its_unit_and_a_line_a_number():
    canvas = runs().plot("x", "y", "i")
    assert [ax.get_ylabel() for ax in canvas.axes] == ["x [m, rad]", "y", "i [A]"]
    assert [len(ax.lines) for ax in canvas.axes] == [2, 2, 1]  # y stands beside what is wanted of it
    np.testing.assert_array_equal(canvas.axes[1].lines[1].get_ydata(), [0.0, 0.5, 1.0])


def test_laws_in_one_figure_share_the_panels_and_no_style():
    canvas = workbench.plot({f"law {k}": runs() for k in range(6)}, "x")
    (ax,) = canvas.axes
    looks = {(line.get_color(), str(line._unscaled_dash_pattern)) for line in ax.lines}
    assert len(ax.lines) == len(looks) == 12
    assert {line.get_label() for line in ax.lines} >= {"law 0, x[0]", "law 5, x[1]"}


def test_more_lines_than_styles_are_refused():
    with pytest.raises(ValueError, match=r"up to 12 lines in a panel, .*; 'x' has 14: name a run, as in `run=0`"):
        runs(7).plot("x")
    assert len(runs(7).plot("x", run=6).axes[0].lines) == 2


def test_a_figure_without_names_is_of_what_the_loop_follows_or_of_all_outputs():
    assert [ax.get_ylabel() for ax in runs(ode=oscillator()).plot().axes] == ["q", "e", "q_ref", "tau_applied"]


def test_what_is_not_there_is_answered_with_the_nearest():
    with pytest.raises(LookupError, match="no 'z' among the 5 states and outputs .* They are: x, P, i, y, y_ref"):
        runs().plot("z")
    with pytest.raises(ValueError, match=r"`plot\(run=...\)` must be a whole number from 0 to 0; got 3"):
        runs().plot("x", run=3)
    with pytest.raises(ValueError, match="got an empty mapping"):
        workbench.plot({})
    with pytest.raises(AttributeError, match="no attribute 'plott'"):
        workbench.plott  # noqa: B018


def test_a_simulation_loads_no_report():
    seen = "import sys, workbench.engine; sys.exit(any(m in sys.modules for m in ('matplotlib', 'workbench.report')))"
    assert subprocess.run([sys.executable, "-c", seen], check=False).returncode == 0
