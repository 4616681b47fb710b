"""The page for those who come from MATLAB or python-control: every name that it says is here, or there, is."""

import inspect
import re
from importlib import import_module
from pathlib import Path

import control
import numpy as np
import pytest

import workbench as wb
from workbench.design.linear_loop import LinearLoop, LinearRows
from workbench.engine import Trajectories
from workbench.report.linear_loop_plots import KINDS
from workbench.report.linear_row_plots import KINDS as OF_ROWS

PAGE = (Path(__file__).parents[2] / "docs" / "howto" / "toolboxes.md").read_text(encoding="utf-8")
ROWS = [
    [cell.strip() for cell in line.strip("|").split(" | ")]
    for line in PAGE.splitlines()
    if line.startswith("|") and "---" not in line and not line.startswith("| |")
]
CODE = re.compile(r"`([^`]+)`")
OURS = {"linear": LinearLoop, "log": wb.Dataset, "rows": LinearRows, "runs": Trajectories, "wb": wb}


def test_the_tables_of_the_page_have_four_columns():
    assert len(ROWS) > 85
    assert {len(row) for row in ROWS} == {4}


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row[0])
def test_each_name_of_python_control_is_there_and_takes_the_option(row):
    for code in CODE.findall(row[2]):
        if code.startswith("control."):
            function = getattr(control, code.removeprefix("control."))
        else:  # an option of the function before it
            option = code.partition("=")[0]
            assert option in inspect.signature(function).parameters or option in inspect.getsource(function)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row[0])
def test_what_python_control_has_not_has_no_function_of_matlabs_name_there(row):
    if row[2] == "no":
        for code in CODE.findall(row[1]):
            assert not hasattr(control, code), code


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row[0])
def test_each_name_of_ours_is_there(row):
    for code in CODE.findall(row[3]):
        head = re.match(r"[\w.]+", code)[0]
        first, _, rest = head.partition(".")
        if first in OURS:
            room, _, name = rest.rpartition(".")  # of a family of names, as wb.synthesis.lqi
            holder = getattr(OURS[first], room) if room else OURS[first]
            assert hasattr(holder, name) or name in getattr(holder, "__dataclass_fields__", ()), code
        elif first == "workbench":
            room, _, name = head.rpartition(".")
            assert hasattr(import_module(room), name), code
        else:
            assert code == "tunings"
            assert code in inspect.signature(wb.Study).parameters
        kinds = {"linear.plot": KINDS, "rows.plot": OF_ROWS}.get(head)
        if kinds and (kind := re.search(r'plot\("(\w+)"', code)):
            assert kind[1] in kinds


OURS_TO_RUN = [(row[0], code) for row in ROWS for code in CODE.findall(row[3]) if "(" in code]
OTHER_PORTS = {
    "plant.m": "plant.J",
    "i_load": "v_load",
    '"z"': '"omega"',
    '{"i": ': '{"v": ',
}  # of the motor that is here


def motor_log(motor):
    """Voltages in random steps and the speeds of the motor, with noise."""
    rng, plant = np.random.default_rng(1), wb.c2d(wb.linearize(wb.open_loop(motor), 0.0, [0.0, 0.0]), 0.02)
    v, x = np.repeat(rng.choice([-6.0, 6.0], 25), 20), np.zeros((500, 2))
    for k in range(499):
        x[k + 1] = plant.A @ x[k] + plant.B @ v[k : k + 1]
    omega = x[:, 0] + rng.normal(0.0, 0.01, 500)
    return wb.Dataset.of(0.02 * np.arange(500), {"v": v, "omega": omega}, {"v": "V", "omega": "rad/s"})


@pytest.fixture(scope="module")
def names():
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0)
    loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    linear, values = wb.linear_loop(loop), np.linspace(0.01, 0.02, 4)
    held = {"rows": linear.rows({"plant.J": values}), "runs": wb.simulate(loop, until=0.1), "matrix": np.eye(2)}
    omega = np.geomspace(1.0, 10.0, 4)
    held |= {"log": motor_log(motor), "motor": wb.open_loop(motor)}
    return held | {"wb": wb, "control": control, "linear": linear, "loop": loop, "values": values, "masses": values,
                   "omega": omega, "G": control.tf([1.0], [1.0, 1.0, 1.0])}  # fmt: skip


@pytest.mark.parametrize(("row", "code"), OURS_TO_RUN, ids=lambda text: text)
def test_each_line_of_python_on_the_page_runs(row, code, names):
    for there, here in OTHER_PORTS.items():
        code = code.replace(there, here)
    own = {"G": control.tf([[[1.0], [2.0]]], [[[1.0, 1.0], [1.0, 2.0]]])} if "G[0, 1]" in code else {}
    assert eval(code, names | own) is not None, row  # the page is ours


def test_each_kind_of_picture_is_on_the_page():
    for kind in KINDS:
        assert f'linear.plot("{kind}"' in PAGE, kind


def test_the_rows_that_say_no_are_not_there():
    for name in ("d2d", "iopzmap", "bodemag", "balred", "minreal", "hinfsyn", "mussv"):
        assert not hasattr(wb, name)
