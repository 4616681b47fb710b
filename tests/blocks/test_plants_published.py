"""The plants that are there behave as their publications say."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from workbench.blocks.laws import PID
from workbench.blocks.loop import AbstractController, AbstractPlant, ClosedLoop, open_loop
from workbench.blocks.plants import BuckConverter, CartPole, DCMotor, QuadrupleTank, StirredTank, TwoMasses
from workbench.blocks.signals import CombinedReference, Constant
from workbench.core import block, layout, parameter, rk4
from workbench.core.block import Vector
from workbench.design.linear import equilibria, linearize, operating_point
from workbench.design.riccati import lqr
from workbench.engine import simulate


def transfer(system, s):
    """C (s I - A)^-1 B + D at one frequency, a matrix."""
    return system.C @ np.linalg.solve(s * np.eye(len(system.A)) - system.A, system.B) + system.D


def test_the_motor_of_the_tutorial_on_speed_has_its_poles_and_its_gain():
    ode = open_loop(DCMotor())
    linear = linearize(ode, 0.0, [0.0, 0.0])
    # "Motor Speed: System Analysis" prints -2.0025, -9.9975 and a steady state of 0.1 rad/s at one volt
    np.testing.assert_allclose(sorted(linear.poles().real), [-9.9975, -2.0025], atol=5e-5)
    assert abs(linear.dcgain().item() - 0.1) < 1e-3
    s = 1.0 + 2.0j
    assert abs(transfer(linear, s).item() - 0.01 / ((0.01 * s + 0.1) * (0.5 * s + 1) + 0.01**2)) < 1e-15


def test_the_motor_of_the_tutorial_on_position_has_its_three_poles():
    poles = linearize(open_loop(DCMotor.position()), 0.0, [0.0, 0.0, 0.0]).poles().real
    # "Motor Position: Root Locus Controller Design" speaks of poles at 0, -59.226 and -1.4545e6
    np.testing.assert_allclose(sorted(poles), [-1.4545e6, -59.226, 0.0], rtol=2e-5, atol=1e-6)


def test_the_regulator_of_the_upright_cart_pole_is_the_one_of_the_tutorial():
    linear = linearize(open_loop(CartPole()), 0.0, np.zeros(4), at_rest=True)
    # "Inverted Pendulum: System Modeling", the printed A and B
    np.testing.assert_allclose(linear.A[[1, 3], 1:3], [[-0.1818, 2.6727], [-0.4545, 31.1818]], atol=5e-5)
    np.testing.assert_allclose(linear.B[[1, 3], 0], [1.8182, 4.5455], atol=5e-5)
    K = lqr(linear, np.diag([5000.0, 0.0, 100.0, 0.0]), [[1.0]]).K
    np.testing.assert_allclose(K, [[-70.7107, -37.8345, 105.5298, 20.9238]], atol=5e-5)  # to the digits printed


@block
class Balance(AbstractController):
    """F = -K x of a cart-pole whose states are all read."""

    K: Vector = parameter(unit="", shape=("4",))

    reads = layout(x="m", xd="m/s", phi="rad", phid="rad/s")
    drives = layout(F="N")

    def command(self, t, z, est, ref):
        return {"F": -self.K.T @ self.reads.flatten(est)}


@block
class Seen(AbstractPlant):
    """A cart-pole whose states are all measured."""

    cart_pole: CartPole
    inputs = CartPole.inputs
    outputs = Balance.reads

    @property
    def states(self):
        return self.cart_pole.states

    def rate(self, t, x, u):
        return self.cart_pole.rate(t, x, u)


def test_the_nonlinear_cart_pole_balances_under_that_regulator():
    K = [-70.7107, -37.8345, 105.5298, 20.9238]
    loop = ClosedLoop(Seen(CartPole(x=0.2, phi=0.3)), controller=Balance(K))
    run = simulate(rk4(loop.ode(), 1e-3), until=6.0)
    assert abs(run["phi"][0, -1]) < 1e-6  # the slowest pole decays by exp(-4.76 6) = 4e-13
    assert abs(run["x"][0, -1]) < 1e-6


@pytest.mark.parametrize("phi", [0.4, np.pi - 0.4])
def test_a_cart_pole_without_friction_or_force_keeps_energy_and_momentum(phi):
    plant = CartPole(b=0.0, phi=phi, xd=0.3, phid=1.0)
    run = simulate(rk4(open_loop(plant), 1e-3), until=3.0)
    _, xd, phi_t, phid = run.x[0].T
    ml, inertia = 0.2 * 0.3, 0.006 + 0.2 * 0.3**2
    energy = 0.35 * xd**2 + inertia * phid**2 / 2 - ml * xd * phid * np.cos(phi_t) + ml * 9.8 * np.cos(phi_t)
    momentum = 0.7 * xd - ml * phid * np.cos(phi_t)
    assert np.ptp(energy) < 1e-8  # of some 0.7 J: the error of RK4 at 1 ms
    assert np.ptp(momentum) < 1e-9
    assert np.ptp(phi_t) > 0.8  # it moves


SETTINGS = {"P-": (QuadrupleTank(), 3.0), "P+": (QuadrupleTank.nonminimum_phase(), 3.15)}


def rest(setting):
    plant, v = SETTINGS[setting]
    ode = open_loop(plant)
    return ode, operating_point(ode, {"v_1": v, "v_2": v})


@pytest.mark.parametrize(("setting", "zeros"), [("P-", (-0.0580, -0.0172)), ("P+", (-0.0562, 0.0128))])
def test_the_four_tanks_have_the_zeros_of_their_settings(setting, zeros):
    ode, point = rest(setting)
    # the published levels are rounded to a decimal, and those of P- move its zeros by 3 %
    x = ode.states.default if setting == "P-" else point.x
    found = linearize(ode, 0.0, x, u=point.u).zeros()
    np.testing.assert_allclose(sorted(found.real), zeros, atol=6e-5)
    np.testing.assert_allclose(point.x, ode.states.default, rtol=0.1)  # "h = 12.4, 12.7, 1.8, 1.4" and so on


@pytest.mark.parametrize(("setting", "gain"), [("P-", 1.40), ("P+", -0.636)])
def test_the_four_tanks_have_the_relative_gain_of_their_valves(setting, gain):
    ode, point = rest(setting)
    G = linearize(ode, 0.0, point.x, u=point.u).dcgain()
    assert abs((G * np.linalg.inv(G).T)[0, 0] - gain) < 5e-4
    one, two = SETTINGS[setting][0].gamma_1, SETTINGS[setting][0].gamma_2
    assert abs((G * np.linalg.inv(G).T)[0, 0] - one * two / (one + two - 1)) < 1e-12  # the paper's formula


SENSOR = 0.5  # V/cm


def decay(setting, K, T):
    """The decay rate of the slowest mode of the four tanks under two PI controllers, in 1/s, negative if it grows."""
    (plant, v), (_, point) = SETTINGS[setting], rest(setting)
    gains = SENSOR * np.array(K)
    pair = PID(plant.outputs, plant.inputs, Kp=gains, Ki=gains / np.array(T), u0=[v, v])
    levels = CombinedReference(
        tuple(Constant(name, "cm", level) for name, level in zip(("h_1", "h_2"), point.x[:2], strict=True))
    )
    ode = ClosedLoop(plant, controller=pair, reference=levels).ode()
    x = np.concatenate([point.x, np.zeros(4)])
    assert np.abs(ode.rate_at(0.0, x)).max() < 1e-12
    return -np.linalg.eigvals(np.array(ode.A(0.0, x, ode.parameters.default))).real.max()


def test_two_pi_controllers_show_which_setting_of_the_tanks_is_hard():
    # the gains of the paper's decentralised PI control
    easy, hard = decay("P-", [3.0, 2.7], [30.0, 40.0]), decay("P+", [1.5, -0.12], [110.0, 220.0])
    assert easy > 0.0
    assert hard > 0.0
    assert 5.0 < easy / hard < 20.0  # the paper's settling time is some ten times longer
    assert decay("P+", [3.0, 2.7], [30.0, 40.0]) < 0.0  # a zero in the right half-plane draws the loop over


@pytest.mark.parametrize("k", [0.5, 1.0, 2.0])
def test_the_two_masses_have_the_transfer_function_of_the_benchmark(k):
    linear = linearize(open_loop(TwoMasses(k=k)), 0.0, np.zeros(4))
    for s in (0.3 + 0.1j, 2.0j + 0.5):
        assert abs(transfer(linear, s).item() - k / (s**2 * (s**2 + 2 * k))) < 1e-12
    assert np.abs(linear.poles().imag).max() == pytest.approx(np.sqrt(2 * k))


def test_the_buck_converter_has_the_resonance_of_the_book():
    ode = open_loop(BuckConverter())
    point = operating_point(ode, {"v": 15.0})
    assert point.u.item() == pytest.approx(0.536, abs=5e-4)  # section 9.5.4: D = 0.536
    linear = linearize(ode, 0.0, point.x, u=point.u)
    pole = linear.poles()[0]
    assert abs(pole) / (2 * np.pi) == pytest.approx(1000.0, rel=0.01)  # f_0 = 1 kHz
    assert 20 * np.log10(abs(pole) / (-2 * pole.real)) == pytest.approx(19.5, abs=0.05)  # Q_0 = 9.5, 19.5 dB
    assert linear.dcgain().item() == pytest.approx(28.0)  # G_d0


def heat(T):
    """What the tank at rest makes less what it gives away, in K a minute, with c_A from its own balance."""
    k = 7.2e10 * np.exp(-8750.0 / T)
    return 350.0 - T + 5e4 / 239.0 * k / (1 + k) + 5e4 / (100 * 239.0) * (300.0 - T)


def test_the_stirred_tank_has_three_steady_states_and_rests_at_the_middle_one():
    found = equilibria(open_loop(StirredTank()), {"c_A": (0.0, 1.0), "T": (280.0, 450.0)}, boxes=20_000)
    assert found.complete
    T = np.linspace(280.0, 450.0, 100_001)
    signs = np.flatnonzero(np.diff(np.sign(heat(T))))
    assert len(found.points) == len(signs) == 3
    np.testing.assert_allclose(sorted(point.x[1] for point in found.points), T[signs], atol=0.002)  # the grid's mesh
    middle = found.points[1]
    assert abs(middle.x[0] - 0.5) < 1e-4  # the nominal point, to its digits
    assert abs(middle.x[1] - 350.0) < 0.01
    assert middle.poles.real.max() > 0 > middle.poles.real.min()


def test_the_stirred_tank_counts_the_seconds_of_minutes():
    tank = StirredTank(T=345.0, c_A=0.55)

    def minutes(t, x):
        k = 7.2e10 * np.exp(-8750.0 / x[1]) * x[0]
        return [1 - x[0] - k, 350 - x[1] + 5e4 / 239.0 * k + 5e4 / (100 * 239.0) * (300 - x[1])]

    run = simulate(rk4(open_loop(tank), 0.1), until=60.0)
    other = solve_ivp(minutes, (0.0, 1.0), [0.55, 345.0], rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose(run.x[0, -1], other.y[:, -1], rtol=1e-8)  # of both solvers
