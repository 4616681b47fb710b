"""A law in C: the bits of the simulation, without a warning, and with an answer to what is not finite."""

import subprocess

import numpy as np
import pytest

import workbench as wb
from tests.support.c_runs import (
    COMPILERS,
    EACH_COMPILER,
    WARNINGS,
    compiled,
    differing,
    needs_compiler,
    recorded,
    warned,
)
from tests.support.digital_laws import digital, kalman_law, motor_law
from workbench.core.templates import template_text
from workbench.handover.c99.c_files import c_code


@needs_compiler
def test_c_and_simulation_have_the_same_bits(tmp_path):
    """Of one law; those of the whole gallery are in test_gallery_forms.py."""
    sampled, law = digital("PID, DC motor")
    y, r, u, z = recorded(sampled, law, 500)
    for number, option in enumerate(("-O0", "-O3")):
        (folder := tmp_path / str(number)).mkdir()
        found = compiled(c_code(law, "law"), folder, options=(option,))(y, r)
        assert (differing(found[0], u), differing(found[1], z), found[2].max()) == (0, 0, 0)


@needs_compiler
@pytest.mark.parametrize("reference", ["input", "built in"])
def test_settable_parameters_and_a_reference_built_in_have_the_same_bits(reference, tmp_path):
    sampled, _ = digital("SMC")
    law = sampled.law(reference)
    y, r, u, z = recorded(sampled, law, 500)
    code = c_code(law, "law", parameters="settable")
    assert "double controller_Lambda[2]; /* controller.Lambda [1/s]" in code.header
    found = compiled(code, tmp_path)(y, r)
    assert (differing(found[0], u), differing(found[1], z)) == (0, 0)


@needs_compiler
@pytest.mark.parametrize("compiler", EACH_COMPILER)
def test_no_compiler_warns(compiler, tmp_path):
    _, law = digital("AOSMC-RGS")
    built_in, kalman = digital("SMC")[0].law("built in"), kalman_law().law()
    laws = {"input": (law, "settable"), "built_in": (built_in, "settable"), "kalman": (kalman, "constant")}
    for name, (each, parameters) in laws.items():
        c_code(each, name, parameters=parameters).write(tmp_path)
    warned(compiler, tmp_path, *(f"{name}.c" for name in laws))


@needs_compiler
def test_fused_products_do_not_enter_by_a_flag(tmp_path):
    sampled, law = digital("AOSMC-RGS")
    y, r, u, _ = recorded(sampled, law, 300)
    options = ("-O3", "-march=native", "-ffp-contract=fast")
    assert differing(compiled(c_code(law, "law"), tmp_path, options=options)(y, r)[0], u) == 0


@needs_compiler
def test_fast_math_is_refused_by_the_compiler(tmp_path):
    c_code(motor_law().law(), "law").write(tmp_path)
    done = subprocess.run([COMPILERS[0], "-ffast-math", "-c", "law.c"], cwd=tmp_path, capture_output=True, timeout=60)
    assert b"compile it without -ffast-math and its parts" in done.stderr
    assert done.returncode


@needs_compiler
def test_what_is_not_finite_gives_the_safe_command_and_leaves_the_memory(tmp_path):
    sampled = motor_law()
    law = sampled.law()
    y, r, u, _ = recorded(sampled, law, 40)
    bad, wanted = y.copy(), r.copy()
    bad[10], bad[11], wanted[20] = np.nan, np.inf, np.nan
    found, memory, flags = compiled(c_code(law, "law", safe={"v": 1.5}), tmp_path)(bad, wanted)
    assert flags.nonzero()[0].tolist() == [10, 11, 20]
    assert flags[[10, 11, 20]].tolist() == [1, 1, 2]
    np.testing.assert_array_equal(found[[10, 11, 20], 0], 1.5)
    np.testing.assert_array_equal(memory[10:12], memory[[9, 9]])
    assert differing(found[:10], u[:10]) == 0
    assert np.isfinite(memory).all()


@needs_compiler
def test_a_result_that_is_not_finite_is_flagged_and_not_kept(tmp_path):
    law = motor_law(Kp=1e300, low=None, high=None).law()
    y, r = np.full((3, 1), -1e300), np.zeros((3, 1))
    y[1] = 0.0
    u, z, flags = compiled(c_code(law, "law"), tmp_path)(y, r)
    assert flags.tolist() == [4, 0, 4]
    assert np.isfinite(u).all()
    assert np.isfinite(z).all()


def test_a_header_says_what_its_caller_must_know():
    sampled = kalman_law()
    code = c_code(
        sampled.law(), "cart_pole", safe={"F": 0.0}, warnings=("the period is long",), command="workbench export"
    )
    for line in (
        "It reads x [m], phi [rad].",
        "It follows x [m].",
        "Limits of F: -10 to 10 N.",
        "Delay: a command is given so long after it is computed: F 1 period.",
        "Safe command, where a flag is raised: F = 0 N.",
        "Note: the period is long.",
        "with: workbench export.",
        sampled.law().fingerprint[:16],
        "#define CART_POLE_PERIOD 0.01",
    ):
        assert line in code.header


