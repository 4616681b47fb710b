"""The findings of b3, each with every variation that the study has, and its one claim."""

from __future__ import annotations

import numpy as np

import workbench as wb
from studies.b3_any_plant.loops import (
    COMPUTER,
    DIGITAL,
    LAWS,
    LQG,
    LQR,
    PID,
    PUSHED_CASES,
    PUSHES,
    all_margins,
    errors,
    indices,
)
from studies.b3_any_plant.orders import ORIGIN, leader, orders, standing, variations_of
from studies.b3_any_plant.settings import REGULATOR, SETTINGS
from studies.b3_any_plant.tank_findings import tank_finding

COUNT = len(SETTINGS)
OUTLET = ", the outlet area of tanks 1 and 3"
LAST = "Gains, weights, starts, horizons and noise are ours, except the gains of the tanks' PI, which are published."


def findings(results: wb.Results) -> tuple[wb.Finding, ...]:
    """All findings, those of the runs first."""
    made = (rest_finding, error_finding, tank_finding, margin_finding, parameter_finding)
    return tuple(one(results) for one in made)


def information() -> str:
    """The information that each law has, with the origin of the gains of PID."""
    return f"Both laws: the same outputs. LQG: the linear model with the plant's nominal numbers. PID: {ORIGIN}."


def rest_finding(results: wb.Results) -> wb.Finding:
    """The loops that settle, and what the computer does to their errors."""
    pairs = [(setting, law) for setting in SETTINGS for law in LAWS]
    growth, ends = {}, {}
    for setting, law in pairs:
        here, there = results[setting.name, law], results[setting.name, f"{law} {COMPUTER}"]
        metric, time = f"RMSE of {setting.main}", f"settling time of {setting.main}"
        growth[setting.name, law] = there.score(metric).pair[0] / here.score(metric).pair[0]
        ends[setting.name, law] = [run.score(time).pair[0] for run in (here, there)]
    settled = [sum(np.isfinite(one[i]) for one in ends.values()) for i in (0, 1)]
    delays = {(s.name, law): all_margins(results)[s.name, law].delay / s.period for s, law in pairs}
    name, law = min(delays, key=delays.__getitem__)
    return wb.Finding(
        name="rest_in_a_computer",
        statement=f"W{DIGITAL[1:]}, {settled[1]} of {len(pairs)} loops settle, with {min(growth.values()):.2f} to "
        f"{max(growth.values()):.2f} times their RMSE in continuous time.",
        evidence="The digital controller samples noisy readings, limits the commands and acts one period late. In "
        "continuous time, the readings are exact and nothing is limited. In "
        f"{sum(one < 1 for one in growth.values())} of {len(pairs)} loops the RMSE is smaller {DIGITAL}.",
        statistic="Settling: the error of one output stays within 5 % of the error at the start. RMSE: of that output "
        "over the whole run.",
        sample=f"{COUNT} settings of eight plants, two laws; for each loop one start and one sequence of noise.",
        information=information(),
        assumptions=LAST,
        answer=f"{settled[1]} of {len(pairs)}",
        variations=(wb.Variation("in continuous time", f"{settled[0]} of {len(pairs)}"),),
        limitations="other starts, other noise, and longer periods; the least delay margin is "
        f"{delays[name, law]:.1f} periods ({name}, {law}), of which the digital controller itself uses 1.5",
    )


def error_finding(results: wb.Results) -> wb.Finding:
    """The law with the smaller error, and every other statistic of which law is better."""
    every = orders(results)
    first, *_ = every
    less, more = standing(every[first])
    busy = {s.name: [results[s.name, f"{law} {COMPUTER}"].score("TV").pair[0] for law in LAWS] for s in SETTINGS}
    ratio = {name: other / one for name, (one, other) in busy.items()}
    most, least = max(ratio, key=ratio.__getitem__), min(ratio, key=ratio.__getitem__)
    own = [setting.name for setting in SETTINGS if setting.pid.origin == REGULATOR]
    return wb.Finding(
        name="smaller_error",
        statement=f"LQG has the smaller RMSE in {less} of {COUNT} settings and PID in {more}. This makes "
        "neither the better law, since other statistics give other counts.",
        evidence=f"In {len(own)} settings ({', '.join(own)}) both laws have the same gain and differ in their filters "
        f"alone. W{DIGITAL[1:]}, PID's commands have {ratio[most]:.0f} times the total variation of LQG's for the "
        f"{most}; for the {least}, LQG's commands have {1 / ratio[least]:.0f} times the total variation of PID's.",
        statistic="The law with the smaller RMSE of one output over the run, counted over the settings. A difference "
        "within the errors of the step counts for neither.",
        sample=f"{COUNT} settings, one start each, in continuous time; {DIGITAL}, one sequence of noise.",
        information=information(),
        assumptions=LAST,
        answer=leader(every[first]),
        variations=variations_of(every),
        limitations="other weights of LQG and other gains of PID: neither was searched for",
    )


