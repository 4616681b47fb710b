"""A finding as these studies print it: what is claimed, with all that a reader needs to hold it to account."""

from workbench.study.document import Verdict


def finding(kind: str, statement: str, evidence: str, *, estimand: str, given: str, reversal: str) -> Verdict:
    """A verdict whose evidence ends with its statistic and sample, who was given what, and what would reverse it."""
    assert kind in ("holds", "fails", "open")
    parts = (evidence, f"Statistic: {estimand}.", f"Given: {given}.", f"What would reverse it: {reversal}.")
    return Verdict(kind, statement, " ".join(parts))
