"""The findings of a3: the loop with a constant P, with the algebraic equation, and P(t) beside other solutions."""

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

import workbench as wb
from studies.a3_riccati_gains import path
from studies.a3_riccati_gains.path import TRANSIENT, WINDOW, RunComparison
from studies.a3_riccati_gains.settings import (
    ALGEBRAIC,
    ASMC_WITH_OBSERVER,
    ASSUMED_WEIGHTS,
    AT_START,
    FORWARD,
    MEAN,
    NONE,
    OTHERS,
    PLACES,
    WEIGHTS,
    scenario_of,
)
from studies.paper.card import CARD, MARGIN, SCENARIOS

RMSE = "sampled RMSE"
OTHER_METRICS = ("IAE", "effort", "TV")
ADAPTATION = "adaptation"
NEAR = 0.05  # of X, within which P(t) is near it
CHEAP = 0.05  # of the least J, by which a choice may exceed it and still be cheap
SMALL = 0.01  # of a metric, a change that is small
Places = Iterable[tuple[str, int]]
INFORMATION = "All loops: positions, one observer, the true disturbance, the exact model."
RUNS = "Two joints in two scenarios: one run of each scenario without noise, over the whole horizon."
ASSUMPTIONS = "Q, R, l, the horizons, the square wave and the shape of (33), as in report a1."
FITS = "Q, R, l and the horizons, to the printed RMSE, with P(t) of (34)."


class Evidence(NamedTuple):
    """The runs, and what each setting gives along its run."""

    results: wb.Results
    answers: Mapping[tuple[str, str], RunComparison]


def change(
    evidence: Evidence, law: str, metric: str = RMSE, weights: str = ASSUMED_WEIGHTS, places: Places = PLACES
) -> float:
    """The change of a metric without (34), as a mean over places: minus one and the geometric mean of the ratios."""
    logs = []
    for scenario, joint in places:
        weighted = scenario_of(scenario, weights)
        frozen = scenario if law in (AT_START, NONE, ASMC_WITH_OBSERVER) else weighted
        without = evidence.results[frozen, law].score(metric, joint).pair[0]
        logs.append(np.log(without / evidence.results[weighted, FORWARD].score(metric, joint).pair[0]))
    return float(np.expm1(np.mean(logs)))


def size(shift: float, part: str = "(34)") -> str:
    """The worth of a part in words, by the change without it: better or worse with the part, or too close to call."""
    if abs(shift) <= MARGIN:
        return f"within {100 * MARGIN:g} %"
    return f"{'better' if shift > 0 else 'worse'} with {part}"


def variation(words: str, shift: float, part: str = "(34)") -> wb.Variation:
    """A variation whose answer is the size of a change without a part."""
    return wb.Variation(words, size(shift, part), f"{100 * shift:+.3g} %".replace("-", "−"))


def spread(evidence: Evidence, law: str, metric: str = RMSE) -> str:
    """The least and the largest change over the four places, in %."""
    moved = [100 * change(evidence, law, metric, places=[place]) for place in PLACES]
    return f"{min(moved):+.3g} to {max(moved):+.3g} %".replace("-", "−")


def answer(evidence: Evidence) -> str:
    """The part of (34) in the law, in one line."""
    return (
        f"P sets the adaptation rate of K. With P held at its mean, RMSE changes by {spread(evidence, MEAN)}, effort "
        f"by {spread(evidence, MEAN, 'effort')}; at P(0), RMSE by {spread(evidence, AT_START)}, effort by "
        f"{spread(evidence, AT_START, 'effort')}."
    )


def findings(evidence: Evidence) -> tuple[wb.Finding, ...]:
    """The findings of the page."""
    return tuple(one(evidence) for one in (riccati_gain, adaptation, algebraic, distance, cost))


def riccati_gain(evidence: Evidence) -> wb.Finding:
    """The loop with (34) beside the loop with a constant P."""
    kept = {weights: [evidence.answers[s, weights].mean.diagonal() for s in SCENARIOS] for weights in WEIGHTS}
    level = f"{np.min(kept[ASSUMED_WEIGHTS]):.2g} to {np.max(kept[ASSUMED_WEIGHTS]):.2g}"
    names = {MEAN: "frozen at its mean", AT_START: "frozen at P(0)"}
    variations = (
        *(
            variation(f"P {names[law]}, {w}", change(evidence, law, weights=w))
            for w in WEIGHTS
            for law in names
            if (w, law) != (ASSUMED_WEIGHTS, MEAN)
        ),
        *(
            variation(f"joint {j + 1}, {SCENARIOS[s]} alone", change(evidence, MEAN, places=[(s, j)]))
            for s, j in PLACES
        ),
        *(variation(f"{metric} in place of {RMSE}", change(evidence, MEAN, metric)) for metric in OTHER_METRICS),
        *(
            variation(f"{metric} in place of {RMSE}, P frozen at P(0)", change(evidence, AT_START, metric))
            for metric in OTHER_METRICS
        ),
    )
    moved = change(evidence, MEAN)
    return wb.Finding(
        "riccati_gain",
        f"Without (34), with P frozen at its mean over the run, {RMSE} changes by {spread(evidence, MEAN)}; with P "
        f"frozen at P(0) = {CARD['P(0)'][0, 0]:g} N m/rad it changes by {spread(evidence, AT_START)}.",
        f"The diagonal of the mean is {level} N m/rad. P is the rate at which (33) learns: with P frozen above its "
        "mean, the law learns faster, tracks better and takes more torque (effort "
        f"{spread(evidence, AT_START, 'effort')}). With P frozen at its mean, the effort changes by "
        f"{spread(evidence, MEAN, 'effort')}.",
        statistic=f"The change of {RMSE} when (34) is left out, as a geometric mean over joints and scenarios.",
        sample=RUNS,
        information=INFORMATION,
        assumptions=ASSUMPTIONS,
        fitted_numbers=FITS,
        answer=size(moved),
        variations=variations,
        limitations="Noise, sampling and other values of P; report a8 has noise, and freezes P at two values.",
    )


