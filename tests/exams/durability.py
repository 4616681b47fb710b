"""The exam of durability: a study that is killed, raced, damaged and starved of disk goes on as if nothing had been."""

from __future__ import annotations

import shlex
import sys
from argparse import Namespace
from pathlib import Path

from .graders import Loaded

STUDY = Path(__file__).with_name("small_study.py")
# Folders, of which each is killed one to three times: with this seed 22 of them are 50 kills.
ASKED = {"kills": 22, "races": 2, "corruptions": 8, "seed": 116}


def survival(exam: Loaded) -> tuple[bool, str]:
    """The small study through the command line."""
    root = STUDY.parents[2]
    workbench = shlex.join(["env", f"PYTHONPATH={root}", sys.executable, "-m", "workbench"])
    run = f"{workbench} run {shlex.quote(str(STUDY))} --out {{out}} --ack"
    dump = f"{workbench} results {{out}} --digests"
    report = exam.module.main(Namespace(run=run, dump=dump, **ASKED))
    counts = [f"{report[key]} {said}" for key, said in COUNTED.items()]
    counts += [" ".join(map(str, words)) for words in report["fail"]]
    return bool(report["passed"]) and report["kills"] >= 50, ", ".join(counts)


COUNTED = {
    "kills": "kills",
    "chunks_lost": "acknowledged chunks lost",
    "chunks_redone": "redone",
    "silent_corruptions": "corruptions delivered",
    "n_fail": "failures in all",
}
PARTS = {"acks": ("survival", survival)}