@pytest.mark.parametrize("name", ["", "1law", "a b", "int", "x" * 41, "law;", "*/ int"])
def test_a_name_that_is_no_identifier_is_refused(name):
    with pytest.raises(ValueError, match=r"must be an identifier of C"):
        c_code(motor_law().law(), name)


def test_names_that_become_one_are_refused():
    @wb.block
    class Twins(wb.Plant):
        """Two outputs whose names differ in a point alone."""

        a: float = wb.initial(default=0.0, unit="m")
        inputs, outputs = wb.layout(u="N"), wb.layout(**{"q.a": "m", "q_a": "m"})

        def rate(self, t, x, u):
            return {"a": u.u}

        def measure(self, t, x):
            return {"q.a": x.a, "q_a": x.a}

    plant = Twins()
    law = wb.StateFeedback(plant.outputs, plant.inputs, K=[[1.0, 1.0]], x0=[0.0, 0.0], u0=[0.0])
    loop = wb.ClosedLoop(plant, controller=law)
    with pytest.raises(ValueError, match=r"'q\.a' and 'q_a' both become 'q_a'"):
        c_code(loop.digital(0.1).law())


def test_a_text_from_outside_ends_no_comment():
    code = c_code(motor_law().law(), "law", warnings=("*/ int evil; /*",))
    assert "*/ int evil" not in code.header
    assert "*/ int evil" not in code.source


def test_a_safe_command_beyond_its_limit_is_refused():
    with pytest.raises(ValueError, match=r"within the limits of the command"):
        c_code(kalman_law().law(), "law", safe={"F": 11.0})
    with pytest.raises(LookupError, match=r"'G'"):
        c_code(kalman_law().law(), "law", safe={"G": 0.0})


def test_a_file_of_somebody_else_is_left_as_it_is(tmp_path):
    (tmp_path / "law.h").write_text("mine")
    with pytest.raises(ValueError, match=r"was not written by an export"):
        c_code(motor_law().law(), "law").write(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["law.h"]
    (tmp_path / "law.h").unlink()
    c_code(motor_law().law(), "law").write(tmp_path)
    c_code(motor_law(Kp=1.0).law(), "law").write(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["law.c", "law.h"]


@needs_compiler
def test_a_limit_hides_no_command_that_is_none(tmp_path):
    motor = wb.DCMotor()

    @wb.block
    class Twice(wb.Controller):
        """v = k (r - y) - k (r - y), of which each half may be infinite."""

        k: float = wb.parameter(unit="V s/rad")
        reads = follows = wb.layout(omega="rad/s")
        drives = wb.layout(v="V")

        def command(self, t, z, est, ref):
            return {"v": self.k * (ref.omega - est.omega) - (self.k * ref.omega - self.k * est.omega)}

    loop = wb.ClosedLoop(motor, controller=Twice(1e300), reference=wb.Step("omega", "rad/s", 1.0))
    law = loop.digital(0.01, wb.Instruments.of(motor, limit={"v": (-5.0, 80.0)})).law()
    u, _, flags = compiled(c_code(law, "law", safe={"v": 20.0}), tmp_path)([[1e308], [0.0]], [[-1e308], [0.0]])
    assert flags.tolist() == [4, 0]
    assert u.ravel().tolist() == [20.0, 0.0]


@needs_compiler
def test_no_command_comes_late_after_readings_that_were_none(tmp_path):
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=10.0)
    loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    law = loop.digital(0.01, delay=2).law()
    y = np.array([[0.0], [0.0], [0.0], [np.nan], [0.0], [0.0], [0.0]])
    u, _, flags = compiled(c_code(law, "law", safe={"v": 1.5}), tmp_path)(y, np.ones((7, 1)))
    assert flags.tolist() == [0, 0, 0, 1, 0, 0, 0]
    assert u.ravel().tolist() == [0.0, 0.0, 10.0, 1.5, 1.5, 1.5, 10.0]


def test_a_number_that_single_precision_lacks_is_refused_or_said():
    for number, found in ((1e300, "refused"), (1e-300, "said")):
        law = motor_law(Kp=number, low=None, high=None).law()
        if found == "refused":
            with pytest.raises(ValueError, match=r"1e\+300, which is inf in 32 bits"):
                c_code(law, "law", precision="single")
        else:
            assert "no guard of a division any more: 1e-300" in c_code(law, "law", precision="single").header


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_safe_command_is_finite(value):
    with pytest.raises(ValueError, match=r"must be a finite number"):
        c_code(motor_law().law(), "law", safe={"v": value})


@needs_compiler
@pytest.mark.parametrize("compiler", EACH_COMPILER)
def test_the_guards_of_a_source_are_c_as_they_stand(compiler, tmp_path):
    (tmp_path / "own.c").write_text('#include "guards.h"\nint own(void);\nint own(void) { return 0; }\n')
    (tmp_path / "guards.h").write_text(template_text("workbench.handover", "c99/guards.h"), encoding="utf-8")
    line = [compiler, *WARNINGS, "-c", "own.c"]
    subprocess.run(line, cwd=tmp_path, check=True, timeout=60)
    assert subprocess.run([*line, "-ffast-math"], cwd=tmp_path, capture_output=True, timeout=60).returncode
