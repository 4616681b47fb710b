"""The pictures, tables and sections of a4."""

import numpy as np

import workbench as wb
from studies.a4_observer_gains.candidates import (
    BOX,
    CLEAR,
    CLOUD,
    COLUMNS,
    DOUBLE_POLE,
    HOW,
    INNER,
    PAPER,
    SCENARIOS,
    STYLES,
    SURFACE,
    TABLE_METRICS,
    WITH_JUMPS,
    candidates,
)


def poles(results: wb.Results) -> wb.document.Figure:
    """The frozen poles of the paper's gains and of the chosen ones, at states of the region."""
    panels = []
    for name in (PAPER, DOUBLE_POLE):
        real, imaginary = candidates(results)[name].cloud
        marks = wb.document.Series(name, real, imaginary, STYLES[name], look="marks")
        panels.append(
            wb.document.Panel("imaginary part [1/s]", (marks,), xlabel="real part [1/s]", vlines=(0.0,), title=name)
        )
    caption = (
        f"Poles of the error with state and torque frozen, at {CLOUD} states of the region. A mode with a pole to the "
        "right of the line at zero grows."
    )
    return wb.document.Figure("poles", caption, tuple(panels), columns=2)


def noise_and_rate(results: wb.Results) -> wb.document.Figure:
    """Noise against the slowest mode."""
    ((slowest, noise),) = results.work("trade_off")
    line = wb.document.Series("double poles", slowest, noise, "reference")
    marks = [
        wb.document.Series(name, np.array([one.slowest]), np.array([one.noise]), STYLES[name], look="marks")
        for name, one in candidates(results).items()
    ]
    caption = (
        "Noise in the velocity estimate, as an H2 norm, against the slowest frozen mode found in the region. The grey "
        "curve has double poles at −22 to −60 1/s. The vertical lines are at 0, left of which a mode grows, and at "
        f"{SURFACE:g} 1/s, the rate of the surface."
    )
    panel = wb.document.Panel(
        "noise gain [s^(-3/2)]", (*marks, line), xlabel="slowest frozen mode [1/s]", yscale="log", vlines=(0.0, SURFACE)
    )
    return wb.document.Figure("noise_and_rate", caption, (panel,))


def errors(results: wb.Results) -> wb.document.Figure:
    """The estimation errors of joint 2 over time, position and velocity, early and late."""
    outcomes = results.scenario(SCENARIOS[0])
    signals = (("q_error", "q_2", " [rad]"), ("qd_error", "qd_2", " [rad/s]"))
    panels = tuple(
        wb.document.Panel(
            ("error of ", wb.notation.symbol(letter), unit),
            tuple(wb.pictures.curve(one, signal, 1, window, one.case.law, one.case.style) for one in outcomes),
            xlim=(window.start, window.end),
        )
        for signal, letter, unit in signals
        for window in (wb.pictures.Window(0.0, 1.0), wb.pictures.Window(5.0, 10.0))
    )
    caption = f"Estimation errors of joint 2, {SCENARIOS[0]}: in the first second, and from 5 s on."
    return wb.document.Figure("estimation_errors", caption, panels, columns=2)


def promise_section() -> wb.Section:
    """The inequality that is proved, and the road to its proof."""
    text = (
        "Equations (12) and (16) are linear in the error x~ = (q - q_hat, qd - qd_hat): by the mean value theorem, the "
        "mismatch (14) is a mean of Jacobians of the acceleration between estimate and state, times the error. If "
        "one P satisfies P A + A' P + 2 alpha P < 0 for the error's matrix A at every state and torque of a region, "
        "V = x~' P x~ falls at least as fast as exp(-2 alpha t) while arm and estimate stay in the region. Errors are "
        "admitted if they lie within an ellipsoid of V that keeps the estimate in the region. The region here is "
        f"{BOX}, for arm and estimate. The arm itself keeps {100 * INNER:g} % of these speeds; the rest is room for "
        "the error. A solver only proposes P. Leading minors in rational arithmetic decide whether P is definite. "
        "Interval arithmetic decides the inequality: the Jacobian is a polynomial in speeds and torques, which lies in "
        "the hull of its coefficients in Bernstein's basis, and boxes of positions are halved until the inequality "
        f"holds in each ({wb.proofs.guarantee()})."
    )
    return wb.Section("What convergence means here, and how it is proved", (wb.Paragraph(text),))


