"""Fits of loops that a computer closes: exact derivatives through plant and law, recovery, and refusals by name."""

from dataclasses import replace
from itertools import pairwise

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import workbench as wb
from workbench.identification.estimation.fit_system import _model_of
from workbench.identification.estimation.multiple_shooting import LogSegments
from workbench.identification.estimation.weighed_data import WeighedData

PERIOD, DELAY = 0.05, 1
TRUE = {"plant.J": 0.4, "plant.b": 0.3, "plant.g": 2.0, "controller.Kp[0]": 3.0, "controller.Ki[0]": 2.5}
FREE = [*TRUE, "plant.angle(0)"]
UNITS = {"angle_ref": "rad", "angle": "rad", "u": "N m"}


@wb.block
class Pendulum(wb.Plant):
    """J angle'' + b angle' + g sin(angle) = u."""

    J: float = wb.parameter(default=0.5, unit="kg m^2", low=0, strict=True)
    b: float = wb.parameter(default=0.4, unit="N m s/rad", low=0)
    g: float = wb.parameter(default=1.5, unit="N m", low=0)
    angle: float = wb.initial(default=0.0, unit="rad")
    speed: float = wb.initial(default=0.0, unit="rad/s")

    inputs = wb.layout(u="N m")
    outputs = wb.layout(angle="rad")

    def rate(self, t, x, u):
        torque = u["u"] - self.b * x["speed"] - self.g * ca.sin(x["angle"])
        return {"angle": x["speed"], "speed": torque / self.J}


def loop(**instruments):
    plant = Pendulum()
    law = wb.PID(plant.outputs, plant.inputs, Kp=2.5, Ki=2.0)
    closed = wb.ClosedLoop(plant, reference=wb.Constant("angle", "rad", 0.0), controller=law)
    made = wb.Instruments.of(plant, **instruments) if instruments else None
    return closed.digital(PERIOD, made, delay=bool(DELAY), inputs=True)


DIGITAL = loop()


def by_scipy(t, instants, wanted, p):
    """Angle and command (N, 2) at times t of a pendulum under a PI law whose command waits a period, by SciPy alone.

    `wanted` (K,) is the reference at the `instants` (K,) k T. At an instant the command is the new one.
    """
    J, b, g, Kp, Ki, angle = p
    x, integral, acts, waits = np.array([angle, 0.0]), 0.0, 0.0, 0.0
    edges, rows = np.unique(np.concatenate([t, instants])), {}
    for edge, following in [*pairwise(edges), (edges[-1], None)]:
        k = int(np.argmin(np.abs(instants - edge)))
        if abs(instants[k] - edge) < 1e-9:
            acts, waits = waits, Kp * (wanted[k] - x[0]) + integral
            integral += PERIOD * Ki * (wanted[k] - x[0])
        rows[edge] = [x[0], acts]
        if following is not None:
            motion = solve_ivp(
                lambda s, z, acts=acts: [z[1], (acts - b * z[1] - g * np.sin(z[0])) / J],
                (edge, following), x, method="DOP853", rtol=1e-11, atol=1e-13,
            )  # fmt: skip
            x = motion.y[:, -1]
    return np.array([rows[at] for at in t])


