"""A browser: the law as WebAssembly in V8, the engine of Chrome, which Node runs without a window."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.core import SampledLaw
from workbench.core.templates import template_text
from workbench.engine.kernel.plan import KernelPlan
from workbench.handover.c99.c_files import CCode
from workbench.handover.memory_digest import digest
from workbench.handover.recording import BLOCK, Recording
from workbench.handover.targets.external_programs import TargetError, run
from workbench.handover.targets.harness import ANSWERS, INPUTS, TargetAnswers
from workbench.handover.targets.target import AbstractTarget, TargetCost

MODULE, NUMBERS, SIZES, SCRIPT = "law.wasm", "numbers", "sizes.json", "march.js"


@dataclass(frozen=True)
class Browser(AbstractTarget):
    """The march of a law's step with the bits of the portable arithmetic, as a live page runs it."""

    name: str

    @property
    def programs(self) -> tuple[str, ...]:
        """Node."""
        return ("node",)

    def answers(self, code: CCode, recording: Recording, folder: Path, seconds: float) -> TargetAnswers:
        """Commands and memories of a march that goes on from its own memory."""
        law, nz = recording.law, recording.law.memory.size
        if code.real != "double":
            raise TargetError("a page computes in double precision alone")
        _write(law, recording, folder)
        run(["node", SCRIPT], folder, seconds)
        rows = np.fromfile(folder / ANSWERS, dtype="<f8")
        if rows.size != recording.periods * (nz + law.commands.size):
            raise TargetError(f"Node has written {rows.size} numbers for {recording.periods} periods")
        rows = rows.reshape(recording.periods, -1)
        parts = (rows[first : first + BLOCK, :nz] for first in range(0, len(rows), BLOCK))
        none = np.zeros(len(rows), dtype=np.uint64)
        return TargetAnswers(rows[:, nz:], none, np.concatenate([digest(part) for part in parts]), rows[-1, :nz])

    def figures(self, code: CCode, recording: Recording, folder: Path, seconds: float) -> TargetCost:
        """The bytes of the module."""
        return TargetCost(code=(folder / MODULE).stat().st_size)


def _write(law: SampledLaw, recording: Recording, folder: Path) -> None:
    """The module, the numbers that it is handed, and the inputs."""
    try:
        from workbench.engine.kernel import webassembly
    except ImportError:
        raise TargetError("nothing is compiled for a browser without llvmlite") from None
    plan = KernelPlan.of_step(law.step, ())
    try:
        (folder / MODULE).write_bytes(webassembly.compile_plan(plan))
    except ValueError as error:
        raise TargetError(str(error)) from error
    outside = law.parameters.size
    constants, chosen = plan.constants(law.period), list(plan.parameters)
    p, start = law.step.parameters.default[chosen], law.memory.default
    numbers = [np.array(constants), p, start, np.zeros(law.commands.size)]
    (folder / NUMBERS).write_bytes(np.concatenate(numbers).astype("<f8").tobytes())
    sizes = {"constants": len(constants), "p": len(chosen), "lanes": plan.scratch, "table": len(plan.table)}
    sizes |= {"states": law.step.states.size, "inputs": law.readings.size + law.references.size}
    varied = [(place, i - outside) for i, place in plan.parameters.items() if i >= outside]
    head = {**sizes, "periods": recording.periods, "block": BLOCK, "varied": varied}
    (folder / SIZES).write_text(json.dumps(head), encoding="utf-8")
    (folder / SCRIPT).write_text(template_text("workbench.handover", "targets/march.js"), encoding="utf-8")
    recording.inputs.astype("<f8").tofile(folder / INPUTS)
