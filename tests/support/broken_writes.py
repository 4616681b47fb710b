"""Reports that are replaced, and stopped at each step on the way: `python broken_writes.py kill|fail FOLDER`.

A step is a call of the system that changes or opens something, as Python tells its audit hooks; and each fsync.
"""

import os
import shutil
import signal
import sys
from pathlib import Path

from workbench.report import folder as module

STEPS = {"open", "os.mkdir", "os.rename", "os.link", "os.remove", "os.rmdir", "shutil.rmtree", "os.scandir"}
PAGE = '<meta name="generator" content="control-workbench 0">'
LEDGER = "ledger/ledger.sqlite"
left, failure = -1, None


def contents(mark, *names):
    names = ("index.html", "report.pdf", "tables/a.csv", "tables/a.tex", *names)
    return {name: f"{PAGE} {mark} {name}".encode() * 9 for name in names}


FIRST = contents("first", "tables/old.csv", "figures/a.svg")
SECOND = contents("second", "figures/a.svg", "figures/new.svg", "runs/new.csv")
THIRD = contents("third", "figures/third.svg")


def step(event, _):
    global left
    if event in STEPS and left >= 0:
        left -= 1
        if left < 0 and failure is None:
            os.kill(os.getpid(), signal.SIGKILL)
        elif left < 0:
            raise failure


def fsync(_):
    """A step that writes nothing: what the system was given outlives a process that is killed."""
    step("open", None)


def held(folder):
    """All files by their paths, and all folders, as None."""
    found = {path.relative_to(folder).as_posix(): path for path in folder.rglob("*")}
    return {name: path.read_bytes() if path.is_file() else None for name, path in found.items()}


def files(folder):
    found = {name: content for name, content in held(folder).items() if content is not None}
    return {name: content for name, content in found.items() if not name.startswith(".partial-")}


def prepare(place, earlier, ledger):
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir()
    if ledger:
        (place / "report" / LEDGER).parent.mkdir(parents=True)
        (place / "report" / LEDGER).write_bytes(b"chunks")
    if earlier:
        written = place.with_name("earlier")  # once, and copied each time
        if not written.exists():
            module.write(FIRST, written)
        shutil.copytree(written, place / "report", dirs_exist_ok=True)
    return {LEDGER: b"chunks"} if ledger else {}


def check_whole(folder, kept, report):
    """The third report replaces whatever was left, and nothing else is there."""
    module.write(THIRD, folder)
    folders = {path.rpartition("/")[0] for path in (*kept, *THIRD)} - {""}
    assert held(folder.parent) == {
        "report": None,
        **{f"report/{name}": content for name, content in (kept | THIRD | dict.fromkeys(folders)).items()},
    }, report


def killed(place, last, earlier, ledger):
    """Whether a write was killed at that step; at each moment a file is the first, or the second, or not yet there."""
    kept = prepare(place, earlier, ledger)
    global left
    if (child := os.fork()) == 0:
        left = last
        module.write(SECOND, place / "report")
        os._exit(0)
    status = os.waitpid(child, 0)[1]
    assert status in (0, signal.SIGKILL), status
    found = files(place / "report") if (place / "report").exists() else {}
    assert kept.items() <= found.items()
    for name in found.keys() - kept.keys():
        assert found[name] in (FIRST.get(name), SECOND.get(name)), (last, name)
    if earlier:
        assert found.keys() >= FIRST.keys() & SECOND.keys(), last
    if status == 0 or found.get("index.html") == SECOND["index.html"]:
        assert kept | SECOND == {name: found.get(name) for name in kept | SECOND}, last
    check_whole(place / "report", kept, last)
    return status != 0


def failed(place, last, earlier, ledger):
    """Whether a write was stopped at that step; where it says that it failed, it leaves the first report."""
    kept = prepare(place, earlier, ledger)
    first, second = kept | (FIRST if earlier else {}), kept | SECOND
    global left
    left, expected = last, [second]
    try:
        module.write(SECOND, place / "report")
    except module.ReportError:
        expected = [first]
    except KeyboardInterrupt:  # while it clears up, the second report stands already
        expected = [first, second]
    reached, left = left < 0, -1
    assert files(place / "report") in expected, last
    check_whole(place / "report", kept, last)
    return reached


if __name__ == "__main__":
    module._contents = lambda document, live: document
    os.fsync = fsync
    sys.addaudithook(step)
    attempt, place = {"kill": killed, "fail": failed}[sys.argv[1]], Path(sys.argv[2]).resolve()
    for failure in (None,) if attempt is killed else (OSError(28, "No space left on device"), KeyboardInterrupt()):
        STEPS -= {"shutil.rmtree", "os.scandir"} if failure else set()  # a full disk stops no clearing
        for earlier in (True, False):
            for ledger in (True, False):
                steps = 0
                while attempt(place, steps, earlier, ledger):
                    steps += 1
                sys.stdout.write(f"{steps}\n")
