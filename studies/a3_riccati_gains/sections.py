"""What a3 says: P of (34) beside its rivals, what that costs, and what it does to the loop."""

from collections.abc import Sequence

import numpy as np

from studies.a3_riccati_gains.loops import ALGEBRAIC, AT_START, FORWARD, LQR, NONE, regulator, weight
from studies.a3_riccati_gains.path import RTOL, WINDOW, Compared, compared, distance, median_in_time, rise, symmetric
from studies.paper.card import CARD
from studies.paper.comparison import BOLD, MARGIN, SCENARIOS
from workbench.notation.formula import symbol
from workbench.study.document.document import Cell, Column, Figure, Panel, Paragraph, Section, Series, Table, Verdict
from workbench.study.document.phrases import raised
from workbench.study.evidence.law_tables import order, side_by_side
from workbench.study.study import Results
from workbench.validation.refusals import Array

SETTLED = 0.05  # s: several times the time in which (34) forgets P(0)
SHOWN = ("RMSE (43)", "RMSE", "IAE", "peak error", "effort", "peak torque", "TV")


def along(results: Results, scenario: str) -> Compared:
    """The comparison along the run of the repaired law."""
    return compared(results[scenario, FORWARD])


def apart(path: Compared) -> float:
    """The largest distance of (34) from the algebraic equation once P(0) is forgotten."""
    return float(distance(path.P, path.X)[path.t >= SETTLED].max())


def usual(path: Compared) -> float:
    """The median over time of the same distance."""
    late = path.t >= SETTLED
    return median_in_time(distance(path.P, path.X)[late], path.t[late])


def changed(results: Results, scenario: str, variant: str, name: str) -> list[float]:
    """By how much a choice of P changes a metric of each joint against (34), relative and with its sign."""
    ours, other = results[scenario, FORWARD], results[scenario, variant]
    return [other.score(name, joint)[0] / ours.score(name, joint)[0] - 1 for joint in (0, 1)]


def moved(results: Results, scenario: str) -> tuple[str, float]:
    """By how much the algebraic equation changes a shown metric at most against (34), relative, and which one."""
    changes = {
        (name, joint): abs(change)
        for name in ("RMSE (43)", "IAE", "effort")
        for joint, change in enumerate(changed(results, scenario, ALGEBRAIC, name))
    }
    (name, joint), change = max(changes.items(), key=lambda item: item[1])
    return f"{name} of joint {joint + 1} in the {SCENARIOS[scenario]}", change


def answers(results: Results) -> Section:
    """The findings first."""
    return Section("What was found", (*_of_the_equations(results), *_of_the_loop(results)))


def _of_the_equations(results: Results) -> tuple[Verdict, ...]:
    """What (34) is beside its rivals."""
    paths = [along(results, scenario) for scenario in SCENARIOS]
    ratios = [path.ratios["P(t) of (34)"] - 1 for path in paths]
    unstable = [float(path.growth.max()) for path in paths]
    sample = f"along one run a scenario until {WINDOW:g} s ({' and '.join(SCENARIOS.values())})"
    numbers = "The assumed Q and R, which the paper does not state; K and the estimate of q along the run."
    return (
        Verdict(
            "found",
            f"P(t) of (34) is at most {_percent([apart(path) for path in paths])} from the algebraic solution X from "
            f"{1e3 * SETTLED:g} ms on, in the median over time {_percent([usual(path) for path in paths])}.",
            "Differences of two solutions of (34) fall to 1/e in at most "
            f"{_list([1e3 * path.memory for path in paths])} ms, while K takes "
            f"{_list([rise(path.K, path.t) for path in paths])} s for 63 % of its way.",
            estimand=f"|P - X| / |X|, Frobenius norms, {sample}.",
            given=numbers,
            reversal="A smaller Q or a larger R, which slow (34) down; no other pair was tried here.",
        ),
        Verdict(
            "found",
            raised(f"As a feedback u = -R^-1 B' P(t) s of (31), P(t) of (34) costs {_percent(ratios)} more than the ")
            + "least J of (32).",
            f"u = 0 costs {_list([path.ratios['P = 0'] for path in paths])} times the least. This is about (31) and "
            "(32) alone: the law applies no such u, and uses P in (33), as a rate of learning.",
            estimand=f"J of (32) over the first {WINDOW:g} s, from the worst s(0), over the least; A {sample}.",
            given=numbers,
            reversal="A smaller Q or a larger R, which slow (34) down, or another horizon of J.",
        ),
        Verdict(
            "found",
            raised("The eigenvalues of A = -M^-1 K of (31), frozen at an instant, have real parts of at most ")
            + f"{_list(unstable)} 1/s along the run.",
            "A decay of A at each instant does not prove that s of (31), whose A moves, decays.",
            estimand=f"The largest real part at {_list([len(p.t) for p in paths])} instants {sample}.",
            given=numbers,
            reversal="A K that loses its positive definite part, as that of the law as printed does (a1).",
        ),
    )


