"""The exam's Riccati equations in other units of states and inputs: `python -m tests.exams.scales DIR [SEEDS]`.

A change of units by powers of two is exact, so the exam's own solution is known in all of them, to 32 digits.
"""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from workbench.design.matrices import DesignError
from workbench.design.riccati import care, dare

from .graders import Loaded, find, loaded

POWERS = (10, 20, 30)
MOST_STATES = 60
EPS = float(np.finfo(float).eps)


def count(exam: Loaded, discrete: bool, seeds: int = 1) -> Counter[str]:
    """How many answers are right, wrong and refused, of all equations that have one."""
    counts: Counter[str] = Counter()
    for case, z in exam.module.load("dare_index.json" if discrete else "care_index.json"):
        if case["n"] > MOST_STATES or case.get("expect", "solve") != "solve":
            continue
        condition = case["cond_est" if discrete else "cond_kenney_hewer"] or 1.0
        for power in POWERS:
            for seed in range(2 * seeds):
                counts[_outcome(z, condition, discrete, power, seed)] += 1
    return counts


def _outcome(z: dict[str, Any], condition: float, discrete: bool, power: int, seed: int) -> str:
    """As the exam grades it; the inputs keep their units in every other seed."""
    n, m = z["B"].shape
    rng = np.random.default_rng([seed, power, n])
    x = np.exp2(rng.integers(-power, power + 1, n))
    u = np.exp2(rng.integers(-power, power + 1, m)) if seed % 2 else np.ones(m)
    S = z["S"] * x[:, None] * u if discrete else None
    A, B, Q, R = z["A"] / x[:, None] * x, z["B"] / x[:, None] * u, z["Q"] * x[:, None] * x, z["R"] * u[:, None] * u
    try:
        found = (dare if discrete else care)(A, B, Q, R, S)
    except DesignError:
        return "refused"
    X, low = (z[name] * x[:, None] * x for name in ("X", "X_lo"))
    error = np.linalg.norm((found.X - X) - low) / np.linalg.norm(X)
    # the exam's tolerance, and no more than twice what the certificate says; both are norms in the new units
    right = error <= min(1e-2, max(1e-12, 1e3 * EPS * condition)) and error <= 2 * found.certificate.error
    return "right" if right else "wrong"


def continuous(exam: Loaded) -> tuple[bool, str]:
    """`care` in other units: all solved."""
    return _figure(count(exam, discrete=False))


def discrete(exam: Loaded) -> tuple[bool, str]:
    """`dare` in other units: all solved."""
    return _figure(count(exam, discrete=True))


def _figure(counts: Counter[str]) -> tuple[bool, str]:
    text = f"{counts['right']} of {counts.total()} right, {counts['refused']} refused, {counts['wrong']} wrong"
    return 0 < counts["right"] == counts.total(), text


PARTS = {"care_residual": ("care in other units", continuous), "dare_residual": ("dare in other units", discrete)}


def main(folder: str, seeds: str = "10") -> int:
    """One line for each kind of equation."""
    missed = 0
    for grader in find(Path(folder)):
        with loaded(grader) as exam:
            figures = [_figure(count(exam, sampled, int(seeds))) for sampled in (False, True)]
        for name, (passed, text) in zip(("care", "dare"), figures, strict=True):
            sys.stdout.write(f"{name} in other units: {text}\n")
            missed += not passed
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
