"""Odd values of a user's own, each refused in one sentence that names the call, or harmless."""

import os
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from tests.support.swept_studies import SWEPT
from workbench.core.validation.refusals import as_number, as_path, as_whole
from workbench.core.validation.signatures import check_arguments
from workbench.engine import simulate
from workbench.handover.replays import replay

MOTOR = wb.DCMotor()
ODE = wb.open_loop(MOTOR)
HUGE = 10**400


def digital():
    law = wb.PID(MOTOR.outputs, MOTOR.inputs, Kp=100.0, Ki=200.0)
    loop = wb.ClosedLoop(MOTOR, controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    return loop.digital(0.01)


NO_PATHS = ["x" * 5000, "a/" * 3000, "study\0.py", "\ud800.py", Path("a\0b")]


@pytest.mark.parametrize("path", [5, None, 1.5, [], b"study.py", *NO_PATHS], ids=lambda path: ascii(path)[:12])
def test_what_is_no_path_is_no_study(path):
    with pytest.raises(
        ValueError, match=r"^`load\(file=\.\.\.\)` must be (a `Path` or text|a path that a file can have)"
    ):
        wb.load(path)


@pytest.mark.parametrize("path", NO_PATHS, ids=lambda path: ascii(path)[:12])
def test_a_page_is_written_to_no_such_path(path):
    page = wb.live(ODE, until=0.1)
    with pytest.raises(ValueError, match=r"^`LoopPage.write\(path=\.\.\.\)` must be a path that a file can have"):
        page.write(path)


def test_a_path_of_the_longest_names_that_a_disk_has_is_one(tmp_path):
    place = tmp_path / ("x" * 255)
    place.write_text("")
    assert as_path(place) == place
    assert as_path(str(tmp_path / ("x" * 256))) is None
    assert as_path("é" * 128) is None  # 256 bytes


def test_a_span_of_time_of_numpy_is_no_number():
    span = np.timedelta64(1, "s")
    assert as_whole(span) is None
    assert as_number(span) is None
    for given in (span, np.array(span)):
        with pytest.raises(ValueError, match=r"`equilibria\(starts=\.\.\.\)` must be a whole number; got"):
            wb.equilibria(ODE, {"omega": (-1.0, 1.0), "i": (-5.0, 5.0)}, starts=given)


@pytest.mark.parametrize(
    "poles",
    [
        [HUGE, -1],
        [-1, -HUGE],
        [ca.MX.sym("a"), -1],
        np.array([ca.MX(-1), -2], dtype=object),
        ca.MX.sym("a", 2),
        ca.SX.sym("a", 2),
        [ca.SX.sym("a"), -1],
        [np.timedelta64(1, "s"), -1],
        ["-1", "-2"],
        [True, False],
        object(),
    ],
    ids=lambda poles: ascii(poles)[:20],
)
def test_poles_are_numbers(poles):
    motor = wb.linearize(ODE, 0.0, np.zeros(2))
    with pytest.raises(ValueError, match=r"^`place\(poles=\.\.\.\)` must be (a vector of numbers|2 finite numbers)"):
        wb.place(motor, poles)


@pytest.mark.parametrize("seed", [-HUGE, HUGE, -1, 2**64])
def test_the_seed_of_a_search_for_rest_points_is_a_key(seed):
    with pytest.raises(ValueError, match=r"^`equilibria\(seed=\.\.\.\)` must be a whole number from 0 to 2\^64 - 1"):
        wb.equilibria(ODE, {"omega": (-1.0, 1.0), "i": (-5.0, 5.0)}, seed=seed)


@pytest.mark.parametrize("unit", ["{x}", "m/{s}", "{0}"])
def test_a_unit_with_the_name_of_no_attribute_is_refused_by_that_name(unit):
    @wb.block
    class Tank(wb.Plant):
        A: float = wb.parameter(unit=unit, default=2.0)
        h: float = wb.initial(default=1.0, unit="m")
        inputs, outputs = wb.layout(w="m^3/s"), wb.layout(h="m")

        def rate(self, t, x, u):
            return {"h": u.w / self.A}

    with pytest.raises(LookupError, match=r"of a `Tank` must have names of its attributes in braces.*; it has no '\w'"):
        wb.open_loop(Tank())


@pytest.mark.parametrize("progress", [object, dict, int, lambda: None, lambda a, b: None])
def test_who_is_told_of_progress_takes_one_argument(progress):
    for call in (
        lambda: replay(digital(), periods=2, targets=[], progress=progress),
        lambda: simulate(wb.rk4(ODE, 0.01), until=0.1, progress=progress),
        lambda: wb.measure(ODE, [wb.rmse("omega")], until=0.1, h=0.01, progress=progress),
    ):
        with pytest.raises(ValueError, match=r"\(progress=\.\.\.\)` must be a function or None; got "):
            call()


def test_a_function_in_c_and_one_of_any_arguments_are_told():
    seen = []
    for progress in (seen.append, lambda *told: seen.append(told), print):
        simulate(wb.rk4(ODE, 0.01), until=0.1, progress=progress)
    assert len(seen) > 1


def test_default_numbers_are_only_read_and_a_copy_is_free():
    for layout in (ODE.parameters, ODE.states, wb.layout()):
        assert not layout.default.flags.writeable
        copy = layout.default.copy()
        copy[:] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        ODE.parameters.default[0] = 5.0


@pytest.mark.parametrize("quantum", [1e-312, 5e-324, 1e-101])
def test_a_quantum_that_no_reading_can_be_counted_in_is_refused_at_the_sensor(quantum):
    with pytest.raises(
        ValueError, match=r"^`Sensor\(quantum=\.\.\.\)` of 'omega' must be 0, for none, or at least 1e-100"
    ):
        wb.Instruments.of(MOTOR, quantum={"omega": quantum})


def test_findings_reach_a_terminal_without_what_it_would_act_on(command, tmp_path):
    finding = r"\x1b]0;owned\x07 and \x1b[31mred\x1b[0m \u202eback"
    study = SWEPT.replace("headlines=lambda results: [", f'headlines=lambda results: ["{finding}", ')
    (tmp_path / "swept.py").write_text(study, encoding="utf-8")
    said = command("run", "swept.py", "--out", "out")
    assert said.exit_code == 0, said.output
    lines = said.stdout.splitlines()
    assert r"\x1b]0;owned\x07 and \x1b[31mred\x1b[0m \u202eback" in lines
    assert all(line.isprintable() for line in lines)


def test_an_item_in_itself_is_refused_in_a_short_sentence():
    inside = []
    inside.append(inside)
    for given in (inside, {"a": inside}, (inside, inside), np.array([inside, None], dtype=object)):
        with pytest.raises(ValueError, match=r"`live\(until=\.\.\.\)` must be a number; got ") as error:
            wb.live(ODE, until=given)
        assert len(str(error.value)) < 200


@pytest.mark.skipif(os.name != "posix", reason="bytes that are no text are names on POSIX alone")
def test_a_path_with_bytes_that_are_no_text_is_one():
    assert as_path("\udcff.py") == "\udcff.py"  # as Python reads the name b"\xff.py"

    @check_arguments
    def read(path: Path | str) -> Path:
        return Path(path)

    assert read(Path("\udcff.py")) == Path("\udcff.py")
