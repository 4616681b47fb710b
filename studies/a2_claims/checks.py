"""How a2 checks a claim: small makers of findings that several groups of claims share."""

from collections.abc import Callable

import numpy as np

from studies.a2_claims.identities import SIDES, both
from studies.a2_claims.searches import found, hunt, line
from studies.paper.card import CARD
from workbench.claims.falsify import Found
from workbench.claims.verdicts import Finding
from workbench.proofs.identity import judge_equal
from workbench.study.provenance import written

Check = Callable[[], Finding]


HORIZONS = f"horizons of {CARD['FS: horizon']:g} s (FS) and {CARD['SS: horizon']:g} s (SS)"


def listed(values: object, digits: int = 4) -> str:
    """Numbers as a reader takes them in: (0.5, -1)."""
    return "(" + ", ".join(f"{value:.{digits}g}" for value in np.ravel(np.asarray(values, dtype=float)) + 0.0) + ")"


def numbers(*names: str) -> str:
    """What the paper leaves open, as it was taken here: Q = diag(1, 1) N m/(rad s), ..."""
    entries = {given.name: given for given in CARD}
    return ", ".join(f"{_letters(name)} = {written(CARD[name])} {entries[name].unit}" for name in names)


def identity(name: str, evidence: str = "") -> Check:
    """An equation that is to be an identity in all its symbols."""

    def check() -> Finding:
        judged = judge_equal(*SIDES[name])
        if judged.kind == "proved":
            return Finding("proved", evidence or "Equal normal forms: an identity in all states, gains and parameters.")
        return Finding("not checkable", judged.evidence)

    return check


def unequal(name: str, evidence: str, **values: tuple[float, ...]) -> Check:
    """An equation whose sides differ at a plain state; `{0}` and `{1}` of the evidence are what they are there."""

    def check() -> Finding:
        left, right = both(name, **values)
        if judge_equal(*SIDES[name]).kind != "refuted" or np.allclose(left, right, rtol=1e-9, atol=0):
            return Finding("not refuted", "the sides agree at the state that was to tell them apart", samples=1)
        shown = ", ".join(f"{key}={_typed(value)}" for key, value in values.items())
        return Finding("refuted", evidence.format(listed(left), listed(right)), f'both("{name}", {shown})')

    return check


def searched(name: str, sentence: Callable[[Found], str], under: str = "") -> Check:
    """A claim that runs can break; the witness runs the worst one again."""

    def check() -> Finding:
        result = found(name)
        if result.worst is None:
            return Finding("not checkable", f"None of {result.runs:,} runs can tell: {result.why}.")
        if result.kind == "refuted":
            kept = tuple(hypothesis.claim.name for hypothesis in hunt(name).kept)  # by each run that counts
            return Finding("refuted", sentence(result), line(name), kept=kept)
        return Finding("not refuted", sentence(result), line(name), samples=result.kept, under=under)

    return check


def sought(name: str) -> str:
    """How a search was done, in a few words."""
    task, result = hunt(name), found(name)
    kept = "" if result.kept == result.runs else f", {result.kept:,} of which kept the hypotheses"
    return f"{result.runs:,} runs of {task.until:g} s{kept}"


def _letters(name: str) -> str:
    """The letters of a card's name: `Q` of `Q as printed`, `a1, a2` of `SS: a1, a2`."""
    return name.removeprefix("SS: ").removesuffix(" as printed")


def _typed(value: tuple[float, ...]) -> str:
    return "(" + ", ".join(f"{number:g}" for number in value) + ")"
