"""Replays: a law on several machines over the inputs of one recording, compared bit by bit."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass

from workbench.core import SampledLaw, SampledSystem
from workbench.core.validation.refusals import known_name, seconds, whole
from workbench.core.validation.signatures import check_arguments
from workbench.handover.bit_comparison import CLOCKS, LIMIT, PeriodShare, TargetResult, compare, fits
from workbench.handover.c99.c_files import CCode, c_code
from workbench.handover.recording import Recording, record, single
from workbench.handover.replay_bounds import afford_periods
from workbench.handover.targets import TARGETS, USUAL, AbstractTarget

__all__ = ["CLOCKS", "PeriodShare", "Replay", "TargetResult", "compare", "fits", "replay"]

COLUMNS = ("target", "periods", "bits", "differing", "memories", "flags", "first", "reason")  # of a row
FIELDS = {"differing": "differing_bits"}  # of a result, where a column has another name
Cell = str | float | None  # of a row; None for what is not known


@dataclass(frozen=True, eq=False)
class Replay:
    """The results of all targets for one law, in the portable arithmetic as the reference."""

    code: CCode
    recording: Recording
    results: tuple[TargetResult, ...]

    @property
    def equal(self) -> bool:
        """True if no target that ran differs, and one ran at least."""
        ran = [result for result in self.results if result.ran]
        return bool(ran) and all(result.equal for result in ran)

    @property
    def counts(self) -> tuple[str, ...]:
        """A sentence for each target that counted instructions: of a period in the mean and at most, and the stack."""
        return tuple(_count_words(result) for result in self.results if result.figures.instructions)

    HEADS = ("target", "periods", "bits", "differing", "memories", "instructions", "most", "stack", "code", "data")

    def __str__(self) -> str:
        return self.text()

    def __repr__(self) -> str:
        return (
            f"<Replay of '{self.code.name}' on {len(self.results)} targets: {'equal' if self.equal else 'different'}>"
        )

    def rows(self) -> list[dict[str, Cell]]:
        """The results as rows of a table, None for what is not known."""
        rows = []
        for result in self.results:
            named = {name: getattr(result, FIELDS.get(name, name)) for name in COLUMNS}
            share = {"share": result.fit.share if result.fit else None}
            rows.append(named | asdict(result.figures) | share)
        return rows

    def text(self) -> str:
        """The results for a terminal."""
        law = self.recording.law
        arithmetic = "the portable arithmetic" if self.code.real == "double" else "single precision"
        lines = [f"{law.name}, every {law.period:g} s: {self.recording.periods:,} periods, in {arithmetic}"]
        cells = [self.HEADS, *(_cells(row, self.HEADS) for row in self.rows() if not row["reason"])]
        widths = [max(len(row[i]) for row in cells) for i in range(len(self.HEADS))]
        for row in cells:
            words = [word.rjust(width) for word, width in zip(row[1:], widths[1:], strict=True)]
            lines.append("  ".join([row[0].ljust(widths[0]), *words]))
        for result in self.results:
            sentences = [result.first, str(result.fit) if result.fit else "", result.figures.doubt]
            sentences.append(f"not run: {result.reason}" * bool(result.reason))
            lines += [f"{result.target}: {sentence}." for sentence in sentences if sentence]
        lines.append(
            "memories: number of periods whose memory differs; most: the longest period; stack, code and data in bytes"
        )
        return "\n".join(lines)


def _count_words(result: TargetResult) -> str:
    """The count of instructions of a target in a sentence."""
    own = result.figures
    most = f", {own.most:,} at most" if own.most else ""
    stack = f"; stack of a call: {own.stack:,} bytes" if own.stack else ""
    return f"Instructions of a period on {result.target}: {own.instructions or 0.0:,.0f} in the mean{most}{stack}."


def _cells(row: Mapping[str, Cell], heads: Sequence[str]) -> tuple[str, ...]:
    """The words of a row; '-' for what is not known."""
    values = [row[head] for head in heads]
    return tuple(
        "-" if value is None else value if isinstance(value, str) else f"{float(value):,.0f}" for value in values
    )


@check_arguments
def replay(
    sampled_loop: SampledSystem,
    *,
    name: str | None = None,
    periods: int = 10_000,
    targets: Sequence[str | AbstractTarget] | None = None,
    substeps: int = 1,
    reference: str = "input",
    truths: tuple[str, ...] = (),
    seed: int = 0,
    precision: str = "double",
    timeout: float = LIMIT,
    progress: Callable[[str], None] | None = None,
) -> Replay:
    """Run the law of a loop on several machines, with the inputs that it gets in the portable arithmetic.

    Commands are compared bit by bit, and after each period a digest of the states of the law. Each target keeps its own
    states of the law from period to period, and gets the recorded readings. As long as its commands are equal to the
    recorded ones, these are the readings that it would get in closed loop.

    Parameters
    ----------
    name, periods, substeps
        The prefix of the C code; the number of periods; the number of Runge-Kutta steps of the plant in a period.
    targets
        Names of `wb.handover.TARGETS`, or targets of your own; by default all but the one whose library has a fault.
    reference, truths
        As of `SampledSystem.law`: "input" or "built in", and names of signals that no instrument gives.
    seed, precision, timeout
        The seed of the noise; "double", or "single" for the law alone; the time in s for one program of a target.
    progress
        Called with the name of each target before it runs; one that cannot run reports it.

    Raises
    ------
    ValueError, LookupError
        If the loop diverges, its law uses a truth that is not named, or a name or a number does not fit.

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0)
    >>> loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    >>> wb.replay(loop.digital(1e-3), periods=100, targets=["numpy"]).equal
    True
    """
    timeout = seconds("replay(timeout=...)", timeout)
    chosen = [_target(target) for target in (USUAL if targets is None else targets)]
    code = c_code(_affordable(sampled_loop.law(reference, truths), periods), name, precision=precision)
    recording = record(sampled_loop, code.law, periods, substeps=substeps, seed=seed)
    recording = single(recording) if code.real == "float" else recording
    results = []
    for target in chosen:
        if progress is not None:
            progress(target.name)
        results.append(compare(target, code, recording, timeout))
    return Replay(code, recording, tuple(results))


def _affordable(law: SampledLaw, periods: int) -> SampledLaw:
    """The law, if `periods` of its periods can be replayed."""
    call = "replay(periods=...)"
    afford_periods(call, law, whole(call, periods), law.step.operations)
    return law


def _target(target: str | AbstractTarget) -> AbstractTarget:
    return TARGETS[known_name(target, TARGETS, "targets")] if isinstance(target, str) else target