def adaptation(evidence: Evidence) -> wb.Finding:
    """The loop with (34) beside the loop whose gain stays at K(0)."""
    moved = change(evidence, NONE)

    def less(words: str, shift: float) -> wb.Variation:
        return variation(words, shift, ADAPTATION)

    return wb.Finding(
        "adaptation",
        f"Without any adaptation of K, {RMSE} changes by {spread(evidence, NONE)}.",
        f"K then stays at {CARD['K(0)'][0, 0]:g} N m. The effort changes by {spread(evidence, NONE, 'effort')}.",
        statistic=f"The change of {RMSE}, as a geometric mean over joints and scenarios.",
        sample=RUNS,
        information=INFORMATION,
        assumptions=ASSUMPTIONS,
        fitted_numbers=FITS,
        answer=size(moved, ADAPTATION),
        variations=(
            *(less(f"joint {j + 1}, {SCENARIOS[s]} alone", change(evidence, NONE, places=[(s, j)])) for s, j in PLACES),
            *(less(f"{metric} in place of {RMSE}", change(evidence, NONE, metric)) for metric in OTHER_METRICS),
            *(less(f"beside (34) with {w}", change(evidence, NONE, weights=w)) for w in OTHERS),
        ),
        limitations="A constant K above K(0).",
    )


def upper_percent(shift: float) -> str:
    """A change in % with two digits, rounded up."""
    percent = 100 * shift
    step = 10.0 ** (np.floor(np.log10(percent)) - 1)
    return f"{step * np.ceil(percent / step - 1e-9):.2g}"


def share(part: float) -> str:
    """A part in per cent, with two digits."""
    return f"{float(f'{100 * part:.2g}'):,.6g} %"


def algebraic(evidence: Evidence) -> wb.Finding:
    """The loop with the algebraic equation at each instant."""

    def answer_for(shift: float) -> str:
        return f"at most {100 * SMALL:g} %" if shift <= SMALL else f"more than {100 * SMALL:g} %"

    def largest(names: Iterable[str], places: Places = PLACES, weights: str = ASSUMED_WEIGHTS) -> float:
        return max(abs(change(evidence, ALGEBRAIC, name, weights, [place])) for name in names for place in places)

    three = (RMSE, "IAE", "effort")
    others = {
        **{f"{name} alone": largest([name]) for name in three},
        **{f"{name} in place of the three": largest([name]) for name in ("peak error", "peak torque", "TV")},
        **{f"{SCENARIOS[s]} alone": largest(three, [(s, j) for j in (0, 1)]) for s in SCENARIOS},
        **{w: largest(three, weights=w) for w in OTHERS},
        **{f"{RMSE} alone, {w}": largest([RMSE], weights=w) for w in OTHERS},
    }
    return wb.Finding(
        "algebraic",
        f"With the algebraic equation at each instant in place of (34), {RMSE}, IAE and effort change by at most "
        f"{upper_percent(largest(three))} % with the assumed Q and R.",
        "With these Q and R, P(t) of (34) follows the algebraic solution within milliseconds, while K changes over "
        "tenths of a second. With other Q and R the change is larger: up to "
        f"{' and '.join(f'{upper_percent(largest(three, weights=w))} % with {w}' for w in OTHERS)}, where (34) "
        "forgets P(0) more slowly.",
        statistic="The largest change of three metrics over joints and scenarios.",
        sample=RUNS,
        information=INFORMATION,
        assumptions=ASSUMPTIONS,
        fitted_numbers=FITS,
        answer=answer_for(largest(three)),
        variations=tuple(
            wb.Variation(words, answer_for(moved), f"{upper_percent(moved)} %") for words, moved in others.items()
        ),
        limitations="Noise, and other values of P(0).",
    )


