"""One ledger, one arithmetic: who goes on with it, with or without a compiler, gives the same bits or is refused."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.swept_studies import SWEPT, acknowledged, forget
from workbench.engine.arithmetic import signature

pytest.importorskip("llvmlite")

ROOT = Path(__file__).parents[2]
PLAIN = "import sys; sys.modules['llvmlite'] = None; from workbench.cli.command import main; main()"
ENGINES = {"compiled": ["-m", "workbench"], "plain": ["-c", PLAIN]}


@pytest.fixture
def run(tmp_path):
    """Run the study of five chunks as a process of its own, with llvmlite or without it."""
    (tmp_path / "swept.py").write_text(SWEPT.replace("until=2.0", "until=0.2"), encoding="utf-8")
    environment = os.environ | {"PYTHONPATH": str(ROOT)}

    def call(engine, *words, out="out"):
        line = [sys.executable, *ENGINES[engine], "run", "swept.py", "--out", out, "--ack", *words]
        return subprocess.run(line, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=120)

    return call


@pytest.mark.parametrize(
    ("first", "then", "words"),
    [
        ("compiled", "plain", []),
        ("plain", "compiled", []),
        ("plain", "compiled", ["--arithmetic", "fused"]),
    ],
)
def test_another_engine_goes_on_with_the_bits_of_the_first(run, tmp_path, first, then, words):
    begun = run(first, *words)
    assert begun.returncode == 0, begun.stderr
    forget(tmp_path / "out", 0, 3)
    ended = run(then)
    assert ended.returncode == 0, ended.stderr
    again = acknowledged(ended.stdout)
    assert len(again) == 2
    assert again.items() <= acknowledged(begun.stdout).items()
    # without a compiler the arithmetic is CasADi's unless one is named, and no machine compiles it
    slow = then == "plain" or (first == "plain" and not words)
    assert ("is not compiled here: the same bits take some" in ended.stderr) == slow


def test_another_arithmetic_is_refused_by_name_before_anything_is_computed(run, tmp_path):
    assert run("compiled").returncode == 0
    forget(tmp_path / "out", 0)
    refused = run("compiled", "--arithmetic", "portable")
    assert (refused.returncode, acknowledged(refused.stdout), refused.stderr.count("\n")) == (2, {}, 1)
    assert (
        f"holds runs of 'decay' in the arithmetic '{signature('fused')}', and this run would compute in "
        f"'{signature('portable')}'" in refused.stderr
    )
    anew = run("compiled", "--arithmetic", "portable", "--fresh")
    assert (anew.returncode, len(acknowledged(anew.stdout))) == (0, 5)
    page = (tmp_path / "out" / "index.html").read_text(encoding="utf-8")
    assert signature("portable") in page
