"""FMUs in an importer: the law as one file, run by FMPy in a process of its own that does not load the workbench."""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from string import Template

import numpy as np

from workbench.handover.c99.c_code import CCode
from workbench.handover.fmi.archive import fmu
from workbench.handover.recording import Recording
from workbench.handover.targets.contract import AbstractTarget, Figures
from workbench.handover.targets.harness import Answers
from workbench.handover.targets.programs import TargetError, run

# An importer in Python: sets the inputs, makes a step of one period, and takes the outputs.
SCRIPT = Template("""
import json, os
import fmpy
import numpy as np
from fmpy.fmi$major import FMU${major}Slave
told = json.load(open("names.json"))
description = fmpy.read_model_description("law.fmu")
places = {variable.name: variable.valueReference for variable in description.modelVariables}
folder, identifier = os.path.abspath("unpacked"), description.coSimulation.modelIdentifier
unit = FMU${major}Slave(guid=description.guid, unzipDirectory=fmpy.extract("law.fmu", folder), instanceName="law",
                  modelIdentifier=identifier)
unit.instantiate()
$begin
unit.exitInitializationMode()
inputs, outputs = ([places[name] for name in told[port]] for port in ("inputs", "outputs"))
rows = np.fromfile("inputs.bin").reshape(-1, len(inputs))
answers = np.empty((len(rows), len(outputs)))
for k, row in enumerate(rows.tolist()):
    unit.$put(inputs, row)
    unit.doStep(currentCommunicationPoint=k * told["period"], communicationStepSize=told["period"])
    answers[k] = unit.$take(outputs)
answers.tofile("answers.bin")
unit.terminate()
""")
CALLS = {
    "2.0": {"major": "2", "put": "setReal", "take": "getReal"},
    "3.0": {"major": "3", "put": "setFloat64", "take": "getFloat64"},
}
BEGINS = {
    "2.0": "unit.setupExperiment(startTime=0.0)\nunit.enterInitializationMode()",
    "3.0": "unit.enterInitializationMode(startTime=0.0)",
}


@dataclass(frozen=True)
class Importer(AbstractTarget):
    """FMPy with an FMU of a version of FMI; commands alone are compared, as an FMU shows no memory."""

    name: str
    version: str

    @property
    def programs(self) -> tuple[str, ...]:
        """The compiler of the FMU's library."""
        return ("gcc",)

    def answers(self, code: CCode, recording: Recording, folder: Path, seconds: float) -> Answers:
        """The commands, step by step."""
        if code.real != "double":
            raise TargetError("an FMU has doubles")
        if find_spec("fmpy") is None:
            raise TargetError("install FMPy with `pip install fmpy`")
        law = recording.law
        try:
            unit = fmu(law, self.version, code.name, compiler="gcc")
        except ValueError as error:
            raise TargetError(str(error)) from error
        unit.write(folder / "law.fmu")
        names = {f"{role}s": [v.name for v in unit.variables if v.role == role] for role in ("input", "output")}
        (folder / "names.json").write_text(json.dumps({"period": law.period, **names}), encoding="utf-8")
        recording.inputs.tofile(folder / "inputs.bin")
        script = SCRIPT.substitute(CALLS[self.version], begin=BEGINS[self.version])
        (folder / "importer.py").write_text(script, encoding="utf-8")
        run([sys.executable, "-I", "importer.py"], folder, seconds)
        u = np.fromfile(folder / "answers.bin").reshape(recording.u.shape)
        return Answers(u, np.zeros(len(u), dtype=np.uint64), None, None)

    def figures(self, code: CCode, recording: Recording, folder: Path, seconds: float) -> Figures:
        """None of them."""
        return Figures()
