"""The full state of any plant: readings where there are instruments, the truth where there are none."""

import numpy as np
import pytest

import workbench as wb

CART = wb.CartPole(phi=0.1)
LAW = wb.StateFeedback.of(CART, [[-70.0, -38.0, 105.0, 21.0]])


def test_a_plant_whose_states_are_all_read_has_the_loop_without_an_observer_to_the_last_bit():
    arm = wb.Manipulator(wb.paper_arm(), q=[0.5, 0.0])
    law = wb.StateFeedback.of(arm, np.eye(2, 4), np.zeros(4), np.zeros(2))
    loops = [wb.ClosedLoop(arm, observer, law) for observer in (wb.FullState.of(arm), None)]
    assert not loops[0].observer.uses_truth
    runs = [wb.simulate(wb.rk4(loop.ode(), 0.01), until=1.0) for loop in loops]
    for name in ("q", "qd", "tau"):
        np.testing.assert_array_equal(runs[0][name], runs[1][name])


def test_its_loop_has_the_poles_that_the_gain_was_designed_for():
    upright = wb.linearize(wb.open_loop(CART), 0.0, np.zeros(4))
    design = wb.lqr(upright, np.diag([5000.0, 0.0, 100.0, 0.0]), [[1.0]])
    ode = wb.ClosedLoop(CART, wb.FullState.of(CART), wb.StateFeedback.of(CART, design)).ode()
    poles = np.linalg.eigvals(np.array(ode.A(0.0, np.zeros(4), ode.parameters.default)))
    np.testing.assert_allclose(np.sort_complex(poles), np.sort_complex(design.poles), rtol=1e-9)


def test_a_state_that_no_instrument_reads_is_the_truth_and_a_run_says_so():
    loop = wb.ClosedLoop(CART, wb.FullState.of(CART), LAW)
    run = wb.simulate(wb.rk4(loop.ode(), 0.01), until=1.0)
    np.testing.assert_array_equal(run["xd_error"], np.zeros_like(run["xd"]))
    assert "uses the true signals xd and phid" in loop.ode().notes[0]
    np.testing.assert_array_equal(run["xd"][..., 0], run["plant.xd"])


def test_in_a_computer_noise_reaches_what_is_read_and_not_what_is_true():
    noise = wb.Instruments.of(CART, noise={"x": 1e-3})
    run = wb.simulate(wb.ClosedLoop(CART, wb.FullState.of(CART), LAW).digital(0.01, noise), until=0.5, seed=1)
    assert np.abs(run["x_error"]).max() > 1e-4
    assert np.abs(run["xd_error"]).max() == 0


def test_no_machine_runs_a_law_that_uses_the_truth():
    loop = wb.ClosedLoop(CART, wb.FullState.of(CART), LAW).digital(0.01)
    with pytest.raises(ValueError, match="No machine can run a law that uses the truth: `FullState` reads 'xd'"):
        loop.law()
    assert loop.law(truths=("xd", "phid")).readings.names == ("x", "xd", "phi", "phid")


def test_a_hidden_state_that_is_none_is_refused():
    with pytest.raises(LookupError, match="Did you mean 'xd'"):
        wb.FullState(CART.states, hidden_states=("xdd",))
