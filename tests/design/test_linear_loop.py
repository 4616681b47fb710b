"""The linear answers of loops in continuous time are those of python-control, of a5's page, and of closed forms."""

import csv
from pathlib import Path

import control
import numpy as np
import pytest

import workbench as wb
from studies.paper.card import PROPOSED_LAW
from studies.paper.linearization import HELD_STATES, LEVEL, POSES, loop_at_rest, still
from tests.support.cases import heavy_but
from workbench.blocks.loop import AbstractReference, ClosedLoop, LinearLaw
from workbench.design.linear_loop import linear_loop

PLANT = control.tf([1, 2], [1, 1, 3], inputs="v", outputs="omega", name="motor")
PI = control.tf([2.0, 3.0], [1.0, 0.0], inputs="omega", outputs="v", name="pi")
OMEGA = np.geomspace(1e-2, 1e3, 200)
CLOSE = {"rtol": 1e-10, "atol": 1e-13}  # rounding near poles a tenth away
TABLES = Path(__file__).parents[2] / "reports" / "a5_linear_analysis" / "tables"


@wb.block
class Level(AbstractReference):
    """A speed that is wanted from the start."""

    level: float = wb.parameter(default=1.0, unit="rad/s")
    gives = wb.layout(omega="rad/s")

    def at(self, t):
        return {"omega": self.level}


@wb.block
class Ball(wb.Plant):
    """A ball at a distance z below a magnet with the current i: m z'' = m g - c (i / z)^2."""

    m: float = wb.parameter(default=0.05, unit="kg", low=0, strict=True)
    c: float = wb.parameter(default=4.9e-5, unit="N m^2/A^2", low=0)
    g: float = wb.parameter(default=9.8, unit="m/s^2")
    z: float = wb.initial(default=0.012, unit="m")
    zd: float = wb.initial(default=0.0, unit="m/s")

    inputs = wb.layout(i="A")
    outputs = wb.layout(z="m", zd="m/s")

    def rate(self, t, x, u):
        return {"z": x.zd, "zd": self.g - self.c / self.m * (u.i / x.z) ** 2}


def typed(law=PI, plant=PLANT):
    return ClosedLoop(plant, controller=LinearLaw(law, error=True), reference=Level())


def answers(system):
    return control.frequency_response(system, OMEGA, squeeze=False).frdata[0, 0]


P, C = PLANT, PI
SIX = {"TF": P * C, "CSF": C, "PS": P, "T": P * C, "CS": C, "S": 1}


@pytest.mark.parametrize("at", ["v", "omega"])
def test_l_s_and_t_of_a_typed_in_loop_are_those_of_python_control(at):
    linear, L = linear_loop(typed(), at), P * C
    for of, theirs in {"L": L, "S": control.feedback(1, L), "T": control.feedback(L, 1)}.items():
        response = linear.response(OMEGA, of)
        np.testing.assert_allclose(response.values[:, 0, 0], answers(theirs), **CLOSE)
        np.testing.assert_allclose(answers(linear.system(of)), answers(theirs), **CLOSE)
        assert (response.inputs, response.outputs) == ((at,), (at,))


@pytest.mark.parametrize("name", SIX)
def test_the_gang_of_six_is_that_of_python_control(name):
    six = linear_loop(typed()).gang_of_six(OMEGA)
    theirs = answers(SIX[name] * control.feedback(1, P * C))
    np.testing.assert_allclose(six[name].values[:, 0, 0], theirs, **CLOSE)


def test_signals_answer_signals_by_name_in_the_closed_and_in_the_open_loop():
    linear = linear_loop(typed())
    S = control.feedback(1, P * C)
    load = linear.response(OMEGA, "closed", "v_load", ("e_omega", "v_applied"))
    np.testing.assert_allclose(load["e_omega", "v_load"], answers(P * S), **CLOSE)
    np.testing.assert_allclose(load["v_applied", "v_load"], answers(S), **CLOSE)
    opened = linear.response(OMEGA, "open", ("drive", "omega_ref"), ("omega", "v"))
    np.testing.assert_allclose(opened["omega", "drive"], answers(P), **CLOSE)
    np.testing.assert_allclose(opened["v", "omega_ref"], answers(C), **CLOSE)
    np.testing.assert_allclose(opened["v", "drive"], -answers(P * C), **CLOSE)


