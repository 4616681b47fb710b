"""How a1 begins and ends: the answers, the numbers with their origin, and how far to trust them."""

from paper_card import CARD, PUBLISHED
from paper_comparison import PROPOSED, SCENARIOS, rankings
from paper_printed import FAR, LATE, leaves, loses_positivity

from workbench.study.document import Cell, Column, Paragraph, Section, Table, Verdict
from workbench.study.study import Results


def summary(results: Results) -> Section:
    """The answers first."""
    printed, repaired = results["FS as printed, derived arm", "outer"], results["FS", PROPOSED]
    lost, left = loses_positivity(printed), leaves(printed)
    fits = [100 * (repaired.score("RMSE (43)", j)[0] / PUBLISHED["FS", j + 1].values[PROPOSED] - 1) for j in (0, 1)]
    late = [repaired.score("late error", j)[0] for j in (0, 1)]
    rows = [r for scenario in SCENARIOS for r in rankings(results, scenario)]
    counts = [
        sum(len(pairs) for pairs in kind) for kind in zip(*((r.holds, r.fails, r.undecided) for r in rows), strict=True)
    ]
    return Section(
        "What was found",
        (
            Verdict(
                "holds" if left is None else "fails",
                "The law as printed tracks the reference.",
                f"First scenario, reading 'outer' of (33): K is not positive definite at {_at(lost)}, "
                f"and an error is beyond {FAR:g} rad at {_at(left)}.",
            ),
            Verdict(
                "holds" if all(abs(f) < 2 for f in fits) else "fails",
                "With the smallest repair the law meets its printed RMSE of the first scenario within 2 %.",
                f"Off by {fits[0]:+.2f} % (joint 1) and {fits[1]:+.2f} % (joint 2). Q, R, the horizon, the reading "
                "of (33) and the grid of (43), which the paper does not state, were chosen for this fit, and others "
                "fit as well.",
            ),
            Verdict(
                "holds" if max(late) < 0.01 else "fails",
                "Repaired, it tracks with a small steady-state error.",
                f"From {LATE:g} s on the errors reach {late[0]:.3f} rad (joint 1) and {late[1]:.3f} rad (joint 2): "
                "the bias of its observer, which ignores the disturbance.",
            ),
            Verdict(
                "holds" if not counts[1] + counts[2] else "fails",
                "Under the numbers assumed for the rivals, the published rankings hold.",
                f"Of {sum(counts)} printed pairs {counts[0]} hold, {counts[1]} are turned round, and {counts[2]} are "
                "too close to call. The paper states none of the rivals' numbers.",
            ),
        ),
    )


def _at(time: float | None) -> str:
    return "no time within 10 s" if time is None else f"{time:.2f} s"


def numbers_section() -> Section:
    """Provenance."""
    return Section(
        "The numbers, and where they come from",
        (
            Paragraph(
                "The paper states the arm, the surface, the boundary layer, the first gains and the observer. It "
                "does not state Q, R, l, the horizon, the square wave, or any number of the rival laws. What is "
                "missing is assumed by a rule: rivals share the surface, the layer and the first gain of the "
                "proposed law, and PID has the bandwidth of that surface. Q, R, the horizon, the reading of (33) "
                "and the square wave were chosen near the printed numbers of the proposed law; nothing was chosen "
                "for a rival."
            ),
            Paragraph(
                "All laws know the arm exactly, no torque is limited, and the rivals are given exact positions and "
                "velocities, the proposed law positions and, by (24), the true disturbance. So the comparison is of "
                "these loops, not of what the laws could do: the first gain of 5 N m lets SMC reach its surface "
                "only after seconds, the network of RBF-ASMC finds nothing to learn in an exact model and leaves it "
                "with nearly the numbers of ASMC, and PID may ask for any torque."
            ),
            CARD.table("stated", "stated", "What the paper states."),
            CARD.table("derived", "derived", "What follows from it."),
            CARD.table("assumed", "assumed", "What the paper does not state, and is assumed here."),
        ),
    )


def trust_section(results: Results) -> Section:
    """Steps, limits and errors."""
    rows: list[tuple[Cell, ...]] = []
    for outcome in results.outcomes:
        limit = outcome.measurement.limits[0]
        rows.append(
            (
                outcome.case.scenario,
                outcome.case.law,
                1e3 * limit.h / 2,
                *(
                    (1e3 * limit.limit, f"{limit.eigenvalue.real:.0f}", f"{limit.at:.2f}")
                    if limit.checked
                    else (None,) * 3
                ),
                "within" if limit.holds else "beyond",
                None if outcome.diverged_at is not None else f"{outcome.score('RMSE', 0)[1]:.1e}",
            )
        )
    columns = (
        Column("scenario"),
        Column("law"),
        Column("step", "ms", "right"),
        Column("limit", "ms", "right"),
        Column("mode", "1/s", "right"),
        Column("at", "s", "right"),
        Column("twice the step is"),
        Column("error of RMSE of q1", "rad", "right"),
    )
    return Section(
        "How far these numbers can be trusted",
        (
            Paragraph(
                "Values are those of RK4 at the step below; errors are the change from twice that step. The limit "
                "is the longest step at which the fastest decaying mode of the exact Jacobian, taken along the run, "
                "still decays: beyond it a simulation chatters by itself, and RMSE hardly shows it while total "
                "variation and effort do. At most 400 kept states of a run are looked at. Where switching has begun "
                "the method is of first order only and its error irregular: the change tells its size, and bounds "
                "nothing."
            ),
            Table(
                "steps",
                "Step, stability limit with the mode that sets it, and the error of RMSE.",
                columns,
                tuple(rows),
            ),
        ),
    )
