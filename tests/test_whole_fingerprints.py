"""The fingerprint of equations holds all that they call."""

import subprocess
import sys
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from workbench.core import Layout, Ode, Sampled, layout
from workbench.core.layout import Entry

SPEEDS = np.linspace(-2.0, 2.0, 9)
FRICTION = np.tanh(SPEEDS)


def ode_of(friction):
    """x' = -friction(x)."""
    states, parameters = layout(x="m/s"), Layout((Entry("m", np.ones(()), "kg"),))
    t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
    return Ode("slide", states, parameters, layout(x="m/s"), t, x, p, -friction(x) / p, x)


def table(values, kind="linear", grid=SPEEDS):
    return ca.interpolant("friction", kind, [grid], values)


def within_a_matrix_graph(values):
    v = ca.MX.sym("v")
    return ca.Function("friction", [v], [2 * table(values)(v)])


def never_written_out(gain):
    v = ca.SX.sym("v")
    return ca.Function("friction", [v], [gain * v], {"never_inline": True})


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (table(FRICTION), table(10 * FRICTION)),
        (table(FRICTION), table(FRICTION, grid=2 * SPEEDS)),
        (table(FRICTION), table(FRICTION, "bspline")),
        (table(FRICTION, "bspline"), table(10 * FRICTION, "bspline")),
        (within_a_matrix_graph(FRICTION), within_a_matrix_graph(10 * FRICTION)),
        (never_written_out(1.0), never_written_out(2.0)),
    ],
    ids=["values", "grid", "method", "spline", "a graph of matrices", "a function apart"],
)
def test_two_functions_that_differ_give_two_fingerprints(one, other):
    assert ode_of(one).fingerprint != ode_of(other).fingerprint


def test_a_table_in_the_jump_is_in_the_fingerprint_of_a_sampled_loop():
    def sampled(values):
        flow = ode_of(never_written_out(1.0))
        return Sampled(flow, 0.1, ca.SX.sym("k"), ca.SX(0, 1), table(values)(flow.x))

    assert sampled(FRICTION).fingerprint != sampled(10 * FRICTION).fingerprint
    assert replace(sampled(FRICTION)).fingerprint == sampled(FRICTION).fingerprint


def test_the_same_table_has_the_same_fingerprint_in_another_process():
    script = "from tests.test_whole_fingerprints import *; print(ode_of(table(FRICTION)).fingerprint)"
    printed = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout
    assert printed.strip() == ode_of(table(FRICTION)).fingerprint


class Doubled(ca.Callback):
    def __init__(self):
        ca.Callback.__init__(self)
        self.construct("doubled", {})

    def eval(self, arguments):
        return [2 * arguments[0]]


def test_what_cannot_be_seen_has_no_fingerprint():
    hidden = Doubled()
    v = ca.MX.sym("v")
    for friction in (hidden, ca.Function("around", [v], [hidden(v)])):
        with pytest.raises(ValueError, match="call 'doubled', whose operations CasADi cannot show"):
            _ = ode_of(friction).fingerprint
