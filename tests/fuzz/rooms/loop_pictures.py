from __future__ import annotations

from functools import partial
from typing import Any

import control
import numpy as np

from workbench.design.chattering import Relay, harmonic_balance
from workbench.design.frequency import stability_margins
from workbench.report import loop_pictures as pictures
from workbench.report import loop_plots
from workbench.study.document import plane_marks as marks

MODULES = ("workbench.report.loop_pictures", "workbench.report.loop_plots")
OMEGA = np.array([0.5, 1.0, 2.0, 4.0])
LAG = control.tf([4.0], [1.0, 3.0, 3.0, 1.0])
TWO = control.ss([[-1.0, 0.0], [0.0, -2.0]], np.eye(2), [[1.0, 1.0], [0.0, 1.0]], np.zeros((2, 2)))
GRID = np.array([-1.0, 0.0, 1.0])


def calls() -> dict[str, Any]:
    values = np.asarray(LAG(1j * OMEGA))
    curve = pictures.FrequencyCurve("L", OMEGA, values)
    matrix = pictures.FrequencyMatrix("L", OMEGA, np.moveaxis(TWO(1j * OMEGA), -1, 0))
    field = pictures.VectorField(GRID, GRID, *np.meshgrid(GRID, GRID))
    response = pictures.TimeResponse("y", OMEGA, [0.0, 0.5, 1.2, 1.0], 1.0)
    draws = pictures.Envelope(OMEGA, [values, 2 * values], 1, "draw 1")
    balance = harmonic_balance(LAG, Relay(1.0))
    return {
        "Area": partial(marks.Area, "a", OMEGA, OMEGA, 1),
        "Arrows": partial(marks.Arrows, "a", OMEGA, OMEGA, OMEGA, OMEGA, 1, 5.0),
        "Guides": partial(marks.Guides, ((OMEGA, OMEGA),), ("g",)),
        "Corners": partial(pictures.Corners, [-1.0], [-2.0], 1.0),
        "CurveTurns": partial(pictures.CurveTurns, 1, 0, ""),
        "Disk": partial(pictures.Disk, "d", -1.0, 0.5),
        "Envelope": partial(pictures.Envelope, OMEGA, [values, values], 0, "draw 0"),
        "FrequencyCurve": partial(
            pictures.FrequencyCurve, "L", OMEGA, values, 0.1, "rad", stability_margins(LAG), None, 1
        ),
        "FrequencyMatrix": partial(
            pictures.FrequencyMatrix, "L", OMEGA, matrix.values, ("a", "b"), ("c", "d"), 0.1, 0.5
        ),
        "GainBound": partial(pictures.GainBound, "b", [1.0, 2.0], [1.0, 0.5], "below"),
        "PhaseCurve": partial(pictures.PhaseCurve, "run", GRID, GRID),
        "PoleZeroSet": partial(pictures.PoleZeroSet, "G", [-1.0, -2.0], [-3.0], 0.1, ("a", "b"), 1),
        "Rest": partial(pictures.Rest, 0.0, 0.0, "saddle"),
        "SampledStepInfo": partial(pictures.SampledStepInfo, 1.0, 2.0, 3.0, 1.1, 1.5, 1.0),
        "TimeResponse": partial(pictures.TimeResponse, "y", OMEGA, OMEGA, 4.0, "rad", 0.1, 1),
        "VectorField": partial(pictures.VectorField, GRID, GRID, *np.meshgrid(GRID, GRID)),
        "bode": partial(loop_plots.bode, LAG, OMEGA, True, True),
        "bode_envelope": partial(pictures.bode_envelope, "f", "c", draws, 0.1),
        "bode_figure": partial(pictures.bode_figure, "f", "c", [curve], False, []),
        "characteristic_loci_figure": partial(pictures.characteristic_loci_figure, "f", "c", matrix, [], 2.0),
        "curve_turns": partial(pictures.curve_turns, OMEGA, values, None, -1.0),
        "describing_function_figure": partial(
            pictures.describing_function_figure, "f", "c", curve, Relay(1.0), balance, "rad", 2.0
        ),
        "determinant_figure": partial(pictures.determinant_figure, "f", "c", [matrix], 0, 2.0),
        "envelope_figure": partial(
            pictures.envelope_figure, "f", "c", pictures.Envelope(OMEGA, [OMEGA, OMEGA]), "t", "y", "rad"
        ),
        "impulse_figure": partial(pictures.impulse_figure, "f", "c", [response], "y"),
        "nichols": partial(loop_plots.nichols, LAG, OMEGA, True),
        "nichols_figure": partial(pictures.nichols_figure, "f", "c", [curve]),
        "nyquist": partial(loop_plots.nyquist, LAG, OMEGA, True, 2.0, (pictures.Disk("d", -1.0, 0.5),)),
        "nyquist_figure": partial(pictures.nyquist_figure, "f", "c", [curve], 0, True, [], 2.0),
        "phase_figure": partial(pictures.phase_figure, "f", "c", field, "x", "y", [pictures.Rest(0.0, 0.0)]),
        "pole_zero_map": partial(loop_plots.pole_zero_map, LAG, True),
        "pole_zero_map of data": partial(pictures.pole_zero_map, "f", "c", [pictures.PoleZeroSet("G", [-1.0])], True),
        "relative_gain_figure": partial(pictures.relative_gain_figure, "f", "c", matrix),
        "root_locus": partial(loop_plots.root_locus, LAG, [0.5, 1.0], None, (0.7,), True),
        "root_locus_figure": partial(
            pictures.root_locus_figure, "f", "c", "k", [0.0, 1.0], [[-1.0], [-2.0]], "V", [0.5], [], 0.1, 3.0
        ),
        "singular_value_figure": partial(pictures.singular_value_figure, "f", "c", [matrix], []),
        "singular_values": partial(loop_plots.singular_values, TWO, OMEGA),
        "step_figure": partial(pictures.step_figure, "f", "c", [response], "y"),
        "sampled_step_info": partial(pictures.sampled_step_info, OMEGA, [0.0, 0.5, 1.2, 1.0], 1.0, 0.02),
        "step_response": partial(loop_plots.step_response, LAG, 5.0),
    }


def arguments() -> dict[str, Any]:
    return {}
