"""What a5 says of the paper's loops, by other roads than the study's own."""

from dataclasses import replace

import numpy as np
import pytest

from studies.a5_linear_analysis.pages import SEED, arm, arm_alone, pole_text
from studies.paper.card import PROPOSED_LAW
from studies.paper.linearization import LEVEL, POSES, SEVEN, at_rest, holding_torque, still
from workbench.arms.manipulator import Manipulator
from workbench.core import rk4
from workbench.design.linear import linearize
from workbench.engine import simulate


def resting(law):
    """The equation of a law's whole loop, and the state in which it rests."""
    ode = still(law, POSES[LEVEL]).ode()
    x = ode.states.default.copy()
    if law == "PID":
        x[ode.states.slice("controller.integral")] = -holding_torque(POSES[LEVEL]) / [648.0, 216.0]
    return ode, x


@pytest.mark.parametrize("law", SEVEN)
def test_each_loop_rests_where_it_is_linearised(law):
    ode, x = resting(law)
    moving = [i for i, label in enumerate(ode.states.labels) if "controller.P" not in label]
    # torques of 20 N m over inertias of 0.2 kg m^2, rounded
    np.testing.assert_allclose(ode.rate_at(0.0, x)[moving], 0, atol=1e-11)


@pytest.mark.parametrize("law", ["SMC", "PID", "RBF-ASMC"])
def test_the_poles_of_the_cut_loop_closed_are_those_of_the_loop(law):
    ode, x = resting(law)
    keep = [i for i, label in enumerate(ode.states.labels) if "controller.K" not in label]
    whole = np.linalg.eigvals(np.array(ode.A(0.0, x, ode.parameters.default))[np.ix_(keep, keep)])
    ours = np.array([pole.value for pole in at_rest(law).poles])
    gaps = np.abs(whole[:, None] - ours[None]).min(axis=1) / (1 + np.abs(whole))
    assert gaps.max() < 1e-6  # multiple poles are moved by the root of rounding


def test_super_twisting_in_its_layer_oscillates_undamped_and_has_no_margin():
    rest = at_rest("super-twisting")
    assert rest.disk is None
    assert "asymptotically stable" in rest.why
    # w'' = -k2 s / phi with s' = w, to first order
    assert abs(rest.poles[0].value) == pytest.approx(np.sqrt(15.0 / 0.01), rel=1e-9)


@pytest.mark.heavy
def test_nine_tenths_of_its_torque_make_the_proposed_law_leave_the_upright_arm():
    rest = at_rest(PROPOSED_LAW, "upright")
    assert rest.disk.alpha < 2 * 0.1 / 1.9 < 0.12  # (2 - a) / (2 + a) = 0.9 lies outside of the disk
    loop = still(PROPOSED_LAW, POSES["upright"])
    pole = np.linalg.eigvals(rest.A - 0.9 * rest.B @ rest.Cy).real.max()
    # M qdd + ... = 0.9 tau is the motion of an arm that is heavier by 1 / 0.9
    heavier = tuple(replace(link, mass=link.mass / 0.9) for link in loop.plant.arm.links)
    later = []
    for links in (loop.plant.arm.links, heavier):
        plant = Manipulator(
            replace(loop.plant.arm, links=links), q=np.array(POSES["upright"]) + [1e-3, 0.0], qd=np.zeros(2)
        )
        ode = replace(loop, plant=plant).ode()
        run = simulate(rk4(ode, 2e-4), ode.parameters.default[np.newaxis], until=40.0, every=20.0)
        later.append(np.abs(run["e"][0, 1:]).max(axis=1))
    assert (later[0] < 1e-6).all()
    # the gain learns a little meanwhile, and the deviation is 0.01 rad in the end
    assert np.log(later[1][1] / later[1][0]) / 20 == pytest.approx(pole, rel=0.02)
    assert pole > 0.1


def test_smc_stands_half_its_delay_and_not_twice_it():
    margin = min(m.delay for m in at_rest("SMC").channels)
    assert 0.5e-3 < margin < 1e-3
    # a computer with period T holds its torque, a delay of T / 2 on average, and hands it out a period late
    loop = still("SMC", POSES[LEVEL])
    loop = replace(loop, plant=Manipulator(loop.plant.arm, q=np.array(POSES[LEVEL]) + 1e-6, qd=np.zeros(2)))
    ends = {}
    for share in (0.5, 2.0):
        period = share * margin / 1.5
        sampled = loop.digital(period, delay=True).step(4)
        waiting = {name: holding_torque(POSES[LEVEL]) for name in ("hold.next", "hold.tau")}
        start = sampled.states.pack({name: tau for name, tau in waiting.items() if name in sampled.states})
        run = simulate(sampled, None, start, until=400 * period, every=400 * period)
        ends[share] = np.abs(run["plant.qd"][0, -1]).max()
    assert ends[0.5] < 1e-4 < 1e-3 < ends[2.0]


@pytest.mark.parametrize(
    ("value", "text"), [(-6.0 + 0j, "−6"), (-2447.7 + 0j, "−2448"), (38.73j, "0 ± 38.7i"), (-2.4 + 5.4j, "−2.4 ± 5.4i")]
)
def test_a_pole_is_printed_as_one_reads_it(value, text):
    assert pole_text(value) == text


@pytest.mark.heavy
def test_at_each_of_four_rest_points_positions_alone_show_the_modes_less_than_positions_and_velocities():
    alone = arm_alone(SEED)
    points = alone.rest_points
    assert (len(points.points), points.complete) == (4, True)
    z = np.array([complex(a, b) for a in np.linspace(-7, 7, 141) for b in np.linspace(0, 7, 71)])  # as below: G is real
    for point, (_, both, positions) in zip(points.points, alone.margins, strict=True):
        G = linearize(arm(), 0.0, point.x, at_rest=True)
        for C, margin in ((np.eye(4), both), (np.eye(2, 4), positions)):
            upper = z[:, np.newaxis, np.newaxis] * np.eye(4) - G.A
            squares = np.linalg.eigvalsh(upper.conj().swapaxes(1, 2) @ upper + C.T @ C)[:, 0]  # of singular values
            least = np.sqrt(squares.min()) / np.linalg.norm(np.vstack([G.A, C]), 2)
            np.testing.assert_allclose(margin, least, rtol=0.01)  # half a step of the grid
        assert positions < both / 3
        if np.allclose(point.x, 0, atol=1e-9):  # the hanging arm: 0.03 with velocities, 0.005 without
            np.testing.assert_allclose((both, positions), (0.0298, 0.00507), rtol=2e-3)
