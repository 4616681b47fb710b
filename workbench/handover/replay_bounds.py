"""The largest number of periods that can be recorded or replayed, by the memory and the time that they need."""

from __future__ import annotations

from workbench.core import SampledLaw
from workbench.engine.batch import LARGEST, LONGEST, SECONDS_PER_OPERATION


def afford_periods(call: str, law: SampledLaw, periods: int, operations: int) -> None:
    """Refuse `periods` periods of a law, of `operations` operations each, if memory or time does not suffice.

    A target is handed what was recorded in a file, and answers in another one: so each number lies in memory twice.
    """
    numbers = 2 * (law.readings.size + law.references.size + law.commands.size) + 3
    need, time = 8 * numbers * periods, SECONDS_PER_OPERATION * periods * operations
    if need > LARGEST:
        most = LARGEST // (8 * numbers)
        raise ValueError(
            f"`{call}` must be at most {most:,} for this law, as {periods:.3g} periods would need "
            f"{need / 2**30:.3g} GB of memory and the limit is {LARGEST / 2**30:.0f} GB. Take fewer periods."
        )
    if time > LONGEST:
        raise ValueError(
            f"`{call}` must be fewer, as {periods:.3g} periods would take about {time / 3600:.0f} hours of one "
            f"processor and the limit is {LONGEST / 3600:.0f}. Take fewer periods, or fewer substeps."
        )
