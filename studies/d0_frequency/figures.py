"""The pictures of d0: over frequency at one pose, over draws, and predictions beside runs."""

from __future__ import annotations

import numpy as np

import workbench as wb
from studies.d0_frequency.draws import OMEGA as OF_DRAWS
from studies.d0_frequency.draws import draws_by_pose
from studies.d0_frequency.limit_cycles import PERIODS, PHI, K, LimitCycle, linear_part
from studies.d0_frequency.loops import CONTINUOUS, DRAWN_LAWS, RUNS, SHORT, AtPose
from studies.d0_frequency.period_limits import STARTS, limits
from studies.d0_frequency.rest_answers import Curves, all_curves, rests
from studies.d0_frequency.step_sizes import SIZES, settlings
from studies.paper.card import LAWS, PROPOSED_LAW
from studies.paper.linearization import LEVEL

STYLES = {law: i for i, law in enumerate(LAWS)}
WHERE = "at rest at the level of SS"
SAME = "The curves of ASMC and Fuzzy-ASMC coincide with that of SMC, as all three laws have the same gain here."
SLOW = 150.0  # 1/s: poles beyond are left to a table
SHOWN_CYCLE = 5e-3  # s
SIX = {
    "TF": "reference to q",
    "CSF": "reference to torque",
    "PS": "load to q and qd",
    "T": "load to torque",
    "CS": "noise to torque",
    "S": "noise to readings",
}


def curve_of(results: wb.Results, law: str, joint: int, late: bool = False) -> wb.FrequencyCurve:
    """The loop gain of a joint with the other closed, with its margins."""
    own: Curves = all_curves(results)[law][int(late)]
    rest = rests(results)[AtPose(law, LEVEL)][f"{1e3 * SHORT:g} ms" if late else CONTINUOUS]
    return wb.FrequencyCurve(
        law,
        own.omega,
        own.single[:, joint],
        own.period or None,
        margins=rest.joints[joint],
        style=STYLES[law],
        multiloop_disk_margin=rest.alpha or None,
    )


def matrix_of(results: wb.Results, law: str, late: bool = False) -> wb.loop_pictures.FrequencyMatrix:
    """The loop gain at both torques."""
    own: Curves = all_curves(results)[law][int(late)]
    rest = rests(results)[AtPose(law, LEVEL)][CONTINUOUS]
    names = ("torque 1", "torque 2")
    return wb.loop_pictures.FrequencyMatrix(
        law, own.omega, own.L, names, names, own.period or None, None if late else rest.alpha
    )


def bode(results: wb.Results, joint: int, late: bool = False) -> wb.document.Figure:
    """The Bode plot of a joint with the other one closed."""
    curves = [curve_of(results, law, joint, late) for law in DRAWN_LAWS]
    time = (
        f"in a computer with a period of {1e3 * SHORT:g} ms and a torque one period late"
        if late
        else "in continuous time"
    )
    caption = f"Bode plot of the loop gain of joint {joint + 1}, the other joint closed, {WHERE}, {time}. {SAME}"
    return wb.loop_pictures.bode_figure(f"bode_{joint + 1}{'_late' * late}", caption, curves)


def nyquist(results: wb.Results, joint: int) -> wb.document.Figure:
    """The Nyquist plot of a joint with the other one closed."""
    curves = [curve_of(results, law, joint) for law in DRAWN_LAWS]
    loop = f"the loop gain of joint {joint + 1}, the other joint closed"
    caption = f"Nyquist plot of {loop}, {WHERE}, in continuous time. {SAME}"
    return wb.loop_pictures.nyquist_figure(f"nyquist_{joint + 1}", caption, curves, reach=3.0)