def grid(count):
    """Instants, and a reference in steps."""
    k = np.arange(count)
    return PERIOD * k, np.random.default_rng(7).choice([-0.8, 0.3, 1.2], count)[k // 8 * 8]


def truth(angle=0.2):
    return np.array([*TRUE.values(), angle])


def log(t, reference, y):
    return wb.Dataset.of(t, {"angle_ref": reference, "angle": y[:, 0], "u": y[:, 1]}, UNITS)


INSTANTS, WANTED = grid(120)
Y = by_scipy(INSTANTS, INSTANTS, WANTED, truth())


def model_of(data, free=FREE, hold="hold", step=PERIOD):
    start = {**TRUE, "plant.angle": 0.2}
    model, _ = _model_of(DIGITAL, data, free, {}, hold, start, {})
    while max(model.h) > step:
        model = model.at_half_step()
    return model


def between_instants():
    """Times of which some are instants and most are not, and the reference there in straight lines."""
    rng = np.random.default_rng(3)
    times = np.union1d(INSTANTS[:60:4], INSTANTS[59] * np.append(0.0, np.sort(rng.random(90))))
    return times, np.sin(1.7 * times)


@pytest.mark.parametrize("kind", ["samples at the instants", "samples between the instants"])
def test_derivatives_through_plant_and_law_are_differences_of_runs_by_an_independent_solver(kind):
    if kind == "samples at the instants":
        t, reference, wanted, hold = INSTANTS[:60], WANTED[:60], WANTED[:60], "hold"
    else:
        (t, reference), hold = between_instants(), "linear"
        wanted = np.interp(INSTANTS[:60], t, reference)
    runs = [INSTANTS[:60], wanted]
    y = by_scipy(t, *runs, truth())
    model = model_of(log(t, reference, y), hold=hold, step=2e-3)
    values, J = model.derivatives(model.starts, 0)
    # steps of 2 ms of a loop whose fastest mode has 5 rad/s: (0.01)^5 / 120 a step, and 1500 steps
    np.testing.assert_allclose(values, y, atol=1e-9)
    for i, size in enumerate(truth()):
        d = 1e-5 * size * np.eye(len(FREE))[i]
        difference = (by_scipy(t, *runs, truth() + d) - by_scipy(t, *runs, truth() - d)) / (2 * d[i])
        # 1e-11 of the solver over 2e-5, and the curvature of 1e-10
        assert np.abs(J[:, :, i] - difference).max() < 2e-6 * np.abs(difference).max(), FREE[i]


def test_a_sampled_proportional_law_has_the_derivatives_of_its_closed_form():
    a, K, x0, r, T, n = 2.0, 3.0, 0.7, 1.0, 0.01, 80

    @wb.block
    class Lag(wb.Plant):
        """x' = u - a x."""

        a: float = wb.parameter(default=2.0, unit="1/s")
        x: float = wb.initial(default=0.7, unit="")

        inputs = wb.layout(u="1/s")
        outputs = wb.layout(x="")

        def rate(self, t, x, u):
            return {"x": u["u"] - self.a * x["x"]}

    plant = Lag()
    law = wb.PID(plant.outputs, plant.inputs, Kp=K, Ki=None)
    system = wb.ClosedLoop(plant, reference=wb.Constant("x", "", r), controller=law).digital(T)
    t = T * np.arange(n)

    def closed_form(a, K, x0):
        held = (1 - np.exp(-a * T)) / a
        ratio = np.exp(-a * T) - K * held
        return ratio ** np.arange(n) * x0 + K * held * r * (1 - ratio ** np.arange(n)) / (1 - ratio)

    free = ["plant.a", "controller.Kp[0]", "plant.x(0)"]
    model, _ = _model_of(system, wb.Dataset.of(t, {"x": closed_form(a, K, x0)}), free, {}, "hold", {}, {})
    y, J = model.derivatives(model.starts, 0)
    # one Runge-Kutta step a period: (a T)^5 / 120 = 3e-11 of the state
    np.testing.assert_allclose(y[:, 0], closed_form(a, K, x0), atol=1e-9)
    for i in range(3):
        z = np.array([a, K, x0], dtype=complex)
        z[i] += 1e-30j
        np.testing.assert_allclose(J[:, 0, i], closed_form(*z).imag / 1e-30, atol=1e-8)


def test_a_log_of_references_and_outputs_gives_numbers_of_the_plant_and_gains_back():
    found = wb.fit(DIGITAL, log(INSTANTS, WANTED, Y), FREE)
    for name, value in zip(FREE, truth(), strict=True):
        # the log is right to 1e-11, and an estimate keeps still to 1e-8 at half a step
        assert found.values[name] == pytest.approx(value, rel=1e-6), name
    assert found.certificate.is_passed
    assert "The log has no angle_noise, u_load: nothing is added to the loop there." in found.warnings


def test_standard_errors_are_those_of_differences_of_runs_by_an_independent_solver():
    e = np.random.default_rng(4).standard_normal(Y.shape) * [0.01, 0.05]
    noise = {"angle": 0.01, "u": 0.05}
    found = wb.fit(DIGITAL, log(INSTANTS, WANTED, Y + e), FREE, noise=noise, hold_out=0.0)
    columns = []
    for i in range(len(FREE)):
        d = 1e-5 * max(abs(found.theta[i]), 0.1) * np.eye(len(FREE))[i]
        ends = [by_scipy(INSTANTS, INSTANTS, WANTED, found.theta + side * d) for side in (1, -1)]
        columns.append(((ends[0] - ends[1]) / (2 * d[i]) / [0.01, 0.05]).ravel())
    expected = np.linalg.inv(np.transpose(columns).T @ np.transpose(columns))
    # the step of the search is so short that it moves no estimate by more than 1e-3 of its error
    np.testing.assert_allclose(np.sqrt(np.diag(found.covariance)), np.sqrt(np.diag(expected)), rtol=1e-3)
    distance = (found.theta - truth()) @ np.linalg.solve(found.covariance, found.theta - truth())
    assert distance < 22.5  # the 99.9 % point of a chi-square distribution of 6 numbers


def test_segments_of_a_log_begin_behind_the_jump_at_which_the_one_before_them_ends():
    data = log(INSTANTS, WANTED, Y)
    model = model_of(data)
    segments = LogSegments(WeighedData(model, (np.ones((len(INSTANTS), 2), dtype=bool),)), np.ones(2))
    every = model_of(data, free=["plant.angle(0)"])
    states = DIGITAL.states.labels
    watched = replace(every, outputs=tuple((f"state {label}", label) for label in states))
    x = watched.values(watched.starts[None], 0)[0]
    z = segments.model.starts.copy()
    z[: len(TRUE)] = list(TRUE.values())
    z[len(TRUE)] = 0.2
    for place, begins in segments.transitions:
        z[begins] = x[segments.cuts[0][place + 1]]
    r = segments.residuals(z, np.ones(len(states)))
    # behind the errors of two outputs come the gaps, of the same steps from the same states: their rounding
    gaps = r[2 * len(INSTANTS) :]
    assert len(gaps) == len(states) * len(segments.transitions)
    assert np.abs(gaps).max() < 1e-13


def test_a_far_start_is_led_to_the_numbers_by_segments_of_the_log():
    far = {"plant.J": 4.0, "plant.b": 3.0, "plant.g": 0.2, "controller.Kp[0]": 20.0, "controller.Ki[0]": 0.3}
    found = wb.fit(DIGITAL, log(INSTANTS, WANTED, Y), list(TRUE), start={**far, "plant.angle": 0.2})
    assert found.end.shooting.startswith("segments")
    for name, value in TRUE.items():
        assert found.values[name] == pytest.approx(value, rel=1e-6), name


def test_a_loop_along_a_log_is_its_own_simulation():
    plant = Pendulum()
    law = wb.PID(plant.outputs, plant.inputs, Kp=2.5, Ki=2.0)
    closed = wb.ClosedLoop(plant, reference=wb.Step("angle", "rad", 1.0, time=0.31), controller=law)
    declared = wb.DigitalLoop(closed, PERIOD, delay=True)
    run = wb.simulate(declared.ode().step(64), until=3.0)
    data = wb.Dataset.of(run.t, {"nothing": run.t})
    made = wb.identification.simulate_log(declared, data, ["angle", "u"], tolerance=1e-9)
    for name in ("angle", "u"):
        np.testing.assert_allclose(made[name].ravel(), run[name][0, :, 0], atol=1e-8)


def test_what_a_loop_cannot_tell_apart_is_refused_by_name():
    data = log(INSTANTS, WANTED, Y)
    alone = data.select(["angle_ref", "angle"])
    scaled = ["plant.J", "plant.b", "plant.g", "controller.Kp[0]", "controller.Ki[0]"]
    answer = wb.identifiability(DIGITAL, alone, scaled, ["angle"])
    assert answer.dimension == 1  # all of them times one number
    assert wb.identifiability(DIGITAL, data, scaled, ["angle", "u"]).is_complete
    with pytest.raises(ValueError, match="cannot tell"):
        wb.fit(DIGITAL, alone, scaled)


@pytest.mark.parametrize(
    ("instruments", "words"),
    [
        ({"quantum": {"angle": 0.01}}, "rounds: hold 'instruments.sensors[0].quantum' at 0 by `start`"),
        ({"noise": {"angle": 0.01}}, "hold 'instruments.sensors[0].noise' at 0 by `start`"),
        ({"dac": {"u": (8, -10.0, 10.0)}}, "rounds: give the loop without that"),
    ],
)
def test_a_computer_that_rounds_or_draws_is_refused_with_what_to_do(instruments, words):
    data = log(INSTANTS, WANTED, Y)
    with pytest.raises(ValueError, match="must have a computer") as refusal:
        wb.fit(loop(**instruments), data, FREE)
    assert words in str(refusal.value)
    with pytest.raises(ValueError, match=r"`identifiability\(system=...\)`"):
        wb.identifiability(loop(**instruments), data, FREE, ["angle"])


def test_an_instrument_that_is_held_at_zero_is_none():
    system = loop(quantum={"angle": 0.01}, noise={"angle": 0.01}, limit={"u": (-50.0, 50.0)})
    off = {"instruments.sensors[0].quantum": 0.0, "instruments.sensors[0].noise": 0.0}
    found = wb.fit(system, log(INSTANTS, WANTED, Y), FREE, start=off)
    assert found.values["plant.J"] == pytest.approx(TRUE["plant.J"], rel=1e-6)


def test_a_delay_of_a_reading_and_a_design_for_a_digital_loop_are_refused():
    with pytest.raises(ValueError, match="shift the signal"):
        wb.fit(DIGITAL, log(INSTANTS, WANTED, Y), ["plant.J", "delay of angle_ref"])
    with pytest.raises(ValueError, match=r"`design_experiment\(system=...\)` must be in continuous time"):
        wb.design_experiment(
            DIGITAL, ["plant.J"], ["angle_ref"], ["angle"], noise={"angle": 0.01}, limits={}, until=4.0, every=0.05
        )


def test_a_log_that_lies_beside_the_instants_is_said():
    late = INSTANTS + np.where(np.arange(len(INSTANTS)) > 0, 1e-4, 0.0)
    found = wb.fit(DIGITAL, log(late, WANTED, Y), ["plant.J", "plant.b"], start=TRUE)
    assert any("beside the instants of the computer" in text for text in found.warnings)


def test_a_command_that_follows_the_noise_of_a_reading_is_said():
    e = 0.02 * np.random.default_rng(6).standard_normal(len(INSTANTS))
    plan = {"angle_ref": (WANTED, "rad"), "angle_noise": (e, "rad")}
    data = wb.Dataset.of(INSTANTS, {n: v for n, (v, _) in plan.items()}, {n: unit for n, (_, unit) in plan.items()})
    values = {**TRUE, "plant.angle": 0.2}
    run = wb.identification.simulate_log(DIGITAL, data, ["angle", "u"], values=values)
    read = np.column_stack([run["angle"].ravel() + e, run["u"].ravel()])
    found = wb.fit(DIGITAL, log(INSTANTS, WANTED, read), FREE, start=values)
    assert "u on residuals of angle (dependence)" in found.warnings[0]
    alone = wb.fit(DIGITAL, log(INSTANTS, WANTED, read).select(["angle_ref", "angle"]), FREE[:3], start=values)
    assert not any("residuals of" in test.about for test in alone.residual_tests)
