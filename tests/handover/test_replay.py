"""A law on several machines against one recording: equal bits, and every kind of difference told with its place."""

import copy
import re

import click
import numpy as np
import pytest
from click.testing import CliRunner

import workbench as wb
from tests.support.c_runs import differing, recorded
from tests.support.cases import heavy_but
from tests.support.digital_laws import arm_law, kalman_law, motor_law
from tests.support.targets_here import needs_aarch64, needs_cortex_m, needs_gcc
from workbench.cli.replay import replay as verb
from workbench.handover.bit_comparison import compare, fits
from workbench.handover.c99.c_files import c_code
from workbench.handover.recording import BLOCK, digest, record
from workbench.handover.replays import replay
from workbench.handover.targets import TARGETS, CalledTarget
from workbench.handover.targets.compilers import CompiledProgram
from workbench.handover.targets.external_programs import missing_programs
from workbench.handover.targets.target import TargetCost

PERIODS = 10_000


def changed(code, old, new):
    """A code with its source changed in one place."""
    assert code.source.count(old) >= 1
    other = copy.copy(code)
    object.__setattr__(other, "source", code.source.replace(old, new, 1))
    return other


@pytest.fixture
def bits_alone(monkeypatch):
    """No figures of a program, for which it is compiled twice more and run by Valgrind: see test_targets.py."""
    monkeypatch.setattr(CompiledProgram, "figures", lambda *_: TargetCost())


def test_a_recording_is_the_run_of_the_joint_loop():
    sampled = arm_law()
    law = sampled.law()
    y, r, u, z = recorded(sampled, law, 300)
    rows = record(sampled, law, 300, substeps=4, seed=1)
    assert [differing(*pair) for pair in ((rows.y, y), (rows.r, r), (rows.u, u))] == [0, 0, 0]
    np.testing.assert_array_equal(rows.digests, digest(z))


def test_a_memory_is_made_again_from_the_start_of_its_block():
    sampled = motor_law()
    rows = record(sampled, sampled.law(), BLOCK + 50)
    memory = rows.memory(BLOCK - 2, BLOCK + 3)
    np.testing.assert_array_equal(digest(memory[1:]), rows.digests[BLOCK - 2 : BLOCK + 3])
    with pytest.raises(ValueError, match="instants in this order from 0"):
        rows.memory(3, 2)


def test_the_digest_is_that_of_fowler_noll_and_vo():
    text = b"foobar\0\0"
    total = 0xCBF29CE484222325
    for octet in text:
        total = (total ^ octet) * 0x100000001B3 % 2**64
    assert digest(np.frombuffer(text, "<f8")[np.newaxis]).tolist() == [total]
    other = np.array([[0x7FF8000000000001], [0xFFF8000000000000]], dtype=np.uint64).view(float)
    assert digest(other)[0] == digest(other)[1] != digest(np.zeros((1, 1)))[0]  # a NaN is like any other


def test_a_run_that_diverges_is_refused_with_its_period():
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=1e9)
    sampled = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0)).digital(0.1)
    with pytest.raises(ValueError, match=r"'loop' diverges in period \d+, in '.*' first") as refused:
        record(sampled, sampled.law(), 1000)
    most = int(re.search(r"at most (\d+) periods", str(refused.value))[1])
    assert np.isfinite(record(sampled, sampled.law(), most).u).all()


def test_a_law_of_another_loop_is_refused():
    with pytest.raises(ValueError, match="takes a law from .*of this loop"):
        record(motor_law(), arm_law().law(), 10)


@needs_gcc
@pytest.mark.parametrize("make", heavy_but([motor_law, arm_law, kalman_law], motor_law))
def test_ten_thousand_periods_have_the_same_bits_without_and_with_optimisation(make, bits_alone):
    sampled = make()
    law = sampled.law()
    rows, code = record(sampled, law, PERIODS), c_code(law, "law")
    for key in ("gcc-O0", "gcc-O3", "numpy"):
        result = compare(TARGETS[key], code, rows)
        bits = 64 * PERIODS * (law.commands.size + law.memory.size)
        assert (result.equal, result.bits, result.differing_bits, result.first) == (True, bits, 0, "")


