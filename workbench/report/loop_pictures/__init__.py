"""Pictures of linear systems and loops: Bode, Nyquist and Nichols plots, pole maps, root loci and step responses.

This package makes figures of plain data: frequencies, complex responses, periods, certified margins, poles. It knows no
robot, law or loop. Read `frequency_curves` first, then `bode_pictures`.

Examples
--------
>>> wb.loop_pictures.FrequencyCurve is wb.FrequencyCurve
True
"""

from workbench.report.loop_pictures.bode_pictures import bode_figure
from workbench.report.loop_pictures.channel_pictures import (
    characteristic_loci_figure,
    determinant_figure,
    relative_gain_figure,
    singular_value_figure,
)
from workbench.report.loop_pictures.curve_turns import CurveTurns, curve_turns
from workbench.report.loop_pictures.describing_pictures import describing_function_figure
from workbench.report.loop_pictures.envelopes import Envelope, bode_envelope, envelope_figure
from workbench.report.loop_pictures.frequency_matrices import FrequencyMatrix
from workbench.report.loop_pictures.margin_words import ROUNDING
from workbench.report.loop_pictures.nichols_pictures import nichols_figure
from workbench.report.loop_pictures.nyquist_pictures import nyquist_figure
from workbench.report.loop_pictures.phase_planes import EquilibriumMark, PhaseCurve, VectorField, phase_figure
from workbench.report.loop_pictures.pole_maps import PoleZeroSet, pole_zero_map
from workbench.report.loop_pictures.root_loci import root_locus_figure
from workbench.report.loop_pictures.step_pictures import (
    SampledStepInfo,
    TimeResponse,
    impulse_figure,
    sampled_step_info,
    step_figure,
)
from workbench.study.document.frequency_curves import CornerFrequencies, FrequencyCurve
from workbench.study.document.gain_bounds import Disk, GainBound

__all__ = [
    "CornerFrequencies",
    "CurveTurns",
    "Disk",
    "Envelope",
    "FrequencyCurve",
    "FrequencyMatrix",
    "GainBound",
    "PhaseCurve",
    "PoleZeroSet",
    "ROUNDING",
    "EquilibriumMark",
    "SampledStepInfo",
    "TimeResponse",
    "VectorField",
    "bode_envelope",
    "bode_figure",
    "characteristic_loci_figure",
    "curve_turns",
    "describing_function_figure",
    "determinant_figure",
    "envelope_figure",
    "impulse_figure",
    "nichols_figure",
    "nyquist_figure",
    "phase_figure",
    "pole_zero_map",
    "relative_gain_figure",
    "root_locus_figure",
    "sampled_step_info",
    "singular_value_figure",
    "step_figure",
]
