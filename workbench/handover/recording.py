"""Recording: what the computer of a loop is handed at its instants, and what it does, in the portable arithmetic.

A machine that is handed the same readings and references, and gives the same commands up to some instant, is in the
same loop up to there: plant, noise and references then have the same bits, and so have the next readings.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, SampledSystem, StepMap
from workbench.core.sampled_law import SampledLaw
from workbench.core.validation import refusals
from workbench.core.validation.refusals import Array, Integers
from workbench.core.validation.signatures import check_arguments
from workbench.engine.arithmetic import PORTABLE, march_of
from workbench.engine.batch import table_of
from workbench.engine.job import Job
from workbench.handover.export_folder import write_files
from workbench.handover.memory_digest import Floats, Reals, Words, digest
from workbench.handover.replay_bounds import afford_periods
from workbench.handover.vector_files import signals_of, vector_files

BLOCK = 10_000  # periods at a time, so that a million need little memory


@dataclass(frozen=True, eq=False)
class Recording:
    """The instants k = 0, ..., N - 1 of a loop, with the bits that its law was handed and sent.

    `rows["y.q"]` is the reading q at each instant as the law got it, `rows["r.q"]` the reference, and `rows["u.v"]` the
    command that acts from the instant on. The memory is kept as a digest, and made again where it is asked for.

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
    y: Reals
    r: Reals
    u: Reals
    digests: Words
    starts: Array
    job: Job
    rows: Reals | None = None

    def __repr__(self) -> str:
        return f"<Recording of '{self.law.name}': {self.periods:,} periods of {self.law.period:g} s>"

    @property
    def periods(self) -> int:
        """The number of instants."""
        return len(self.u)

    @property
    def signals(self) -> Layout:
        """The readings, references and commands below 'y.', 'r.' and 'u.'."""
        return signals_of(self.law)

    @property
    def t(self) -> Array:
        """The instants k period in s, (N,)."""
        return np.asarray(np.arange(self.periods) * self.law.period, dtype=float)

    def __getitem__(self, name: str) -> Array:
        """A signal by its name, (N,) or (N, *shape)."""
        columns = self.signals.unpack(np.concatenate([self.y, self.r, self.u], axis=1))
        return columns[refusals.known_name(name, columns, "signals of this recording")]

    @check_arguments
    def write(self, folder: str | Path, form: str = "csv", name: str | None = None) -> list[Path]:
        """Write the signals to a folder as test vectors of the law in another machine; the paths of the files.

        Parameters
        ----------
        form
            "csv" is NAME_vectors.csv, a row an instant, whose numbers are doubles to the last bit; "c" is
            NAME_vectors.h with the same numbers as arrays, and NAME_check.c, a program that hands them to NAME_step of
            the exported law and compares its commands bit by bit.
        name
            The prefix of the law in C; that of the law unless given.

        Raises
        ------
        ValueError
            If the form is none of these, the name cannot be one of C, or a file of somebody else is in the way.
        """
        files = vector_files(self.law, (self.y, self.r, self.u), form, name)
        target = write_files(folder, files)
        return [target / path for path in files]

    @property
    def inputs(self) -> Array:
        """Readings and references side by side, (N, ny + nr)."""
        return np.concatenate([self.y, self.r], axis=1)

    @check_arguments
    def until(self, periods: int) -> Recording:
        """Its first periods."""
        periods = refusals.whole("until(periods=...)", periods, most=self.periods)
        parts = {name: getattr(self, name)[:periods] for name in ("y", "r", "u", "digests")}
        return replace(self, **parts)

    @check_arguments
    def memory(self, first: int, last: int) -> Reals:
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


