"""FMUs in an importer: the law as one file, run by FMPy in a process of its own that does not load the workbench."""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from workbench.core.templates import fill
from workbench.handover.c99.c_files import CCode
from workbench.handover.fmi.archive import fmu
from workbench.handover.recording import Recording
from workbench.handover.targets.external_programs import TargetError, run
from workbench.handover.targets.harness import TargetAnswers
from workbench.handover.targets.target import AbstractTarget, TargetCost

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

    def answers(self, code: CCode, recording: Recording, folder: Path, seconds: float) -> TargetAnswers:
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
        script = fill("workbench.handover", "targets/importer.py.j2", **CALLS[self.version], begin=BEGINS[self.version])
        (folder / "importer.py").write_text(script, encoding="utf-8")
        run([sys.executable, "-I", "importer.py"], folder, seconds)
        u = np.fromfile(folder / "answers.bin").reshape(recording.u.shape)
        return TargetAnswers(u, np.zeros(len(u), dtype=np.uint64), None, None)

    def figures(self, code: CCode, recording: Recording, folder: Path, seconds: float) -> TargetCost:
        """None of them."""
        return TargetCost()
