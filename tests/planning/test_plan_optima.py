"""Plans against optima in closed form, published ones, and the derivatives that multipliers promise."""

import math

import casadi as ca
import numpy as np
import pytest

import workbench as wb


def system(f, states, inputs, **more):
    """The equations of a function f(t, x, u, m)."""
    return wb.open_loop(wb.OdePlant.of(f, states=states, inputs=inputs, **more))


def car():
    """A point mass driven by its acceleration."""
    return system(lambda t, x, u: [x[1], u[0]], ("x:m", "v:m/s"), ("a:m/s^2",))


CAR = car()
REST = {"x": 0.0, "v": 0.0}


@pytest.fixture(scope="module")
def fastest():
    """The least time over 300 m with a from -2 to 1."""
    return wb.plan(CAR, (1.0, 100.0), start=REST, end={"x": 300.0, "v": 0.0}, limits={"a": (-2.0, 1.0)})


def test_the_least_time_of_a_car_is_that_of_full_throttle_and_full_brakes(fastest):
    assert fastest.objective == pytest.approx(math.sqrt(2 * 300 * (1 + 1 / 2)), rel=1e-6)  # Bryson and Ho, 3.9
    assert fastest.hold == "zero"
    assert set(fastest.active_limits) == {"a >= -2", "a <= 1"}
    ((first, brakes),) = fastest.active_limits["a <= 1"]
    assert first == 0.0
    assert brakes == pytest.approx(20.0, abs=1.0)  # the interval of the switch is on neither limit


def test_the_march_from_node_to_node_and_from_the_start_meets_the_plan(fastest):
    certificate = fastest.certificate
    assert certificate.is_passed
    assert certificate.defect < 1e-10  # a quadratic motion, which collocation and march have without error
    assert certificate.run_defect < 1e-8
    assert max(certificate.violations.values()) < 1e-8


def test_the_plan_of_a_touched_state_limit_is_bryson_and_denhams():
    # Bryson, Denham and Dreyfus (1963): 4 / (9 l) for l <= 1/6
    plan = wb.plan(
        CAR,
        1.0,
        cost=lambda t, x, u: u.a**2 / 2,
        start={"x": 0.0, "v": 1.0},
        end={"x": 0.0, "v": -1.0},
        limits={"x": (None, 1 / 9)},
    )
    assert plan.objective == pytest.approx(4.0, rel=1e-6)
    assert plan.multipliers["x <= 0.111111"] == pytest.approx(-4 / (9 * (1 / 9) ** 2), rel=1e-3)  # dJ/dl, by the mesh


def test_the_multipliers_of_values_and_duration_are_derivatives_of_the_objective():
    def least_energy(x=1.0, T=2.0):
        return wb.plan(CAR, T, cost=lambda t, x, u: u.a**2 / 2, start={"x": x, "v": 2.0}, end=REST)

    middle, d = least_energy(), 1e-3
    by_x = (least_energy(x=1 + d).objective - least_energy(x=1 - d).objective) / (2 * d)
    by_T = (least_energy(T=2 + d).objective - least_energy(T=2 - d).objective) / (2 * d)
    assert middle.objective == pytest.approx(7.75, rel=1e-9)  # by the Gramian
    assert middle.multipliers["start of x = 1"] == pytest.approx(by_x, rel=1e-5)  # d^2 of the difference
    assert middle.multipliers["duration = 2"] == pytest.approx(by_T, rel=1e-5)


def test_collocation_and_shooting_agree():
    pendulum = system(lambda t, x, u, m: [x[1], -m.sin(x[0]) + u[0]], ("th:rad", "w:rad/s"), ("u:1/s^2",))
    plans = [
        wb.plan(pendulum, 3.0, cost="energy", start={"th": 0.0, "w": 0.0}, end={"th": 2.0, "w": 0.0}, method=method)
        for method in ("collocation", "shooting")
    ]
    assert plans[0].objective == pytest.approx(plans[1].objective, rel=1e-6)  # each march by 1e-6
    np.testing.assert_allclose(plans[0].at([1.0, 2.0])[0], plans[1].at([1.0, 2.0])[0], atol=1e-4)