def test_bode_data_are_those_of_python_control():
    linear = linear_loop(typed())
    magnitude, phase, _ = control.frequency_response(P * C, OMEGA)
    bode = linear.response(OMEGA).bode()
    np.testing.assert_allclose(bode.magnitude[:, 0, 0], magnitude, rtol=1e-10)
    np.testing.assert_allclose(bode.decibels[:, 0, 0], 20 * np.log10(magnitude), atol=1e-9)
    np.testing.assert_allclose(bode.phase[:, 0, 0], np.degrees(np.unwrap(phase)), atol=1e-8)


def test_margins_and_norms_of_a_triple_lag_are_those_of_its_closed_form():
    lag = control.tf([1], [1, 3, 3, 1], inputs="v", outputs="omega")
    law = control.tf([4.0, 4.0], [1.0, 5.0], inputs="omega", outputs="v")
    linear, L = linear_loop(typed(law, lag)), lag * law
    (found,) = linear.margins().values()
    gain, phase, _, _ = control.margin(L)
    assert found.stable
    assert linear.stable
    np.testing.assert_allclose(found.gain_high.value, gain, rtol=1e-7)
    assert np.isinf(found.phase_margin.value) == np.isinf(phase)
    # the largest |S|, by two roads: exact polynomials of L, and those of the state space of S
    assert linear.hinf_norm("S").gain.value == pytest.approx(found.Ms.gain.value, rel=1e-12)
    assert linear.disk_margin.alpha == pytest.approx(found.disk_margin.value, rel=1e-5)
    theirs = control.norm(control.ss(lag * control.feedback(1, L)), 2)
    assert linear.h2_norm("closed", "v_load", "omega").gain.value == pytest.approx(theirs, rel=1e-6)


def test_poles_have_the_names_of_the_states_and_are_those_of_python_control():
    linear = linear_loop(typed())
    theirs = np.sort_complex(control.feedback(P * C, 1).poles())
    np.testing.assert_allclose(np.sort_complex([pole.value for pole in linear.poles]), theirs, rtol=1e-9)
    assert {state.partition(".")[0] for pole in linear.poles for state in pole.states} == {"plant", "controller"}


def test_the_rest_of_a_nonlinear_loop_is_found_and_its_loop_gain_is_in_closed_form():
    ball, rest, current = Ball(), [0.01, 0.0], [1.0]
    point = wb.linearize(wb.open_loop(ball), t=0.0, x=rest, u=current, at_rest=True)
    design = wb.lqr(point, Q=np.diag([1e6, 1e2]), R=[[1.0]])
    linear = linear_loop(ClosedLoop(ball, controller=wb.StateFeedback.of(ball, design)))
    np.testing.assert_allclose(linear.x0, rest, rtol=1e-9, atol=1e-12)  # it starts at 12 mm
    a, b = 2 * ball.g / 0.01, -2 * ball.g / 1.0  # of m g = c (i / z)^2
    s = 1j * OMEGA
    K = np.asarray(design.K)[0]
    theirs = (K[0] + K[1] * s) * b / (s**2 - a)
    np.testing.assert_allclose(linear.response(OMEGA).values[:, 0, 0], theirs, rtol=1e-8)  # the rest to 1e-10


def test_states_that_are_named_keep_their_values():
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=1.0)
    loop = ClosedLoop(motor, controller=law, reference=Level())
    assert linear_loop(loop, values={"plant.omega": 0.4}).x0[0] == 0.4
    assert linear_loop(loop, values={"plant.J": 0.02}).p0[0] == 0.02


def rows_of(table):
    with (TABLES / f"{table}.csv").open(encoding="utf-8") as file:
        return {row["law"]: row for row in csv.DictReader(file)}


