"""The findings of a3: the loop with a constant P, with the algebraic equation, and P(t) beside other solutions."""

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

import workbench as wb
from studies.a3_riccati_gains import path
from studies.a3_riccati_gains.path import SETTLED, WINDOW, Along
from studies.a3_riccati_gains.settings import (
    ALGEBRAIC,
    ASSUMED,
    AT_START,
    FORWARD,
    MEAN,
    NONE,
    OBSERVED,
    OTHERS,
    PLACES,
    WEIGHTS,
    scenario_of,
)
from studies.paper.card import CARD, MARGIN, SCENARIOS

RMSE = "sampled RMSE"
ADAPTATION = "adaptation"
NEAR = 0.05  # of X, within which P(t) is near it
CHEAP = 0.05  # of the least J, by which a choice may exceed it and still be cheap
SMALL = 0.01  # of a metric, a change that is small
Places = Iterable[tuple[str, int]]
GIVEN = "All loops: positions, one observer, the true disturbance, the exact model."
RUNS = "Two joints in two scenarios, one run each without noise, over the whole horizon."
CHOSEN = "Q, R, l, the horizons, the square wave and the shape of (33), as a1 has them."
FITTED = "Q, R, l and the horizons to the printed RMSE, with P(t) of (34)."


class Evidence(NamedTuple):
    """The runs, and what each setting gives along its run."""

    results: wb.Results
    answers: Mapping[tuple[str, str], Along]


def change(held: Evidence, law: str, metric: str = RMSE, weights: str = ASSUMED, places: Places = PLACES) -> float:
    """The change of a metric without (34), as a mean over places: minus one and the geometric mean of the ratios."""
    logs = []
    for scenario, joint in places:
        frozen = scenario if law in (AT_START, NONE, OBSERVED) else scenario_of(scenario, weights)
        without = held.results[frozen, law].score(metric, joint).pair[0]
        logs.append(
            np.log(without / held.results[scenario_of(scenario, weights), FORWARD].score(metric, joint).pair[0])
        )
    return float(np.expm1(np.mean(logs)))


def size(moved: float, part: str = "(34)") -> str:
    """The worth of a part in words, by the change without it: better or worse with the part, or too close to call."""
    if abs(moved) <= MARGIN:
        return f"within {100 * MARGIN:g} %"
    return f"{'better' if moved > 0 else 'worse'} with {part}"


def variation(words: str, moved: float, part: str = "(34)") -> wb.Variation:
    """A variation whose answer is the size of a change without a part."""
    return wb.Variation(words, size(moved, part), f"{100 * moved:+.3g} %")


def spread(held: Evidence, law: str, metric: str = RMSE) -> str:
    """The least and the largest change over the four places, in %."""
    moved = [100 * change(held, law, metric, places=[place]) for place in PLACES]
    return f"{min(moved):+.3g} to {max(moved):+.3g} %"


def answer(held: Evidence) -> str:
    """The part of (34) in the law, in one line."""
    return (
        f"(34) sets how fast K learns: P frozen at its mean changes RMSE by {spread(held, MEAN)} and effort by "
        f"{spread(held, MEAN, 'effort')}; at P(0), RMSE by {spread(held, AT_START)} and effort by "
        f"{spread(held, AT_START, 'effort')}."
    )


def findings(held: Evidence) -> tuple[wb.Finding, ...]:
    """The findings of the page."""
    return tuple(one(held) for one in (riccati_gain, adaptation, algebraic, distance, cost))


