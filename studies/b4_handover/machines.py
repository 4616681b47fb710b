"""The machines of b4: each law replayed on every target that is installed here, and the share of a period it takes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import workbench as wb
from studies.b4_handover.findings import FITS, START_WORDS, allowed_period
from studies.b4_handover.loops import FAR_START, NEAR_START, PERIODS, HandoverLoop, by_key, handover_loops
from studies.b4_handover.margins import BOTH
from studies.b4_handover.operations import operations_by_target
from studies.paper.card import PROPOSED_LAW

M4F = "cortex-m4f"
SINGLY = ("gcc-O2", "clang-O2", "arm64", M4F, "cortex-m7")  # in single precision
FEW = 1000  # periods of a replay in single precision, whose reference goes period by period
BOARDS = wb.handover.CLOCKS  # Hz, of the microcontrollers
SINGLE_BOARDS = (M4F, "cortex-m7")
CYCLES = (2, 4)  # an instruction, in place of one

TargetResults = tuple[wb.handover.TargetResult, ...]


def replay_works() -> tuple[wb.Work, wb.Work]:
    """The replays of all loops, in double and in single precision."""
    keys = tuple(one.key for one in handover_loops())
    return wb.Work("replays", in_doubles, keys, seconds=30.0), wb.Work("single_replays", in_singles, keys, seconds=10.0)


def in_doubles(key: str) -> TargetResults:
    """The replay of a loop on all targets, the library with a known fault among them."""
    return wb.replay(by_key(key).digital(), name=key, periods=PERIODS, targets=tuple(wb.handover.TARGETS)).results


def in_singles(key: str) -> TargetResults:
    """The replay of a loop's law in single precision, on the readings of the loop in double precision."""
    return wb.replay(by_key(key).digital(), name=key, periods=FEW, targets=SINGLY, precision="single").results


def replays(results: wb.Results, work: str = "replays") -> Mapping[str, TargetResults]:
    """The results of all targets by the name of the loop."""
    return dict(zip((one.name for one in handover_loops()), results.work(work), strict=True))


def by_target(results: wb.Results) -> dict[str, dict[str, wb.handover.TargetResult]]:
    """The results of each target, by target and law."""
    by_law = replays(results)
    names = [one.target for one in next(iter(by_law.values()))]
    return {name: {law: next(r for r in each if r.target == name) for law, each in by_law.items()} for name in names}


def fit_of(
    results: wb.Results, one: HandoverLoop, key: str, start: str = NEAR_START, precision: str = "double"
) -> wb.handover.PeriodShare | None:
    """The count of a law at the clock of a microcontroller, on the longest period allowed from a start."""
    work = "replays" if precision == "double" else "single_replays"
    each = replays(results, work)[one.name]
    count = next((r.figures.instructions for r in each if r.target == wb.handover.TARGETS[key].name), None)
    return wb.handover.fits(count, allowed_period(results, one, start), wb.handover.CLOCKS[key]) if count else None


def machine_findings(results: wb.Results) -> tuple[wb.Finding, ...]:
    """The findings of the replays."""
    law = next(one for one in handover_loops() if one.name == PROPOSED_LAW)
    near, far = (fit_of(results, law, M4F, start) for start in BOTH)
    return (bits_finding(results), *((fit_finding(results, near, far),) if near and far else ()))


def differing_laws(results: wb.Results, work: str = "replays", laws: tuple[str, ...] = ()) -> dict[str, list[str]]:
    """The targets that ran, each with the laws of which a bit differs on that target."""
    targets: dict[str, list[str]] = {}
    for law, each in replays(results, work).items():
        for result in each:
            if result.ran and (not laws or law in laws):
                targets.setdefault(without_compiler(result.target), []).extend([law] * (not result.equal))
    return targets


def differing_words(targets: Mapping[str, Sequence[str]]) -> str:
    """The targets on which a bit differs, in a sentence."""
    return with_verb([name for name, laws in targets.items() if laws], "differs", "differ", "no target differs")


def with_verb(names: Sequence[str], one: str, several: str, nobody: str) -> str:
    """Some names with their verb, or the words for none of them."""
    return f"{wb.document.join_names(names)} {several if len(names) > 1 else one}" if names else nobody


