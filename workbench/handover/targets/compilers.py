"""Programs of an operating system: a law compiled for this processor, or for 64-bit ARM under QEMU."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from workbench.core.validation.refusals import Array
from workbench.handover.c99.c_files import CCode
from workbench.handover.recording import Recording
from workbench.handover.targets import harness
from workbench.handover.targets.binary_size import code_and_data, deepest
from workbench.handover.targets.external_programs import TargetError, missing_programs, run, there
from workbench.handover.targets.harness import TargetAnswers
from workbench.handover.targets.target import AbstractTarget, TargetCost

STANDARD = ("-std=c99", "-Wall", "-Wextra")
COUNTED_PERIODS = 1_000  # periods under a tool that counts instructions
LOGGED_PERIODS = 100  # periods in a log that has a line for each instruction
PROGRAM, COUNTS = "law", "counts"


@dataclass(frozen=True)
class CompiledProgram(AbstractTarget):
    """A law that a compiler makes a program of this operating system, which an emulator may run.

    No option tells of fused products: the source itself forbids them.
    """

    name: str
    compiler: str
    options: tuple[str, ...]  # the level of optimisation among them
    emulator: str = ""
    tools: str = ""  # the prefix of `size`

    @property
    def programs(self) -> tuple[str, ...]:
        """Compiler and emulator."""
        return (self.compiler, *([self.emulator] if self.emulator else ()))

    def answers(self, code: CCode, recording: Recording, folder: Path, seconds: float) -> TargetAnswers:
        """The answers of the program."""
        write_files({**harness.program(code), harness.PLATFORM: harness.hosted_platform()}, folder)
        sources = [harness.MAIN, harness.PLATFORM, f"{code.name}.c"]
        static = ["-static"] if self.emulator else []
        run([self.compiler, *STANDARD, *self.options, *static, *sources, "-o", PROGRAM], folder, seconds)
        return self._run(code, recording, folder, seconds)

    def _run(self, code: CCode, recording: Recording, folder: Path, seconds: float) -> TargetAnswers:
        harness.write_inputs(code, recording.inputs, folder)
        run([*([self.emulator] if self.emulator else ()), f"./{PROGRAM}"], folder, seconds)
        return harness.read_answers(code, recording.periods, folder)

    def figures(self, code: CCode, recording: Recording, folder: Path, seconds: float) -> TargetCost:
        """Instructions as Callgrind counts them, or QEMU's log of steps; stack as GCC tells it; sizes of the object."""
        stack, sizes, smallest = sizes_of(code, folder, self.compiler, self.options, f"{self.tools}size", seconds)
        rows = recording.inputs[:COUNTED_PERIODS]
        instructions, doubt = None, "" if self.emulator else missing_programs(["valgrind"])
        try:
            if self.emulator:
                instructions = self._steps(code, rows[:LOGGED_PERIODS], folder, seconds)
            elif not doubt:
                instructions = _calls(code, rows, folder, seconds)
        except TargetError as error:
            doubt = str(error)
        doubt = doubt and f"instructions were not counted: {doubt}"
        return TargetCost(instructions, stack=stack, code=sizes[0], data=sizes[1], smallest=smallest, doubt=doubt)

    def _steps(self, code: CCode, rows: Array, folder: Path, seconds: float) -> float:
        """The instructions in the law's own code, each a line of the emulator's log, without those of `init`."""
        symbols = [line.split() for line in run([f"{self.tools}nm", "-S", PROGRAM], folder, seconds).splitlines()]
        own = [(int(words[0], 16), int(words[1], 16)) for words in symbols if words[-1].startswith(f"{code.name}_")]
        if len(own) == 0:
            raise TargetError(f"{self.tools}nm lists no function of the law")
        begin, end = min(place for place, _ in own), max(place + size for place, size in own)
        new = "one-insn-per-tb" in run([self.emulator, "-help"], folder, seconds)  # its name since QEMU 8.1
        log = ["-d", "exec,nochain", "-dfilter", f"{begin:#x}..{end - 1:#x}", "-D", COUNTS]
        lines = []
        for count in (0, len(rows)):
            harness.write_inputs(code, rows[:count], folder)
            run([self.emulator, "-one-insn-per-tb" if new else "-singlestep", *log, f"./{PROGRAM}"], folder, seconds)
            with (folder / COUNTS).open("rb") as file:
                lines.append(sum(line.startswith(b"Trace") for line in file))
        return (lines[1] - lines[0]) / len(rows)


def _calls(code: CCode, rows: Array, folder: Path, seconds: float) -> float:
    """The instructions of a call, its own functions among them, as Callgrind counts them."""
    harness.write_inputs(code, rows, folder)
    options = ["--tool=callgrind", f"--toggle-collect={code.name}_step", f"--callgrind-out-file={COUNTS}"]
    run(["valgrind", *options, f"./{PROGRAM}"], folder, seconds)
    lines = (folder / COUNTS).read_text(encoding="utf-8", errors="replace").splitlines()
    totals = [line.split()[1] for line in lines if line.startswith("totals:")]
    if not totals:
        raise TargetError("valgrind has counted no instructions")
    return int(totals[0]) / len(rows)


def sizes_of(
    code: CCode, folder: Path, compiler: str, options: tuple[str, ...], size: str, seconds: float
) -> tuple[int | None, tuple[int | None, int | None], int | None]:
    """The stack of the step, the bytes of code and data of the law's object, and those of its code at -Os."""
    source, object_file, stack = f"{code.name}.c", f"{code.name}.o", None
    graph = [] if compiler == "clang" else ["-fcallgraph-info=su"]
    run([compiler, *STANDARD, *options, *graph, "-c", source, "-o", object_file], folder, seconds)
    if graph and (folder / f"{code.name}.ci").is_file():  # which is not so where code is made at the end, by -flto
        stack = deepest(folder / f"{code.name}.ci", f"{code.name}_step")
    if not there(size):
        return stack, (None, None), None
    sizes = code_and_data(run([size, object_file], folder, seconds))
    run([compiler, *STANDARD, *options, "-Os", "-c", source, "-o", "small.o"], folder, seconds)
    return stack, sizes, code_and_data(run([size, "small.o"], folder, seconds))[0]


def write_files(texts: dict[str, str], folder: Path) -> None:
    """Write texts to files of a folder."""
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")


LEVELS = ("-O0", "-O1", "-O2", "-O3")
HERE = tuple(
    CompiledProgram(f"{compiler} {level}", compiler, (level,)) for compiler in ("gcc", "clang") for level in LEVELS
)
ARM_64 = CompiledProgram(
    "64-bit ARM, gcc -O2, QEMU", "aarch64-linux-gnu-gcc", ("-O2",), "qemu-aarch64", "aarch64-linux-gnu-"
)