def riccati_gain(held: Evidence) -> wb.Finding:
    """The loop with (34) beside the loop with a constant P."""
    kept = {weights: [held.answers[s, weights].mean.diagonal() for s in SCENARIOS] for weights in WEIGHTS}
    level = f"{np.min(kept[ASSUMED]):.2g} to {np.max(kept[ASSUMED]):.2g}"
    names = {MEAN: "frozen at its mean", AT_START: "frozen at P(0)"}
    variations = (
        *(
            variation(f"P {names[law]}, {w}", change(held, law, weights=w))
            for w in WEIGHTS
            for law in names
            if (w, law) != (ASSUMED, MEAN)
        ),
        *(variation(f"joint {j + 1}, {SCENARIOS[s]} alone", change(held, MEAN, places=[(s, j)])) for s, j in PLACES),
        *(variation(f"{metric} in place of {RMSE}", change(held, MEAN, metric)) for metric in ("IAE", "effort", "TV")),
        *(
            variation(f"{metric} in place of {RMSE}, P frozen at P(0)", change(held, AT_START, metric))
            for metric in ("IAE", "effort", "TV")
        ),
    )
    moved = change(held, MEAN)
    return wb.Finding(
        "riccati_gain",
        f"Without (34), with P frozen at its mean over the run, {RMSE} changes by {spread(held, MEAN)}; with P frozen "
        f"at P(0) = {CARD['P(0)'][0, 0]:g} N m/rad it changes by {spread(held, AT_START)}.",
        f"The diagonal of the mean is {level} N m/rad. P is the rate at which (33) learns: a P that is frozen above "
        f"its mean learns faster, tracks better and takes more torque (effort {spread(held, AT_START, 'effort')}). "
        f"Frozen at its mean, it changes the effort by {spread(held, MEAN, 'effort')}.",
        statistic=f"The change of {RMSE} when (34) is left out, as a geometric mean over joints and scenarios.",
        sample=RUNS,
        given=GIVEN,
        chosen=CHOSEN,
        fitted=FITTED,
        answer=size(moved),
        variations=variations,
        untried="Noise, sampling and other values of P; a8 has noise, and freezes P at two values.",
    )


def adaptation(held: Evidence) -> wb.Finding:
    """The loop with (34) beside the loop whose gain stays at K(0)."""
    moved = change(held, NONE)

    def less(words: str, moved: float) -> wb.Variation:
        return variation(words, moved, ADAPTATION)

    return wb.Finding(
        "adaptation",
        f"Without any adaptation of K, {RMSE} changes by {spread(held, NONE)}.",
        f"K then stays at {CARD['K(0)'][0, 0]:g} N m. The effort changes by {spread(held, NONE, 'effort')}.",
        statistic=f"The change of {RMSE}, as a geometric mean over joints and scenarios.",
        sample=RUNS,
        given=GIVEN,
        chosen=CHOSEN,
        fitted=FITTED,
        answer=size(moved, ADAPTATION),
        variations=(
            *(less(f"joint {j + 1}, {SCENARIOS[s]} alone", change(held, NONE, places=[(s, j)])) for s, j in PLACES),
            *(less(f"{metric} in place of {RMSE}", change(held, NONE, metric)) for metric in ("IAE", "effort", "TV")),
            *(less(f"beside (34) with {w}", change(held, NONE, weights=w)) for w in OTHERS),
        ),
        untried="A constant K above K(0).",
    )


def bound(moved: float) -> str:
    """A change in % with two digits, rounded up."""
    percent = 100 * moved
    step = 10.0 ** (np.floor(np.log10(percent)) - 1)
    return f"{step * np.ceil(percent / step - 1e-9):.2g}"


def share(part: float) -> str:
    """A part in per cent, with two digits."""
    return f"{float(f'{100 * part:.2g}'):,.6g} %"


def algebraic(held: Evidence) -> wb.Finding:
    """The loop with the algebraic equation at each instant."""

    def said(moved: float) -> str:
        return f"at most {100 * SMALL:g} %" if moved <= SMALL else f"more than {100 * SMALL:g} %"

    def largest(names: Iterable[str], places: Places = PLACES, weights: str = ASSUMED) -> float:
        return max(abs(change(held, ALGEBRAIC, name, weights, [place])) for name in names for place in places)

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
        f"{bound(largest(three))} % with the assumed Q and R.",
        "With these P(t) of (34) follows the algebraic solution within milliseconds; K moves in tenths of a second. "
        f"The change is up to {' and '.join(f'{bound(largest(three, weights=w))} % with {w}' for w in OTHERS)}, where "
        "(34) forgets P(0) more slowly.",
        statistic="The largest change of three metrics over joints and scenarios.",
        sample=RUNS,
        given=GIVEN,
        chosen=CHOSEN,
        fitted=FITTED,
        answer=said(largest(three)),
        variations=tuple(wb.Variation(words, said(moved), f"{bound(moved)} %") for words, moved in others.items()),
        untried="Noise, and other values of P(0).",
    )