def several_channels(results: wb.Results) -> tuple[wb.document.Figure, ...]:
    """Singular values, det(I + L) and characteristic loci of both torques at once."""
    every = [matrix_of(results, law) for law in DRAWN_LAWS]
    caption = f"The singular values of the loop gain L at both torques, {WHERE}, in continuous time. {SAME}"
    found = [wb.loop_pictures.singular_value_figure("singular_values", caption, every)]
    caption = (
        f"det(I + L) at both torques, {WHERE}, in continuous time. {SAME} Without a law the arm swings "
        "undamped: at its two natural frequencies L is infinite, and the curve jumps."
    )
    found.append(wb.loop_pictures.determinant_figure("determinant", caption, every, reach=3.0))
    for law in (PROPOSED_LAW, "PID"):
        caption = f"The characteristic loci of {law}, the eigenvalues of L over frequency, {WHERE}, in continuous time."
        name = f"loci_{law.lower().replace('-', '_')}"
        found.append(wb.loop_pictures.characteristic_loci_figure(name, caption, matrix_of(results, law), reach=3.0))
    return tuple(found)


def poles(results: wb.Results) -> wb.document.Figure:
    """The slow poles of each loop that is drawn."""
    sets = []
    for law in DRAWN_LAWS:
        held = rests(results)[AtPose(law, LEVEL)][CONTINUOUS].poles
        sets.append(wb.loop_pictures.PoleZeroSet(law, held[np.abs(held) < SLOW], style=STYLES[law]))
    caption = (
        f"The poles of the closed loops nearer to zero than {SLOW:g} 1/s, {WHERE}, in continuous time. The laws with a "
        "boundary layer have two faster poles; the table of margins over six poses has the fastest."
    )
    return wb.loop_pictures.pole_zero_map("poles", caption, sets)


def gang_of_six(results: wb.Results) -> wb.document.Figure:
    """The largest singular values of the gang of six."""
    every, panels = all_curves(results), []
    for name, words in SIX.items():
        series = [
            wb.document.Series(law, own.omega, own.gang[name], STYLES[law])
            for law, (own, _) in every.items()
            if (own.gang[name] > 0).all()
        ]
        label = f"gain, {words}"
        panels.append(
            wb.document.Panel(label, tuple(series), "frequency [rad/s]", xscale="log", yscale="log", title=name)
        )
    caption = (
        f"The gang of six, {WHERE}, in continuous time: the largest gain from one kind of signal to another over all "
        "directions, in rad, rad/s, s and N m. Position, speed and acceleration of the reference move independently. "
        "AOSMC-RGS has noise only on positions, as it measures no speed."
    )
    return wb.document.Figure("gang_of_six", caption, tuple(panels), columns=2)


def envelopes(results: wb.Results) -> tuple[wb.document.Figure, ...]:
    """The loop gain of joint 1 over the draws, a figure a law."""
    found = []
    for law in (PROPOSED_LAW, "SMC", "PID"):
        own = draws_by_pose(results)[AtPose(law, LEVEL)]
        worst = own.worst
        name = f"draw {worst}, disk margin {own.alpha[worst]:.3g}"
        caption = f"{law}: the loop gain of joint 1, joint 2 closed, {WHERE}, with numbers drawn at random."
        draws = wb.loop_pictures.Envelope(OF_DRAWS, own.single, worst, name)
        found.append(wb.loop_pictures.bode_envelope(f"draws_{law.lower().replace('-', '_')}", caption, draws))
    return tuple(found)


def limit_figure(results: wb.Results) -> wb.document.Figure:
    """The longest period of the runs over the one that the linear map predicts."""
    every, panels = limits(results), []
    for start, size in STARTS.items():
        marks: list[wb.document.Mark] = []
        for law in LAWS:
            own = [every[one] for one in RUNS if one.law == law]
            x = np.array([1e3 * one.limit for one in own])
            ends = np.array([one.ends(start) for one in own])
            low, high = x * np.maximum(ends[:, 0], 0.05), x * ends[:, 1]
            middle = np.sqrt(low * np.where(np.isfinite(high), high, low))
            marks.append(wb.document.Points(law, x, middle, style=STYLES[law], ylow=low, yhigh=high))
        line = np.array([0.2, 50.0])
        marks.append(wb.document.Series("as predicted", line, line, "reference"))
        panels.append(
            wb.document.Panel(
                "longest period of the runs [ms]",
                tuple(marks),
                "period predicted by the linear loop [ms]",
                xscale="log",
                yscale="log",
                title=f"started {1e6 * size:.0f} µrad from equilibrium"
                if size < 1e-3
                else f"started {size:g} rad from equilibrium",
            )
        )
    caption = (
        "The longest sampling period at which runs come to rest, against the period at which the linear loop becomes "
        "unstable, for each law at three poses, with the torque one period late. A bar goes from the longest period at "
        "which a run comes to rest to the next one tried. The boundary layer ends 1.7 mrad from equilibrium."
    )
    return wb.document.Figure("period_limits", caption, tuple(panels), columns=2)


