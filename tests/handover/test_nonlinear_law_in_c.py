"""The nonlinear predictive law on other machines: NumPy, the compiled kernel and C have the same bits."""

import re

import numpy as np
import pytest

import workbench as wb
from tests.support.c_runs import compiled, differing, needs_compiler, recorded
from workbench.handover.c99.c_files import c_code

PERIODS, PERIOD = 40, 0.02
STATES = ("x", "xd", "phi", "phid")


def swinging_loop(horizon, preview):
    """A cart with a hanging pole whose law plans, to a rest or along a planned swing-up with a soft limit."""
    plant = wb.CartPole(phi=3.0)
    ode = wb.open_loop(plant)
    rest = wb.linearize(ode, t=0.0, x=np.zeros(4), at_rest=True)
    limits, more = {"F": (-10.0, 10.0)}, {}
    reference = wb.Step("x", "m", 0.2)
    if preview:
        swing = wb.plan(ode, 1.5, cost="energy", end=dict.fromkeys(STATES, 0.0), limits={"F": (-8.0, 8.0)})
        reference = wb.PlannedReference(swing.motion, rest_inputs=[0.0])
        limits, more = limits | {"x": (-0.2, 0.2)}, {"soft_weight": 1e2, "steps": 2, "iterations": 2}
    weights = np.diag([10.0, 1.0, 10.0, 1.0]), [[0.1]]
    design = wb.nonlinear_predictive_design(rest, PERIOD, *weights, horizon, limits=limits, **more)
    how = {"preview": reference, "safe_command": {"F": 0.0}} if preview else {"follow": ("x",)}
    law = wb.NonlinearPredictive.of(plant, design, **how)
    return wb.ClosedLoop(plant, observer=wb.FullState.of(plant), controller=law, reference=reference).digital(PERIOD)


@pytest.fixture(scope="module", params=[False, True], ids=["to a rest", "along a plan"])
def loop(request):
    return swinging_loop(12, request.param)


@needs_compiler
def test_c_has_the_bits_of_the_simulation(loop, tmp_path):
    law = loop.law(truths=("xd", "phid"))
    y, r, u, z = recorded(loop, law, PERIODS, substeps=1)
    made, memory, flags = compiled(c_code(law, "planned"), tmp_path)(y, r)
    assert not flags.any()
    assert differing(made, u) == differing(memory, z) == 0
    assert np.abs(u).max() > 5.0


def test_numpy_has_the_bits_of_the_compiled_kernel(loop):
    step, bits = loop.step(1), []
    for engine in ("native", "numpy"):
        bits.append(wb.simulate(step, until=5 * PERIOD, arithmetic="portable", engine=engine).x)
    assert differing(*bits) == 0


def test_a_longer_horizon_writes_no_more_equations():
    sizes = []
    for horizon in (10, 40):
        source = c_code(swinging_loop(horizon, False).law(truths=("xd", "phid")), "planned").source
        sizes.append(len(re.findall(r" \* ", source)))
    assert sizes[1] == sizes[0]