@needs_cortex_m
@pytest.mark.heavy
def test_ten_thousand_periods_have_the_same_bits_on_a_microcontroller():
    sampled = kalman_law()
    result = replay(sampled, periods=PERIODS, targets=["cortex-m7"]).results[0]
    assert (result.equal, result.periods, result.differing_bits, result.memories) == (True, PERIODS, 0, 0)
    assert 100 < result.figures.instructions <= result.figures.most
    assert result.figures.stack <= result.figures.touched
    assert result.fit.fits


@pytest.mark.heavy
@needs_gcc
def test_single_precision_has_the_bits_of_numpys_floats(bits_alone):
    here = [key for key in ("gcc-O0", "gcc-O3", "arm64", "cortex-m4f") if not missing_programs(TARGETS[key].programs)]
    done = replay(arm_law(), periods=100, precision="single", targets=[*here, "numpy"])
    assert [result.equal for result in done.results] == [True] * len(here) + [False]
    assert done.results[0].bits == 32 * 100 * (2 + done.recording.law.memory.size)
    assert done.results[-1].reason == "NumPy is the reference of single precision itself"
    assert done.recording.u.dtype == np.float32


@needs_aarch64
def test_equal_bits_on_64_bit_arm():
    assert replay(motor_law(), periods=1000, targets=["arm64"]).equal


@needs_gcc
def test_a_constant_that_is_wrong_in_its_last_bit_is_seen_with_its_period(bits_alone):
    sampled = motor_law()
    rows, code = record(sampled, sampled.law(), 200), c_code(sampled.law(), "law")
    broken = changed(code, "200.0;", f"{float(np.nextafter(200.0, 201.0))!r};")  # Ki
    result = compare(TARGETS["gcc-O0"], broken, rows)
    assert not result.equal
    assert result.differing_bits > 0
    found = re.match(r"period (\d+), '(.*)': .*\(0x([0-9a-f]{16})\) instead of .*\(0x([0-9a-f]{16})\)$", result.first)
    assert found
    assert (int(found[1]), found[2]) == (20, "controller.integral[0]")  # the step of the reference
    assert found[3] != found[4]
    again = compare(TARGETS["gcc-O0"], code, rows)
    assert again.equal


@pytest.mark.heavy
@needs_gcc
def test_a_difference_of_the_memory_alone_is_seen_before_it_acts(bits_alone):
    sampled = motor_law()
    rows, code = record(sampled, sampled.law(), 50), c_code(sampled.law(), "law")
    broken = changed(code, "controller_integral[0] = integral_next", "controller_integral[0] = 0.5 * integral_next")
    result = compare(TARGETS["gcc-O0"], broken, rows)
    assert result.first.startswith("period 20, 'controller.integral[0]': ")  # the step of the reference
    assert result.memories > 0


@needs_gcc
@pytest.mark.heavy
def test_fused_products_are_seen(bits_alone):
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        if " fma " not in file.read():
            pytest.skip("this processor has no fused products")
    sampled = arm_law()
    law = sampled.law()
    rows, code = record(sampled, law, 500), c_code(law, "law")
    fused = CompiledProgram("fused", "gcc", ("-O2", "-std=gnu99", "-mfma", "-ffp-contract=fast"))
    pragma = '#pragma GCC optimize ("fp-contract=off")'
    assert compare(fused, code, rows).equal
    result = compare(fused, changed(code, pragma, ""), rows)
    assert result.differing_bits > 0
    assert result.first.startswith("period ")


@needs_gcc
def test_a_flag_is_a_difference():
    sampled = motor_law()
    rows, code = record(sampled, sampled.law(), 50), c_code(sampled.law(), "law")
    result = compare(TARGETS["gcc-O0"], changed(code, "!= 0x7ff0000000000000u;", "== 0u;"), rows)
    assert (result.equal, result.first) == (False, "period 0 raises the flags 2")
    assert result.flags > 0