def size_figure(results: wb.Results) -> wb.document.Figure:
    """The settling times of runs over the size of the start, as shares of the linear prediction."""
    every = settlings(results)
    series = []
    for law in LAWS:
        own = every[AtPose(law, LEVEL)]
        share = np.where(np.isfinite(own.runs), own.runs / own.prediction, np.nan)
        series.append(wb.document.Series(law, np.array(SIZES), share, STYLES[law]))
    caption = (
        "The ratio of the settling time of runs to that of the linear loop, against the distance from equilibrium at "
        "which both joints start, at the level of SS. The vertical line, at 1.7 mrad, is the end of the boundary layer."
    )
    panel = wb.document.Panel(
        "settling time / predicted",
        tuple(series),
        "start of both joints from equilibrium [rad]",
        xscale="log",
        yscale="log",
        hlines=(1.0,),
        vlines=(1.7e-3,),
    )
    return wb.document.Figure("step_sizes", caption, (panel,))


def cycle_figures(results: wb.Results) -> tuple[wb.document.Figure, ...]:
    """The describing function at one period, and amplitude and frequency over the period."""
    held: dict[float, LimitCycle] = dict(zip(PERIODS, results.work("limit_cycles"), strict=True))
    W, shown = linear_part(SHOWN_CYCLE), held[SHOWN_CYCLE]
    omega = np.geomspace(1.0, np.pi / SHOWN_CYCLE * (1 - 1e-9), 400)
    caption = (
        f"SMC on the folded arm, with a period of {1e3 * SHOWN_CYCLE:g} ms and the torque one period late: the linear "
        "part W from the switched torque of joint 1 to s of joint 1, and the describing function of the boundary "
        "layer. An oscillation is predicted where the two curves meet."
    )
    curve = wb.FrequencyCurve("W", omega, W.response(omega)[0], SHOWN_CYCLE, unit="rad/s per N m")
    layer = wb.chattering.BoundaryLayer(K, PHI)
    first = wb.loop_pictures.describing_function_figure(
        "describing_function", caption, curve, layer, shown.balance, "rad/s"
    )
    panels = []
    for place, label in ((1, "amplitude of s of joint 1 [rad/s]"), (0, "frequency of s of joint 1 [rad/s]")):
        moving = [(T, one) for T, one in held.items() if one.prediction is not None and not one.rest]
        x = np.array([1e3 * T for T, _ in moving])
        balance = np.array([(one.prediction or (0.0, 0.0))[place] for _, one in moving])
        seen = np.array([[(run.frequency or np.nan, run.amplitude)[place] for run in one.runs] for _, one in moving])
        series = (
            wb.document.Series("balance", x, balance, 0),
            *(wb.document.Series(f"run {k + 1}", x, column, k + 1, "marks") for k, column in enumerate(seen.T)),
        )
        panels.append(wb.document.Panel(label, series, "sampling period [ms]"))
    caption = (
        "The oscillation of SMC in its boundary layer against the sampling period, by harmonic balance and in runs "
        f"from {len(held[SHOWN_CYCLE].runs)} starts. At shorter periods than those shown there is no oscillation, "
        "neither by the balance nor in runs."
    )
    return first, wb.document.Figure("limit_cycles", caption, tuple(panels), columns=2)
