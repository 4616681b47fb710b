"""One ledger, one arithmetic: who goes on with it, with or without a compiler, gives the same bits or is refused."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from tests.support.swept_studies import SWEPT, acknowledged, forget
from workbench.engine.arithmetic import signature

pytest.importorskip("llvmlite")

ROOT = Path(__file__).parents[2]
# Runs of a process without llvmlite, by their folders: what each ended with, printed and said.
PLAIN = """
import json, sys
sys.modules["llvmlite"] = None
from click.testing import CliRunner
from workbench.cli.command import cli
ended = {}
for out, words in json.loads(sys.argv[1]).items():
    done = CliRunner().invoke(cli, ["run", "swept.py", "--out", out, "--ack", *words])
    ended[out] = [done.exit_code, done.stdout, done.stderr]
print(json.dumps(ended))
"""
FUSED = ["--arithmetic", "fused"]


def compiled(out, *words):
    """Run the study in this process, which has a compiler."""
    from workbench.cli.command import cli

    done = CliRunner().invoke(cli, ["run", "swept.py", "--out", out, "--ack", *words])
    return done.exit_code, done.stdout, done.stderr


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with the study of five chunks, in which this module works."""
    place = tmp_path_factory.mktemp("engines")
    (place / "swept.py").write_text(SWEPT.replace("until=2.0", "until=0.2"), encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(place)
        patch.setattr(sys, "path", list(sys.path))
        patch.delitem(sys.modules, "__study__", raising=False)
        yield place


@pytest.fixture(scope="module")
def ended(folder):
    """What a run with a compiler ended with."""
    return {"compiled": compiled("compiled")}


@pytest.fixture(scope="module")
def begun(folder, ended):
    """What the first runs of all cases ended with, and the run without a compiler that goes on with a compiled one."""
    shutil.copytree(folder / "compiled", folder / "compiled-plain")
    forget(folder / "compiled-plain", 0, 3)
    runs = {"plain": [], "plain fused": FUSED, "compiled-plain": []}
    line, environment = [sys.executable, "-c", PLAIN, json.dumps(runs)], os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run(line, cwd=folder, env=environment, capture_output=True, text=True, timeout=120, check=True)
    return ended | {out: tuple(end) for out, end in json.loads(done.stdout).items()}


@pytest.mark.heavy
@pytest.mark.parametrize(("first", "then"), [("compiled", "plain"), ("plain", "compiled"), ("plain fused", "compiled")])
def test_another_engine_goes_on_with_the_bits_of_the_first(begun, folder, first, then):
    code, printed, said = begun[first]
    assert code == 0, said
    if then == "compiled":
        forget(folder / first, 0, 3)
    code, printed_then, said = compiled(first) if then == "compiled" else begun["compiled-plain"]
    assert code == 0, said
    again = acknowledged(printed_then)
    assert len(again) == 2
    assert again.items() <= acknowledged(printed).items()
    # without a compiler the arithmetic is CasADi's unless one is named, and no machine compiles it
    slow = then == "plain" or first == "plain"
    assert ("is not compiled here: the same bits take some" in said) == slow


def test_another_arithmetic_is_refused_by_name_before_anything_is_computed(ended, folder):
    assert ended["compiled"][0] == 0
    out = "compiled again"
    shutil.copytree(folder / "compiled", folder / out)
    forget(folder / out, 0)
    code, printed, said = compiled(out, "--arithmetic", "portable")
    assert (code, acknowledged(printed), said.count("\n")) == (2, {}, 1)
    assert (
        f"holds runs of 'decay' in the arithmetic '{signature('fused')}', and this run would compute in "
        f"'{signature('portable')}'" in said
    )
    code, printed, _ = compiled(out, "--arithmetic", "portable", "--fresh")
    assert (code, len(acknowledged(printed))) == (0, 5)
    page = (folder / out / "index.html").read_text(encoding="utf-8")
    assert signature("portable") in page