def _of_the_loop(results: Results) -> tuple[Verdict, ...]:
    """What (34) does to the loop."""
    same = max((moved(results, scenario) for scenario in SCENARIOS), key=lambda change: change[1])
    rmse = {title: changed(results, s, AT_START, "RMSE (43)") for s, title in SCENARIOS.items()}
    tracked = " and ".join(f"by {100 * a:+.2g} and {100 * b:+.2g} % in the {title}" for title, (a, b) in rmse.items())
    worked = [100 * change for s in SCENARIOS for change in changed(results, s, AT_START, "effort")]
    better = [
        order(results[s, FORWARD].score("RMSE (43)", j), results[s, AT_START].score("RMSE (43)", j), MARGIN)
        for s in SCENARIOS
        for j in (0, 1)
    ]
    observer = "Both loops: positions, one observer, the true disturbance, the exact model."
    return (
        Verdict(
            "found",
            "With the algebraic equation at each instant in place of (34), RMSE (43), IAE and effort change by at most "
            f"{100 * same[1]:.2g} %.",
            f"The largest of the changes is that of {same[0]}.",
            estimand="Three metrics at two joints in two scenarios, one run each without noise, the whole horizon.",
            given=observer,
            reversal="A smaller Q or a larger R, with which (34) lags behind X.",
        ),
        Verdict(
            "found",
            f"With P left at P(0) in place of (34), RMSE (43) of joints 1 and 2 changes {tracked}, and the effort by "
            f"{min(worked):+.2g} to {max(worked):+.2g} % over the four.",
            f"Beyond {100 * MARGIN:g} % RMSE (43) is the smaller with P(0) in {better.count('above')} of {len(better)} "
            f"comparisons, and the larger in {better.count('below')}. Two rates of learning are compared: (33) learns "
            "with P.",
            estimand="RMSE (43) and effort at two joints in two scenarios, one noiseless run each, the whole horizon.",
            given=observer,
            reversal="Another Q, R or P(0): of these the paper states P(0) alone.",
        ),
        _beside_the_regulator(results),
    )


def _beside_the_regulator(results: Results) -> Verdict:
    """The seventh law."""
    places = [(results[s, FORWARD], results[s, LQR], j) for s in SCENARIOS for j in (0, 1)]
    stands = [order(ours.score("RMSE (43)", j), lqr.score("RMSE (43)", j), MARGIN) for ours, lqr, j in places]
    peaks = [lqr.score("peak torque", j)[0] / ours.score("peak torque", j)[0] for ours, lqr, j in places]
    return Verdict(
        "found",
        f"A linear regulator as fast as the surface has the smaller RMSE (43) in {stands.count('above')} of "
        f"{len(stands)} comparisons with the repaired law, and {min(peaks):.2g} to {max(peaks):.2g} times its peak "
        "torque.",
        f"It has the larger RMSE in {stands.count('below')}. No torque is limited.",
        estimand="RMSE (43) and the largest torque at two joints in two scenarios, one run each without noise.",
        given="The regulator: exact positions and velocities. The law: positions and the true disturbance.",
        reversal="A limit on the torque, noise on what the regulator reads, or the same measurements for both.",
    )


def matrices(results: Results, scenario: str) -> Section:
    """P(t) against its rivals in one scenario."""
    path, title = along(results, scenario), SCENARIOS[scenario]
    costs = tuple((name, f"{ratio:.4f}") for name, ratio in path.ratios.items())
    return Section(
        f"P(t) in the {title}",
        (
            distances(path, scenario),
            figure(path, scenario, title),
            Table(
                f"{scenario.lower()}_cost",
                "J of (32) for (31) along the run with u = -R^-1 B' P s, over the least J, from the worst start.",
                (Column("P"), Column("J / J*", align="right")),
                costs,
            ),
            Paragraph(
                f"The least eigenvalue of the symmetric part of K is {least(symmetric(path.K)):.3g} N m, and K is "
                f"unsymmetric by up to {skew(path.K):.0%} of its norm."
            ),
        ),
    )


