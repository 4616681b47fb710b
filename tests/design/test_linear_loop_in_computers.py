"""The map of a period is that of the step that runs, and its answers are those of python-control and of runs."""

import math

import casadi as ca
import control
import numpy as np
import pytest

import workbench as wb
from studies.b3_any_plant.loops import SUBSTEPS, run
from studies.b3_any_plant.settings import SETTINGS
from studies.paper.card import CARD
from studies.paper.laws import ARM
from studies.paper.linearization import still
from tests.support.cases import heavy_but
from workbench.blocks.loop import ClosedLoop, LinearLaw
from workbench.design.linear_loop import linear_loop
from workbench.design.linear_loop.loop_equations import labels_of
from workbench.engine import simulate

PERIOD, OMEGA = 0.1, np.geomspace(1e-2, np.pi / 0.1, 60)
PLANT = control.tf([1, 2], [1, 1, 3], inputs="v", outputs="omega", name="motor")
PI = control.c2d(control.tf([2.0, 3.0], [1.0, 0.0], inputs="omega", outputs="v", name="pi"), PERIOD, "tustin")
LOOP = ClosedLoop(PLANT, controller=LinearLaw(PI, error=True), reference=wb.Step("omega", "rad/s", 1.0))


@wb.block
class Ball(wb.Plant):
    """A ball at a distance z below a magnet with the current i: m z'' = m g - c (i / z)^2."""

    m: float = wb.parameter(default=0.05, unit="kg", low=0, strict=True)
    c: float = wb.parameter(default=4.9e-5, unit="N m^2/A^2", low=0)
    z: float = wb.initial(default=0.0101, unit="m")
    zd: float = wb.initial(default=0.0, unit="m/s")

    inputs, outputs = wb.layout(i="A"), wb.layout(z="m")

    def rate(self, t, x, u):
        return {"z": x.zd, "zd": 9.8 - self.c / self.m * (u.i / x.z) ** 2}


@wb.block
class Lead(wb.Controller):
    """i = i0 + k (z - z0) + d f, f' = (z - z0 - f) / T, whose filter a computer steps by Euler's method."""

    k: float = wb.parameter(default=500.0, unit="A/m")
    d: float = wb.parameter(default=-300.0, unit="A/m")
    T: float = wb.parameter(default=0.02, unit="s")
    f: float = wb.initial(default=0.0, unit="m")
    reads, drives = wb.layout(z="m"), wb.layout(i="A")

    def command(self, t, z, est, ref):
        return {"i": 1.0 + self.k * (est.z - 0.01) + self.d * z.f}

    def rate(self, t, z, est, ref):
        return {"f": (est.z - 0.01 - z.f) / self.T}


def computers(delay, period=4e-3):
    return wb.DigitalLoop(ClosedLoop(Ball(), controller=Lead()), period, delay=delay)


@pytest.mark.parametrize("delay", [0, 1, 3])
@pytest.mark.parametrize("at", ["v", "omega"])
def test_a_typed_in_loop_in_a_computer_is_that_of_python_control(at, delay):
    linear = linear_loop(wb.DigitalLoop(LOOP, PERIOD, delay=delay), at)
    late = control.tf([1], [1] + [0] * delay, PERIOD)
    L = control.c2d(PLANT, PERIOD, "zoh") * PI * late
    z = np.exp(1j * OMEGA * PERIOD)
    np.testing.assert_allclose(linear.response(OMEGA).values[:, 0, 0], L(z), rtol=1e-9)
    np.testing.assert_allclose(linear.response(OMEGA, "S").values[:, 0, 0], 1 / (1 + L(z)), rtol=1e-9, atol=1e-12)
    wanted = linear.response(OMEGA, "closed", "omega_ref", "omega").values[:, 0, 0]
    np.testing.assert_allclose(wanted, L(z) / (1 + L(z)), rtol=1e-9, atol=1e-12)
    (found,) = linear.margins().values()
    assert found.stable == linear.stable
    if found.stable:
        # python-control's margin finds a gain of 1e-12 beside the integrator; with the gain a pole is on the circle
        on_circle = control.feedback(found.gain_high.value * L, 1).poles()
        assert np.abs(on_circle).max() == pytest.approx(1.0, abs=1e-7)
        assert found.phase_margin.value == pytest.approx(control.margin(L)[1], rel=1e-6)
        grid = np.exp(1j * np.linspace(1e-3, np.pi, 20_000))
        most = np.abs((1 - L(grid)) / (1 + L(grid))).max()
        assert linear.disk_margin.alpha == pytest.approx(2 / most, rel=1e-4)  # the grid misses less