def bits_finding(results: wb.Results) -> wb.Finding:
    """The targets on which each law computes the bits of the reference implementation, the portable arithmetic."""
    by_law = replays(results)
    targets = differing_laws(results)
    other = {name: laws for name, laws in targets.items() if laws}
    equal = len(targets) - len(other)
    each = [result for of_law in by_law.values() for result in of_law]
    missing = sorted({without_compiler(one.target) for one in each} - set(targets))
    not_run = f"Not run: {wb.document.join_names(missing)}." if missing else "Every target was run."
    bits = sum(one.bits for one in each if one.ran)
    unlike = "; ".join(
        f"on the {name}, {len(laws)} of {len(by_law)} laws {'differs' if len(laws) == 1 else 'differ'} "
        f"({wb.document.join_names(laws)})"
        for name, laws in other.items()
    )
    alone = operations_by_target(results)
    variations = [wb.Variation(f"{law} alone", differing_words(differing_laws(results, laws=(law,)))) for law in by_law]
    variations.append(
        wb.Variation("laws in single precision", differing_words(differing_laws(results, "single_replays")))
    )
    variations.append(
        wb.Variation(
            "single operations in place of laws",
            differing_words({without_compiler(name): ["operations"] * bool(bad) for name, bad in alone.items()}),
        )
    )
    return wb.Finding(
        "same_bits",
        f"All {len(by_law)} laws compute the same bits as the reference implementation (IEEE 754) on {equal} of "
        f"{len(targets)} targets"
        f"{'; ' + unlike if unlike else ''}.",
        f"{bits:,} bits of commands and memories were compared. {not_run} Sines, cosines, exponentials and powers "
        "are functions of our own in each law's C code. GCC's software double-precision library rounds some "
        "differences wrongly. In the target 'with mended sums', a routine of our own replaces it for these; in 'with "
        "libgcc alone' it does not.",
        statistic="Bits of the commands, and of the memory after each period. If all commands agree, a replay equals "
        "the closed loop with that machine.",
        sample=f"{PERIODS:,} periods of each law on each target, from the near start.",
        information="Each law's C code in double precision, or its graph, with the same readings and references.",
        assumptions="The targets: those installed here. Our own functions for sine, cosine and others; our own sum "
        "on one target.",
        answer=differing_words(targets),
        variations=tuple(variations),
        limitations="Other compilers, options that allow a compiler to fuse or reorder, and other libraries.",
        is_decided=bool(targets),
    )


def unfit(results: wb.Results, key: str, start: str, precision: str = "double", cycles: float = 1.0) -> tuple[str, str]:
    """The laws that do not fit a microcontroller at a number of cycles per instruction, with the largest share."""
    fitted = {one.name: fit for one in handover_loops() if (fit := fit_of(results, one, key, start, precision))}
    most = max(fitted, key=lambda name: fitted[name].share)
    return (
        with_verb(
            [name for name, fit in fitted.items() if cycles * fit.share > 1],
            "does not fit",
            "do not fit",
            "all laws fit",
        ),
        f"{most} {wb.document.percent(cycles * fitted[most].share)}",
    )


def fit_finding(results: wb.Results, near: wb.handover.PeriodShare, far: wb.handover.PeriodShare) -> wb.Finding:
    """The count of instructions and the longest period, by start; `near` and `far` are for AOSMC-RGS in doubles."""
    law = next(one for one in handover_loops() if one.name == PROPOSED_LAW)
    single = fit_of(results, law, M4F, FAR_START, "single")
    variations = [
        wb.Variation(
            f"{without_compiler(wb.handover.TARGETS[key].name)}, {precision} precision, {START_WORDS[start]}",
            *unfit(results, key, start, precision),
        )
        for precision, keys in (("double", BOARDS), ("single", SINGLE_BOARDS))
        for key in keys
        for start in BOTH
        if (key, precision, start) != (M4F, "double", FAR_START) and fit_of(results, law, key, start, precision)
    ]
    variations += [
        wb.Variation(
            f"{cycles} cycles per instruction, {START_WORDS[start]}", *unfit(results, M4F, start, cycles=cycles)
        )
        for cycles in CYCLES
        for start in BOTH
    ]
    other = f" In single precision the latter is {percent_of(single)}." if single else ""
    misfits = unfit(results, M4F, FAR_START)[0]
    return wb.Finding(
        "period_used",
        f"In double precision {PROPOSED_LAW} takes {1e3 * far.count / far.clock:.2g} ms per period on a Cortex-M4F: "
        f"{percent_of(near)} of the longest period allowed from a start on the reference, and {percent_of(far)} from "
        f"the paper's start.{other}",
        f"The longest periods allowed are {1e3 * near.period:.2g} and {1e3 * far.period:.2g} ms. In double precision "
        f"from the far start, {misfits}. {stack_words(results)}",
        statistic="Mean count of instructions per period under QEMU, at one instruction per cycle and "
        f"{wb.handover.CLOCKS[M4F] / 1e6:g} MHz, divided by the longest period allowed (the third finding). A law fits "
        "if this is below 100 %.",
        sample="Six laws, compiled by gcc -O2; the processors Cortex-M4F and Cortex-M7; two starts.",
        information="Double precision, which the Cortex-M4F has in software alone.",
        assumptions="The clocks, 168 and 480 MHz, and one cycle per instruction; waits for memory and divisions take "
        "more.",
        fitted_numbers=FITS,
        answer=unfit(results, M4F, FAR_START)[0],
        variations=tuple(variations),
        limitations="Cycles on a real board, and other work of the same processor.",
    )


def stack_words(results: wb.Results) -> str:
    """The deepest stack on a microcontroller, and the deepest one over all targets, in a sentence."""
    boards = {wb.handover.TARGETS[key].name for key in BOARDS}
    stacks = [(r.target, r.figures.stack) for each in replays(results).values() for r in each if r.figures.stack]
    name, most = max(stacks, key=lambda one: one[1])
    board = max((size for target, size in stacks if target in boards), default=None)
    if board is None or board == most:
        return f"The deepest stack takes {most:,} bytes, on {without_compiler(name)}."
    return (
        f"The deepest stack takes {board:,} bytes on a Cortex-M processor, and {most:,} bytes over all targets "
        f"({without_compiler(name)})."
    )


def percent_of(fit: wb.handover.PeriodShare) -> str:
    """The share of a period in per cent."""
    return wb.document.percent(fit.share)


def without_compiler(name: str) -> str:
    """The name of a target without its compiler, where it has but one."""
    return name.split(",")[0]
