"""Words that the findings of a9 share: what each law has, what was chosen and fitted, and lists of names."""

from __future__ import annotations

from collections.abc import Iterable

GIVEN = (
    "AOSMC-RGS: positions and the true disturbance. Other laws: positions and velocities. All laws but PID: the exact "
    "model."
)
CHOSEN = "Scenarios, horizons and the numbers of the laws as in a1; the computer of Table 1."
COUNTS_ON = "The observer counts on the torque that acts, which may be late; that of a5 counts on the commanded one."
FITTED = "Q, R and the horizon of the first scenario: to the printed RMSE of AOSMC-RGS (a1)."


def listed(laws: Iterable[str]) -> str:
    """Names with commas and an 'and', or 'none'."""
    names = list(laws)
    return f"{', '.join(names[:-1])} and {names[-1]}" if len(names) > 1 else names[0] if names else "none"


def rounded(value: float) -> str:
    """A number with two digits."""
    return f"{float(f'{value:.2g}'):,.6g}"
