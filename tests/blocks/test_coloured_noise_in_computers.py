"""Noise that remembers, as a computer and its law meet it: substeps, seeds, missed periods and engines."""

import numpy as np
import pytest

import workbench as wb
from tests.support.compilers import needs_llvmlite

MOTOR = wb.DCMotor()


# In a loop


def servo(plant, **instruments):
    law = wb.PID(MOTOR.outputs, MOTOR.inputs, Kp=100.0, Ki=200.0)
    loop = wb.ClosedLoop(plant, controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    return loop.digital(0.01, wb.Instruments.of(plant, **instruments))


def test_the_computer_reads_what_the_plant_does_with_the_noises_of_its_instruments():
    noises = (wb.GaussMarkov("omega", 0.05, 0.5), wb.RandomWalk("omega", 0.01, 0.02))
    digital = servo(MOTOR, coloured_noises=noises, quantum={"omega": 2.0**-10})
    assert digital.noise_states == ("instruments.omega.noise", "instruments.omega.noise_2")
    rows = wb.record(digital, periods=500, seed=4)
    run = wb.simulate(digital.step(1), until=5.0, seed=4, arithmetic="portable")
    after = [run.x[0, 1:, run.step.states.slice(name)].ravel() for name in digital.noise_states]
    read = rows.y[1:, 0]
    # the noise of an instant is in the state behind it
    want = np.floor((run["omega"][0, 1:500, 0] + (after[0] + after[1])[1:500]) * 2**10 + 0.5) / 2**10
    np.testing.assert_array_equal(read, want)


def test_the_noise_of_a_run_follows_from_its_seed_and_key_and_from_no_substep():
    plant = wb.DisturbedPlant(MOTOR, by=wb.SecondOrderNoise("v", 0.5, 5.0, 0.2))
    digital = servo(plant, noise={"omega": 0.01})
    coarse, fine = (digital.step(substeps) for substeps in (1, 4))
    starts = np.tile(coarse.states.default, (3, 1))
    one = wb.simulate(coarse, x0=starts, until=1.0, seed=7)["d_v"]
    np.testing.assert_array_equal(one, wb.simulate(fine, x0=starts, until=1.0, seed=7)["d_v"])
    np.testing.assert_array_equal(
        one[2:], wb.simulate(coarse, until=1.0, seed=7, noise_keys=np.array([2]), x0=starts[2:])["d_v"]
    )
    assert np.all(one[0] != one[1])
    assert np.all(one != wb.simulate(coarse, x0=starts, until=1.0, seed=8)["d_v"])


@needs_llvmlite
@pytest.mark.parametrize("arithmetic", ["fused", "portable"])
def test_the_noise_has_the_same_bits_in_the_compiled_march_and_in_numpy(arithmetic):
    plant = wb.DisturbedPlant(MOTOR, by=wb.SecondOrderNoise("v", 0.5, 5.0, 0.2))
    step = servo(plant, coloured_noises=(wb.GaussMarkov("omega", 0.05, 0.5),)).step(2)
    p = step.parameters.pack({"plant.by.damping": [0.1, 1.0, 3.0]})
    runs = [wb.simulate(step, p, until=1.0, engine=e, arithmetic=arithmetic, seed=1) for e in ("native", "numpy")]
    np.testing.assert_array_equal(*(run.x.view(np.uint64) for run in runs))
    assert step.parameters["plant.by.sigma"].unit == "V"
    assert step.parameters["instruments.coloured_noises[0].sigma"].unit == "rad/s"


def test_the_law_that_is_handed_over_knows_no_noise():
    plant = wb.DisturbedPlant(MOTOR, by=wb.GaussMarkov("v", 0.5, 0.2))
    digital = servo(plant, coloured_noises=(wb.RandomWalk("omega", 0.05),))
    law = digital.law()
    assert not [name for name in law.memory.names + law.parameters.names if "noise" in name or "coloured" in name]
    assert wb.replay(digital, periods=200, targets=["numpy"]).equal


def test_noise_goes_on_where_a_computer_misses_its_periods():
    plant = wb.DisturbedPlant(MOTOR, by=wb.GaussMarkov("v", 0.5, 0.2))
    digital = servo(plant, coloured_noises=(wb.RandomWalk("omega", 0.05),))
    late = digital.with_timing_faults().step(1)
    p = late.parameters.pack({"computer.missed": 1.0})
    run, other = wb.simulate(late, p, until=0.5, seed=3), wb.simulate(digital.step(1), until=0.5, seed=3)
    assert np.all(run["v"] == 0)
    assert np.unique(run["d_v"]).size == run["d_v"].size
    np.testing.assert_allclose(run["d_v"].std(), other["d_v"].std(), rtol=0.9)