def distance(held: Evidence) -> wb.Finding:
    """P(t) of (34) beside the algebraic solution."""

    def said(far: float) -> str:
        return f"within {100 * NEAR:g} %" if far <= NEAR else f"beyond {100 * NEAR:g} %"

    gaps = {key: one.compared.gap(one.compared.X) for key, one in held.answers.items()}
    ours = [gaps[s, ASSUMED] for s in SCENARIOS]
    firsts = [held.answers[s, ASSUMED].compared for s in SCENARIOS]
    memory = [1e3 * one.memory for one in firsts]
    rises = [path.rise(one.K, one.t) for one in firsts]
    return wb.Finding(
        "distance",
        f"P(t) of (34) is at most {share(ours[0][1])} (first scenario) and {share(ours[1][1])} (second) from the "
        f"algebraic solution X, from {1e3 * SETTLED:g} ms on.",
        f"A difference of two solutions of (34) falls to 1/e in at most {memory[0]:.3g} and {memory[1]:.3g} ms; K "
        f"takes {rises[0]:.3g} and {rises[1]:.3g} s for 63 % of its way.",
        statistic="The largest |P - X| / |X| in Frobenius norms.",
        sample=f"One run a scenario until {WINDOW:g} s.",
        given="K and the estimate of q along the run.",
        chosen=CHOSEN,
        fitted=FITTED,
        answer=said(max(largest for _, largest in ours)),
        variations=(
            *(
                wb.Variation(f"{SCENARIOS[s]}, {w}", said(gaps[s, w][1]), share(gaps[s, w][1]))
                for w in OTHERS
                for s in SCENARIOS
            ),
            *(
                wb.Variation(f"{SCENARIOS[s]}, median over time, {w}", said(gaps[s, w][0]), share(gaps[s, w][0]))
                for w in WEIGHTS
                for s in SCENARIOS
            ),
        ),
        untried="Times after 2.5 s.",
    )


def cost(held: Evidence) -> wb.Finding:
    """J of (32) with P(t) of (34) and with other choices."""

    def said(ratio: float) -> str:
        return f"at most {100 * CHEAP:g} % more" if ratio <= 1 + CHEAP else f"over {100 * CHEAP:g} % more"

    ratios = {key: one.compared.ratios for key, one in held.answers.items()}
    ours = [ratios[s, ASSUMED][path.FORWARD] for s in SCENARIOS]
    variations = tuple(
        wb.Variation(f"{SCENARIOS[s]}, {choice}, {w}", said(ratio), f"{ratio:.4g} times the least")
        for (s, w), found in ratios.items()
        for choice, ratio in found.items()
        if (choice, w) != (path.FORWARD, ASSUMED)
    )
    return wb.Finding(
        "cost",
        f"As a feedback u = -R^-1 B' P(t) s of (31), P(t) of (34) costs {100 * (ours[0] - 1):.2g} % (first scenario) "
        f"and {100 * (ours[1] - 1):.2g} % (second) more than the least J of (32).",
        "The law applies no such u: it uses P in (33), as a rate of learning.",
        statistic=f"J of (32) over the first {WINDOW:g} s from the worst s(0), over the least J.",
        sample="A along one run a scenario.",
        given="K and the estimate of q along the run.",
        chosen=f"{CHOSEN} The input u, which the paper does not print.",
        fitted=FITTED,
        answer=said(max(ours)),
        variations=variations,
        untried="Other horizons of J.",
    )


def frozen_table(held: Evidence) -> wb.document.Table:
    """The change of three metrics without (34), by the weights, the value of P and the place."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for weights in WEIGHTS:
        for law in (MEAN, AT_START):
            for s, j in PLACES:
                P = held.answers[s, weights].mean if law == MEAN else np.asarray(CARD["P(0)"])
                values = ", ".join(f"{value:.3g}" for value in P.diagonal())
                moved = (100 * change(held, law, name, weights, [(s, j)]) for name in (RMSE, "effort", "TV"))
                scenario = SCENARIOS[s].removesuffix(" scenario")
                rows.append((weights, law, values, scenario, j + 1, *(f"{value:+.3g}" for value in moved)))
    heads = ("weights", "P in place of (34)", "its diagonal [N m/rad]", "scenario", "joint")
    changes = (f"change of {RMSE} [%]", "change of effort [%]", "change of TV [%]")
    columns = (*map(wb.document.Column, heads), *(wb.document.Column(head, align="right") for head in changes))
    caption = "Three metrics with P frozen, against the same law with P(t) of (34)."
    note = "P(0) exceeds what (34) settles at, so P = P(0) learns faster than (34) does, most of all where Q is small."
    return wb.document.Table("frozen", caption, columns, tuple(rows), (note,))