@check_arguments
def record(
    sampled_loop: SampledSystem,
    law: SampledLaw | None = None,
    periods: int | None = None,
    *,
    until: float | None = None,
    substeps: int = 1,
    p: Array | None = None,
    seed: int = 0,
) -> Recording:
    """The readings, references and commands of the law in its loop, bit by bit, from the start of the loop.

    A signal of a run, `runs["omega"]`, is computed again from the states, and may differ from the recorded signal in
    the last digit. So test vectors for an exported law must come from a recording.

    Parameters
    ----------
    law
        The law, as `sampled_loop.law(...)` gives it; by default `sampled_loop.law()`.
    periods, until
        The number of periods, or their total length in s: one of the two.
    substeps
        The number of Runge-Kutta steps of the plant in a period, on which the readings depend.
    p
        The parameters of the loop, (np,) or (1, np); by default its own.
    seed
        The seed of the noise; the noise is that of run 0.

    Raises
    ------
    ValueError
        If the law is not one of this loop, neither length is given, `periods` is less than 1, `until` is no multiple of
        the period, or the run diverges.

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> pid = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0)
    >>> loop = wb.ClosedLoop(motor, controller=pid, reference=wb.Step("omega", "rad/s", 1.0)).digital(0.01)
    >>> rows = wb.record(loop, until=1.0)
    >>> rows.signals.names, rows["u.v"].shape
    (('y.omega', 'r.omega', 'u.v'), (100,))
    """
    sampled_loop = refusals.require("record(sampled_loop=...)", sampled_loop, SampledSystem)
    law, periods = sampled_loop.law() if law is None else law, _periods(sampled_loop, periods, until)
    step = _taken(sampled_loop, law, substeps)
    step.flow.refuse_beyond("record(periods=...)", periods * step.h)
    afford_periods("record(periods=...)", law, periods, step.operations)
    rows = table_of("record(p=...)", step.parameters, p)
    if len(rows) != 1:
        raise ValueError(f"`record(p=...)` takes the parameters of one run; got {len(rows)} rows.")
    seed = refusals.seed("record(seed=...)", seed)
    job = Job(step, rows, 1, seed, np.zeros(1, dtype=np.int64), arithmetic=PORTABLE)
    return _recorded(law, job, periods)


def _recorded(law: SampledLaw, job: Job, periods: int) -> Recording:
    """The rows of a job whose states are those of the loop and what its computer is handed."""
    ports, step = (("y.", law.readings), ("r.", law.references), ("hold.", law.commands)), job.step
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


@check_arguments
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
    z, u = [_floats(law.memory.default)], list[Floats]()
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


def _periods(sampled: SampledSystem, periods: int | None, until: float | None) -> int:
    """The number of periods, from one of the two."""
    if (periods is None) == (until is None):
        raise ValueError(
            "`record(periods=..., until=...)` takes the number of periods or their length in s, one of the two; got "
            f"{'none' if until is None else 'both'}."
        )
    if until is None:
        return refusals.whole("record(periods=...)", periods)
    return refusals.multiple(
        "record(until=...)", refusals.seconds("record(until=...)", until), sampled.period, "the period"
    )


def _floats(numbers: Reals) -> Floats:
    return numbers.astype(np.float32)


def _taken(sampled: SampledSystem, law: SampledLaw, substeps: int) -> StepMap:
    """The step of a loop with what its computer is handed as further states."""
    layout = Layout(tuple(Entry(name, np.zeros(part.numel())) for name, part in sampled.computer_inputs.items()))
    parts = [ca.vec(part) for part in sampled.computer_inputs.values()]
    step = sampled.step(substeps).with_memory(layout, ca.SX.sym("taken", layout.size), ca.vertcat(*parts, ca.SX(0, 1)))
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
            state, k = job.step.states.labels[int(np.argmin(np.isfinite(rows[at])))], begin + at - 1
            raise ValueError(
                f"`record(...)` needs a run that stays finite: '{job.step.flow.name}' diverges in period {k}, in "
                f"'{state}' first. Take at most {k} periods, or a loop that is stable."
            )
        x = rows[-1]
        yield rows


def _marched(job: Job, x: Array, begin: int, periods: int) -> Array:
    job, rows = replace(job, begin=begin), np.empty((1, periods + 1, len(x)))
    rows[0, 0] = x
    if periods:
        march_of(job)(job, rows, lambda share: None)
    return np.asarray(rows[0])
