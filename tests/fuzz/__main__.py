"""`python -m tests.fuzz --calls 50000 --seed 1 [room ...]`: counts, and each raw error once with its shortest call."""

from __future__ import annotations

import argparse
import sys
from collections import Counter

from .calls import aims, room_files
from .workers import Outcome, outcomes


def main(words: list[str]) -> int:
    """Make the calls, print what came of them, and return 1 if anything is raw."""
    files = {file.__name__.rpartition(".")[2]: file for file in room_files()}
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description="Call public names with odd arguments.")
    parser.add_argument("rooms", nargs="*", metavar="room", choices=[[], *files], help=", ".join(files))
    parser.add_argument("--calls", type=int, default=50_000, metavar="N")
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args(words)
    held = aims([files[name] for name in asked.rooms or files])
    kinds: Counter[str] = Counter()
    shortest: dict[str, tuple[int, Outcome]] = {}
    for outcome in outcomes(held, asked.seed, range(asked.calls)):
        kinds[outcome.kind] += 1
        if outcome.kind == "raw":
            count, best = shortest.get(outcome.place, (0, outcome))
            key = (outcome.replaced, len(outcome.text))
            shortest[outcome.place] = (count + 1, outcome if key < (best.replaced, len(best.text)) else best)
    for place, (count, outcome) in sorted(shortest.items()):
        sys.stdout.write(f"{count:6} {place}\n       {outcome.text[:300]}   [{outcome.number}]\n")
    sys.stdout.write(
        f"{asked.calls} calls of {len(held.targets)} targets: {kinds['done']} done, {kinds['refused']} refused, "
        f"{kinds['raw']} raw on {len(shortest)} lines\n"
    )
    return 1 if shortest else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
