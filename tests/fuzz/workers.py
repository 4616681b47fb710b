"""Processes that make calls one after another, so that a crash or a hang is an outcome of its call."""

from __future__ import annotations

import json
import os
import resource
import select
import signal
import time
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

from .calls import Aims, Call, call_of
from .judgement import raw

SECONDS = 10  # that a call may take, and a process that does not answer thrice as long
MEMORY = 3 * 2**30  # bytes beyond those in use at the start


@dataclass(frozen=True)
class Outcome:
    """What came of a call: done, refused, or raw with kind and place."""

    number: int
    kind: str
    text: str
    replaced: int
    place: str = ""


class TooLongError(BaseException):
    """A call that takes too long; no `except Exception` catches it."""


def outcomes(held: Aims, seed: int, numbers: range) -> Iterator[Outcome]:
    """The outcomes of the calls of these numbers, in order."""
    number = numbers.start
    while number < numbers.stop:
        inbox, outbox = os.pipe()
        child = os.fork()
        if child == 0:
            os.close(inbox)
            _work(held, seed, range(number, numbers.stop), outbox)
        os.close(outbox)
        for outcome in _read(inbox, child):
            yield outcome
            number = outcome.number + 1
        os.close(inbox)
        status = os.waitpid(child, 0)[1]
        if number < numbers.stop:
            call = call_of(held, seed, number)
            end = signal.Signals(os.WTERMSIG(status)).name if os.WIFSIGNALED(status) else f"exit {status}"
            yield Outcome(number, "raw", call.text, call.replaced, f"the process ended by {end} in {call.target}")
            number += 1


def _read(inbox: int, child: int) -> Iterator[Outcome]:
    """Outcomes line by line, until the process ends or says nothing for too long."""
    rest, heard = b"", time.monotonic()
    while True:
        if not select.select([inbox], [], [], 1.0)[0]:
            if time.monotonic() - heard > 3 * SECONDS:
                os.kill(child, signal.SIGKILL)
            continue
        block = os.read(inbox, 1 << 16)
        if not block:
            return
        heard = time.monotonic()
        *lines, rest = (rest + block).split(b"\n")
        for line in lines:
            yield Outcome(**json.loads(line))


def _work(held: Aims, seed: int, numbers: range, outbox: int) -> NoReturn:
    """Make the calls and write what came of them; the process ends here."""
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(nowhere, stream)
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, used + MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    signal.signal(signal.SIGALRM, _too_long)
    warnings.simplefilter("error")
    for number in numbers:
        outcome = _outcome(number, call_of(held, seed, number))
        os.write(outbox, json.dumps(vars(outcome)).encode() + b"\n")
    os._exit(0)


def _too_long(*_: Any) -> NoReturn:
    raise TooLongError


def _outcome(number: int, call: Call) -> Outcome:
    signal.setitimer(signal.ITIMER_REAL, SECONDS)
    try:
        call.make()
    except BaseException as error:
        signal.setitimer(signal.ITIMER_REAL, 0)
        place = f"more than {SECONDS} s in {call.target}" if isinstance(error, TooLongError) else raw(error)
        return Outcome(number, "raw" if place else "refused", call.text, call.replaced, place or "")
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
    return Outcome(number, "done", call.text, call.replaced)
