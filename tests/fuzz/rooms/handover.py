from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

import workbench as wb
from workbench.handover.bit_comparison import fits
from workbench.handover.c99.c_files import c_code
from workbench.handover.programs.casadi_law import casadi_law
from workbench.handover.programs.linear_law import as_control, linear_law, mat_of
from workbench.handover.programs.python_law import python_law
from workbench.handover.single.rounding_bounds import rounding_bound
from workbench.handover.single.rounding_statement import stated_bound
from workbench.handover.single.single_precision import single_precision
from workbench.handover.wrappers.ros2 import ros2
from workbench.handover.wrappers.simulink import simulink


def sampled() -> Any:
    """A small loop in a computer."""
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=10.0, Ki=20.0)
    return wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0)).digital(0.01)


def calls() -> dict[str, Any]:
    loop = sampled()
    law, rows = loop.law(), (np.zeros((2, 2)), np.zeros((2, 1)), np.ones((2, 1)))
    code, size = c_code(law, "law"), law.memory.size + 2
    return {
        "python_law": partial(python_law, law, "law", safe={"v": 0.0}),
        "casadi_law": partial(casadi_law, law, "law"),
        "linear_law": partial(linear_law, law, constants="refused"),
        "as_control": partial(as_control, law),
        "mat_of": partial(mat_of, law),
        "simulink": partial(simulink, code),
        "ros2": partial(ros2, code, "law_controller", {"omega": "wheel/velocity"}),
        "fits": partial(fits, 1000.0, 1e-3, 1e8),
        "single_precision": partial(single_precision, law, np.arange(2.0), *rows),
        "rounding_bound": partial(rounding_bound, law, np.arange(2.0), *rows),
        "stated_bound": partial(stated_bound, law, -np.ones(size), np.ones(size), 10, 0),
    }


def arguments() -> dict[str, Any]:
    return {}
