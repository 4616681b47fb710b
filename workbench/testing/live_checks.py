"""The live page of a loop: it can be turned, and JavaScript computes the numbers of the portable arithmetic."""

from __future__ import annotations

import base64
import json
import re
import shutil
import subprocess
import zlib
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import workbench as wb
from workbench.core import Ode, SampledSystem, rk4
from workbench.core.templates import template_text
from workbench.core.validation.refusals import Array
from workbench.engine import simulate
from workbench.engine.arithmetic import PORTABLE
from workbench.testing.failure_sentences import fail, no_refusal, skip

STEPS = 40
DATA = re.compile(r'<script type="application/json" id="live">(.*?)</script>', re.DOTALL)
TIMEOUT = 60  # s
SPELL = "write the block with operations that every machine has, or declare `exportable = False` in its class"


def demand_live_page(name: str, equation: Ode | SampledSystem, h: float) -> None:
    """Fail where the page of a loop is a printed one, or JavaScript gives other bits than the simulation."""
    if find_spec("llvmlite") is None:
        skip("nothing is compiled for a browser without llvmlite")
    length = equation.period if isinstance(equation, SampledSystem) else h
    with no_refusal(name, "have a live page", SPELL):
        page = wb.live(equation, until=STEPS * length, h=length)
    found = DATA.search(page.text)
    if page.no_live_reason or found is None:
        fail(name, "have a live page", f"the page says '{page.no_live_reason}'", SPELL)
    if shutil.which("node") is None:
        return  # the page is made, and nothing here can run it
    data = json.loads(found[1])
    loop = data["loops"][0]
    after = _in_node(data["modules"][loop["whole"]["module"]], loop, STEPS)
    step = equation.step(1) if isinstance(equation, SampledSystem) else rk4(equation, h)
    wanted = simulate(step, until=STEPS * step.h, arithmetic=PORTABLE).x[0, 1:]
    nx = step.states.size
    if (after[:, :nx].view(np.uint64) != wanted.view(np.uint64)).any():
        k = int(np.argmax((after[:, :nx] != wanted).any(axis=1)))
        fail(name, "give the bits of the portable arithmetic on its page", f"they differ from step {k} on", SPELL)


def demand_printed_page(name: str, equation: Ode | SampledSystem, h: float) -> None:
    """Fail where the page of a block that is declared not to be exportable can be turned."""
    length = equation.period if isinstance(equation, SampledSystem) else h
    page = wb.live(equation, until=STEPS * length, h=length)
    if not page.no_live_reason:
        fail(name, "have a printed page, as `exportable = False` says", "its page is live", "take the declaration out")


def _in_node(module: str, loop: dict[str, object], steps: int) -> Array:
    """The states (steps, nx) of the march of a page, each step by the script that runs a law in Node."""
    march = loop["whole"]
    assert isinstance(march, dict)
    with TemporaryDirectory(prefix="workbench-") as place:
        folder = Path(place)
        (folder / "law.wasm").write_bytes(zlib.decompress(base64.b64decode(module), wbits=-15))
        p, x0 = (np.array(loop[key], dtype=float) for key in ("p", "x0"))
        numbers = [np.array(march["constants"], dtype=float), p[march["parameters"]], x0]
        (folder / "numbers").write_bytes(np.concatenate(numbers).astype("<f8").tobytes())
        sizes = {"constants": len(march["constants"]), "p": len(march["parameters"]), "lanes": march["lanes"]}
        sizes |= {"table": march["table"], "states": march["states"], "inputs": 0, "varied": []}
        (folder / "sizes.json").write_text(json.dumps(sizes | {"periods": steps, "block": steps}), encoding="utf-8")
        (folder / "march.js").write_text(template_text("workbench.handover", "targets/march.js"), encoding="utf-8")
        (folder / "inputs").write_bytes(b"")
        subprocess.run(["node", "march.js"], cwd=folder, check=True, timeout=TIMEOUT, capture_output=True)
        return np.fromfile(folder / "answers", dtype="<f8").reshape(steps, -1)