def test_a_cost_of_the_ode_s_own_symbols_and_a_cost_of_the_end_are_those_of_functions():
    x, v = ca.vertsplit(CAR.x)
    by_symbols = wb.plan(CAR, 2.0, cost=x**2 + v**2 + CAR.input_symbols**2, start={"x": 1.0, "v": 0.0})
    by_function = wb.plan(CAR, 2.0, cost=lambda t, x, u: x.x**2 + x.v**2 + u.a**2, start={"x": 1.0, "v": 0.0})
    # the same cost as the end of a state of its own
    augmented = system(
        lambda t, x, u: [x[1], u[0], x[0] ** 2 + x[1] ** 2 + u[0] ** 2], ("x:m", "v:m/s", "J:"), ("a:m/s^2",)
    )
    zero = wb.plan(
        augmented, 2.0, cost=lambda t, x, u: 0.0, end_cost=lambda t, x: x.J, start={"x": 1.0, "v": 0.0, "J": 0.0}
    )
    assert by_symbols.objective == pytest.approx(by_function.objective, rel=1e-9)
    assert zero.objective == pytest.approx(by_function.objective, rel=1e-6)  # the state J is marched, too


def test_limits_on_rates_are_kept_and_change_the_optimum():
    plan = wb.plan(
        CAR,
        (1.0, 50.0),
        start=REST,
        end={"x": 10.0, "v": 0.0},
        limits={"a": (-1.0, 1.0)},
        rate_limits={"a": (-0.5, 0.5)},
    )
    assert plan.hold == "linear"
    assert np.abs(np.diff(plan["a"]) / np.diff(plan.t)).max() <= 0.5 + 1e-8
    # a = 1 for t1, then a ramp of 4 s to -1, for t1: t1^2 + 4 t1 + 8/3 = 10
    assert plan.objective == pytest.approx(2 * (math.sqrt(4 + 22 / 3) - 2) + 4, rel=2e-4)  # twice the tolerance of it


def test_limits_on_signals_make_a_way_around_an_obstacle():
    point = system(lambda t, x, u: [u[0], u[1]], ("x:m", "y:m"), ("p:m/s", "q:m/s"))
    plan = wb.plan(
        point,
        1.0,
        cost="energy",
        start={"x": -1.0, "y": 0.0},
        end={"x": 1.0, "y": 0.0},
        signals={"r": lambda t, x, u: ca.sqrt(x.x**2 + x.y**2)},
        limits={"r": (0.5, None)},
        guess={"y": [0.0, 0.6, 0.0]},
    )
    tangent, arc = math.sqrt(1 - 0.25), 0.5 * (math.pi - 2 * math.acos(0.5))  # of the shortest way
    assert plan.objective == pytest.approx((2 * tangent + arc) ** 2, rel=1e-4)  # the objective's own tolerance
    assert plan.certificate.violations["r"] < 1e-4
    assert "r >= 0.5" in plan.active_limits


def test_the_reference_of_a_closed_loop_is_planned_while_other_inputs_keep_their_values():
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=10.0, Ki=20.0)
    loop = wb.ClosedLoop(motor, controller=law, reference=wb.Constant("omega", "rad/s", 0.0))
    ode = loop.ode(inputs=True)
    held = {name: 0.0 for name in ode.inputs if name != "omega_ref"}
    plan = wb.plan(ode, (0.05, 5.0), values=held, end={"plant.omega": 0.5, "plant.i": 0.1}, limits={"v": (-24.0, 24.0)})
    assert plan.inputs.names == ("omega_ref",)
    assert plan.certificate.is_passed
    assert "v[0] <= 24" in plan.active_limits  # the command of the law, which is an output of the loop


