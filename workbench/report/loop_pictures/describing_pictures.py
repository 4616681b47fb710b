"""Describing functions over a Nyquist curve: where W meets -1 / N(a), the loop may oscillate with the amplitude a."""

from __future__ import annotations

import numpy as np

from workbench.core.validation.refusals import positive
from workbench.core.validation.signatures import check_arguments
from workbench.design.chattering.harmonic_balance import AbstractSwitch, Balance
from workbench.report.loop_pictures.bode_pictures import check_curves, numbers_of_curves
from workbench.report.loop_pictures.nyquist_pictures import Plane, plane_marks, plane_panel
from workbench.study.document.figure import Figure, Mark, Points, Series
from workbench.study.document.frequency_curves import FrequencyCurve, add_remarks, number
from workbench.study.document.phrases_and_tables import Phrase

SPAN = 300  # amplitudes of the line -1 / N(a)
DECADES = 4.0  # of the amplitudes, about those that are predicted
REACH = 2.5  # times the largest |1 / N| of the predicted oscillations


@check_arguments
def describing_function_figure(
    name: str,
    caption: Phrase,
    linear: FrequencyCurve,
    switch: AbstractSwitch,
    balance: Balance,
    unit: str = "",
    reach: float | None = None,
) -> Figure:
    """The curve of the linear part W over frequency, the line -1 / N(a) of a switch, and the oscillations predicted.

    Each oscillation of the balance is marked where both meet, with its amplitude, in the `unit` of s, and its
    frequency. A ring marks an oscillation that attracts, a cross one that repels.

    Raises
    ------
    ValueError
        If the curve has no answer, or the reach is not positive.

    Examples
    --------
    >>> import control
    >>> from workbench.design.chattering import Relay, harmonic_balance
    >>> from workbench.report.loop_pictures import FrequencyCurve, describing_function_figure
    >>> L, omega = control.tf([4.0], [1.0, 3.0, 3.0, 1.0]), np.array([0.5, 1.0, 2.0, 4.0])
    >>> curve, balance = FrequencyCurve("L", omega, L(1j * omega)), harmonic_balance(L, Relay(1.0))
    >>> describing_function_figure("balance", "A relay in the loop", curve, Relay(1.0), balance, "rad").name
    'balance'
    """
    check_curves("describing_function_figure", [linear])
    found = balance.oscillations
    sizes = [1 / switch.gain(one.amplitude) for one in found]
    far = REACH * max(sizes, default=float(np.nanmedian(np.abs(linear.values))))
    plane = Plane(0.0, "", far if reach is None else positive("describing_function_figure(reach=...)", reach))
    marks: list[Mark] = [
        mark for mark in plane_marks([linear], plane, with_mirror_image=False) if not isinstance(mark, Points)
    ]
    middle = [one.amplitude for one in found] or [4 * switch.K / np.pi * plane.reach / REACH]
    amplitudes = np.geomspace(min(middle) * 10**-DECADES, max(middle) * 10**DECADES, SPAN)
    line = np.array([-1 / switch.gain(float(a)) for a in amplitudes])
    line = line[line > -4 * plane.reach]
    marks.append(Series("−1 / N(a)", line, np.zeros(len(line)), 1))
    for label, stable in (("attracts", True), ("repels", False)):
        if some := [one for one in found if one.stable == stable]:
            at = np.array([-1 / switch.gain(one.amplitude) for one in some])
            names = tuple(
                f"a = {number(one.amplitude)}{f' {unit}' if unit else ''}, {number(one.frequency)} rad/s"
                for one in some
            )
            marks.append(Points(label, at, np.zeros(len(at)), names, 6, shape="zero" if stable else "pole"))
    verdict = f"{balance.verdict[0].upper()}{balance.verdict[1:]}."
    panel = plane_panel(marks, [linear], Plane(-plane.reach / REACH, "", plane.reach))
    remarks: list[Phrase] = [f"Harmonic balance predicts: {verdict[0].lower()}{verdict[1:]}"]
    return Figure(name, add_remarks(caption, remarks), (panel,), 1, numbers_of_curves(name, caption, [linear]))
