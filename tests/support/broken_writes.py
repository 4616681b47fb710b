"""Reports that are replaced, and stopped at each step on the way: `python broken_writes.py kill|fail FOLDER`.

A step is a call of the system that changes or opens something, as Python tells its audit hooks; and each fsync.
"""

import os
import re
import shutil
import signal
import sys
from pathlib import Path
from types import ModuleType

GENERATOR = "control-workbench"
# What makes the contents of a report, which are given here: without it a process starts and forks at once.
for name, words in {
    "pdf": {},
    "figures": {"numbers_of": None, "sheets": None},
    "findings_json": {"findings_json": None},
    "html_page": {"GENERATOR": GENERATOR, "html": None},
    "table_text": {"to_csv": None, "to_latex": None},
}.items():
    sys.modules[f"workbench.report.{name}"] = ModuleType(name)
    vars(sys.modules[f"workbench.report.{name}"]).update(words)

from workbench.report import folder as module  # noqa: E402

STEPS = {"open", "os.mkdir", "os.rename", "os.link", "os.remove", "os.rmdir", "shutil.rmtree", "os.scandir"}
PAGE = f'<meta name="generator" content="{GENERATOR} 0">'
LEDGER = "ledger/ledger.sqlite"
KILLED = 16  # at each such step the process is killed, too
waiting = None  # what happens at the next step


def contents(mark, *names):
    names = ("index.html", "report.pdf", "tables/a.csv", "tables/a.tex", *names)
    return {name: f"{PAGE} {mark} {name}".encode() * 9 for name in names}


FIRST = contents("first", "tables/old.csv", "figures/a.svg")
SECOND = contents("second", "figures/a.svg", "figures/new.svg", "runs/new.csv")
THIRD = contents("third", "figures/third.svg")


def step(event, _):
    global waiting
    if event in STEPS and waiting is not None:
        own, waiting = waiting, None  # what it does itself is no step
        if own():
            waiting = own


def after(steps, act):
    """What acts at that step, and at no other."""
    left = steps

    def own():
        nonlocal left
        left -= 1
        if left < 0:
            act()
        return left >= 0

    return own


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


def tree(files, *empty):
    """The files of a place with the folders that hold them."""
    files = {f"report/{name}": content for name, content in files.items()}
    folders = {parent.as_posix() for name in files for parent in Path(name).parents} - {"."}
    return dict.fromkeys([*folders, *empty]) | files


def check_whole(folder, kept, report):
    """The third report replaces whatever was left, and nothing else is there."""
    module.write(THIRD, folder)
    assert held(folder.parent) == tree(kept | THIRD), report


def lay(place, state):
    """A place as it was held."""
    shutil.rmtree(place)
    place.mkdir()
    for name, content in sorted(state.items()):
        (place / name).mkdir() if content is None else (place / name).write_bytes(content)


def kill(place, last):
    """What a process leaves that is killed at that step."""
    global waiting
    if (child := os.fork()) == 0:
        waiting = after(last, lambda: os.kill(os.getpid(), signal.SIGKILL))
        module.write(SECOND, place / "report")
        os._exit(0)
    assert os.waitpid(child, 0)[1] == signal.SIGKILL
    return held(place)


def killed(place, earlier, ledger):
    """The steps of a write; killed there, each file is the first, or the second, or not yet there.

    A kill leaves what lies on the disk at that moment, as is seen at some of the steps.
    """
    kept, states = prepare(place, earlier, ledger), []
    global waiting

    def keep():
        states.append(held(place))
        return True

    waiting = keep
    module.write(SECOND, place / "report")
    waiting = None
    steps = len(states)
    for last, state in enumerate([*states, held(place)]):
        if last % KILLED == 0 and last < steps:
            prepare(place, earlier, ledger)
            assert unnamed(kill(place, last)) == unnamed(state), last
        elif state == states[last - 1]:
            continue  # a step that only reads
        else:
            lay(place, state)
        check_killed(place, kept, earlier, last, last == steps)
    return steps


def unnamed(state):
    """A state without the random name of its hidden folder."""
    return {re.sub(r"[.]partial-[^/]*", ".partial", name): content for name, content in state.items()}


def check_killed(place, kept, earlier, last, done):
    found = files(place / "report") if (place / "report").exists() else {}
    assert kept.items() <= found.items()
    for name in found.keys() - kept.keys():
        assert found[name] in (FIRST.get(name), SECOND.get(name)), (last, name)
    if earlier:
        assert found.keys() >= FIRST.keys() & SECOND.keys(), last
    if done or found.get("index.html") == SECOND["index.html"]:
        assert kept | SECOND == {name: found.get(name) for name in kept | SECOND}, last
    check_whole(place / "report", kept, last)


def failed(place, earlier, ledger, failure):
    """The steps of a write, at each of which it fails; where it says so, it leaves the first report and no more."""
    kept, last = prepare(place, earlier, ledger), 0
    first, second = kept | (FIRST if earlier else {}), kept | SECOND
    global waiting
    while True:
        expected, waiting = [second], after(last, lambda: throw(failure))
        try:
            module.write(SECOND, place / "report")
        except module.ReportError:
            expected = [first]
        except KeyboardInterrupt:  # while it clears up, the second report stands already
            expected = [first, second]
        reached, waiting = waiting is None, None
        left = held(place)
        if left not in map(tree, expected):  # stopped while it clears up: what is left goes with the next report
            assert (files(place / "report") if (place / "report").exists() else {}) in expected, last
            check_whole(place / "report", kept, last)
        if not reached:
            return last
        if left != tree(first):
            prepare(place, earlier, ledger)
        last += 1


def throw(failure):
    raise failure


if __name__ == "__main__":
    module._contents = lambda document, live: document
    os.fsync = fsync
    sys.addaudithook(step)
    attempt, place = sys.argv[1], Path(sys.argv[2]).resolve()
    for failure in (None,) if attempt == "kill" else (OSError(28, "No space left on device"), KeyboardInterrupt()):
        STEPS -= {"shutil.rmtree", "os.scandir"} if failure else set()  # a full disk stops no clearing
        for earlier in (True, False):
            for ledger in (True, False):
                steps = failed(place, earlier, ledger, failure) if failure else killed(place, earlier, ledger)
                sys.stdout.write(f"{steps}\n")