def test_phases_meet_and_a_bounce_jumps():
    ball = wb.plan(
        CAR,
        phases=(
            wb.planning.Phase((0.1, 5.0), end={"x": 0.0}, jump=lambda x: {"v": -0.8 * x.v}, name="fall"),
            wb.planning.Phase((0.1, 5.0), name="rise"),
        ),
        start={"x": 1.0, "v": 0.0},
        end={"x": 0.5, "v": 0.0},
        cost=lambda t, x, u: (u.a + 9.81) ** 2,
        limits={"x": (0.0, None)},
    )
    before, after = (i for i in range(len(ball.t)) if ball.t[i] == pytest.approx(ball.durations[0]))
    assert ball["v"][after] == pytest.approx(-0.8 * ball["v"][before], rel=1e-9)
    assert ball["x"][after] == pytest.approx(ball["x"][before], abs=1e-9)
    assert len(ball.durations) == 2
    assert ball.certificate.is_passed


def test_a_periodic_orbit_of_a_free_oscillator_costs_nothing():
    oscillator = system(lambda t, x, u: [x[1], -4.0 * x[0] + u[0]], ("x:m", "v:m/s"), ("F:N",))
    orbit = wb.plan(
        oscillator, (2.0, 4.0), cost="energy", start={"x": 1.0, "v": 0.0}, periodic=("x", "v"), guess={"x": [1, -1, 1]}
    )
    assert orbit.until == pytest.approx(math.pi, rel=1e-3)  # the cost is flat to second order there
    assert orbit.objective < 1e-8
    np.testing.assert_allclose(orbit.x[0], orbit.x[-1], atol=1e-9)


def test_a_periodic_input_ends_as_it_starts():
    damped = system(lambda t, x, u: [x[1], -x[0] - 0.2 * x[1] + u[0]], ("x:m", "v:m/s"), ("F:N",))
    orbit = wb.plan(damped, 5.0, cost="energy", start={"x": 1.0}, periodic=("x", "v", "F"))
    assert orbit.hold == "linear"
    assert orbit["F"][0] == pytest.approx(orbit["F"][-1], abs=1e-8)
    assert orbit["v"][0] == pytest.approx(orbit["v"][-1], abs=1e-8)


def test_another_plan_is_a_start_that_ends_at_once(fastest):
    again = wb.plan(
        CAR, (1.0, 100.0), start=REST, end={"x": 300.0, "v": 0.0}, limits={"a": (-2.0, 1.0)}, guess=fastest, starts=1
    )
    assert again.objective == pytest.approx(fastest.objective, rel=1e-6)


@pytest.mark.parametrize(("length", "time"), [(1e-6, 1e-4), (1e6, 1e3)])
def test_a_plan_does_not_depend_on_the_units_of_length_and_time(length, time):
    goal = {"start": {"x": 0.0, "v": length / time}, "end": {"x": 0.0, "v": -length / time}}
    plan = wb.plan(CAR, time, cost=lambda t, x, u: u.a**2 / 2, limits={"x": (None, length / 9)}, **goal)
    assert plan.objective * time**3 / length**2 == pytest.approx(4.0, rel=1e-5)  # as the mesh has it in any unit
    assert plan.certificate.is_passed


def test_a_plan_is_drawn_with_its_limits_and_read_as_a_table(fastest):
    panels = fastest.plot("v", "a").figure.panels
    assert [panel.hlines for panel in panels] == [(), (-2.0, 1.0)]
    assert list(fastest.to_frame().columns) == ["x", "v", "a"]
    times, values = fastest.table("v")
    peak = int(np.argmax(values))
    assert float(wb.Table("v", "m/s", times, values).at(float(times[peak])).v) == pytest.approx(20.0, abs=0.2)
    assert repr(fastest).count("\n") == 0


@pytest.mark.heavy
def test_the_best_of_several_starts_is_no_worse_and_the_same_for_a_seed():
    pole = wb.open_loop(wb.CartPole(phi=np.pi))
    up = {"x": 0.0, "xd": 0.0, "phi": 0.0, "phid": 0.0}
    goal = {"cost": "energy", "end": up, "limits": {"F": (-40.0, 40.0), "x": (-1.0, 1.0)}}
    one, three, again = (wb.plan(pole, 2.0, starts=count, seed=1, **goal) for count in (1, 3, 3))
    assert 1 < len(three.search.starts) <= 3
    assert three.search.starts[0] <= one.search.starts[0] * (1 + 1e-9)
    assert three.objective == again.objective


