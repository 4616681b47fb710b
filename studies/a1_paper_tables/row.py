"""The printed values of the first scenario at any horizon: the runs that meet them, and a witness with two repairs."""

from dataclasses import dataclass

import numpy as np

import workbench as wb
from studies.paper.card import CARD, PROPOSED_LAW, PUBLISHED_COLUMNS

SHORTEST = 5.0  # s, the lower end of the card's range of the horizon
CLOSE = 0.01  # a larger miss than this share of a printed value is none that meets it
PERIOD = float(CARD["sample time of (43)"])  # s, at which the runs are kept
ROW = np.array([PUBLISHED_COLUMNS["FS", joint].values[PROPOSED_LAW] for joint in (1, 2)])  # rad
HALF_DIGIT = 0.5e-4 / ROW.max()  # half a unit of the last printed digit
# Q as a multiple of I, in N m/(rad s), and the horizon in s, which were fitted for each shape of (33); R = I.
WITNESS = "(3) and (28) repaired, Q and the horizon fitted"
FITTED_WEIGHTS = {"elementwise": (0.7, 39.49), "outer": (0.4, 40.06), "diagonal": (1.0, 40.0)}
# Another pair of repairs, shape 'outer': Q and R as multiples of I in N m/(rad s), and the horizon in s.
OTHER_PAIR = "(3) and (33) repaired, Q, R and the horizon fitted"
OTHER_Q, OTHER_R, OTHER_HORIZON = 160.0, 0.5, 42.5


@dataclass(frozen=True)
class Nearest:
    """The horizon in s at which a run is nearest to the printed row, and the larger relative difference there."""

    horizon: float
    rmse: tuple[float, float]
    miss: float


def multiple(weight: float) -> str:
    """A multiple of the identity matrix: 'I', '0.7 I'."""
    return "I" if weight == 1 else f"{weight:g} I"


def limit(share: float) -> str:
    """The least number of percent with one digit that is not below a share: 'within 0.009 %' of 0.0082 %."""
    unit = 10.0 ** np.floor(np.log10(100 * share))
    return f"{np.ceil(100 * share / unit - 1e-9) * unit:.1g}"


def rmse(outcome: wb.study.Outcome) -> wb.Array:
    """Sampled RMSE at each kept time as the horizon, (N, 2), in rad; infinite after the run has diverged."""
    e = outcome.measurement.trajectories["e"][0]
    squares = np.where(np.isfinite(e), e, np.inf) ** 2
    return np.asarray(np.sqrt(np.cumsum(squares, axis=0) / np.arange(1, len(e) + 1)[:, np.newaxis]))


def nearest(outcome: wb.study.Outcome, longest: float = np.inf, shortest: float = SHORTEST) -> Nearest:
    """The nearest of all horizons from the shortest to the longest, in s."""
    values = rmse(outcome)
    inside = (outcome.t >= shortest - PERIOD / 2) & (outcome.t <= longest + PERIOD / 2)
    misses = np.where(inside, np.abs(values / ROW - 1).max(axis=1), np.inf)
    at = int(np.argmin(misses))
    return Nearest(float(outcome.t[at]), (float(values[at, 0]), float(values[at, 1])), float(misses[at]))


def row_figure(curves: dict[str, wb.study.Outcome]) -> wb.document.Figure:
    """Sampled RMSE over the horizon for the law as printed and as repaired, with the printed values as lines."""
    panels = tuple(
        wb.document.Panel(
            f"sampled RMSE of q{joint + 1} [rad]",
            tuple(
                wb.document.Series(
                    words, run.t[1:], np.where(np.isfinite(rmse(run)), rmse(run), np.nan)[1:, joint], style
                )
                for style, (words, run) in enumerate(curves.items())
            ),
            xlabel="horizon [s]",
            xlim=(SHORTEST, float(max(run.t[-1] for run in curves.values()))),
            ylim=(0.25, 2.0),
            yscale="log",
            hlines=(float(ROW[joint]),),
        )
        for joint in (0, 1)
    )
    close = [one.horizon for one in map(nearest, curves.values()) if one.miss <= CLOSE]
    met = " and ".join(f"{horizon:.0f} s" for horizon in sorted(close))
    caption = (
        "Sampled RMSE of AOSMC-RGS in the first scenario against the horizon, which the paper does not state. Thin "
        f"line: the printed value. The printed values of both joints are met within {100 * CLOSE:g} % at horizons of "
        f"{met}{', by different curves' * (len(close) > 1)}."
    )
    return wb.document.Figure("horizons", caption, panels, columns=2)


def witness_table(results: wb.Results, four: wb.study.Outcome) -> wb.document.ReportTable:
    """The runs with two repairs at their own horizons, beside the run with four."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    two = [(run, *FITTED_WEIGHTS[run.case.law.partition(",")[0]]) for run in results.scenario(WITNESS)]
    weights = CARD["Q"][0, 0], CARD["R"][0, 0]
    sets = [("(3), (28)", run, f"{Q:g}", "1", horizon) for run, Q, horizon in two]
    sets.append(("(3), (33)", results[OTHER_PAIR, "outer"], f"{OTHER_Q:g}", f"{OTHER_R:g}", OTHER_HORIZON))
    sets.append(("(3), (24), (28), (33)", four, *(f"{w:g}" for w in weights), CARD["FS: horizon"]))
    for repaired, run, Q, R, horizon in sets:
        scores = [wb.study.cell(run, "sampled RMSE", joint) for joint in (0, 1)]
        values = np.array([run.score("sampled RMSE", joint).pair[0] for joint in (0, 1)])
        miss = 100 * np.abs(values / ROW - 1).max()
        shape = CARD["reading of (33)"] if run is four else run.case.law.partition(",")[0]
        rows.append((repaired, shape, Q, R, f"{horizon:g}", *scores, f"{miss:.2g}"))
    rows.append(("printed", None, None, None, None, *(f"{value:.4f}" for value in ROW), None))
    columns = (
        wb.document.TableColumn("repaired"),
        wb.document.TableColumn("shape of (33)"),
        wb.document.TableColumn("Q", "N m/(rad s)", "right"),
        wb.document.TableColumn("R", "N m/(rad s)", "right"),
        wb.document.TableColumn("horizon", "s", "right"),
        wb.document.TableColumn("sampled RMSE of q1", "rad", "right"),
        wb.document.TableColumn("sampled RMSE of q2", "rad", "right"),
        wb.document.TableColumn("larger miss", "%", "right"),
    )
    caption = (
        "The printed values of AOSMC-RGS in the first scenario, met by two pairs of repairs and by four repairs. Q and "
        "the horizon were fitted for each run, and R too for the last two runs. An equation that is not named is as "
        "printed."
    )
    notes = (
        "Q and R are multiples of I.",
        (
            "The horizon was fitted together with the other numbers of its line. With these numbers kept, the nearest "
            "horizons of ",
            wb.document.CrossReference("slips"),
            " and ",
            wb.document.CrossReference("two_repair_runs"),
            " miss by less.",
        ),
    )
    return wb.document.ReportTable("witness", caption, columns, tuple(rows), notes)
