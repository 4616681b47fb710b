"""DataFinding: one point of a check of data, in a sentence."""

from __future__ import annotations

from dataclasses import dataclass

SEVERITIES = ("refused", "question", "remark")


@dataclass(frozen=True)
class DataFinding:
    """One point of a check of data.

    Parameters
    ----------
    point
        A short name, such as 'gap' or 'saturated signal'.
    severity
        'refused' if no fit can take the data as they are; 'question' if a fit waits for an answer of the user;
        'remark' for the report.
    text
        One sentence that names the signal, the rule, what came, and what to do.
    signal
        The signal, or empty if it is about the times or the whole log.
    """

    point: str
    severity: str
    text: str
    signal: str = ""

    @property
    def name(self) -> str:
        """The point with its signal, 'gap' or 'saturated signal: y', by which it can be answered alone."""
        return f"{self.point}: {self.signal}" if self.signal else self.point

    def __str__(self) -> str:
        return f"{self.severity}, {self.name}. {self.text}"


def count_text(count: int, noun: str) -> str:
    """A count with its noun and verb: '1 sample is', '3 samples are'."""
    return f"{count} {noun} is" if count == 1 else f"{count} {noun}s are"
