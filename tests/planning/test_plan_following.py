"""A plan in a loop: the reference and the feedback along it, the Riccati gains and the sampled funnel."""

import numpy as np
import pytest

import workbench as wb
from workbench.planning import funnel, trajectory_lqr

Q, R = np.diag([10.0, 1.0, 10.0, 1.0]), np.array([[0.1]])


@pytest.fixture(scope="module")
def swing():
    """The swing-up of a cart-pole in 2 s with its regulator, which ends as that of the upright pole."""
    plant = wb.CartPole(phi=np.pi)
    ode = wb.open_loop(plant)
    up = {"x": 0.0, "xd": 0.0, "phi": 0.0, "phid": 0.0}
    plan = wb.plan(ode, 2.0, cost="energy", end=up, limits={"F": (-40.0, 40.0), "x": (-1.0, 1.0)})
    upright = wb.lqr(wb.linearize(ode, 0.0, np.zeros(4)), Q=Q, R=R)
    return plant, plan, upright, trajectory_lqr(plan, Q, R, upright.X)


def test_the_reference_of_a_plan_is_the_plan_between_its_nodes_too(swing):
    _, plan, _, _ = swing
    reference = wb.PlannedReference(plan.motion)
    times = np.linspace(0.0, 1.99, 7)
    x, u = plan.at(times)
    for t, states, inputs in zip(times, x, u, strict=True):
        at = reference.at(float(t))
        values = [float(at[name]) for name in reference.gives.names]
        # both are polynomials of degree 3 through the nodes; the march holds them apart by the tolerance of the plan
        np.testing.assert_allclose(values, [*states, *inputs], atol=1e-4)
    assert reference.ends == pytest.approx(2.0)


def test_the_gain_at_the_end_is_that_of_the_end_and_solves_the_riccati_equation_before(swing):
    _, plan, upright, near = swing
    np.testing.assert_allclose(near.K[-1], upright.K, rtol=1e-9)
    assert near.error < 1e-6
    k = len(near.times) // 2
    h = near.times[k + 1] - near.times[k - 1]
    slope = (near.P[k + 1] - near.P[k - 1]) / h
    p = plan.problem.ode.parameters.pack({"F": plan["F"][k]})[0]
    A, B = (np.array(part(near.times[k], plan.x[k], p)) for part in (plan.problem.ode.A, plan.problem.ode.B))
    P = near.P[k]
    rest = A.T @ P + P @ A - P @ B @ np.linalg.solve(R, B.T @ P) + Q
    # a difference over two intervals of 0.03 s is good to some per cent
    assert np.abs(slope + rest).max() < 0.1 * np.abs(rest).max()


def test_a_loop_follows_the_plan_from_another_start_and_holds_its_end(swing):
    plant, plan, _, near = swing
    law = wb.TrajectoryFeedback(near.states, near.inputs, near.gains)
    reference = wb.PlannedReference(plan.motion, rest_inputs=[0.0])
    loop = wb.ClosedLoop(plant, observer=wb.FullState.of(plant), controller=law, reference=reference)
    x0 = loop.ode().states.pack({"plant.phi": np.pi + 0.2, "plant.x": 0.1})
    run = wb.simulate(wb.rk4(loop.ode(), 4e-3), x0=x0, until=4.0)
    assert abs(run["phi"][0, -1, 0]) < 1e-3
    middle = np.argmin(np.abs(run.t - 1.0))
    assert run["phi_ref"][0, middle, 0] == pytest.approx(plan.at([run.t[middle]])[0][0, 2], abs=1e-4)


def test_a_funnel_counts_the_starts_that_stay(swing):
    _, _, _, near = swing
    small = funnel(near, {"phi": 0.05, "x": 0.05}, {"phi": 0.6, "x": 0.6}, runs=200)
    wide = funnel(near, {"phi": 1.5, "phid": 8.0}, {"phi": 0.6, "x": 0.6}, runs=200)
    assert small.share == 1.0
    assert small.interval[0] == pytest.approx(0.025 ** (1 / 200))  # Clopper and Pearson, where all stay
    assert 0.0 < wide.share < 1.0
    assert wide.interval[0] < wide.share < wide.interval[1]
    assert wide.share == (wide.deviations[:, [0, 2]] <= 0.6).all(axis=1).mean()


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda near: funnel(near, {"phi": -1.0}, {}), "positive"),
        (lambda near: funnel(near, {"angle": 1.0}, {}), "angle"),
        (lambda near: funnel(near, {}, {}, confidence=1.0), "between 0 and 1"),
        (lambda near: near.plan.at([3.0]), "from 0 to 2"),
        (lambda near: near.plan["angle"], "angle"),
        (lambda near: wb.TrajectoryFeedback(near.inputs, near.inputs, near.gains), "shape"),
        (lambda near: wb.core.GainRecord(near.times[1:], near.K[1:]), "first at 0 s"),
        (lambda near: wb.PlannedReference(near.plan.motion, rest_inputs=[0.0, 0.0]), "rest_inputs"),
    ],
)
def test_a_bad_argument_is_refused_in_a_sentence_that_names_it(swing, call, words):
    with pytest.raises((ValueError, LookupError), match=words):
        call(swing[3])
