"""A small study of a motor whose page is live."""

import numpy as np

import workbench as wb
from workbench.report.live.live_data import live_data
from workbench.report.pictures.traces import Window, curve
from workbench.study import case_runs, writeup
from workbench.study.document.document import Figure, Panel, ReportTable, Section, Series, TableColumn
from workbench.study.knob import Knob
from workbench.study.result_marks import cell
from workbench.study.study import Case, Study

MOTOR = wb.DCMotor()
KP = Knob("Kp", "controller.Kp", 10.0, 1000.0, log=True)


def loop(Kp=100.0):
    law = wb.PID(MOTOR.outputs, MOTOR.inputs, Kp=Kp, Ki=200.0, low=-24.0, high=24.0)
    return wb.ClosedLoop(MOTOR, controller=law, reference=wb.Step("omega", "rad/s", 1.0, time=0.1))


def case(law="PI", Kp=100.0, metrics=(wb.rmse(), wb.effort(), wb.overshoot())):
    return Case("speed", law, wb.Run(loop(Kp), metrics, until=1.0, every=0.01, h=1e-3))


def page(results):
    outcome = results.outcomes[0]
    omega = outcome.signal("omega", 0)
    lines = (
        curve(outcome, "omega", label="omega"),
        curve(outcome, "omega", window=Window(0.5, 1.0), label="late"),
        curve(outcome, "omega", label="in rev/min", unit=(30 / np.pi, "1/min")),
        curve(outcome, "v_applied", label="v over i", over=("plant.i", 0)),
        Series("by hand", outcome.t, omega),
    )
    rows = [(o.label, cell(o, "RMSE"), cell(o, "effort"), 0.123) for o in results.outcomes]
    table = ReportTable("scores", "Scores.", tuple(map(TableColumn, ("law", "RMSE", "effort", "other"))), tuple(rows))
    return [Section("All", (Figure("speed", "Speed.", (Panel("omega", lines),)), table))]


def data_of(*cases, live=(KP,), sections=page, **more):
    study = Study("small", "T", "Q?", "M.", sections, cases=cases or (case(),), live=live, **more)
    results = case_runs.run(study)
    return live_data(study, results, writeup.document(study, results, "command"), "small.py")
