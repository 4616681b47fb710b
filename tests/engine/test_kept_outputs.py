"""The outputs of runs with loops in their law: those that are asked for, by the kernel, as CasADi evaluates them."""

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from workbench.engine.kept_outputs import output_groups


@wb.block
class Rooted(wb.Controller):
    """v = K (omega_ref - omega) with K = sqrt(gain) by passes of Newton's method, and the error beside it."""

    gain: float = wb.parameter(default=4.0, unit="V^2 s^2/rad^2")

    reads = follows = wb.layout(omega="rad/s")
    drives = wb.layout(v="V")
    signal_units = {"error": "rad/s"}

    def command(self, t, z, est, ref):
        (root,) = wb.bounded_loop(8, lambda w: ((w + self.gain / w) / 2,), ca.SX(1.0))
        return {"v": root * (ref.omega - est.omega)}

    def signals(self, z, est, ref):
        return {"error": ref.omega - est.omega}


def digital():
    motor = wb.DCMotor()
    loop = wb.ClosedLoop(motor, controller=Rooted(), reference=wb.Step("omega", "rad/s", 1.0))
    return loop.digital(0.01, wb.Instruments.of(motor, noise={"omega": 0.02}))


COMPUTER = digital()


def runs_of(gains, every=0.05, **options):
    p = COMPUTER.parameters.pack({"controller.gain": np.array(gains)})
    return wb.simulate(COMPUTER.step(2), p, until=0.5, every=every, **options)


@pytest.mark.parametrize("every", [0.01, 0.05])
def test_outputs_of_runs_are_those_of_the_step_at_each_kept_time(every):
    runs = runs_of([1.0, 4.0, 9.0], every)
    for run in range(3):
        for i in (0, 1, 7, len(runs.t) - 1):
            k = round(runs.t[i] / 0.01)
            noise = runs.job.part(np.array([run]), 1, 0).noise(np.array([k]))[0, 0]
            y = runs.step.outputs.unpack(np.array(runs.step.y(k, runs.x[run, i], runs.p[run], noise)).ravel())
            for name in runs.step.outputs.names:
                # two machines: the last place of a product or of a sum of some terms of size 1
                np.testing.assert_allclose(runs[name][run, i], y[name], rtol=0, atol=1e-14)


def test_only_the_outputs_behind_loops_wait_for_them():
    runs = runs_of([4.0])
    plain, looped = output_groups(runs.step)
    assert not plain.has_loops
    assert looped.has_loops
    assert "omega" in plain.layout
    assert "error" in plain.layout
    assert {"v"} <= set(looped.layout.names)
    calls = [plain.function.instruction_id(i) for i in range(plain.function.n_instructions())]
    assert ca.OP_CALL not in calls
    assert runs["error"].shape == (1, 11, 1)
    assert set(runs._kept_outputs) == {plain.layout.names[0]}
    assert set(runs.outputs) == set(runs.step.outputs.names)


def test_outputs_of_a_run_do_not_depend_on_the_runs_beside_it():
    many = runs_of(np.linspace(1.0, 9.0, 20), noise_keys=np.arange(20))
    alone = wb.simulate(COMPUTER.step(2), many.p[[13]], until=0.5, every=0.05, noise_keys=np.array([13]))
    for name in many.step.outputs.names:
        np.testing.assert_array_equal(many[name][13], alone[name][0])


def test_outputs_behind_loops_are_no_numbers_once_a_run_has_diverged():
    runs = runs_of([4.0, 1e20])
    assert runs.has_diverged.tolist() == [False, True]
    lost = np.isnan(runs.x[1]).any(axis=1)
    assert np.isnan(runs["v"][1, lost]).all()
    assert np.isfinite(runs["v"][0]).all()


def test_casadi_s_own_arithmetic_evaluates_its_outputs_too():
    runs = [runs_of([4.0], arithmetic=name)["v"] for name in ("casadi", "portable")]
    np.testing.assert_allclose(runs[0], runs[1], rtol=0, atol=1e-10)  # of 50 periods with 2 substeps
