"""The pictures of a loop on a live page, and the curves that are drawn in them."""

import json
import re

import numpy as np

import workbench as wb
from workbench.report.live.loop_study import loop_study
from workbench.study import case_runs

IDLE = "livePage.flight && !livePage.flight.fine.size && !livePage.held"
CURVE = """(() => { const {x, y} = livePage.figure(%r).panels[%d].curves.get(%d);
  return [[...x], [...y].map((one) => (Number.isFinite(one) ? one : null))]; })()"""


def loop(**gains):
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, **{"Kp": 100.0, "Ki": 200.0} | gains)
    return wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0, time=0.1))


def data_of(page):
    return json.loads(re.search(r'<script type="application/json" id="live">(.*?)</script>', page.text, re.S)[1])


def blocks_of(closed, until=0.2):
    study = loop_study(closed, until=until, h=1e-2)
    return [block for section in study.sections(case_runs.run(study)) for block in section.blocks]


def turn(page, value, knob=0):
    page.value(f"livePage.bench.knobs[{knob}].turn({value})")
    page.until(IDLE)
    page.until(f"livePage.answers.get(0)?.key === '{knob}:{value}'")
    page.until("!livePage.late.size && !livePage.away.size")


def drawn(page, figure, panel, series):
    x, y = page.value(CURVE % (figure, panel, series))
    return np.array(x), np.array([np.nan if one is None else one for one in y])
