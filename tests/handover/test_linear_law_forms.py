"""A linear law as its matrices: in python-control, and in a file for MATLAB."""

import io

import casadi as ca
import control
import numpy as np
import pytest
from scipy.io import loadmat

import workbench as wb
from studies.paper.laws import rival
from tests.support.law_forms import pid
from workbench.blocks.loop import AbstractController, ClosedLoop, LinearLaw
from workbench.core import LinearSystem, block, layout
from workbench.design.riccati import lqg as lqg_design
from workbench.handover.programs.linear_law import as_control, linear_law, mat_of

MOTOR = wb.DCMotor()
STEP = wb.Step("omega", "rad/s", 1.0)


def lqg():
    masses = control.ss(
        [[0, 0, 1, 0], [0, 0, 0, 1], [-1, 1, -0.1, 0.1], [1, -1, 0.1, -0.1]],
        [[0], [0], [1], [0]], [[0, 1, 0, 0]], [[0]],
        inputs=["F"], outputs=["x2"], states=["x1", "x2", "v1", "v2"], name="masses",
    )  # fmt: skip
    design = lqg_design(control.c2d(masses, 0.1), np.eye(4), [[1.0]], 0.1 * np.eye(4), [[0.01]])
    return ClosedLoop(masses, controller=LinearLaw(design.controller))


LINEAR = {
    "motor PID": lambda: pid().digital(0.01),
    "PID with a delay": lambda: pid().digital(0.01, delay=2),
    "PID of an arm, without a name of its own for each joint": lambda: rival("FS", "PID").digital(1e-3),
    "LQG": lambda: lqg().digital(0.1),
    "PID about a point": lambda: pid(u0=3.0, y0=1.0).digital(0.01, delay=True),
    "a gain without a memory": lambda: ClosedLoop(
        MOTOR, controller=wb.PID(MOTOR.outputs, MOTOR.inputs, Kp=2.0), reference=STEP
    ).digital(0.01),
}


@pytest.mark.parametrize("name", LINEAR)
def test_the_matrices_in_python_control_are_the_law(name):
    law, scope = LINEAR[name]().law(), {}
    exec(as_control(law), scope)
    system = scope["law"]
    assert system.dt == law.period
    assert system.nstates == law.memory.size
    v = np.random.default_rng(4).normal(size=(system.ninputs, 30))
    v[law.readings.size + law.references.size :] = 1.0  # of a law with constant terms
    theirs = control.forced_response(system, inputs=v, initial_state=scope["START"]).outputs
    z, ours = law.memory.default, []
    for y, r in zip(
        v[: law.readings.size].T, v[law.readings.size : law.readings.size + law.references.size].T, strict=True
    ):
        z, u = (np.array(part).ravel() for part in law.F(0, z, y, r, law.parameters.default))
        ours.append(u)
    theirs = np.reshape(theirs, (system.noutputs, -1)).T
    np.testing.assert_allclose(theirs, ours, rtol=1e-12, atol=1e-12 * np.abs(ours).max())


def test_constant_terms_are_an_input_that_is_one():
    law = pid(u0=3.0).digital(0.01).law()
    system = linear_law(law, constants="input")
    assert system.inputs.names == ("omega", "omega_ref", "one")
    np.testing.assert_array_equal(system.D[:, -1], [3.0])
    held = loadmat(io.BytesIO(mat_of(law)))
    assert held["inputs_names"].ravel()[-1].item() == "one"
    np.testing.assert_array_equal(held["D"], system.D)


def test_the_linear_law_has_the_names_and_units_of_its_signals():
    law = pid().digital(0.01).law()
    system = linear_law(law)
    assert isinstance(system, LinearSystem)
    assert (system.inputs.names, system.outputs.names) == (("omega", "omega_ref"), ("v",))
    assert system.inputs["omega_ref"].unit == "rad/s"
    assert system.states.names == law.memory.names
    assert system.dt == 0.01


@pytest.mark.parametrize(
    ("digital", "words"),
    [
        (lambda: pid(low=-24.0, high=24.0).digital(0.01), "'controller.integral.*' .*operation lt"),
        (lambda: pid().digital(0.01, wb.Instruments.of(MOTOR, limit={"v": (-1.0, 1.0)})), "'v.*operation fm(ax|in)"),
        (lambda: pid(u0=1.0).digital(0.01), "'v.*constant term 1"),
        (lambda: rival("FS", "SMC").digital(1e-3), r"'tau\[0\]' takes the"),
    ],
)
def test_a_law_that_is_not_linear_is_refused_by_what_is_not(digital, words):
    with pytest.raises(ValueError, match=words):
        linear_law(digital().law())


def test_a_law_with_its_reference_built_in_is_not_linear():
    law = rival("FS", "PID").digital(1e-3).law(reference="built in")
    with pytest.raises(ValueError, match="takes the number of the instant"):
        linear_law(law)


def test_a_relay_is_not_taken_for_a_zero():
    """Its derivative is zero wherever there is one, and its value at zero is zero."""

    @block
    class Relay(AbstractController):
        """The sign of the error."""

        reads = follows = layout(omega="rad/s")
        drives = layout(v="V")

        def command(self, t, z, est, ref):
            """A voltage."""
            return {"v": ca.sign(ref.omega - est.omega)}

    with pytest.raises(ValueError, match="operation sign"):
        linear_law(ClosedLoop(MOTOR, controller=Relay(), reference=STEP).digital(0.01).law())


def test_a_file_for_matlab_holds_a_linear_law():
    law = pid().digital(0.01, delay=True).law()
    held, system = loadmat(io.BytesIO(mat_of(law))), linear_law(law)
    for letter in "ABCD":
        np.testing.assert_array_equal(held[letter], getattr(system, letter))
    assert held["Ts"].item() == 0.01
    assert [text.item() for text in held["readings_names"].ravel()] == list(law.readings.labels)
    assert held["note"].item() == "A, B, C and D of 'PID', its period Ts, its names and the start of its memory."


def test_a_file_for_matlab_says_that_it_holds_no_matrices():
    law = rival("FS", "ASMC").digital(1e-3).law()
    held = loadmat(io.BytesIO(mat_of(law)))
    assert "A" not in held
    np.testing.assert_array_equal(held["memory"].ravel(), law.memory.default)
    np.testing.assert_array_equal(held["parameters"].ravel(), law.parameters.default)
    assert held["note"].item().startswith("No matrices: `linear_law(law)` must have a linear law; of 'AdaptiveSl")
