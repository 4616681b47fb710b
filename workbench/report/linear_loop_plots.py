"""The pictures of a `LinearLoop` by the names of their kinds, and the small grid of what is looked at first."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from workbench.core.validation.refusals import Array, one_of
from workbench.core.validation.signatures import check_arguments
from workbench.design.linear_loop import LinearLoop
from workbench.report import loop_plots
from workbench.report.channel_plots import (
    characteristic_loci,
    determinant,
    determinant_plot,
    gang_of_six,
    relative_gains,
    singular_values,
)
from workbench.report.linear_loop_curves import Curves, answer_curves
from workbench.report.linear_loop_responses import Names
from workbench.report.loop_pictures import bode_figure, nichols_figure, nyquist_figure, pole_zero_map
from workbench.report.picture import Picture, known_options
from workbench.report.response_figures import joined_figures, responses_figure
from workbench.report.system_curves import Systems, curves_of, roots_of, systems_by_name
from workbench.study.document.figure import Figure
from workbench.study.document.gain_bounds import GainBound

CALL = "LinearLoop.plot"


def draw_loops(loops: LinearLoop | Mapping[str, LinearLoop], kind: str = "", **options: object) -> Picture:
    """The picture of a kind of a loop, or of several by their names; without a kind what is looked at first."""
    one_of(f"{CALL}(kind)", kind, ("", *KINDS))
    made: Callable[..., Picture] = KINDS[kind] if kind else overview
    return made(loops, **known_options(f"{CALL}({repr(kind) * bool(kind)})", made, options))


@check_arguments
def overview(loops: Systems, frequencies: Array | None = None) -> Picture:
    """Bode and Nyquist plots with margins, and the poles of the closed loop, in one picture.

    Of several channels the Nyquist plot is that of det(I + L). A loop with a delay has a Nichols plot in the place of
    its poles, of which it has infinitely many.
    """
    found = curves_of("bode", loops, frequencies, None)
    bode = bode_figure("loop", "", found.curves)
    turns, beside = _or_reason(lambda: _turns(loops, found, frequencies))
    poles, refused = _or_reason(lambda: pole_zero_map("loop", "", roots_of(CALL, loops)))
    if poles is None and turns is not None:
        poles = nichols_figure("loop", "", found.curves)
        refused = [f"In the place of the poles there is a Nichols plot: {refused[0]}"]
    others = [figure for figure in (turns, poles) if figure is not None]
    remarks = [*found.remarks, bode.caption, *(figure.caption for figure in others[:1] if figure is turns)]
    remarks += [*beside, *refused]
    panels = [bode.panels[0], *(figure.panels[0] for figure in others[:1]), bode.panels[1]]
    panels += [figure.panels[0] for figure in others[1:]]
    pages = [Figure("loop", "", tuple(panels))]
    return Picture(joined_figures("loop", [said for said in remarks if said], pages, 2 if others else 1))


def _turns(loops: Systems, found: Curves, frequencies: Array | None) -> Figure:
    """The Nyquist plot of one channel each, or of det(I + L) where a loop has several."""
    if any(len(one.channels) > 1 for _, one in systems_by_name(loops)):
        return determinant_plot(loops, frequencies)
    curves = curves_of("nyquist", loops, frequencies, None)
    return nyquist_figure("loop", "", curves.curves, curves.unstable[0] if len(curves.curves) == 1 else None)


def _or_reason(made: Callable[[], Figure]) -> tuple[Figure | None, list[str]]:
    """A figure, or the sentence that refuses it."""
    try:
        return made(), []
    except ValueError as refusal:
        return None, [str(refusal)]


@check_arguments
def bode(
    loops: Systems,
    frequencies: Array | None = None,
    of: str = "L",
    inputs: str | tuple[str, ...] | None = None,
    outputs: str | tuple[str, ...] | None = None,
    margins: bool = True,
    asymptotes: bool = False,
    bounds: tuple[GainBound, ...] = (),
) -> Picture:
    """The Bode plot of the loop gain at each channel, or of another kind from some inputs to some outputs."""
    if of == "L" and inputs is None and outputs is None:
        return loop_plots.bode(loops, frequencies, margins, asymptotes, bounds)
    found = Curves([])
    for label, one in systems_by_name(loops):
        found += answer_curves(CALL, one, label, frequencies, of, inputs, outputs)
    return Picture(bode_figure("bode", "", found.curves, False, bounds))


@check_arguments
def step(loops: Systems, until: float | None = None, inputs: Names = None, outputs: Names = None) -> Picture:
    """The step responses of what a loop follows to its reference, or of outputs to inputs by their names."""
    return Picture(responses_figure("step", loops, until, inputs, outputs))


@check_arguments
def impulse(loops: Systems, until: float | None = None, inputs: Names = None, outputs: Names = None) -> Picture:
    """The impulse responses of what a loop follows to its reference, or of outputs to inputs by their names."""
    return Picture(responses_figure("impulse", loops, until, inputs, outputs, impulse=True))


@check_arguments
def root_locus(
    loop: Systems,
    over: object = None,
    values: Array | None = None,
    marked_values: tuple[float, ...] = (),
    grid: bool = True,
) -> Picture:
    """The poles of one loop over the values of a parameter by its path."""
    return loop_plots.root_locus(loop, over, values, marked_values, grid)


KINDS: dict[str, Callable[..., Picture]] = {
    "bode": bode,
    "nyquist": loop_plots.nyquist,
    "nichols": loop_plots.nichols,
    "poles": loop_plots.pole_zero_map,
    "root_locus": root_locus,
    "step": step,
    "impulse": impulse,
    "gang_of_six": gang_of_six,
    "singular_values": singular_values,
    "determinant": determinant,
    "characteristic_loci": characteristic_loci,
    "relative_gains": relative_gains,
}
