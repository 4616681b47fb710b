"""Pendulum, quadrotors and vehicle obey the laws of mechanics, and the figures of their publications."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from workbench.arms.manipulator import Manipulator
from workbench.blocks import plants
from workbench.blocks.loop import AbstractPlant, open_loop
from workbench.blocks.plants import (
    DisturbedPlant,
    EquippedPlant,
    FurutaPendulum,
    InputDisturbances,
    LinearPlant,
    OdePlant,
    PlanarQuadrotor,
    Quadrotor,
    SingleTrackVehicle,
)
from workbench.core import lift, rk4
from workbench.design.linear import linearize, operating_point
from workbench.engine import simulate

FURUTA = FurutaPendulum()
JH_2 = FURUTA.J_2 + FURUTA.m_2 * FURUTA.l_2**2
JH_0 = FURUTA.J_1 + FURUTA.m_1 * FURUTA.l_1**2 + FURUTA.m_2 * FURUTA.L_1**2
COUPLING = FURUTA.m_2 * FURUTA.L_1 * FURUTA.l_2
WEIGHT = FURUTA.g * FURUTA.m_2 * FURUTA.l_2


@pytest.mark.parametrize("theta_2", [0.5, 2.5])
def test_a_furuta_pendulum_without_friction_or_torque_keeps_energy_and_momentum(theta_2):
    # two integrals of two degrees of freedom: no term of the full dynamics can be wrong or missing
    plant = FurutaPendulum(b_1=0.0, b_2=0.0, theta_2=theta_2, theta_1d=3.0, theta_2d=-2.0)
    run = simulate(rk4(open_loop(plant), 1e-3), until=3.0)
    _, angle, turn, swing = run.x[0].T
    M_11, M_12 = JH_0 + JH_2 * np.sin(angle) ** 2, COUPLING * np.cos(angle)
    energy = M_11 * turn**2 / 2 + M_12 * turn * swing + JH_2 * swing**2 / 2 - WEIGHT * np.cos(angle)
    momentum = M_11 * turn + M_12 * swing
    assert np.ptp(energy) < 1e-9  # of 0.2 J, the error of RK4 at 1 ms
    assert np.ptp(momentum) < 1e-10
    assert np.ptp(turn) > 0.4


def test_the_upright_furuta_pendulum_has_the_linear_model_of_the_paper():
    linear = linearize(open_loop(FURUTA), 0.0, [0.0, np.pi, 0.0, 0.0], at_rest=True)
    D = JH_0 * JH_2 - COUPLING**2  # the paper writes both rows over this determinant
    b_1, b_2, m_2, L_1, l_2 = FURUTA.b_1, FURUTA.b_2, FURUTA.m_2, FURUTA.L_1, FURUTA.l_2
    arm = [0.0, FURUTA.g * m_2**2 * l_2**2 * L_1 / D, -b_1 * JH_2 / D, -b_2 * COUPLING / D]
    pendulum = [0.0, WEIGHT * JH_0 / D, -b_1 * COUPLING / D, -b_2 * JH_0 / D]
    np.testing.assert_allclose(linear.A[2:], [arm, pendulum], rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(linear.B[2:, 0], [JH_2 / D, COUPLING / D], rtol=1e-10)
    assert (linear.poles().real > 1.0).sum() == 1


def test_the_quadrotor_hovers_at_the_rotor_speed_of_its_weight():
    ode = open_loop(Quadrotor())
    point = operating_point(ode, {"xi": [1.0, 2.0, 3.0], "eta[2]": 0.7})
    np.testing.assert_allclose(point.u, 620.6108, atol=5e-5)  # sqrt(m g / (4 k))
    np.testing.assert_allclose(point.x, [1, 2, 3, 0, 0, 0.7, 0, 0, 0, 0, 0, 0], atol=1e-9)


def test_a_tumbling_body_keeps_its_angular_momentum_in_space():
    # Euler's equations and the kinematics of roll, pitch and yaw at once, against SciPy's own rotations
    plant = Quadrotor(I=(0.004, 0.006, 0.009), A=(0.0, 0.0, 0.0), eta=(0.3, -0.2, 1.0), nu=(1.0, 2.0, -1.5))
    ode = open_loop(plant)
    run = simulate(rk4(ode, 1e-3), ode.parameters.pack({"w": np.zeros(4)}), until=0.5)
    turned = Rotation.from_euler("ZYX", run["eta"][0][:, ::-1])
    momentum = turned.apply(run["nu"][0] * np.array([0.004, 0.006, 0.009]))
    assert np.ptp(run["nu"][0], axis=0).max() > 0.3
    np.testing.assert_allclose(momentum, np.tile(momentum[0], (len(momentum), 1)), atol=1e-12)
    fall = run["xi"][0, -1]
    np.testing.assert_allclose(fall, [0.0, 0.0, -9.81 * 0.5**2 / 2], atol=1e-12)


def test_the_thrust_is_along_the_third_axis_of_the_body():
    plant = Quadrotor(eta=(0.4, -0.3, 1.1), A=(0.0, 0.0, 0.0))
    ode = open_loop(plant)
    p = ode.parameters.pack({"w": np.full(4, 700.0)})[0]
    push = ode.states.unpack(ode.rate_at(0.0, ode.states.default, p))["xid"] + np.array([0.0, 0.0, 9.81])
    axis = Rotation.from_euler("ZYX", [1.1, -0.3, 0.4]).apply([0.0, 0.0, 1.0])
    np.testing.assert_allclose(push, 4 * 2.980e-6 * 700.0**2 / 0.468 * axis, rtol=1e-12)


def test_fast_rotors_turn_a_pitching_body_by_their_gyroscopic_moment():
    still, fast = (open_loop(Quadrotor(I_r=I_r, b=0.0, nu=(0.0, 2.0, 0.0))) for I_r in (0.0, 3.357e-5))
    rates = []
    for ode in (still, fast):
        p = ode.parameters.pack({"w": [700.0, 500.0, 700.0, 500.0]})[0]
        rates.append(ode.states.unpack(ode.rate_at(0.0, ode.states.default, p))["nu"])
    # -I_r nu x e_3 w_G with w_G = 700 - 500 + 700 - 500 rad/s
    np.testing.assert_allclose(rates[1] - rates[0], [-3.357e-5 * 2.0 * 400.0 / 4.856e-3, 0.0, 0.0], rtol=1e-12)


def test_a_quadrotor_that_only_rolls_is_the_planar_one():
    flat = open_loop(PlanarQuadrotor(x=1.0, y=2.0, theta=0.4, xd=0.1, yd=-0.2, thetad=3.0))
    body = Quadrotor(
        m=0.486, l=0.25, I=(0.00383, 1.0, 1.0), A=(0.0, 0.0, 0.0), b=0.0, I_r=0.0,
        xi=(0.0, 1.0, 2.0), eta=(0.4, 0.0, 0.0), xid=(0.0, 0.1, -0.2), nu=(3.0, 0.0, 0.0),
    )  # fmt: skip
    space, k = open_loop(body), 2.980e-6
    left = simulate(rk4(flat, 1e-3), flat.parameters.pack({"u_1": 3.0, "u_2": 2.0}), until=0.4)
    w = [0.0, np.sqrt(2.0 / k), 0.0, np.sqrt(3.0 / k)]
    right = simulate(rk4(space, 1e-3), space.parameters.pack({"w": w}), until=0.4)
    for name, (other, place) in {"x": ("xi", 1), "y": ("xi", 2), "theta": ("eta", 0)}.items():
        np.testing.assert_allclose(left[name][0].ravel(), right[other][0][:, place], atol=1e-9)  # of values near 1


def test_a_hovering_planar_quadrotor_moves_sideways_through_four_integrators():
    ode = open_loop(PlanarQuadrotor())
    linear = linearize(ode, 0.0, np.zeros(6), u=[0.486 * 9.81 / 2] * 2, at_rest=True)
    s = 0.7 + 0.4j
    G = linear.C @ np.linalg.solve(s * np.eye(6) - linear.A, linear.B)
    np.testing.assert_allclose(G[0], [-9.81 * 0.25 / 0.00383 / s**4, 9.81 * 0.25 / 0.00383 / s**4], rtol=1e-12)


def turning(V):
    """Slip velocity and yaw rate of the vehicle in a steady turn, for one radian at the wheels."""
    ode = open_loop(SingleTrackVehicle(V_x=V))
    A, B = (np.array(J(0.0, np.zeros(4), ode.parameters.default)) for J in (ode.A, ode.B))
    return -np.linalg.solve(A[2:, 2:], B[2:, 0])


def test_the_vehicle_understeers_by_the_gradient_of_the_book():
    car = SingleTrackVehicle()
    L = car.l_f + car.l_r
    m_f, m_r = car.m * car.l_r / L, car.m * car.l_f / L
    K_V = m_f / (2 * car.C_f) - m_r / (2 * car.C_r)  # section 3.3: K_V = m_f / (2 C_f) - m_r / (2 C_r)
    for V in (5.0, 30.0, 60.0):
        R = V / turning(V)[1]
        assert pytest.approx(1.0, rel=1e-12) == L / R + K_V * V**2 / R  # delta = L / R + K_V a_y
    characteristic = np.sqrt(L / K_V)  # where the yaw rate answers the wheel most
    assert turning(characteristic)[1] > max(turning(0.99 * characteristic)[1], turning(1.01 * characteristic)[1])


def test_a_vehicle_with_weak_rear_tyres_is_unstable_beyond_its_critical_speed():
    car = SingleTrackVehicle(C_r=40_000.0)
    L = car.l_f + car.l_r
    critical = np.sqrt(-L / (car.m / L * (car.l_r / (2 * car.C_f) - car.l_f / (2 * car.C_r))))
    for V, unstable in ((0.99 * critical, False), (1.01 * critical, True)):
        ode = open_loop(SingleTrackVehicle(C_r=40_000.0, V_x=V))
        A = np.array(ode.A(0.0, np.zeros(4), ode.parameters.default))[2:, 2:]
        assert (np.linalg.eigvals(A).real.max() > 0) == unstable


MADE = {name: getattr(plants, name) for name in plants.__all__}
# made of what a user brings
OF_OTHERS = (DisturbedPlant, EquippedPlant, InputDisturbances, LinearPlant, Manipulator, OdePlant)
WHOLE = [
    kind()
    for kind in MADE.values()
    if isinstance(kind, type) and issubclass(kind, AbstractPlant) and kind not in OF_OTHERS
]


@pytest.mark.parametrize("plant", WHOLE, ids=lambda plant: type(plant).__name__)
def test_a_plant_of_the_literature_needs_no_numbers_and_has_units(plant):
    units = [entry.unit for entry in lift(plant).layout.entries]
    assert units.count("") == ("gamma_1" in vars(plant)) + ("gamma_2" in vars(plant))  # shares alone have none
