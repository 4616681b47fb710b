"""The table: every row with its name, and what measures it."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from functools import partial

from studies.performance.accuracy import cvodes_name, cvodes_row, peer_row
from studies.performance.effort import Effort
from studies.performance.engine import TARGETS
from studies.performance.peers import PEERS, Peer
from studies.performance.peers.contract import ABSENT
from studies.performance.row import Row, lines
from workbench.study.processor import machine
from workbench.validation.refusals import nearest

Measure = Callable[[Effort], Row]

EQUAL = ((1e-3, 20.0), (3e-5, 10.0))  # the error of the RMSE, and how many times as fast we must be


def measures(peers: Sequence[Peer] = PEERS) -> dict[str, Measure]:
    """All rows by name, in the order of the table."""
    return {
        **{peer.name: partial(_of_peer, peer) for peer in peers},
        **{cvodes_name(target): partial(cvodes_row, target, bar) for target, bar in EQUAL},
        **{target.name: target.row for target in TARGETS},
    }


def _of_peer(peer: Peer, effort: Effort) -> Row:
    if not peer.installed:
        return Row(peer.name, peer.bar, note=ABSENT)
    try:
        return peer_row(peer, effort)
    except ImportError as error:
        return Row(peer.name, peer.bar, note=f"not measured, it cannot be imported: {error}")


def measured(
    effort: Effort, only: str = "", say: Callable[[str], None] = lambda said: None, peers: Sequence[Peer] = PEERS
) -> Iterator[Row]:
    """The rows whose names have `only` in them, one after the other as they are measured.

    Raises
    ------
    LookupError
        If there is none; the message names the nearest, or all.
    """
    known = measures(peers)
    chosen = {name: measure for name, measure in known.items() if only.lower() in name.lower()}
    if not chosen:
        hint = nearest(only, known) or f" They are: {'; '.join(known)}."
        raise LookupError(f"There is no '{only}' in the names of the rows.{hint}")
    for place, (name, measure) in enumerate(chosen.items(), start=1):
        say(f"{place} of {len(chosen)}: {name}")
        yield measure(effort)


def as_json(rows: Sequence[Row]) -> str:
    """The table for a machine."""
    return json.dumps({"rows": [row.as_json() for row in rows], "machine": machine()}, indent=1)


def as_text(rows: Sequence[Row]) -> str:
    """The table for a screen, with how many bars were reached at its end."""
    verdicts = [row.reached for row in rows]
    verdict = f"{verdicts.count(True)} reached, {verdicts.count(False)} MISSED, {verdicts.count(None)} not measured"
    about = ", ".join(f"{name} {value}" if name != "cpu" else value for name, value in machine().items())
    return "\n".join([*lines(rows), "", f"{verdict}; runs of W per CPU-second of one core, medians.", about])
