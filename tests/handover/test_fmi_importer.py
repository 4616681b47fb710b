"""FMUs in FMPy: it finds nothing to blame, and runs them with the bits of the simulation, in a process without us."""

import importlib.util
import json
import subprocess
import sys

import numpy as np
import pytest

import workbench as wb
from docs import fmus
from docs.fmus import examples, of_computer, of_law, of_plant, outputs_of, write
from docs.loops import gallery_loop
from tests.support.c_runs import needs_compiler
from tests.support.cases import heavy_but
from tests.support.digital_laws import motor_law
from tests.support.springs import spring
from workbench.handover.fmi import fmu

needs_fmpy = pytest.mark.skipif(importlib.util.find_spec("fmpy") is None, reason="this environment has no FMPy")
VERSIONS = "2.0", "3.0"
STEPS = 100  # of an example here

# In another process: each folder of an example, as an importer runs it.
CROSS_CHECK = """
import csv, json, pathlib, sys
import fmpy, fmpy.validation
told = {}
for own in map(pathlib.Path, sys.argv[2:]):
    name = own.name
    findings = fmpy.validation.validate_fmu(str(own / f"{name}.fmu"))
    if not (own / f"{name}_ref.csv").exists():
        told[str(own)] = {"findings": findings}
        continue
    lines = (own / f"{name}_ref.opt").read_text().splitlines()
    options = {key: float(value) for key, value in (line.split(", ") for line in lines)}
    inputs = own / f"{name}_in.csv"
    result = fmpy.simulate_fmu(
        str(own / f"{name}.fmu"), start_time=options["StartTime"], stop_time=options["StopTime"],
        output_interval=options["StepSize"], input=fmpy.read_csv(str(inputs)) if inputs.exists() else None)
    with open(own / f"{name}_ref.csv", newline="") as file:
        head, *rows = csv.reader(file)
    equal = [[float(x).hex() for x in row[1:]] for row in rows] == [
        [float(result[column][i]).hex() for column in head[1:]] for i in range(len(result))]
    told[str(own)] = {"equal": equal, "findings": findings, "rows": len(rows)}
assert not any(module.split(".")[0] in ("workbench", "casadi") for module in sys.modules)
pathlib.Path(sys.argv[1]).write_text(json.dumps(told))
"""

# In another process: the calls that no simulation makes, by value references.
CALLS = """
import json, pathlib, sys
import fmpy
from fmpy.fmi2 import FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE, fmi2CallbackAllocateMemoryTYPE
from fmpy.fmi2 import fmi2CallbackFreeMemoryTYPE, fmi2StepFinishedTYPE
from fmpy.fmi3 import FMU3Slave
target, file, step = sys.argv[1], sys.argv[2], float(sys.argv[3])
description = fmpy.read_model_description(file)
variables = {v.name: v.valueReference for v in description.modelVariables}
folder, said, two = fmpy.extract(file), [], description.fmiVersion == "2.0"
callbacks = fmi2CallbackFunctions()
callbacks.logger = fmi2CallbackLoggerTYPE(lambda environment, name, status, category, text: said.append(text.decode()))

def instance(name, token=description.guid, start=0.0):
    kind = FMU2Slave if two else FMU3Slave
    unit = kind(guid=token, unzipDirectory=folder, instanceName=name,
                modelIdentifier=description.coSimulation.modelIdentifier)
    if two:
        unit.instantiate(callbacks=callbacks)
        unit.setupExperiment(startTime=start)
        unit.enterInitializationMode()
    else:
        unit.instantiate(logMessage=lambda environment, status, category, text: said.append(text.decode()))
        unit.enterInitializationMode(startTime=start)
    return unit

def put(unit, name, value):
    (unit.setReal if two else unit.setFloat64)([variables[name]], [value])

def take(unit, name):
    return (unit.getReal if two else unit.getFloat64)([variables[name]])[0]

def steps(unit, first, count, of=1):
    for i in range(first, first + count, of):
        unit.doStep(currentCommunicationPoint=i * step, communicationStepSize=of * step)
    return take(unit, "omega")

def refused(call, *arguments, **named):
    said.clear()
    try:
        call(*arguments, **named)
    except Exception:
        return (said or ["nothing was said"])[0]
    return "it was done"

a, b = instance("a"), instance("b")
a.exitInitializationMode(), b.exitInitializationMode()
told = {"before": take(a, "omega")}
put(a, "v", 1.0), put(b, "v", 2.0)
told["one by one"] = steps(a, 0, 100)
told["at once"] = steps(b, 0, 100, 100)
name = "FMUstate" if two else "FMUState"
state = getattr(a, "get" + name)()
saved = getattr(a, "serialize" + name)(state)
told["ahead"] = steps(a, 100, 50)
getattr(a, "set" + name)(state)
told["again"] = steps(a, 100, 50)
other = getattr(b, "deSerialize" + name if two else "deserialize" + name)(saved)
getattr(b, "set" + name)(other)
told["in another"] = steps(b, 100, 50)
getattr(a, "free" + name)(state), getattr(b, "free" + name)(other)
told["half a step"] = refused(a.doStep, currentCommunicationPoint=150 * step, communicationStepSize=1.5 * step)
told["elsewhere"] = refused(a.doStep, currentCommunicationPoint=7 * step, communicationStepSize=step)
told["no number"] = refused(put, a, "v", float("nan"))
told["an output"] = refused(put, a, "omega", 1.0)
told["a start"] = refused(put, a, "start.omega", 1.0)
told["no variable"] = refused(a.getReal if two else a.getFloat64, [99])
told["beyond numbers"] = [put(a, "J", 1e-300), refused(steps, a, 150, 1), put(a, "J", 0.01)][1]
told["after refusals"] = steps(a, 150, 1)
told["undisturbed"] = steps(b, 150, 1)
a.reset()
if two:
    a.setupExperiment(startTime=0.0), a.enterInitializationMode()
else:
    a.enterInitializationMode(startTime=0.0)
put(a, "start.omega", 0.5), a.exitInitializationMode()
told["another start"] = take(a, "omega")
told["between steps"] = refused(instance, "d", start=0.5 * step)
told["another token"] = refused(instance, "c", "{none}")
pathlib.Path(target).write_text(json.dumps(told))
"""


