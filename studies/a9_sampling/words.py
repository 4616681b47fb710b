"""Words that the findings of a9 share: what each law has, what was chosen and fitted, and lists of names."""

from __future__ import annotations

INFORMATION = (
    "AOSMC-RGS: positions and the true disturbance. Other laws: positions and velocities. All laws but PID: the exact "
    "model."
)
ASSUMPTIONS = "Scenarios, horizons and the numbers of the laws as in report a1; the computer of Table 1."
COUNTS_ON = "The observer uses the torque that acts, which may be late; in report a5 it uses the commanded torque."
FITS = "Q, R and the horizon of the first scenario, to the printed RMSE of AOSMC-RGS (report a1)."


def two_digits(value: float) -> str:
    """A number with two digits."""
    return f"{float(f'{value:.2g}'):,.6g}"
