"""`python -m tests.fuzz --calls 50000 --seed 1 [room ...]`: counts, and each raw error once with its shortest call."""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from collections import Counter

from .calls import Aims, aims
from .workers import Outcome, outcomes


def main(words: list[str]) -> int:
    """Make the calls, print what came of them, and return 1 if anything is raw."""
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description="Call public names with odd arguments.")
    parser.add_argument("rooms", nargs="*", metavar="room", help="a folder of the workbench, as in `design`")
    parser.add_argument("--calls", type=int, default=50_000, metavar="N")
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args(words)
    with tempfile.TemporaryDirectory() as folder:  # where examples and odd paths write
        os.chdir(folder)
        text = report(aims().of_rooms(asked.rooms), asked.seed, asked.calls)
    sys.stdout.write(text)
    return 0 if " 0 raw" in text else 1


def report(held: Aims, seed: int, calls: int) -> str:
    """Counts of what came of the calls, after each raw error with its shortest call."""
    kinds: Counter[str] = Counter()
    shortest: dict[str, tuple[int, Outcome]] = {}
    for outcome in outcomes(held, seed, range(calls)):
        kinds[outcome.kind] += 1
        if outcome.kind == "raw":
            count, best = shortest.get(outcome.place, (0, outcome))
            key = (outcome.replaced, len(outcome.text))
            shortest[outcome.place] = (count + 1, outcome if key < (best.replaced, len(best.text)) else best)
    lines = [
        f"{count:6} {place}\n       {outcome.text[:300]}   [{outcome.number}]"
        for place, (count, outcome) in sorted(shortest.items())
    ]
    made = f"{calls} calls of {len(held.targets)} functions with {held.arguments} arguments: "
    came = f"{kinds['done']} done, {kinds['refused']} refused, {kinds['raw']} raw on {len(shortest)} lines"
    return "\n".join([*lines, made + came, ""])


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
