"""Recording: what the computer of a loop is handed at its instants, and what it does, in the portable arithmetic.

A machine that is handed the same readings and references, and gives the same commands up to some instant, is in the
same loop up to there: plant, noise and references then have the same bits, and so have the next readings.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np
import numpy.typing as npt

from workbench.core import Entry, Layout, Sampled, Step
from workbench.core.sampled_law import SampledLaw
from workbench.handover.replay_bounds import afford_periods
from workbench.simulate.arithmetic import PORTABLE, march_of
from workbench.simulate.batch import table_of
from workbench.simulate.job import Job
from workbench.validation import refusals
from workbench.validation.refusals import Array, Integers
from workbench.validation.signatures import door

Words = npt.NDArray[np.uint64]

BLOCK = 10_000  # periods at a time, so that a million need little memory
BASIS, PRIME = 0xCBF29CE484222325, 0x100000001B3  # of FNV-1a with 64 bits


@dataclass(frozen=True, eq=False)
class Recording:
    """The instants k = 0, ..., N - 1 of a loop; the memory is kept as a digest, and made again where it is asked for.

    Parameters
    ----------
    y, r, u
        Readings, references and commands, (N, ny), (N, nr) and (N, nu).
    digests
        FNV-1a of the memory behind each instant, (N,).
    starts
        The states of the loop before every block of instants.
    rows
        The memory before each instant and behind the last one, (N + 1, nz), where it cannot be made again.
    """

    law: SampledLaw
    y: Array
    r: Array
    u: Array
    digests: Words
    starts: Array
    job: Job
    rows: Array | None = None

    def __repr__(self) -> str:
        return f"<Recording of '{self.law.name}': {self.periods:,} periods of {self.law.period:g} s>"

    @property
    def periods(self) -> int:
        """The number of instants."""
        return len(self.u)

    @property
    def inputs(self) -> Array:
        """Readings and references side by side, (N, ny + nr)."""
        return np.concatenate([self.y, self.r], axis=1)

    @door
    def until(self, periods: int) -> Recording:
        """Its first periods."""
        periods = refusals.whole("until(periods=...)", periods, most=self.periods)
        parts = {name: getattr(self, name)[:periods] for name in ("y", "r", "u", "digests")}
        return replace(self, **parts)

    @door
    def memory(self, first: int, last: int) -> Array:
        """The memory (last - first + 1, nz) before instant `first`, before the next one, ..., before `last`.

        Raises
        ------
        ValueError
            If these are no instants of it in this order.
        """
        if not 0 <= first <= last <= self.periods:
            raise ValueError(
                f"`memory(first, last)` takes instants in this order from 0 to {self.periods}; got {first} and {last}."
            )
        if self.rows is not None:
            return self.rows[first : last + 1]
        block = min(first // BLOCK, len(self.starts) - 1)
        x = _marched(self.job, self.starts[block], block * BLOCK, last - block * BLOCK)
        places = _places(self.job.step.states, self.law.memory.names, "")
        return np.asarray(x[first - block * BLOCK :, places])


@door
def record(
    sampled: Sampled, law: SampledLaw, periods: int, *, substeps: int = 1, p: Array | None = None, seed: int = 0
) -> Recording:
    """The recording of so many periods of a loop from its start, with the plant in `substeps` Runge-Kutta steps each.

    Parameters
    ----------
    law
        As `sampled.law(...)` gives it.
    p
        (np,) or (1, np) of the loop.
    seed
        Of the noise, which is that of run 0.

    Raises
    ------
    ValueError
        If the law is none of this loop, the number of periods is none from 1 on, or the run diverges.

    Examples
    --------
    >>> from workbench.handover.recording import record
    >>> motor = wb.DCMotor()
    >>> pid = wb.PID2(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0)
    >>> loop = wb.ClosedLoop(motor, controller=pid, reference=wb.Step("omega", "rad/s", 1.0)).digital(0.01)
    >>> rows = record(loop, loop.law(), 100)
    >>> rows.y.shape, rows.u.shape
    ((100, 1), (100, 1))
    """
    periods = refusals.whole("record(periods=...)", periods)
    step = _taken(sampled, law, substeps)
    step.flow.refuse_beyond("record(periods=...)", periods * step.h)
    afford_periods("record(periods=...)", law, periods, step.operations)
    rows = table_of("record(p=...)", step.parameters, p)
    if len(rows) != 1:
        raise ValueError(f"`record(p=...)` takes the parameters of one run; got {len(rows)} rows.")
    seed = refusals.seed("record(seed=...)", seed)
    job = Job(step, rows, 1, seed, np.zeros(1, dtype=np.int64), arithmetic=PORTABLE)
    ports = (("y.", law.readings), ("r.", law.references), ("hold.", law.commands))
    columns = [_places(step.states, port.names, prefix) for prefix, port in ports]
    kept = _places(step.states, law.memory.names, "")
    shares: list[tuple[Array, ...]] = []
    digests, starts = list[Words](), list[Array]()
    for x in _blocks(job, periods):
        starts.append(x[0].copy())
        shares.append(tuple(x[1:, places] for places in columns))
        digests.append(digest(x[1:, kept]))
    y, r, u = (np.concatenate(parts) for parts in zip(*shares, strict=True))
    return Recording(law, y, r, u, np.concatenate(digests), np.stack(starts), job)


@door
def single(recording: Recording) -> Recording:
    """The same readings and references, rounded, and what the law makes of them in single precision, as floats.

    Raises
    ------
    ValueError
        If a command or a number of the memory is not finite there.
    """
    from workbench.handover.single.single_precision import single_precision

    law = recording.law
    y, r = (_floats(part) for part in (recording.y, recording.r))
    z, u = [_floats(law.memory.default)], list[Any]()
    for k in range(recording.periods):
        new = single_precision(law, k, z[-1:], y[k : k + 1], r[k : k + 1])
        if not (np.isfinite(new.z_next).all() and np.isfinite(new.u).all()):
            raise ValueError(
                f"`single(recording)` needs numbers that stay finite: '{law.name}' makes one that is not in period {k}."
            )
        z.append(new.z_next[0])
        u.append(new.u[0])
    rows, commands = np.stack(z), np.stack(u)
    return replace(recording, y=y, r=r, u=commands, digests=digest(rows[1:]), rows=rows)


def _floats(numbers: Array) -> Any:
    return numbers.astype(np.float32)


def digest(rows: Array) -> Words:
    """FNV-1a with 64 bits of the bytes of each row, in the order of this processor's memory from its least byte on.

    Every NaN counts as the one of the sign 0 and the first bit of the fraction.
    """
    rows = np.where(np.isnan(rows), rows.dtype.type(np.nan), rows)
    octets = np.ascontiguousarray(rows, dtype=rows.dtype.newbyteorder("<")).view(np.uint8)
    octets = np.ascontiguousarray(octets.reshape(len(rows), -1).T)
    total = np.full(len(rows), BASIS, dtype=np.uint64)
    for column in octets:
        total = (total ^ column) * np.uint64(PRIME)
    return total


def _taken(sampled: Sampled, law: SampledLaw, substeps: int) -> Step:
    """The step of a loop with what its computer is handed as further states."""
    layout = Layout(tuple(Entry(name, np.zeros(part.numel())) for name, part in sampled.taken.items()))
    parts = [ca.vec(part) for part in sampled.taken.values()]
    step = sampled.step(substeps).extended(layout, ca.SX.sym("taken", layout.size), ca.vertcat(*parts, ca.SX(0, 1)))
    needs = [f"y.{name}" for name in law.readings.names] + [f"r.{name}" for name in law.references.names]
    needs += [f"hold.{name}" for name in law.commands.names] + [*law.memory.names]
    lacking = [name for name in needs if name not in step.states.names]
    if lacking or law.period != sampled.period:
        raise ValueError(
            f"`record(sampled, law, ...)` takes a law that this loop gave by `sampled.law(...)`; '{law.name}', every "
            f"{law.period:g} s, has {', '.join(map(repr, lacking)) or 'another period'}, which "
            f"'{sampled.name}', every {sampled.period:g} s, lacks."
        )
    return step


def _places(states: Layout, names: tuple[str, ...], prefix: str) -> Integers:
    slices = [states.slice(prefix + name) for name in names]
    every = np.arange(states.size)
    return np.concatenate([every[part] for part in slices] + [np.zeros(0, dtype=np.int64)])


def _blocks(job: Job, periods: int) -> Iterator[Array]:
    """The states (1 + periods of the block, nx) block by block."""
    x = job.step.states.default
    for begin in range(0, periods, BLOCK):
        rows = _marched(job, x, begin, min(BLOCK, periods - begin))
        finite = np.isfinite(rows).all(axis=1)
        if not finite.all():
            at = int(np.argmin(finite))
            state = job.step.states.labels[int(np.argmin(np.isfinite(rows[at])))]
            k = begin + at - 1
            raise ValueError(
                f"`record(...)` needs a run that stays finite: '{job.step.flow.name}' diverges in period {k}, in "
                f"'{state}' first. Take at most {k} periods, or a loop that is stable."
            )
        x = rows[-1]
        yield rows


def _marched(job: Job, x: Array, begin: int, periods: int) -> Array:
    job = replace(job, begin=begin)
    rows = np.empty((1, periods + 1, len(x)))
    rows[0, 0] = x
    if periods:
        march_of(job)(job, rows, lambda share: None)
    return np.asarray(rows[0])