@pytest.mark.parametrize("law", heavy_but(["AOSMC-RGS", "SMC", "ASMC", "Fuzzy-ASMC", "RBF-ASMC"], "AOSMC-RGS", "SMC"))
def test_the_loops_of_a5_have_the_margins_that_its_page_prints(law):
    linear = linear_loop(still(law, POSES[LEVEL]), freeze=HELD_STATES.get(law, ()))
    theirs = loop_at_rest(law)
    for ours, matrix in ((linear.L.A, theirs.A), (linear.L.B, theirs.B), (linear.L.C, theirs.C)):
        np.testing.assert_allclose(ours, matrix, rtol=1e-12, atol=1e-12 * np.abs(matrix).max())
    printed = rows_of("margins")[law]
    margins = list(linear.margins().values())
    # the page takes its crossovers from eigenvalues in doubles
    assert min(m.phase_margin.value for m in margins) == pytest.approx(float(printed["phase [deg]"]), rel=1e-6)
    assert 1e3 * min(m.delay_margin.value for m in margins) == pytest.approx(float(printed["delay [ms]"]), rel=1e-6)
    assert linear.disk_margin.alpha == pytest.approx(float(printed["disk margin"]), rel=1e-6)


def test_a_delay_is_exact_at_every_frequency():
    delay = 0.05
    linear, L = linear_loop(typed(), delays={"v": delay}), answers(P * C) * np.exp(-1j * OMEGA * delay)
    np.testing.assert_allclose(linear.response(OMEGA).values[:, 0, 0], L, **CLOSE)
    np.testing.assert_allclose(linear.response(OMEGA, "S").values[:, 0, 0], 1 / (1 + L), **CLOSE)
    np.testing.assert_allclose(linear.response(OMEGA, "T").values[:, 0, 0], L / (1 + L), **CLOSE)
    load = linear.response(OMEGA, "closed", "v_load", "omega").values[:, 0, 0]
    np.testing.assert_allclose(load, answers(P) / (1 + L), **CLOSE)
    assert linear.stable
    (found,) = linear.margins().values()
    (plain,) = linear_loop(typed()).margins().values()
    lost = np.degrees(delay * found.gain_crossovers[0].frequency.value)
    assert found.phase_margin.value == pytest.approx(plain.phase_margin.value - lost, rel=1e-12)


def test_a_delay_elsewhere_is_that_of_the_same_loop_with_a_pade_of_high_order():
    delay, low = 0.05, OMEGA[OMEGA < 40]
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=10.0, Ki=20.0)
    late = wb.EquippedPlant(motor, actuators=(wb.PadeDelay("v", time=delay, order=8),))
    exact = linear_loop(ClosedLoop(motor, controller=law, reference=Level()), "omega", delays={"v": delay})
    pade = linear_loop(ClosedLoop(late, controller=law, reference=Level()), "omega")
    for of, source in (("L", "omega"), ("S", "omega"), ("closed", ("omega_ref", "omega_noise"))):
        ours, theirs = (one.response(low, of, source, "omega").values for one in (exact, pade))
        np.testing.assert_allclose(ours, theirs, rtol=1e-6)  # [8/8] is off by less than 1e-8 at 2 rad


def test_one_channel_of_a_vector_is_cut_while_the_other_is_closed():
    own = still(PROPOSED_LAW, POSES[LEVEL])
    both, one = (linear_loop(own, at, freeze=HELD_STATES[PROPOSED_LAW]) for at in ("tau", "tau[1]"))
    L = both.response(OMEGA).values
    across = L[:, 1, 1] - L[:, 1, 0] * L[:, 0, 1] / (1 + L[:, 0, 0])
    np.testing.assert_allclose(one.response(OMEGA).values[:, 0, 0], across, rtol=1e-9)
    assert one.channels == ("tau[1]",)
    assert one.margins()["tau[1]"].delay_margin == both.margins()["tau[1]"].delay_margin


def test_equations_alone_answer_from_their_inputs_to_their_outputs():
    linear = linear_loop(wb.open_loop(wb.DCMotor()))
    theirs = control.frequency_response(wb.linearize(wb.open_loop(wb.DCMotor()), 0.0, [0.0, 0.0]), OMEGA)
    np.testing.assert_allclose(linear.response(OMEGA, "closed").values[:, 0, 0], theirs.complex, rtol=1e-10)
    with pytest.raises(ValueError, match="needs a loop that can be cut"):
        linear.response(OMEGA, "L")


def test_a_value_may_be_an_array_without_axes():
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0)
    loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    plain, same = (wb.linear_loop(loop, values={"plant.J": J}) for J in (0.02, np.array(0.02)))
    np.testing.assert_array_equal([pole.value for pole in same.poles], [pole.value for pole in plain.poles])
