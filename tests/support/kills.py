"""Kills of a study at random moments: what is held afterwards, and how often each piece was computed.

`python tests/support/kills.py 200` makes so many by hand, some five seconds each.
"""

import os
import random
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

from tests.support import warm_runs
from workbench.study.ledger.store import about_in, chunks, is_chunk

ROOT = Path(__file__).resolve().parents[2]
STUDY = Path(__file__).parents[1] / "exams" / "every_kind.py"
LONGEST = 600.0  # s of a run: machines may be busy
DELAY = 0.05  # s after a piece was acknowledged, at most, until the process is killed
BEGIN, END = 1.0, 1.0  # s of the start, and of what follows the last piece, in which it may be killed


@dataclass
class Tally:
    """The kills, those by the kind of piece under way, and whatever went wrong."""

    kills: int = 0
    folders: int = 0
    kinds: dict[str, int] = field(default_factory=dict)
    faults: list[str] = field(default_factory=list)
    lost: int = 0  # items of works that were under way when the process was killed, and computed again

    def __str__(self):
        kinds = ", ".join(f"{count} {kind}" for kind, count in sorted(self.kinds.items()))
        said = f"{self.kills} kills of {self.folders} folders ({kinds}), {self.lost} items under way computed again"
        return "; ".join([said, *self.faults])


def start(folder, fork=True):
    """A run of the study in a folder, as a process whose pieces are acknowledged: a fork, or a Python of its own."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "BEGUN": str(folder / "begun"), "PYTHONWARNINGS": "error"}
    words = ["run", str(STUDY), "--out", "out", "--ack"]
    if fork:
        return warm_runs.start(words, folder, environment)
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    return subprocess.Popen([sys.executable, "-m", "workbench", *words], cwd=folder, env=environment, **pipes)


def held(folder):
    """The pieces in the ledger of a folder: the digest of each by its name, and the items of works among them."""
    pieces = {chunk.name: chunk for chunk in chunks(folder / "out") if is_chunk(chunk.name)}
    items = {(name.split("/")[0], one.content["item"]) for name, one in pieces.items() if "/item/" in name}
    return {name: chunk.digest.hex() for name, chunk in pieces.items()}, items


def begun(folder):
    """The items of works that began, in the order in which they did."""
    file = folder / "begun"
    return [tuple(line.split(" ", 1)) for line in file.read_text().splitlines()] if file.exists() else []


def acknowledged(lines):
    """The pieces that a process has acknowledged."""
    return [line.split()[1] for line in lines if line.startswith("ACK ")]


def undisturbed(folder):
    """A run that nobody disturbs: its pieces in order, and its files."""
    folder.mkdir()
    process = start(folder, fork=False)
    out, error = process.communicate(timeout=LONGEST)
    assert process.returncode == 0, error
    return acknowledged(out.splitlines()), files(folder)


def files(folder):
    """All files of a report and its ledger but the lock, which names a process."""
    out = folder / "out"
    paths = (path for path in out.rglob("*") if path.is_file() and path.name != "lock")
    return {str(path.relative_to(out)): path.read_bytes() for path in paths}


def disturb(folder, pieces, rng, most, tally):
    """Kill runs in a folder, one to six times at random pieces of random kinds, at most so often, then finish it."""
    folder.mkdir()
    tally.folders += 1
    kinds = list(dict.fromkeys(name.split("/")[0] for name in pieces))
    for _ in range(min(rng.randint(1, 6), most)):
        kind = rng.choice(["start", *kinds, "end"])
        places = [i for i, name in enumerate(pieces) if name.startswith(f"{kind}/")]
        wanted = 0 if kind == "start" else len(pieces) if kind == "end" else rng.choice(places) + 1
        delay = rng.uniform(0, {"start": BEGIN, "end": END}.get(kind, DELAY))
        _run(folder, tally, (kind, wanted, delay))
    _run(folder, tally, None)


def _run(folder, tally, moment):
    """One run, killed at a moment: the kind of piece, how many are held by then, and a delay in s; or to its end."""
    before, items = held(folder)
    count = len(begun(folder))
    process = start(folder)
    acks, there = [], set(before)
    if moment is not None:
        kind, wanted, delay = moment
        while len(there) < wanted and (line := process.stdout.readline()):
            acks += acknowledged([line])
            there |= set(acks)
        time.sleep(delay)
        process.kill()
    out, error = process.communicate(timeout=LONGEST)
    acks += acknowledged(out.splitlines())
    if moment is not None and process.returncode != 0:
        tally.kills += 1
        tally.kinds[kind] = tally.kinds.get(kind, 0) + 1
    elif process.returncode != 0:
        tally.faults.append(f"{folder.name}: ended with {process.returncode}: {error}")
    now, _ = held(folder)
    new = begun(folder)[count:]
    tally.lost += sum(begun(folder)[:count].count(one) for one in set(new))
    checks = {
        "a piece was acknowledged twice": len(acks) > len(set(acks)) or set(acks) & set(before),
        "a piece that was acknowledged is lost": set(acks) - set(now),
        "a piece that was held has changed": {name for name in before if now.get(name) != before[name]},
        "an item that was held was computed again": set(new) & items,
        "an item was computed twice in one run": len(new) > len(set(new)),
        "a piece that is held is not counted by `status`": _uncounted(folder, now),
    }
    tally.faults += [f"{folder.name}: {fault}" for fault, found in checks.items() if found]


def _uncounted(folder, now):
    """The pieces that the study's state does not know; those of a tuning may wait a second until they are told."""
    about = about_in(folder / "out")
    if about is None or about.more:
        return set()
    return {name for name in now if name not in about.chunks and not name.startswith("gains_by_search")}


def survive(folder, kills, seed, other=None):
    """The tally of so many kills, each folder held in the end against the `other` run, which nobody disturbed."""
    rng, tally = random.Random(seed), Tally()
    pieces, wanted = other or undisturbed(folder / "undisturbed")
    while tally.kills < kills and len(tally.faults) < 5:
        place = folder / f"killed_{tally.folders}"
        disturb(place, pieces, rng, kills - tally.kills, tally)
        found = files(place)
        tally.faults += [
            f"{place.name}: '{name}' is another one than undisturbed"
            for name in sorted(found.keys() | wanted.keys())
            if found.get(name) != wanted.get(name)
        ]
    return tally


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as made:
        print(survive(Path(made), int(sys.argv[1]), seed=2030))  # noqa: T201