def test_a_function_is_a_target_too():
    sampled = motor_law()
    rows, code = record(sampled, sampled.law(), 50), c_code(sampled.law(), "law")
    same = CalledTarget("same", lambda y, r: (rows.u.copy(), None))
    assert compare(same, code, rows).equal
    assert compare(same, code, rows).bits == 64 * 50  # those of the commands alone

    def other(y, r):
        u = rows.u.copy()
        u[7, 0] = np.nextafter(u[7, 0], np.inf)
        return u, rows.digests

    result = compare(CalledTarget("other", other), code, rows)
    assert result.first.startswith("period 7, 'v': ")
    assert 0 < result.differing_bits <= 64


def test_a_program_that_is_not_there_is_named_with_its_package_and_the_others_run(monkeypatch):
    monkeypatch.setenv("PATH", "")
    result = replay(motor_law(), periods=100, targets=["cortex-m4f", "gcc-O0", "numpy"])
    assert [row["reason"] for row in result.rows()] == [
        "install arm-none-eabi-gcc and qemu-system-arm with "
        "`apt-get install gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm`",
        "install gcc with `apt-get install gcc libc6-dev`",
        "",
    ]
    assert result.equal
    assert "not run: install gcc with" in result.text()


def test_the_share_of_a_period_is_the_count_at_one_instruction_a_cycle():
    fit = fits(84_000, 1e-3, 168e6)
    assert (fit.share, fit.fits) == (0.5, True)
    assert str(fit) == "84,000 instructions are 50 % of 0.001 s at 168 MHz, at one instruction per cycle"
    assert not fits(200_000, 1e-3, 168e6).fits
    with pytest.raises(ValueError, match=r"fits\(clock=...\)"):
        fits(1.0, 1.0, 0.0)


def test_an_unknown_target_is_refused():
    with pytest.raises(LookupError, match=r"cortex-m4f"):
        replay(motor_law(), periods=10, targets=["cortex-m4"])


FILE = """
import workbench as wb
motor = wb.DCMotor()
law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0)
loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0))
digital = loop.digital(0.01)
run = wb.Run(digital, (wb.effort("v"),), until=1.0)
study = wb.Study("mine", "T", "Q?", "M.", sections=lambda results: [], cases=(wb.Case("speed", "PID", run),))
"""


@pytest.fixture
def call(tmp_path, monkeypatch):
    """Call the verb on a file with a loop, one in a computer, and a case."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "motor.py").write_text(FILE, encoding="utf-8")

    def of(*words):
        done = CliRunner().invoke(verb, ["motor.py", *words, "--periods", "50", "--target", "numpy"])
        return done.exit_code, done.stdout, click.unstyle(done.stderr)

    return of


@pytest.mark.parametrize("words", [["--period", "0.01"], ["--loop", "digital"], ["--case", "speed: PID"]])
def test_the_verb_takes_a_loop_with_a_period_one_in_a_computer_or_a_case(call, words):
    status, out, _ = call(*words)
    assert status == 0
    assert "PID, every 0.01 s: 50 periods" in out
    assert re.search(r"^NumPy +50 ", out, re.MULTILINE)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ([], "'loop' is in continuous time: say how often the computer runs it, as `--period 0.001`."),
        (["--loop", "digital", "--period", "0.1"], "'digital' runs in a computer already, every 0.01 s"),
        (["--loop", "lop"], "Did you mean 'loop'?"),
        (["--case", "speed: PI"], "Did you mean 'speed: PID'?"),
        (["--case", "speed: PID", "--loop", "loop"], "name two loops"),
        (["--period", "0.01", "--truth", "d"], "'d'"),
    ],
)
def test_the_verb_refuses_in_one_sentence(call, words, sentence):
    status, out, error = call(*words)
    assert (status, out, len(error.splitlines())) == (2, "", 1)
    assert sentence in error
