"""Standings: who is best in how many scenarios, by each estimand."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from workbench.study.evidence.judgement import Judgement, least_of
from workbench.validation.signatures import door


@dataclass(frozen=True, eq=False)
@door
class Standings:
    """Judgements of the same laws by the same estimands in several scenarios."""

    judgements: Mapping[str, Judgement]

    def __post_init__(self) -> None:
        kinds = {(one.paired.laws, tuple(one.by)) for one in self.judgements.values()}
        if len(kinds) != 1:
            raise ValueError(
                "`Standings(judgements=...)` must have the same laws and the same estimands in each scenario; got "
                f"{len(kinds)} kinds of them."
            )

    @property
    def wins(self) -> Mapping[str, Mapping[str, tuple[str, ...]]]:
        """By the words of each estimand, each law and the scenarios in which it is best by that one; most first."""
        found = {}
        for words in self._one.by:
            of = {law: self._where(words, law) for law in self._one.paired.laws}
            found[words] = dict(sorted(of.items(), key=lambda pair: -len(pair[1])))
        return found

    @property
    def best(self) -> Mapping[str, tuple[str, ...]]:
        """Each law and the scenarios in which it is best, whatever is asked; most first."""
        verdicts = {name: one.best for name, one in self.judgements.items()}
        of = {law: tuple(name for name, best in verdicts.items() if best == law) for law in self._one.paired.laws}
        return dict(sorted(of.items(), key=lambda pair: -len(pair[1])))

    @property
    def open(self) -> tuple[str, ...]:
        """The scenarios in which no law is best."""
        return tuple(name for name, one in self.judgements.items() if one.kind == "open")

    @property
    def depends(self) -> tuple[str, ...]:
        """The scenarios in which it depends on what is asked."""
        return tuple(name for name, one in self.judgements.items() if one.kind == "depends")

    @property
    def differing(self) -> Mapping[str, tuple[str, ...]]:
        """The scenarios in which an estimand has another law best than the one asked, or none; and which do."""
        found = {}
        for name, judgement in self.judgements.items():
            first, *others = judgement.by.items()
            if words := tuple(words for words, one in others if one.best != first[1].best):
                found[name] = words
        return found

    @property
    def agree(self) -> bool:
        """Whether all estimands have the same law best in each scenario."""
        return not self.differing

    @property
    def sentence(self) -> str:
        """The tally in plain words."""
        metrics = {one.paired.metric for one in self.judgements.values()}
        least = least_of(self._one.asked, metrics.pop() if len(metrics) == 1 else "value")
        total = f" of {len(self.judgements)}"
        parts = []
        for law, where in self.best.items():
            if where:
                parts.append(f"{law} in {len(where)}{total}")
                total = ""
        tally = f"{least}: {', '.join(parts)}" if parts else f"{least}: no law in any{total}"
        said = [tally, f"open in {len(self.open) or 'none'}{_named(self.open)}"]
        if self.depends:
            said.append(f"depends on what is asked in {len(self.depends)}{_named(self.depends)}")
        return "; ".join(said)

    @property
    def _one(self) -> Judgement:
        return next(iter(self.judgements.values()))

    def _where(self, words: str, law: str) -> tuple[str, ...]:
        return tuple(name for name, one in self.judgements.items() if one.by[words].best == law)


def _named(names: tuple[str, ...]) -> str:
    return f" ({', '.join(names)})" if names else ""