@pytest.mark.heavy
def test_the_paper_s_arm_moves_in_least_time_on_its_torque_limits():
    arm = wb.open_loop(wb.Manipulator(wb.paper_arm(), q=[0.0, 0.0]))
    plan = wb.plan(arm, (0.1, 10.0), end={"q": [1.0, 1.0], "qd": 0.0}, limits={"tau": ([-100.0, -50.0], [100.0, 50.0])})
    assert plan.certificate.is_passed
    assert np.abs(plan["tau"]).max(axis=0) == pytest.approx([100.0, 50.0], rel=1e-6)
    on_a_limit = (np.abs(plan["tau"]) > [99.99, 49.99]).any(axis=1)
    assert on_a_limit.mean() > 0.9  # Pontryagin: at least one torque is on its limit but for the switches


def test_a_robot_that_starts_crosswise_to_its_first_coordinate_flies_as_published():
    # Betts (2010), section 6.13: 7.9101. At the start no jet moves x, as cos(pi/2) is rounding.
    def robot(t, x, u, m):
        first, second = u[0] - u[1], u[2] - u[3]
        ahead = first + second
        return [x[2], x[3], ahead * m.cos(x[4]), ahead * m.sin(x[4]), x[5], 0.2 * (first - second)]

    jets, rest = ("a", "b", "c", "d"), dict.fromkeys(("x", "y", "vx", "vy", "th", "w"), 0.0)
    states = ("x:m", "y:m", "vx:m/s", "vy:m/s", "th:rad", "w:rad/s")
    plan = wb.plan(
        system(robot, states, tuple(f"{jet}:m/s^2" for jet in jets)),
        12.0,
        cost=lambda t, x, u: u.a + u.b + u.c + u.d,
        start={**rest, "x": -10.0, "y": -10.0, "th": math.pi / 2},
        end=rest,
        limits=dict.fromkeys(jets, (0.0, 1.0)),
        objective_tolerance=1e-3,
        starts=1,
    )
    assert plan.certificate.is_passed
    assert plan.objective == pytest.approx(7.9101, rel=1e-3)  # what was asked of the mesh


def test_a_signal_has_a_value_at_the_end_and_the_orbit_is_as_wide_as_published():
    # Bryson and Ho (1975), section 2.5: from the orbit of the earth, 193 days of low thrust reach a circle of 1.525 AU
    def sail(t, x, u, m):
        thrust, r = 0.1405 / (1 - 0.0749 * t), x[0]
        radial = x[2] ** 2 / r - 1 / r**2 + thrust * m.sin(u[0])
        return [x[1], radial, -x[1] * x[2] / r + thrust * m.cos(u[0])]

    def widest(circle=0.0):
        return wb.plan(
            system(sail, ("r:1", "vr:1", "vt:1"), ("angle:rad",)),
            3.32,
            cost=lambda t, x, u: 0.0 * x.r,
            end_cost=lambda t, x: -x.r,
            start={"r": 1.0, "vr": 0.0, "vt": 1.0},
            end={"vr": 0.0, "circle": circle},
            signals={"circle": lambda t, x, u: x.vt**2 * x.r - 1},
            limits={"angle": (-4.0, 4.0)},
            starts=1,
        )

    plan, d = widest(), 1e-3
    assert plan.certificate.is_passed
    assert plan["r"][-1] == pytest.approx(1.525, abs=1e-3)  # the digits that are printed
    assert plan["vt"][-1] ** 2 * plan["r"][-1] == pytest.approx(1.0, abs=1e-8)  # the tolerance of IPOPT
    slope = (widest(d).objective - widest(-d).objective) / (2 * d)
    assert plan.multipliers["end of circle = 0"] == pytest.approx(slope, rel=1e-3)  # the mesh and d^2