def in_another_process(script, folder, *arguments):
    """What a script tells, which has no way to the workbench of this process."""
    told = folder / "told.json"
    command = [sys.executable, "-c", script, str(told), *map(str, arguments)]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return json.loads(told.read_text(encoding="utf-8"))


def cross_checked(folders, folder):
    """What FMPy says of examples that were written, or of units of sources alone."""
    return list(in_another_process(CROSS_CHECK, folder, *folders).values())


def equations_of(unit):
    """The files of C but those of a version of the standard, without the token, which names all files."""
    texts = {path: text.decode() for path, text in unit.files.items() if path.startswith("sources/")}
    shared = {path: text for path, text in texts.items() if path.endswith((".c", ".h")) and "/fmi" not in path}
    return {path: text.replace(unit.token, "") for path, text in shared.items()}


@needs_fmpy
@needs_compiler
def test_an_importer_computes_the_bits_of_the_simulation(tmp_path, monkeypatch):
    monkeypatch.setattr(fmus, "STEPS", STEPS)
    cases = (
        of_law("with a reference that it knows", gallery_loop("PID, DC motor"), "built in"),
        of_plant("quadruple tank", gallery_loop("PID, quadruple tank P+")),
        of_computer("cart-pole", gallery_loop("PID, cart-pole")),
    )
    turns = zip(
        cases, (*VERSIONS, VERSIONS[0]), strict=True
    )  # the equations in C are the same in both, as is seen below
    told = cross_checked([write(case, tmp_path, version) for case, version in turns], tmp_path)
    assert len(told) == 3
    assert all(each == {"equal": True, "findings": [], "rows": STEPS + 1} for each in told), told


@needs_fmpy
@needs_compiler
@pytest.mark.parametrize(
    ("first", "number"),
    [pytest.param(2, 3, marks=pytest.mark.heavy), pytest.param(6, 2, marks=pytest.mark.release)],
)
def test_every_eighth_example_has_its_bits_in_an_importer(tmp_path, monkeypatch, first, number):
    """In 2.0 or 3.0 by turns, as the equations in C are the same in both; their descriptions are checked in both."""
    monkeypatch.setattr(fmus, "STEPS", STEPS)
    ran, described = [], []
    for place, case in enumerate(examples(first, every=8)):
        here, there = (VERSIONS[(place + other) % 2] for other in (0, 1))
        units = [fmu(case.what, here, case.name, h=case.h), fmu(case.what, there, case.name, h=case.h, compiler="")]
        ran.append(write(case, tmp_path / "ran", here, units[0]))
        assert equations_of(units[0]) == equations_of(units[1])
        assert "sources/model.h" in equations_of(units[0])
        described.append(tmp_path / "described" / units[1].identifier)
        described[-1].mkdir(parents=True)
        units[1].write(described[-1] / f"{units[1].identifier}.fmu")
    told = cross_checked([*ran, *described], tmp_path)
    assert told[: len(ran)] == [{"equal": True, "findings": [], "rows": STEPS + 1}] * number
    assert told[len(ran) :] == [{"findings": []}] * number