def gains_section(results: wb.Results) -> wb.Section:
    """The gains, and all that is seen and proved of each."""
    text = (
        "The admitted errors are small in all cases: with high gains the estimate peaks, and a peak takes it out of "
        "the region. The bound is sufficient, not sharp. Report a2 proves that the observer has a false equilibrium "
        "with 1, 10 and 100 times the paper's gains: larger gains alone do not make the convergence global. The LMI "
        "minimises the bound on the noise that its one P gives, not the noise itself."
    )
    table = wb.document.ReportTable(
        "gains",
        "The paper's gains and four others.",
        (
            wb.document.TableColumn("gains"),
            wb.document.TableColumn("how"),
            wb.document.TableColumn(wb.notation.symbol("L1"), "1/s"),
            wb.document.TableColumn(wb.notation.symbol("L2"), "1/s^2"),
        ),
        tuple(
            (name, HOW[name], wb.provenance.value_text(one.L1), wb.provenance.value_text(one.L2))
            for name, one in candidates(results).items()
        ),
    )
    return wb.Section(
        "Proved convergence, and its price",
        (table, audits_table(results), definitions_table(), wb.Paragraph(text)),
    )


def audits_table(results: wb.Results) -> wb.document.ReportTable:
    """The frozen modes, the proof and the price of each."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for name, one in candidates(results).items():
        seen = 100 * one.growing_share, one.slowest, one.path
        proved = (100 * one.share, 1e3 * one.admitted_radius) if one.share and one.admitted_radius else (None, None)
        rows.append((name, *seen, *proved, one.tolerated_mismatch, one.noise, one.peaking, one.bound))
    columns = (
        wb.document.TableColumn("gains"),
        *(wb.document.TableColumn(head, unit, digits=digits) for head, unit, digits, _ in COLUMNS),
    )
    caption = "Frozen modes, proved decay and price of the paper's gains and four others."
    return wb.document.ReportTable("audits", caption, columns, tuple(rows))


def definitions_table() -> wb.document.ReportTable:
    """The definition of each column of the audits."""
    rows = tuple((head, wb.document.superscript_powers(definition)) for head, *_, definition in COLUMNS)
    return wb.document.ReportTable(
        "definitions",
        "The columns of the table above.",
        (wb.document.TableColumn("column"), wb.document.TableColumn("definition")),
        rows,
    )


def tracking_section(results: wb.Results) -> wb.Section:
    """The repaired law with each observer."""
    text = (
        "The repaired law of a1 runs for 10 s with each observer in the loop. The estimate starts at zero, as in "
        "section 5, or at the measured positions, q_hat(0) = y(0). All these loops leave the region at first, and in "
        "the second scenario also after each jump; the proof holds for the rest of the time. The law has D_hat, "
        "filtered from the true disturbance as in (24). The reference of the second scenario jumps by 0.8 and 0.4 rad "
        f"every 2 s, which no law follows at once. So the late error leaves out the first {CLEAR:g} s after each jump; "
        f"'{WITH_JUMPS}' includes them."
    )
    tables = []
    for place, scenario in enumerate(SCENARIOS, 1):
        for joint in (0, 1):
            name, caption = f"tracking_{place}_q{joint + 1}", f"Joint {joint + 1} with each observer, {scenario}."
            shown = TABLE_METRICS if scenario != SCENARIOS[-1] else (*TABLE_METRICS, WITH_JUMPS)
            tables.append(wb.side_by_side(name, caption, results.scenario(scenario), shown, joint))
    return wb.Section("Tracking with each observer", (wb.Paragraph(text), errors(results), *tables))
