"""What follows from the comparisons of a8: who is best where, by how much, and which claims hold."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from workbench.study.document import Verdict
from workbench.study.evidence import Comparison

Held = Mapping[str, Comparison]  # a measure in each held-out scenario, by the scenario's name


@dataclass(frozen=True)
class Standing:
    """The scenarios in which a law is best, in which another is below it, and those that are open."""

    best: tuple[str, ...]
    behind: tuple[str, ...]
    open: tuple[str, ...]

    @property
    def sentence(self) -> str:
        """In plain words."""
        total = len(self.best) + len(self.behind) + len(self.open)
        parts = [f"best in {len(self.best)} of {total}{_listed(self.best)}"]
        parts.append(f"behind another law in {len(self.behind)}{_listed(self.behind)}")
        parts.append(f"open in {len(self.open)}{_listed(self.open)}")
        return ", ".join(parts)

    @property
    def kind(self) -> str:
        """Whether it is best everywhere."""
        return "fails" if self.behind else "open" if self.open else "holds"


def standing(held: Held, law: str) -> Standing:
    """How a law stands in each scenario, among all that were compared there."""
    places: dict[str, list[str]] = {"best": [], "behind": [], "open": []}
    for scenario, one in held.items():
        places["best" if one.best == law else "open" if law in one.leaders else "behind"].append(scenario)
    return Standing(*(tuple(places[name]) for name in ("best", "behind", "open")))


def wins(held: Held) -> dict[str, int]:
    """In how many scenarios each law is best, those with most first."""
    laws = next(iter(held.values())).paired.laws
    counts = {law: sum(one.best == law for one in held.values()) for law in laws}
    return dict(sorted(counts.items(), key=lambda pair: -pair[1]))


def champion(held: Held) -> str | None:
    """The law that is best in more scenarios than any other; None where two share that."""
    (first, most), (_, next_most), *_ = wins(held).items()
    return first if most > next_most else None


def everywhere(held: Held, law: str, measure: str) -> Verdict:
    """Whether a law is best in all scenarios."""
    found = standing(held, law)
    return Verdict(found.kind, f"{law} has the least {measure} in every held-out scenario.", f"It is {found.sentence}.")


def mostly(held: Held, law: str) -> Verdict:
    """Whether a law is best in more scenarios than any other."""
    counts = ", ".join(f"{name} in {count}" for name, count in wins(held).items() if count)
    nobody = sum(one.best is None for one in held.values())
    said = f"Best is {counts or 'no law anywhere'}; nobody in {nobody} of {len(held)}."
    kind = "holds" if champion(held) == law else "fails" if champion(held) is not None else "open"
    return Verdict(kind, f"{law} has the least cost in more held-out scenarios than any other law.", said)


def diverged(held: Held, law: str) -> str:
    """Where runs of a law diverge, and how many; empty if none does."""
    lost = {scenario: int(one.paired.failed[one.paired.place(law)]) for scenario, one in held.items()}
    return ", ".join(f"{n} of {len(held[scenario].paired)} in '{scenario}'" for scenario, n in lost.items() if n)


def fails_nowhere(held: Held, law: str) -> Verdict:
    """Whether all runs of a law stay finite."""
    lost, others = diverged(held, law), [name for name in next(iter(held.values())).paired.laws if name != law]
    rivals = [f"{name}: {said}" for name in others if (said := diverged(held, name))]
    evidence = f"Diverged: {lost or 'none'}. Of its rivals: {'; '.join(rivals) or 'none'}."
    return Verdict("fails" if lost else "holds", f"No run of {law} diverges in a held-out scenario.", evidence)


def by_its_law(held: Held, law: str) -> Verdict:
    """Whether the lead of a law remains where its rivals have its observers."""
    found = standing(held, law)
    laws = next(iter(held.values())).paired.laws
    return Verdict(
        found.kind,
        f"Where {len(laws) - 1} of its rivals have its observers too, {law} has the least cost in every held-out "
        "scenario.",
        f"Among {_and(laws)} it is {found.sentence}.",
    )


def parts_matter(held: Held, whole: str) -> Verdict:
    """Whether each part of a law lowers its cost in each scenario in which the law was taken apart."""
    found: dict[str, dict[str, list[str]]] = {"below": {}, "above": {}, "alike": {}, "undecided": {}}
    for scenario, one in held.items():
        for part in one.paired.laws:
            if part != whole:
                order = "alike" if one.alike(whole, part) else one.order(whole, part)
                found[order].setdefault(part, []).append(scenario)
    words = {
        "below": "cost rises without",
        "above": "cost falls without",
        "alike": f"cost changes by less than {100 * next(iter(held.values())).margin:g} % without",
        "undecided": "open is",
    }
    said = (
        f"{words[order]} {', '.join(f'{part}{_listed(where)}' for part, where in parts.items())}"
        for order, parts in found.items()
        if parts
    )
    kind = "fails" if found["above"] or found["alike"] else "open" if found["undecided"] else "holds"
    return Verdict(kind, f"Each part of {whole} lowers its cost.", f"As tuned, {'; '.join(said)}.")


def whichever_search(first: Held, other: Held) -> Verdict:
    """Whether the laws as another search tuned them come to the same winner in each scenario."""
    pairs = {scenario: (first[scenario].best, one.best) for scenario, one in other.items()}
    said = ", ".join(f"{scenario}: {a or 'nobody'} and {b or 'nobody'}" for scenario, (a, b) in pairs.items())
    same = all(a == b for a, b in pairs.values())
    turned = any(a and b and a != b for a, b in pairs.values())
    return Verdict(
        "holds" if same else "fails" if turned else "open",
        "The best law is the same, whichever of the two searches tuned all laws.",
        f"Best by the better search and by the other: {said}.",
    )


def _listed(names: Sequence[str]) -> str:
    return f" ({', '.join(names)})" if names else ""


def _and(names: Sequence[str]) -> str:
    return f"{', '.join(names[:-1])} and {names[-1]}"
