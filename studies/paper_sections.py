"""How a1 begins and ends: the answers, the numbers with their origin, and how far to trust them."""

from paper_card import CARD, PUBLISHED
from paper_comparison import PROPOSED, SCENARIOS, rankings
from paper_printed import loses_positivity

from workbench.study.document import Cell, Column, Paragraph, Section, Table, Verdict
from workbench.study.study import Results


def summary(results: Results) -> Section:
    """The answers first."""
    printed, repaired = results["FS as printed", "outer"], results["FS", PROPOSED]
    negative = loses_positivity(printed)
    fits = [100 * (repaired.score("RMSE (43)", j)[0] / PUBLISHED["FS", j + 1].values[PROPOSED] - 1) for j in (0, 1)]
    rows = [r for scenario in SCENARIOS for r in rankings(results, scenario)]
    holds, pairs = sum(len(r.holds) for r in rows), sum(len(r.holds) + len(r.fails) + len(r.undecided) for r in rows)
    lost = (
        f"K is no longer positive definite from {negative:.2f} s on, and "
        if negative is not None
        else "K stays positive definite, and "
    ) + (
        f"the run diverges at {printed.diverged_at:.2f} s."
        if printed.diverged_at is not None
        else "the run stays finite."
    )
    return Section(
        "What was found",
        (
            Verdict(
                "fails", "The law as printed tracks the reference.", f"First scenario, reading 'outer' of (33): {lost}"
            ),
            Verdict(
                "holds",
                "With the smallest repair the law tracks, and meets its printed RMSE of the first scenario within 2 %.",
                f"Off by {fits[0]:+.2f} % (joint 1) and {fits[1]:+.2f} % (joint 2); "
                "Q, R, l and the horizon, which the paper does not state, were chosen for this fit.",
            )
            if all(abs(f) < 2 for f in fits)
            else Verdict(
                "fails", "With the smallest repair the law meets its printed RMSE within 2 %.", f"Off by {fits} %."
            ),
            Verdict(
                "open",
                "The published rankings of the six laws hold.",
                f"Of {pairs} printed pairs {holds} hold under the assumed numbers of the rivals, of which the "
                f"paper states none.",
            ),
        ),
    )


def numbers_section() -> Section:
    """Provenance."""
    return Section(
        "The numbers, and where they come from",
        (
            Paragraph(
                "The paper states the arm, the surface, the boundary layer, the first gains and the observer. It "
                "does not "
                "state Q, R, l, the horizon, the square wave, or any number of the rival laws. What is missing is "
                "assumed "
                "by a rule: rivals share the surface, the layer and the first gain of the proposed law, PID has the "
                "bandwidth of that surface, and all rivals are given exact measurements of position and velocity."
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
                1e3 * limit.limit,
                f"{limit.eigenvalue.real:.0f}",
                f"{limit.at:.2f}",
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
                "is the "
                "longest step at which the fastest decaying mode of the exact Jacobian, taken along the run, still "
                "decays: "
                "beyond it a simulation chatters by itself, and RMSE hardly shows it while total variation and "
                "effort do. "
                "Where switching has begun the method is of first order only, and no more is claimed."
            ),
            Table(
                "steps",
                "Step, stability limit with the mode that sets it, and the error of RMSE.",
                columns,
                tuple(rows),
            ),
        ),
    )
