"""`python -m workbench` as a fork of a process that has imported it: a run begins at once, and ends as any process.

Tests that start, stop and kill many runs would import the same modules each time for three seconds of a processor.
What a start of Python of its own must show is shown where `subprocess` starts one.
"""

import atexit
import json
import os
import signal
import socket
import subprocess
import sys
import threading
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
ENVIRONMENT = os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])}
CLUSTER = ("distributed.cli.dask_scheduler", "distributed.cli.dask_worker")  # what a run with `--cluster` imports

# A request comes with the ends of three pipes. A keeper waits for the run, as a process can only wait for its children,
# and writes down who it is and how it ended. The run leaves the loop, and ends with all that Python does at its end.
SERVER = """
import importlib, json, os, signal, socket, sys, warnings
import workbench as wb
import workbench.cli.command
for name in dir(wb):
    getattr(wb, name)
channel = socket.socket(fileno=0)
signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # no keeper is waited for
while True:
    text, ends, *_ = socket.recv_fds(channel, 2**20, 3)
    if not text:
        os._exit(0)
    job = json.loads(text)
    for name in job["modules"]:
        importlib.import_module(name)
    if not os.fork():
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
        told = ends.pop()
        run = os.fork()
        if not run:
            break
        os.write(told, f"{run}\\n".encode())
        for end in ends:
            os.close(end)
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        os.write(told, str(os.waitstatus_to_exitcode(os.waitpid(run, 0)[1])).encode())
        os._exit(0)
    for end in ends:
        os.close(end)
os.close(told)
channel.close()
os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
for number, end in enumerate(ends, 1):
    os.dup2(end, number)
    os.close(end)
os.chdir(job["folder"])
os.environ.clear()
os.environ.update(job["environment"])
if os.environ.get("PYTHONWARNINGS") == "error":
    warnings.simplefilter("error")
sys.path[0], sys.argv = job["folder"], ["workbench", *job["words"]]
exec(job["code"], {"__name__": "__main__"})
"""


COMMAND = 'import runpy; runpy.run_module("workbench", run_name="__main__", alter_sys=True)'


@cache
def _channel():
    """The connection to the process whose forks are the runs; it ends with this one."""
    ours, theirs = socket.socketpair()
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    server = subprocess.Popen([sys.executable, "-c", SERVER], stdin=theirs, env=environment)
    theirs.close()
    atexit.register(server.wait)
    atexit.register(ours.close)  # is called first
    return ours


class Run:
    """A run of the command line, with what a test uses of `subprocess.Popen`."""

    def __init__(self, words, folder, environment, code, modules):
        pipes = [os.pipe() for _ in range(3)]
        job = {"words": [str(word) for word in words], "folder": str(folder), "environment": dict(environment)}
        job |= {"code": code, "modules": modules}
        socket.send_fds(_channel(), [json.dumps(job).encode()], [end for _, end in pipes])
        for _, end in pipes:
            os.close(end)
        self.stdout, self.stderr, self._told = (os.fdopen(start, encoding="utf-8") for start, _ in pipes)
        self.pid, self.returncode = int(self._told.readline()), None
        self._found, self._readers = {}, {}

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self.communicate()

    def send_signal(self, sign):
        """Send a signal to the run, unless it has ended."""
        try:
            os.kill(self.pid, sign)
        except ProcessLookupError:
            return

    def kill(self):
        """End the run at once."""
        self.send_signal(signal.SIGKILL)

    def communicate(self, timeout=None):
        """All that the run writes from now on to stdout and stderr, once it has ended."""
        for name in ("stdout", "stderr", "_told"):
            if name not in self._readers:
                self._readers[name] = threading.Thread(target=self._read, args=(name,), daemon=True)
                self._readers[name].start()
        for reader in self._readers.values():
            reader.join(timeout)
            if reader.is_alive():
                raise subprocess.TimeoutExpired("workbench", timeout)
        self.returncode = int(self._found["_told"])
        return self._found["stdout"], self._found["stderr"]

    def _read(self, name):
        with getattr(self, name) as pipe:
            self._found[name] = pipe.read()


def start(words, folder, environment=os.environ, code=COMMAND, modules=()):
    """A run of `python -m workbench`, or of other code, with these words in a folder.

    The process that is forked imports the modules once for all. Where nothing can be forked, a process by itself.
    """
    if hasattr(os, "fork"):
        return Run(words, folder, environment, code, modules)
    call = [sys.executable, "-c", code, *map(str, words)]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    return subprocess.Popen(call, cwd=folder, env=environment, **pipes)