def margin_finding(results: wb.Results) -> wb.Finding:
    """The disk margin with all states read, and behind a filter."""
    by, pushed = all_margins(results), dict(zip(PUSHED_CASES, results.work("recovery"), strict=True))
    disks = {s.name: [by[s.name, law].disk for law in (LQR, LQG, PID)] for s in SETTINGS}
    worst = min(disks, key=lambda name: disks[name][1] / disks[name][0])
    fewer = sum(behind < full for full, behind, _ in disks.values())
    shares = {s.name: pushed[s.name, PUSHES[-1]] / disks[s.name][0] for s in SETTINGS}
    grown = [s.name for s in SETTINGS if pushed[s.name, PUSHES[-1]] > disks[s.name][1]]
    left = ", ".join(s.name for s in SETTINGS if s.name not in grown)
    delays = [by[s.name, LQG].delay < by[s.name, LQR].delay for s in SETTINGS]
    varied = [
        wb.Variation(
            f"a filter designed for {factor:,.0f} times the input noise",
            f"smaller in {sum(pushed[s.name, factor] < disks[s.name][0] for s in SETTINGS)} of {COUNT}",
        )
        for factor in PUSHES
    ]
    return wb.Finding(
        name="margin_behind_a_filter",
        statement=f"Behind its Kalman filter the regulator has a smaller disk margin than with all states read, in "
        f"{fewer} of {COUNT} settings; the largest loss, from {disks[worst][0]:.2f} to {disks[worst][1]:.2f}, is for "
        f"the {worst}.",
        evidence=f"A filter designed for {PUSHES[-1]:,.0f} times the input noise raises the margin in {len(grown)} of "
        f"{COUNT} settings, to {100 * min(shares[name] for name in grown):.0f} % of the regulator's or more. It does "
        f"not raise the margin for {left}, which has a zero in the right half-plane.",
        statistic="The disk margin of all inputs at once, of the linear loop at rest.",
        sample=f"{COUNT} settings, each with a regulator of all states, LQG and PID.",
        information=f"The regulator alone: all states. {information()}",
        assumptions=LAST,
        answer=f"smaller in {fewer} of {COUNT}",
        variations=(
            wb.Variation("the delay margin of the worst input", f"smaller in {sum(delays)} of {COUNT}"),
            *varied,
        ),
        limitations="other weights of the regulator",
    )


def scatter(values: np.ndarray) -> dict[str, float]:
    """The scatter of errors by several statistics, relative to mean or median; runs that diverged are left out."""
    low, middle, high, top = np.nanquantile(values, (0.25, 0.5, 0.75, 0.95))
    return {
        "standard deviation over mean": float(np.nanstd(values) / np.nanmean(values)),
        "quartile distance over median": float((high - low) / middle),
        "95th percentile over median": float(top / middle - 1),
    }


def parameter_finding(results: wb.Results) -> wb.Finding:
    """The scatter of the error over the plant's parameters, and the parameter that causes most of it."""
    spread = {s.name: [scatter(errors(results, s, law)) for law in LAWS] for s in SETTINGS}
    every = {
        name: {
            plant: "above" if one[name] > other[name] else "below" if one[name] < other[name] else "equal"
            for plant, (one, other) in spread.items()
        }
        for name in next(iter(spread.values()))[0]
    }
    first, *_ = every
    worst = max(spread, key=lambda name: spread[name][0][first] / spread[name][1][first])
    deciding = indices(next(s for s in SETTINGS if s.name == worst), results)[LQG]
    top = int(np.argmax(deciding.ST.value))
    more = sum(one == "above" for one in every[first].values())
    return wb.Finding(
        name="scatter_over_parameters",
        statement=f"If the plant's numbers differ from the nominal ones, the RMSE scatters more under LQG than under "
        f"PID in {more} of {COUNT} settings. For the {worst}, its standard deviation is "
        f"{100 * spread[worst][0][first]:.0f} "
        f"% of its mean under LQG and {100 * spread[worst][1][first]:.0f} % under PID.",
        evidence=f"There, under LQG, the parameter with the largest total Sobol index is {deciding.factors[top]}"
        f"{OUTLET * (deciding.factors[top] == 'a_1')}: the index is {deciding.ST.value[top]:.2f} "
        f"({deciding.ST.low[top]:.2f} to {deciding.ST.high[top]:.2f}). LQG has no integral. A plant that needs another "
        "input at rest than the nominal one therefore stays off its level.",
        statistic="Standard deviation over mean of the RMSE of one output, over the ranges of the plant's parameters.",
        sample=f"{sum(len(sample) for sample in results.samples):,} runs in continuous time, of which "
        f"{sum(sample.diverged_count for sample in results.samples)} diverged; the same points for both laws.",
        information=information(),
        assumptions=f"Ranges of the parameters. {LAST}",
        answer="LQG",
        variations=variations_of(every, larger=True),
        limitations="an integral of the error in LQG, and narrower ranges",
    )


def mass_claim(results: wb.Results) -> wb.document.Verdict:
    """The two masses, which no PID with a simple filter makes stable."""
    pd, filtered = (all_margins(results)["two masses", law].disk for law in (PID, LQG))
    return wb.document.Verdict(
        "holds",
        "No PID of x_2 whose derivative has a filter of first order makes the two masses asymptotically stable.",
        "The first four coefficients of the characteristic polynomial are a, a N, b, b N, for all gains: N is the "
        "filter's bandwidth, a = m_1 m_2, b = k (m_1 + m_2). Its second Hurwitz determinant, a N b \N{MINUS SIGN} a "
        "b N, is zero; stability needs a positive one. The loop of a PD with a filter of second order is stable: its "
        f"disk margin is {pd:.2f}, and that of LQG is {filtered:.2f}. With friction at both masses, or a reading of "
        "x_1, the loop of a PD with a filter of first order is stable, too.",
    )


def answer(results: wb.Results) -> str:
    """The page in one line."""
    rest, _, tanks, *_ = findings(results)
    less, _ = standing(next(iter(orders(results).values())))
    return (
        f"{rest.answer} digital loops settle. LQG's RMSE is smaller in {less} of {COUNT} settings; other statistics "
        f"differ. Under PI, quadruple-tank level h_1 settles in {tanks.answer} times the time with a right half-plane "
        "zero; the zero does not force this."
    )