@needs_fmpy
@needs_compiler
@pytest.mark.parametrize("version", heavy_but(VERSIONS, "2.0"))
def test_instances_states_and_refusals_go_by_the_standard(version, tmp_path):
    ode = wb.open_loop(wb.DCMotor())
    path = fmu(ode, version, "motor", h=1e-3).write(tmp_path / "motor.fmu")
    told = in_another_process(CALLS, tmp_path, path, 1e-3)
    step = wb.rk4(ode, 1e-3)
    slow, fast = (outputs_of(step, 151, ode.parameters.pack({"v": v}))[:, 0].tolist() for v in (1.0, 2.0))
    assert told["before"] == 0.0
    assert (told["one by one"], told["at once"]) == (slow[100], fast[100])
    assert told["ahead"] == told["again"] == told["in another"] == slow[150]
    assert told["after refusals"] == told["undisturbed"] == slow[151]
    assert told["another start"] == 0.5
    assert "whole multiple of 0.001" in told["half a step"]
    assert "begin where the last one ended, at 0.1" in told["elsewhere"]
    assert told["no number"] == "'v' must be a finite number."
    assert told["an output"] == "'omega' cannot be set: it is no parameter and no input."
    assert told["a start"] == "'start.omega' can be set before the first step only."
    assert "value reference without a variable" in told["no variable"]
    assert "no finite number, and is undone" in told["beyond numbers"]
    assert "must start at a whole number of steps" in told["between steps"]
    assert "differs" in told["another token"]


@needs_fmpy
@needs_compiler
def test_the_fmus_of_a_law_and_its_plant_are_the_loop(tmp_path):
    motor, sampled = wb.DCMotor(), motor_law()
    script = """
import json, pathlib, sys
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
units, places, told = [], [], []
for path in sys.argv[2:]:
    description = read_model_description(path)
    units.append(FMU2Slave(guid=description.guid, unzipDirectory=extract(path), instanceName="one",
                           modelIdentifier=description.coSimulation.modelIdentifier))
    places.append({variable.name: variable.valueReference for variable in description.modelVariables})
for unit in units:
    unit.instantiate(), unit.setupExperiment(startTime=0.0), unit.enterInitializationMode()
    unit.exitInitializationMode()
(law, plant), (of_law, of_plant) = units, places
law.setReal([of_law["r.omega"]], [1.0])
for i in range(100):
    told.append(plant.getReal([of_plant["omega"]])[0])
    law.setReal([of_law["y.omega"]], told[-1:])
    law.doStep(i * 0.01, 0.01)
    plant.setReal([of_plant["v"]], law.getReal([of_law["u.v"]]))
    plant.doStep(i * 0.01, 0.01)
pathlib.Path(sys.argv[1]).write_text(json.dumps(told))
"""
    law = fmu(sampled.law(), name="law").write(tmp_path / "law.fmu")
    plant = fmu(wb.open_loop(motor), name="plant", h=1e-3).write(tmp_path / "plant.fmu")
    told = in_another_process(script, tmp_path, law, plant)
    run = wb.simulate(sampled.step(10), until=1.0, arithmetic="portable")
    assert max(told) > 0.5  # rad/s
    np.testing.assert_allclose(told, run["omega"][0, :-1].ravel(), rtol=1e-12, atol=1e-14)  # sums in another order


@needs_fmpy
@needs_compiler
def test_an_fmu_ends_where_its_equations_end(tmp_path):
    script = """
import json, pathlib, sys
import fmpy
try:
    fmpy.simulate_fmu(sys.argv[2], stop_time=1.0, output_interval=0.01)
    told = "it was done"
except Exception as error:
    told = "refused"
end = fmpy.simulate_fmu(sys.argv[2], output_interval=0.01)["time"][-1]
pathlib.Path(sys.argv[1]).write_text(json.dumps([told, end]))
"""
    path = fmu(spring(horizon=0.5), h=0.01).write(tmp_path / "spring.fmu")
    assert in_another_process(script, tmp_path, path) == ["refused", 0.5]
