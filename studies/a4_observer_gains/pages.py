"""The pictures and tables of a4."""

from studies.a4_observer_gains.candidates import (
    BOX,
    CHOSEN,
    HOW,
    INNER,
    MODEST,
    PAPER,
    SCENARIOS,
    STYLES,
    SURFACE,
    audits,
    followed,
    gains,
    trade_off,
)
from workbench.notation.formula import symbol
from workbench.proofs.interval import guarantee
from workbench.study.document.document import Figure, Panel, Paragraph, Section, Series
from workbench.study.document.phrases import Cell, Column, Table
from workbench.study.evidence.law_tables import side_by_side
from workbench.study.pictures.traces import Window, curve
from workbench.study.provenance import written
from workbench.study.study import Results

CLOUD = 300  # states of the cloud of poles
SHOWN = ("late error", "RMS qd_error", "peak torque")


def poles() -> Figure:
    """The frozen poles of the paper's gains and of the chosen ones, at states of the region."""
    panels = []
    for name in (PAPER, CHOSEN):
        cloud = audits()[name].frozen.poles[:CLOUD].ravel()
        marks = Series(name, cloud.real, cloud.imag, STYLES[name], look="marks")
        panels.append(Panel("imaginary part [1/s]", (marks,), xlabel="real part [1/s]", vlines=(0.0,), title=name))
    caption = (
        f"Poles of the error with state and torque frozen, at {CLOUD} states of the region. Right of the line at zero "
        "a mode grows."
    )
    return Figure("poles", caption, tuple(panels), columns=2)


def noise_and_rate() -> Figure:
    """Noise against the slowest mode."""
    line = Series("double poles", *trade_off(), "reference")
    marks = [
        Series(name, [one.frozen.slowest], [one.noise.velocity], STYLES[name], look="marks")
        for name, one in audits().items()
    ]
    caption = (
        "Noise in the velocity estimate, as an H2 norm, against the slowest frozen mode seen in the region. The line "
        "are double poles at -22 to -60 1/s; left of zero a mode grows somewhere."
    )
    panel = Panel(
        "noise gain [s^(-3/2)]", (*marks, line), xlabel="slowest frozen mode [1/s]", yscale="log", vlines=(0.0, SURFACE)
    )
    return Figure("noise_and_rate", caption, (panel,))


def errors(results: Results) -> Figure:
    """The estimation errors of joint 2 over time, position and velocity, early and late."""
    outcomes = results.scenario(SCENARIOS[0])
    signals = (("q_error", "q_2", " [rad]"), ("qd_error", "qd_2", " [rad/s]"))
    panels = tuple(
        Panel(
            ("error of ", symbol(letter), unit),
            tuple(curve(one, signal, 1, window, one.case.law, one.case.style) for one in outcomes),
            xlim=(window.start, window.end),
        )
        for signal, letter, unit in signals
        for window in (Window(0.0, 1.0), Window(5.0, 10.0))
    )
    caption = f"Estimation errors of joint 2, {SCENARIOS[0]}: the first second, and once the start is forgotten."
    return Figure("estimation_errors", caption, panels, columns=2)


def promise_section() -> Section:
    """The inequality that is proved, and the road to its proof."""
    text = (
        "With the error x~ = (q - q_hat, qd - qd_hat), (12) and (16) are linear in it: by the mean value theorem the "
        "mismatch (14) is a mean of Jacobians of the acceleration between estimate and state, times the error. If "
        "one P satisfies P A + A' P + 2 alpha P < 0 for the error's matrix A at every state and torque of a region, "
        "V = x~' P x~ falls at least as exp(-2 alpha t) as long as arm and estimate stay in it. Errors within an "
        f"ellipsoid of V that keeps the estimate there are admitted. The region here: {BOX}, for arm and estimate; the "
        f"arm itself keeps {100 * INNER:g} % of these speeds, and the rest is room for the error. A solver only "
        "proposes P. Its definiteness is decided by leading minors in rational arithmetic, the inequality by "
        "intervals: the Jacobian is a polynomial in speeds and torques, which lies in the hull of its coefficients in "
        f"Bernstein's basis, and positions are halved until each box holds ({guarantee()})."
    )
    return Section("What a promise is, and how it is proved", (Paragraph(text),))


