"""Noise on its way through every march: by seed, run and step, and by nothing else."""

import numpy as np
import pytest

from tests.support.arms import arm_instruments
from tests.support.compilers import ENGINES, WITHOUT, needs_llvmlite
from workbench.arms.laws import ArmPID
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import ArmFullState
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Sines
from workbench.engine import simulate
from workbench.engine.job import Job
from workbench.engine.kernel.noise import normals
from workbench.engine.metrics import rmse, total_variation
from workbench.engine.metrics.measure_loop import measure

ARM = paper_arm()
LOOP = ClosedLoop(
    Manipulator(ARM, q=[0.5, -0.5]),
    ArmFullState(2),
    ArmPID(Kp=[60.0, 40.0], Ki=[20.0, 10.0], Kd=[10.0, 8.0]),
    Sines("q", "rad", [1.0, 0.5], [2.0, 3.0]),
)
ROUGH = LOOP.digital(2e-3, arm_instruments(2, noise_q=1e-4, noise_qd=1e-2, quantum_q=1e-5, limit=40.0))
STEP = ROUGH.step(2)


def test_a_noisy_run_is_the_recursion_with_the_numbers_of_its_keys():
    keys = np.array([5, 17])
    runs = simulate(STEP, x0=np.tile(STEP.states.default, (2, 1)), until=0.2, seed=9, noise_keys=keys)
    w = normals(9, keys, np.arange(100), STEP.noises)
    for i in range(2):
        x = STEP.states.default
        for k in range(100):
            x = np.array(STEP.F(k, x, STEP.parameters.default, w[i, k])).ravel()
            # rounding, carried through a hundred steps of a stable loop, but for a quantum of 1e-5 rad that flips
            np.testing.assert_allclose(runs.x[i, k + 1], x, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("engine", [pytest.param("numpy", marks=needs_llvmlite), "casadi"])
def test_every_engine_draws_the_same_noise(engine):
    starts = np.tile(STEP.states.default, (3, 1))
    one, other = (simulate(STEP, x0=starts, until=0.5, every=0.1, seed=4, engine=e) for e in (ENGINES[0], engine))
    np.testing.assert_allclose(one.x, other.x, rtol=1e-9, atol=1e-9)  # rounding, as above


def test_a_noisy_run_keeps_its_bits_in_any_order_part_and_width():
    starts = STEP.states.default + 0.01 * np.random.default_rng(1).standard_normal((21, STEP.states.size))
    whole = simulate(STEP, x0=starts, until=0.2, every=0.1, seed=3).x
    order = np.random.default_rng(2).permutation(21)
    np.testing.assert_array_equal(
        simulate(STEP, x0=starts[order], until=0.2, every=0.1, seed=3, noise_keys=order).x, whole[order]
    )
    alone = simulate(STEP, x0=starts[13:14], until=0.2, every=0.1, seed=3, noise_keys=np.array([13])).x
    np.testing.assert_array_equal(alone[0], whole[13])
    pytest.importorskip("llvmlite", reason=WITHOUT)
    from workbench.engine.kernel import native

    for width in (1, 4, 8):
        x = np.stack([starts, starts], axis=1)
        p = np.tile(STEP.parameters.default, (21, 1))
        native.march(Job(STEP, p, 100, 3, np.arange(21)), x, lambda share: None, width)
        np.testing.assert_array_equal(x[:, 1], whole[:, -1])


def test_equal_calls_of_many_lots_give_equal_bits_every_time():
    # the keys must live as long as the march that reads them, whatever else takes and leaves memory meanwhile
    starts = np.tile(STEP.states.default, (65, 1))
    first = simulate(STEP, x0=starts, until=0.02, every=0.02, seed=8).x
    for _ in range(60):
        np.testing.assert_array_equal(simulate(STEP, x0=starts, until=0.02, every=0.02, seed=8).x, first)


def test_keys_alone_make_as_many_runs():
    runs = simulate(STEP, until=0.1, seed=3, noise_keys=np.arange(7))
    assert len(runs) == 7
    assert len(np.unique(runs.x[:, -1, 0])) == 7


def test_another_seed_and_another_run_are_other_noise():
    starts = np.tile(STEP.states.default, (2, 1))
    a, b = (simulate(STEP, x0=starts, until=0.1, seed=seed).x for seed in (0, 1))
    assert not np.array_equal(a[0], a[1])
    assert not np.array_equal(a[0], b[0])


def test_the_outputs_of_a_noisy_loop_are_those_of_its_noise():
    runs = simulate(STEP, until=0.1, seed=6)
    # the torque that is held from an instant on is what the state holds at the next
    np.testing.assert_allclose(runs["tau"][0, :-1], runs["hold.tau"][0, 1:], rtol=1e-12)


def test_a_metric_of_a_noisy_loop_sees_the_same_noise_at_both_substeps():
    metrics = (rmse(), total_variation(2e-3))
    noisy = measure(ROUGH, metrics, until=1.0, h=2e-3, seed=2)
    tv = noisy.score("TV")
    # were the noise another at half the substep, the two would differ by far more than the integrator's error
    assert (tv.error < 1e-3 * tv.value).all()
    quiet = measure(LOOP.digital(2e-3), metrics, until=1.0, h=2e-3)
    assert (tv.value > 1.2 * quiet.score("TV").value).all()


@pytest.mark.parametrize("seed", [-1, 2**64, 0.5, True, "a"])
def test_a_seed_that_is_none_is_refused(seed):
    with pytest.raises(
        ValueError,
        match=r"`simulate\(seed=...\)` must be a whole number(; got| from 0 to 2\^64 - 1)",
    ):
        simulate(STEP, until=0.1, seed=seed)


@pytest.mark.parametrize("runs", [[0], [0, -1], [0.5, 1.0], "ab", [], [[0], [1, 2]], [0, 10**400], [0, 2**63]])
def test_keys_that_name_no_runs_are_refused(runs):
    with pytest.raises(ValueError, match=r"`simulate\(noise_keys=...\)` must be (2 )?whole numbers"):
        simulate(STEP, x0=np.tile(STEP.states.default, (2, 1)), until=0.1, noise_keys=runs)