def distance(evidence: Evidence) -> wb.Finding:
    """P(t) of (34) beside the algebraic solution."""

    def answer_for(far: float) -> str:
        return f"within {100 * NEAR:g} %" if far <= NEAR else f"beyond {100 * NEAR:g} %"

    gaps = {key: one.comparison.gap(one.comparison.X) for key, one in evidence.answers.items()}
    ours = [gaps[s, ASSUMED_WEIGHTS] for s in SCENARIOS]
    firsts = [evidence.answers[s, ASSUMED_WEIGHTS].comparison for s in SCENARIOS]
    memory = [1e3 * one.memory for one in firsts]
    rises = [path.rise(one.K, one.t) for one in firsts]
    return wb.Finding(
        "distance",
        f"From {1e3 * TRANSIENT:g} ms on, P(t) of (34) differs from the algebraic solution X by at most "
        f"{share(ours[0][1])} (first scenario) and {share(ours[1][1])} (second scenario).",
        f"A difference of two solutions of (34) falls to 1/e in at most {memory[0]:.3g} ms (first scenario) and "
        f"{memory[1]:.3g} ms (second scenario). K takes {rises[0]:.3g} s and {rises[1]:.3g} s for 63 % of its change.",
        statistic="The largest |P - X| / |X| in Frobenius norms.",
        sample=f"One run of each scenario until {WINDOW:g} s.",
        information="K and the estimate of q along the run.",
        assumptions=ASSUMPTIONS,
        fitted_numbers=FITS,
        answer=answer_for(max(largest for _, largest in ours)),
        variations=(
            *(
                wb.Variation(f"{SCENARIOS[s]}, {w}", answer_for(gaps[s, w][1]), share(gaps[s, w][1]))
                for w in OTHERS
                for s in SCENARIOS
            ),
            *(
                wb.Variation(f"{SCENARIOS[s]}, median over time, {w}", answer_for(gaps[s, w][0]), share(gaps[s, w][0]))
                for w in WEIGHTS
                for s in SCENARIOS
            ),
        ),
        limitations="Times after 2.5 s.",
    )


def cost(evidence: Evidence) -> wb.Finding:
    """J of (32) with P(t) of (34) and with other choices."""

    def answer_for(ratio: float) -> str:
        return f"at most {100 * CHEAP:g} % more" if ratio <= 1 + CHEAP else f"over {100 * CHEAP:g} % more"

    ratios = {key: one.comparison.ratios for key, one in evidence.answers.items()}
    ours = [ratios[s, ASSUMED_WEIGHTS][path.FORWARD] for s in SCENARIOS]
    variations = tuple(
        wb.Variation(f"{SCENARIOS[s]}, {choice}, {w}", answer_for(ratio), f"{ratio:.4g} times the least")
        for (s, w), found in ratios.items()
        for choice, ratio in found.items()
        if (choice, w) != (path.FORWARD, ASSUMED_WEIGHTS)
    )
    return wb.Finding(
        "cost",
        "With P(t) of (34) in the feedback u = -R^-1 B' P(t) s of (31), J of (32) is "
        f"{100 * (ours[0] - 1):.2g} % (first scenario) and {100 * (ours[1] - 1):.2g} % (second scenario) above the "
        "least J.",
        "The law applies no such u: it uses P in (33), as a rate of learning.",
        statistic=f"The ratio of J of (32), over the first {WINDOW:g} s from the worst s(0), to the least J.",
        sample="A along one run of each scenario.",
        information="K and the estimate of q along the run.",
        assumptions=f"{ASSUMPTIONS} The input u, which the paper does not print.",
        fitted_numbers=FITS,
        answer=answer_for(max(ours)),
        variations=variations,
        limitations="Other horizons of J.",
    )


def frozen_table(evidence: Evidence) -> wb.document.ReportTable:
    """The change of three metrics without (34), by the weights, the value of P and the place."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for weights in WEIGHTS:
        for law in (MEAN, AT_START):
            for s, j in PLACES:
                P = evidence.answers[s, weights].mean if law == MEAN else np.asarray(CARD["P(0)"])
                values = ", ".join(f"{value:.3g}" for value in P.diagonal())
                moved = (100 * change(evidence, law, name, weights, [(s, j)]) for name in (RMSE, "effort", "TV"))
                scenario = SCENARIOS[s].removesuffix(" scenario")
                rows.append((weights, law, values, scenario, j + 1, *(f"{value:+.3g}" for value in moved)))
    heads = ("weights", "P in place of (34)", "diagonal of P [N m/rad]", "scenario", "joint")
    changes = (f"change of {RMSE} [%]", "change of effort [%]", "change of TV [%]")
    columns = (
        *map(wb.document.TableColumn, heads),
        *(wb.document.TableColumn(head, align="right") for head in changes),
    )
    caption = "The change of three metrics with P frozen, compared with the same law with P(t) of (34)."
    note = "P(0) exceeds the value at which (34) settles: with P = P(0) the law learns faster, most so if Q is small."
    return wb.document.ReportTable("frozen", caption, columns, tuple(rows), (note,))
