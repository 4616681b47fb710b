"""The kinds of check: a claim bound to the function that judges it, an identity, and a search for a run."""

from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import numpy as np

from studies.a2_claims.identities import SIDES, both
from studies.a2_claims.searches import hunt, line, outcome, worst_component
from studies.paper.card import CARD
from workbench.claims.verdicts import Check, Finding
from workbench.core import Claim
from workbench.proofs.identity import judge_equal
from workbench.study.provenance import written

HORIZONS = f"horizons of {CARD['FS: horizon']:g} s (FS) and {CARD['SS: horizon']:g} s (SS)"


class Checked(NamedTuple):
    """A claim with the check that judges it."""

    claim: Claim
    check: Check


def judges(name: str, statement: str, source: str, *below: Claim) -> Callable[[Check], Checked]:
    """Bind a check to its claim, with the claims below it."""
    return lambda check: Checked(Claim(name, statement, source, below), check)


def refutation(broken: bool, evidence: str, witness: str, kept: tuple[str, ...] = ()) -> Finding:
    """The finding of a witness against the claim, where its numbers break it."""
    if not broken:
        return Finding("not refuted", "The run or state that was to break it does not.", samples=1)
    return Finding("refuted", evidence, witness, kept=kept)


def identity_finding(name: str) -> Finding:
    """The finding of an equation's normal forms."""
    if (judged := judge_equal(*SIDES[name])).kind == "proved":
        return Finding("proved", "Equal normal forms: an identity in all states, gains and parameters.")
    return Finding("not checkable", judged.evidence)


def identity(name: str, statement: str, source: str) -> Checked:
    """An equation that is to be an identity in all its symbols."""
    return Checked(Claim(name, statement, source), lambda: identity_finding(name))


def inequality(
    name: str, statement: str, source: str, evidence: str, *below: Claim, **values: tuple[float, ...]
) -> Checked:
    """An equation whose sides differ at a plain state; `{0}` and `{1}` of the evidence are the sides there."""
    witness = ", ".join(f"{letter}={literal(value)}" for letter, value in values.items())

    def check() -> Finding:
        left, right = both(name, **values)
        differ = judge_equal(*SIDES[name]).kind == "refuted" and not np.allclose(left, right, rtol=1e-9, atol=0)
        return refutation(differ, evidence.format(row(left), row(right)), f'both("{name}", {witness})')

    return Checked(Claim(name, statement, source, below), check)


def by_search(search: str, claim: Claim, evidence: str, under: str = "", units: Sequence[str] = ("",)) -> Checked:
    """A claim that runs can break; the evidence takes the numbers of the worst run, which the witness runs again.

    The numbers are `value`, `least` = -value, its `error`, the `unit` of the worst component, and the runs `sought`.
    """

    def check() -> Finding:
        result, task = outcome(search), hunt(search)
        if result.worst is None:
            return Finding("not checkable", f"None of {result.runs:,} runs can tell: {result.why}.")
        counted = "" if result.kept == result.runs else f", {result.kept:,} of which kept the hypotheses"
        sought = f"{result.runs:,} runs of {task.until:g} s{counted}"
        value, error, unit = result.worst.value, result.worst.error, units[worst_component(search) if units[1:] else 0]
        words = evidence.format(value=value, least=-value, error=error, unit=unit, sought=sought)
        if result.kind == "refuted":
            kept = tuple(hypothesis.claim.name for hypothesis in task.kept)  # by each run that counts
            return Finding("refuted", words, line(search), kept=kept)
        return Finding("not refuted", words, line(search), samples=result.kept, under=under)

    return Checked(claim, check)


def row(values: object, digits: int = 4) -> str:
    """Numbers as a reader takes them in: (0.5, -1)."""
    return "(" + ", ".join(f"{value:.{digits}g}" for value in np.ravel(np.asarray(values, dtype=float)) + 0.0) + ")"


def literal(values: Iterable[float]) -> str:
    """A tuple as a witness types it."""
    return "(" + ", ".join(f"{value:g}" for value in values) + ")"


def numbers(*names: str) -> str:
    """Numbers that the paper leaves open, as they were taken here: Q = diag(1, 1) N m/(rad s), ..."""
    units = {given.name: given.unit for given in CARD}
    letters = {name: name.removeprefix("SS: ").removesuffix(" as printed") for name in names}
    return ", ".join(f"{letter} = {written(CARD[name])} {units[name]}" for name, letter in letters.items())