def distances(path: Compared, scenario: str) -> Table:
    """How far P of (34) is from other choices."""
    rows: list[tuple[Cell, ...]] = []
    rivals = {
        "SDRE: the CARE at each instant": path.X,
        "backward, from 0 at the end": path.backward.P,
        "P = P(0)": np.broadcast_to(path.P[0], path.P.shape),
        "(34), solved again": path.forward.P,
    }
    for name, P in rivals.items():
        end = len(P) - (P is path.backward.P)  # where it is zero, a distance relative to it has no meaning
        gaps, late = distance(path.P[:end], P[:end]), path.t[:end] >= SETTLED
        settled = gaps[late]
        usually = median_in_time(settled, path.t[:end][late])
        rows.append((name, f"{least(P[:end]):.3g}", *(f"{value:.2g}" for value in (gaps[0], usually, settled.max()))))
    columns = (
        Column("P by"),
        Column("least eigenvalue", "N m/rad", "right"),
        *(Column(words, align="right") for words in ("at t = 0", "median after", "largest after")),
    )
    return Table(
        f"{scenario.lower()}_distance",
        f"Distance of P(t) of (34) from other choices over the first {WINDOW:g} s; 'after' is from {SETTLED:g} s on.",
        columns,
        tuple(rows),
        (
            f"Distance: Frobenius norm of the difference over that of the other choice, at {len(path.t)} instants, "
            "which are closer at the beginning. Median: over time. A = -M^-1 K has M at the estimate of q, as the law "
            "has it.",
            f"Residual of the algebraic equation at most {path.residual:.0e}. Error of the backward and of the "
            f"forward solution at most {path.backward.error.max():.0e} and {path.forward.error.max():.0e} "
            f"for a path that is a spline through the kept states; they were asked for {RTOL:.0e}.",
            f"The backward solution is zero at the end, where no distance relative to it has a meaning: the last time "
            f"of its row is {1e3 * (path.t[-1] - path.t[-2]):.2g} ms before.",
            "(34), solved again: another method, from the same path; it differs by what the spline leaves out.",
        ),
    )


def figure(path: Compared, scenario: str, title: str) -> Figure:
    """Diagonal entries over time, and the distance."""
    labels = (("(34)", path.P), ("algebraic", path.X), ("backward", path.backward.P))
    entries = tuple(
        Panel(
            (symbol(f"P_{i + 1}{i + 1}"), " [N m/rad]"),
            tuple(Series(label, path.t, P[:, i, i], style) for style, (label, P) in enumerate(labels)),
        )
        for i in (0, 1)
    )
    gap = np.maximum(distance(path.P, path.X), 1e-16)
    far = Panel("relative distance", (Series("(34)", path.t, gap, 0),), yscale="log")
    caption = f"P(t), {title}: its diagonal, and the distance of (34) from the algebraic solution."
    return Figure(f"{scenario.lower()}_p", caption, (*entries, far), columns=3)


def loops(results: Results, scenario: str) -> Section:
    """The closed loops side by side."""
    title, shown = SCENARIOS[scenario], results.scenario(scenario)
    return Section(
        f"The loop in the {title}",
        (
            Paragraph(
                f"The first four rows are one law on one observer; in '{ALGEBRAIC}' P solves (34) with P' = 0, in "
                f"'{AT_START}' (34) is switched off, in '{NONE}' (33) as well, so that K stays "
                f"{np.asarray(CARD['K(0)'])[0, 0]:g} N m. '{LQR}' is feedforward along the reference and the regulator "
                f"of the arm that hangs at rest, weighted such that its slowest pair of poles is about as fast as the "
                f"surface; it and ASMC in the row above it know q and qd exactly."
            ),
            Paragraph(_regulator()),
            *(
                side_by_side(
                    f"{scenario.lower()}_loops_q{j}",
                    f"Metrics of joint {j}, {title}.",
                    shown,
                    SHOWN,
                    j - 1,
                    (BOLD,),
                    MARGIN,
                )
                for j in (1, 2)
            ),
        ),
    )


def _regulator() -> str:
    """The numbers of the regulator, and how far they can be trusted."""
    found = regulator()
    rows = "; ".join(", ".join(f"{entry:.4g}" for entry in row) for row in found.K)
    sure = found.certificate
    return (
        f"Its weights: Q = diag({weight():.4g}, {weight():.4g}, 0, 0) in (N m/rad)^2 for the positions, R = I. They "
        f"give K = [{rows}], rows by torque, in N m/rad and N m s/rad, and poles whose slowest is {-sure.margin:.3g} "
        f"1/s (residual {sure.residual:.0e}, error {sure.error:.0e})."
    )


def least(P: Array) -> float:
    """The least eigenvalue among symmetric matrices (N, 2, 2)."""
    return float(np.linalg.eigvalsh(P)[:, 0].min())


def skew(K: Array) -> float:
    """The largest norm of K - K' over twice that of K."""
    gap = np.linalg.norm(K - np.swapaxes(K, 1, 2), axis=(1, 2))
    return float((gap / (2 * np.linalg.norm(K, axis=(1, 2)))).max())


def _percent(values: list[float]) -> str:
    return " and ".join(f"{100 * value:.2g} %" for value in values)


def _list(values: Sequence[float]) -> str:
    return " and ".join(f"{value:.3g}" for value in values)