@pytest.mark.parametrize("delay", [0, 2])
def test_the_map_of_a_period_is_the_derivative_of_the_step_that_runs(delay):
    linear, substeps = linear_loop(computers(delay), substeps=3), 3
    sampled = computers(delay).ode()
    step, x = sampled.step(substeps), linear.x0
    names = labels_of(sampled.states)
    p, reach, columns = step.parameters.default, 1e-6, []
    for i in range(len(x)):
        sides = [np.array(step.F(0, x + s * reach * np.eye(len(x))[i], p, [])).ravel() for s in (1, -1)]
        columns.append((sides[0] - sides[1]) / (2 * reach))
    kept = [names.index(name) for name in linear.models.closed_model.states]
    theirs = np.array(columns).T
    # curvatures of 1e6 and steps of 1e-6: differences of second order leave some 1e-7 of the entries
    np.testing.assert_allclose(
        linear.models.closed_model.A[0], theirs[np.ix_(kept, kept)], rtol=1e-6, atol=1e-6 * np.abs(theirs).max()
    )
    np.testing.assert_allclose(np.array(step.F(0, x, p, [])).ravel()[kept], x[kept], rtol=1e-9, atol=1e-12)


def test_a_run_beside_the_rest_follows_the_powers_of_the_map():
    linear = linear_loop(computers(1), substeps=3)
    step = computers(1).ode().step(3)
    start, reach, periods = linear.x0.copy(), 1e-8, 25
    start[0] += reach
    run = simulate(step, None, start[np.newaxis], until=periods * step.h)
    kept = [labels_of(step.states).index(name) for name in linear.models.closed_model.states]
    moved = np.zeros(len(kept))
    moved[0] = reach
    for k in range(periods + 1):
        np.testing.assert_allclose((run.x[0, k] - linear.x0)[kept], moved, atol=2e-4 * np.abs(moved).max() + 1e-13)
        moved = linear.models.closed_model.A[0] @ moved


def test_the_exact_flow_is_the_limit_of_many_substeps():
    fine, exact = linear_loop(computers(1), substeps=64), linear_loop(computers(1))
    np.testing.assert_allclose(fine.models.closed_model.A, exact.models.closed_model.A, rtol=1e-9, atol=1e-12)


def rates():
    """A plant with an observer that runs every two periods and a law that runs every three."""
    matrices = ([[0.0, 1.0], [-2.0, -2.0]], [[0.0], [1.0]], [[1.0, 0.5]], 0.0)
    plant = control.ss(*matrices, 0, states=["a", "b"], inputs=["u"], outputs=["w"])
    filters = control.ss(0.6, 0.4, 1.0, 0.0, 0.2, inputs=["w"], outputs=["w"])
    law = control.ss(0.5, 0.2, -1.0, -0.4, 0.3, inputs=["w"], outputs=["u"])
    return ClosedLoop(plant, filters, law)


def test_several_periods_are_lifted_over_their_common_one():
    digital = wb.DigitalLoop(rates(), 0.1)
    linear, sampled = linear_loop(digital, substeps=4), digital.ode()
    assert linear.models.closed_model.count == 6
    step, p, names = sampled.step(4), sampled.parameters.default, labels_of(sampled.states)
    x = ca.SX.sym("x", len(names))
    state = x
    for k in range(6, 12):  # all blocks run at the instant 6
        state = step.F(k, state, p, [])
    theirs = np.array(ca.Function("map", [x], [ca.jacobian(state, x)])(np.zeros(len(names))))
    kept = [names.index(name) for name in linear.models.closed_model.states]
    np.testing.assert_allclose(linear.models.closed_model.A[0], theirs[np.ix_(kept, kept)], atol=1e-13)
    assert np.abs(np.linalg.eigvals(theirs)).max() == pytest.approx(abs(linear.poles[0].value), rel=1e-9)
    for figure in (linear.margins, linear.bandwidth, lambda: linear.step_info("u_load", "w")):
        with pytest.raises(ValueError, match="several periods"):
            figure()


