"""The figures of a5: frequency responses at rest, and frozen poles and margins along a run."""

import numpy as np

from studies.a1_paper_tables.study import STYLES
from studies.paper.linearization import PROPOSED, SEVEN, at_rest, on_path
from workbench.design.linear import frequency_response, one_loop, sensitivity
from workbench.study.document.document import Figure, Panel, Series
from workbench.study.study import Results
from workbench.validation.refusals import Array

FREQUENCIES = np.geomspace(0.01, 1e5, 300)
DRAWN = (PROPOSED, "RBF-ASMC", "PID", "SMC")
RAD = "frequency [rad/s]"


def bode() -> Figure:
    """Gain and phase of each joint's loop, the other closed."""
    panels = []
    for joint in (0, 1):
        curves = {law: frequency_response(one_loop(at_rest(law).loop, joint), FREQUENCIES)[:, 0, 0] for law in DRAWN}
        size = tuple(Series(law, FREQUENCIES, np.abs(L), STYLES[law]) for law, L in curves.items())
        turn = tuple(Series(law, FREQUENCIES, _degrees(L), STYLES[law]) for law, L in curves.items())
        panels += [
            Panel("gain", size, RAD, xscale="log", yscale="log", hlines=(1.0,), title=f"joint {joint + 1}"),
            Panel("phase [deg]", turn, RAD, xscale="log", hlines=(-180.0,), title=f"joint {joint + 1}"),
        ]
    caption = "The loop gain at one torque while the other loop is closed, at rest at the level of the second scenario."
    return Figure("bode", caption, tuple(panels), columns=2)


def sensitivities() -> Figure:
    """The largest singular values of S and T."""
    S = {law: frequency_response(sensitivity(at_rest(law).loop), FREQUENCIES) for law in DRAWN}
    sizes = {law: (_largest(value), _largest(np.eye(2) - value)) for law, value in S.items()}
    panels = tuple(
        Panel(
            f"largest gain of {name}",
            tuple(Series(law, FREQUENCIES, both[k], STYLES[law]) for law, both in sizes.items()),
            RAD,
            xscale="log",
            yscale="log",
            hlines=(1.0,),
        )
        for k, name in enumerate("ST")
    )
    caption = "Sensitivity S and complementary sensitivity T at the torques: their largest singular values."
    return Figure("sensitivity", caption, panels, columns=2)


def poles_on_path(results: Results) -> Figure:
    """The slowest and the fastest frozen pole over time."""
    slow, fast = [], []
    for law in SEVEN:
        path = on_path(results["FS", law])
        slow.append(Series(law, path.t, path.eigenvalues.real.max(axis=1), STYLES[law]))
        fast.append(Series(law, path.t, -path.eigenvalues.real.min(axis=1), STYLES[law]))
    panels = (
        Panel("largest real part [1/s]", tuple(slow), title="slowest"),
        Panel("decay of the fastest [1/s]", tuple(fast), yscale="log", title="fastest"),
    )
    caption = (
        "Frozen poles of the whole loop along the first scenario. A gain that is free to stay where it is leaves a "
        "pole at 0."
    )
    return Figure("frozen_poles", caption, panels, columns=2)


def margins_on_path(results: Results) -> Figure:
    """The disk margin over time."""
    series = []
    for law in SEVEN:
        path = on_path(results["FS", law])
        series.append(Series(law, path.sparse, path.alpha, STYLES[law]))
        series.append(Series(law, path.sparse, path.alpha, STYLES[law], look="marks"))
    panel = Panel("disk margin", tuple(series), ylim=(0.0, 2.05))
    return Figure("frozen_margins", "The disk margin at the torques, frozen along the first scenario.", (panel,))


def _largest(matrices: np.ndarray[tuple[int, ...], np.dtype[np.complex128]]) -> Array:
    return np.asarray(np.linalg.norm(matrices, 2, axis=(-2, -1)))


def _degrees(values: np.ndarray[tuple[int, ...], np.dtype[np.complex128]]) -> Array:
    """The phase in degrees from -275 to 85, with a gap where it leaves at one end and comes back at the other."""
    phase = np.mod(np.degrees(np.angle(values)) + 275, 360) - 275
    phase[1:][np.abs(np.diff(phase)) > 200] = np.nan
    return np.asarray(phase)