def gains_section() -> Section:
    """The gains, and all that is seen and proved of each."""
    text = (
        "The admitted errors are small in all cases: high gains peak, and a peak takes the estimate out of the region. "
        "The bound is sufficient, not sharp. Of gains of 1, 10 and 100 times the paper's, a2 proves that each has a "
        "false rest point: more gain alone does not make the promise global. The LMI minimises the bound of noise "
        "that its one P gives, not the noise itself."
    )
    table = Table(
        "gains",
        "The paper's gains and four others.",
        (Column("gains"), Column("how"), Column(symbol("L1"), "1/s"), Column(symbol("L2"), "1/s^2")),
        tuple((name, HOW[name], written(one.L1), written(one.L2)) for name, one in gains().items()),
    )
    return Section("What the gains promise, and what they cost", (table, audits_table(), Paragraph(text)))


def audits_table() -> Table:
    """The frozen modes, the proof and the price of each."""
    rows: list[tuple[Cell, ...]] = []
    for name, one in audits().items():
        seen = 100 * one.frozen.unstable, one.frozen.slowest, followed()[name].slowest
        proved, peak = (None, None), None
        if one.certificate is not None:
            proved, peak = (100 * one.share, 1e3 * one.reach.position), one.reach.peaking
        rows.append((name, *seen, *proved, one.tolerated, one.noise.velocity, one.peaking, peak))
    return Table(
        "audits",
        "What is seen, what is proved and what it costs. Growing, slowest: frozen modes at 20,000 states spread over "
        "the region, negative where one grows; path: along the desired motion. Share: of the region's speeds and "
        f"torques, in which {MODEST:g} 1/s is proved of the paper's gains and {SURFACE:g} 1/s of all others. Admitted: "
        f"|q~(0)| with qd~(0) = 0, for an arm within {100 * INNER:g} % of the speeds of that share. Borne: the largest "
        "rho such that one quadratic form proves a decay for all |Delta| ≤ rho |x~|, in rad and rad/s. Noise: the H2 "
        "norm to qd_hat where the model adds nothing; white noise of density S gives sqrt(S) times it. Peak: of |qd~| "
        "a rad of first error, where the model adds nothing; proved: in the region of the certificate.",
        (
            Column("gains"),
            Column("growing", "%", digits=3),
            Column("slowest", "1/s", digits=3),
            Column("path", "1/s", digits=3),
            Column("share", "%", digits=2),
            Column("admitted", "mrad", digits=2),
            Column("borne", digits=3),
            Column("noise", "s^(-3/2)", digits=3),
            Column("peak", "1/s", digits=3),
            Column("proved", "1/s", digits=3),
        ),
        tuple(rows),
    )


def tracking_section(results: Results) -> Section:
    """The repaired law with each observer."""
    text = (
        "The repaired law of a1 with each observer in the loop, 10 s: as in section 5, with q_hat(0) = 0, and from the "
        "measured positions, q_hat(0) = y(0). All these loops leave the region at first, and in the second scenario "
        "after each jump: the proof is of the rest. The law is given D_hat, filtered from the true disturbance as in "
        "(24)."
    )
    tables = []
    for place, scenario in enumerate(SCENARIOS, 1):
        for joint in (0, 1):
            name, caption = f"tracking_{place}_q{joint + 1}", f"Joint {joint + 1} with each observer, {scenario}."
            tables.append(side_by_side(name, caption, results.scenario(scenario), SHOWN, joint))
    return Section("The tracking that they give", (Paragraph(text), errors(results), *tables))