def test_the_lifted_sensitivity_bounds_the_gains_that_several_periods_stand():
    linear = linear_loop(wb.DigitalLoop(rates(), 0.1), substeps=4)
    M, L = linear.hinf_norm("S").gain.high, linear.L
    turn = 2 * math.asin(1 / (2 * M))
    low, high = M / (M + 1), M / (M - 1) if M > 1 else math.inf
    for factor in (low, min(high, 1e6), 1 + 0.5 * (low - 1), np.exp(1j * turn), np.exp(-1j * turn)):
        # I + k L of the lifted loop, closed at all instants with the same factor, inside of the open range
        k = 1 + 0.999 * (factor - 1) if np.isreal(factor) else factor**0.999
        E = np.linalg.inv(np.eye(L.ninputs) + k * L.D)
        assert np.abs(np.linalg.eigvals(L.A - k * L.B @ E @ L.C)).max() < 1


@pytest.mark.parametrize("turns", heavy_but([1, 24], 1))
def test_the_answer_at_a_frequency_of_several_periods_is_the_part_of_a_run_at_it(turns):
    count, h = 60, 0.1  # a multiple of six instants, and whole turns of the signal
    omega = 2 * np.pi * turns / (count * h)
    digital = wb.DigitalLoop(rates(), h)
    linear, sampled = linear_loop(digital, substeps=4), digital.ode(inputs=True)
    step, place = sampled.step(4), sampled.parameters.slice("u_load")
    x, p, seen = np.zeros(sampled.states.size), sampled.parameters.default.copy(), []
    row = sampled.outputs.slice("w")
    for k in range(6, 6 + 40 * count):
        p[place] = np.cos(omega * k * h)
        seen.append(np.array(step.y(k, x, p, [])).ravel()[row])
        x = np.array(step.F(k, x, p, [])).ravel()
    last = np.array(seen[-count:])
    k = np.arange(6 + 39 * count, 6 + 40 * count)
    theirs = 2 / count * np.exp(-1j * omega * k * h) @ last
    ours = linear.response([omega], "closed", "u_load", "w").values[0, :, 0]
    np.testing.assert_allclose(ours, theirs, rtol=1e-6, atol=1e-9)  # what is left of the start, after 39 x 60 periods


@pytest.mark.heavy
def test_smc_in_a_computer_is_quiet_up_to_the_period_that_a9_prints():
    q2 = np.linspace(0, np.pi, 181)
    pose = ca.SX.sym("q", 2)
    M = ca.Function("M", [pose], [ARM.mass_matrix(pose)])
    K = np.diag(np.broadcast_to(CARD["SMC: K"], 2))
    rho = [np.abs(np.linalg.eigvals(np.linalg.solve(np.array(M([0.0, one])), K))).max() for one in q2]
    least = 2 * CARD["phi"] / max(rho)  # the rule of a9: 0.686 ms of SMC
    assert 1e3 * least == pytest.approx(0.6863, rel=1e-3)
    loop = still("SMC", (0.0, q2[int(np.argmax(rho))]))
    # "quiet up to, not at": 0.667, not 0.714 ms at once, and 0.333, not 0.357 ms with a torque that is a period late
    for delay, quiet, not_quiet in ((False, 0.667e-3, 0.714e-3), (True, 0.333e-3, 0.357e-3)):
        assert linear_loop(wb.DigitalLoop(loop, quiet, delay=delay)).stable
        assert not linear_loop(wb.DigitalLoop(loop, not_quiet, delay=delay)).stable


def test_the_memories_of_a_computer_are_sought_where_all_states_of_the_plant_are_named():
    setting = next(one for one in SETTINGS if one.name == "cart-pole")
    inside = run(setting, "PID", computer=True).loop
    values = {f"plant.{name}": 0.0 for name in setting.open.states.names}
    named, sought = (linear_loop(inside, values=given, substeps=SUBSTEPS) for given in (values, {}))
    assert named.point.at_rest
    np.testing.assert_array_equal(named.x0[:4], 0.0)
    np.testing.assert_allclose(named.x0[4:8], sought.x0[4:8], atol=1e-9)  # filters and commands: Newton's last step
    ours, theirs = (np.array([pole.value for pole in one.poles]) for one in (named, sought))
    np.testing.assert_allclose(ours, theirs, atol=1e-9)
