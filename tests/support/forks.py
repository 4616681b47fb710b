"""Python programs one after the other, each in a fork of one process that has imported the whole workbench."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

# A fork begins with the modules of its parent, and with nothing else of it: a new `__main__`, its own folder and files.
SERVER = """
import gc, json, os, sys, traceback, types
import workbench as wb
for name in dir(wb):
    getattr(wb, name)
gc.collect()
gc.freeze()  # no fork searches what it begins with
gc.set_threshold(20_000, 20, 20)

def run(job):
    os.chdir(job["folder"])
    for number, place in ((1, job["out"]), (2, job["error"])):
        os.dup2(os.open(place, os.O_WRONLY | os.O_CREAT, 0o600), number)
    main = sys.modules["__main__"] = types.ModuleType("__main__")
    try:
        exec(compile(job["code"], "<program>", "exec"), vars(main))
    except SystemExit as stop:
        return stop.code
    except BaseException:
        traceback.print_exc()
        return 1
    return 0

ends = []
for job in json.load(sys.stdin):
    child = os.fork()
    if child == 0:
        status = run(job)
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status if isinstance(status, int) else 0 if status is None else 1)
    ends.append(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
print(json.dumps(ends))
"""


class Done(NamedTuple):
    """How a program ended, in which folder, and what it wrote."""

    folder: Path
    returncode: int
    stdout: str
    stderr: str


def run_all(programs, folder, environment):
    """The ends of programs, given as texts by their names; each runs in a folder of its own, which is there by then."""
    jobs = []
    for i, code in enumerate(programs.values()):
        place = folder / str(i)
        place.mkdir()
        jobs.append({"code": code, "folder": str(place), "out": f"{place}.out", "error": f"{place}.error"})
    if not hasattr(os, "fork"):
        return {name: _alone(job, environment) for name, job in zip(programs, jobs, strict=True)}
    told = subprocess.run(
        [sys.executable, "-c", SERVER],
        input=json.dumps(jobs),
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    ends = json.loads(told.stdout)
    return {name: _done(job, end) for name, job, end in zip(programs, jobs, ends, strict=True)}


def _done(job, end):
    return Done(Path(job["folder"]), end, *(Path(job[pipe]).read_text(encoding="utf-8") for pipe in ("out", "error")))


def _alone(job, environment):
    call = [sys.executable, "-c", job["code"]]
    done = subprocess.run(call, cwd=job["folder"], env=environment, capture_output=True, text=True, check=False)
    return Done(Path(job["folder"]), done.returncode, done.stdout, done.stderr)
