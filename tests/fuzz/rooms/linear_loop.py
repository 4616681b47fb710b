from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

import workbench as wb
from workbench.design import linear_loop

MOTOR = wb.DCMotor()
LAW = wb.PID(MOTOR.outputs, MOTOR.inputs, Kp=100.0, Ki=200.0)
LOOP = wb.ClosedLoop(MOTOR, controller=LAW, reference=wb.Step("omega", "rad/s", 1.0))
OMEGA = np.array([1.0, 10.0])


def calls() -> dict[str, Any]:
    linear = linear_loop.linear_loop(LOOP)
    rows = linear.rows({"plant.J": [0.01, 0.02]})
    return {
        "LinearLoop.gang_of_six": partial(linear.gang_of_six, OMEGA),
        "LinearLoop.rows": partial(linear.rows, {"plant.J": [0.01, 0.02]}),
        "LinearLoop.bandwidth": partial(linear.bandwidth, "T"),
        "LinearLoop.step_info": partial(linear.step_info, "omega_ref", "omega", "closed"),
        "LinearLoop.hinf_norm": partial(linear.hinf_norm, "closed", "v_load", "omega"),
        "LinearLoop.h2_norm": partial(linear.h2_norm, "closed", "v_load", "omega"),
        "LinearRows.response": partial(rows.response, OMEGA, "S", None, None),
    }


def arguments() -> dict[str, Any]:
    return {"name": lambda thing: "omega"}
