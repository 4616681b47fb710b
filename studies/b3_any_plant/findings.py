"""What b3 found, each sentence made of its figures."""

from __future__ import annotations

import numpy as np

from studies.b3_any_plant.loops import COMPUTER, LAWS, LQG, LQR, PID, called, cut, margins
from studies.b3_any_plant.settings import EASY, HARD, SETTINGS, Setting
from workbench.design.linear import sensitivity
from workbench.study import Results, Section, Verdict, sobol
from workbench.study.evidence.law_tables import order
from workbench.study.uncertainty import SobolIndices
from workbench.validation.refusals import Array

BY_NAME = {setting.name: setting for setting in SETTINGS}
COUNT = len(SETTINGS)
GIVEN = "Both laws: the same outputs. LQG: the linear model with its true numbers too. PID: no model."


def findings(results: Results) -> Section:
    """The answers first."""
    return Section(
        "What was found",
        (_runs(results), _errors(results), _commands(results), _filters(), _parameters(results), _tanks(), _masses()),
    )


def _runs(results: Results) -> Verdict:
    ends = [settled(results, setting, f"{law} {COMPUTER}") for setting in SETTINGS for law in LAWS]
    growth = [
        rms(results, setting, f"{law} {COMPUTER}")[0] / rms(results, setting, law)[0]
        for setting in SETTINGS
        for law in LAWS
    ]
    return Verdict(
        "found",
        f"{sum(ends)} of {len(ends)} loops come to rest in a computer, where the RMSE is {min(growth):.2f} to "
        f"{max(growth):.2f} times that in continuous time.",
        "A computer reads with noise, keeps the commands within limits, and acts a period late; in continuous time "
        "readings are exact and nothing is limited. A limit may even help, where it cuts what a law would overdo.",
        estimand="Whether the error stays within 5 % of that of the start from some instant on, and RMSE of one "
        f"output over the run, for {COUNT} settings and two laws, one start and one draw of the noise each.",
        given=GIVEN,
        reversal="Longer periods: the summary has the delay that each loop stands, in periods.",
    )


def _tanks() -> Verdict:
    easy, hard = (BY_NAME[name] for name in (EASY, HARD))
    slow = {s.name: -sensitivity(cut(s, PID)).poles().real.max() for s in (easy, hard)}
    optimal = {s.name: -s.design.poles.real.max() for s in (easy, hard)}
    zero = hard.model.zeros().real.max()
    return Verdict(
        "found",
        f"Under two PI controllers the slowest mode of the four tanks decays {slow[EASY] / slow[HARD]:.0f} times more "
        "slowly at P+ than at P\N{MINUS SIGN}, as the publication says of its settling times.",
        f"At P+ a zero at {zero:+.4f} 1/s bounds what any law can reach: LQG, given the model, decays with "
        f"{optimal[HARD]:.4f} 1/s there and with {optimal[EASY]:.4f} 1/s at P\N{MINUS SIGN}, by the same weights.",
        estimand="The slowest pole of the linear loop at rest, for both settings of the valves.",
        given="The published gains of both settings, of two PI controllers that read one level each.",
        reversal="Other gains, within what the zero allows.",
    )


def _masses() -> Verdict:
    setting = BY_NAME["two masses"]
    return Verdict(
        "holds",
        "No PID of x_2 whose derivative has a filter of first order makes the two masses stable.",
        "The characteristic polynomial begins with a, a N, b, b N, whatever the gains: N is the filter's bandwidth, "
        "a = m_1 m_2, b = k (m_1 + m_2). Its second Hurwitz determinant, a N b \N{MINUS SIGN} a b N, is zero and would "
        "have to be positive. A PD with a filter of second order is stable: its disk margin is "
        f"{margins(setting, PID).disk.alpha:.2f}, that of LQG {margins(setting, LQG).disk.alpha:.2f}.",
        estimand="The characteristic polynomial of the linear loop, for all masses, stiffnesses, gains and filters.",
        given="The position of the second mass alone.",
        reversal="Friction, or a reading of the first mass.",
    )


def _filters() -> Verdict:
    change = {s.name: (margins(s, LQR).disk.alpha, margins(s, LQG).disk.alpha) for s in SETTINGS}
    less = [name for name, (full, seen) in change.items() if seen < full]
    worst = min(change, key=lambda name: change[name][1] / change[name][0])
    smaller = [s.name for s in SETTINGS if margins(s, LQG).disk.alpha < margins(s, PID).disk.alpha]
    return Verdict(
        "found",
        f"The Kalman filter takes from the disk margin of its regulator in {len(less)} of {COUNT} settings, most for "
        f"the {worst}: {change[worst][0]:.2f} with all states read, {change[worst][1]:.2f} with the filter.",
        f"A regulator that reads all states has margins that are guaranteed; behind a filter it has none that are "
        f"(Doyle 1978). In {len(smaller)} of {COUNT} settings LQG has the smaller disk margin of the two laws.",
        estimand="The disk margin of all inputs at once of the linear loop at rest.",
        given=f"The regulator alone: all states. {GIVEN}",
        reversal="More noise that is assumed at the inputs, which brings the margins back where the plant has no zero "
        "in the right half-plane.",
    )


def _errors(results: Results) -> Verdict:
    sides = {where: [_order(results, s, where) for s in SETTINGS] for where in ("", f" {COMPUTER}")}
    tally = {where: [one.count(word) for word in ("below", "above")] for where, one in sides.items()}
    same = sum(a == b for a, b in zip(*sides.values(), strict=True))
    (less, more), (less_there, more_there) = tally.values()
    return Verdict(
        "depends",
        f"LQG has the smaller RMSE in {less} of {COUNT} settings and PID in {more}; in a computer LQG in {less_there} "
        f"and PID in {more_there}. In {same} the order is the same in both.",
        "No law is called the better one: the two are given unlike things, and none was tuned for this error.",
        estimand="RMSE of one output over the run, one start, and in a computer one draw of the noise; a gap within "
        "the errors of the step is not counted.",
        given=GIVEN,
        reversal="Other weights of LQG or other gains of PID: neither was searched for.",
    )


def _commands(results: Results) -> Verdict:
    busy = {s.name: [results[s.name, f"{law} {COMPUTER}"].score("TV", 0)[0] for law in LAWS] for s in SETTINGS}
    ratio = {name: other / one for name, (one, other) in busy.items()}
    most, least = max(ratio, key=ratio.__getitem__), min(ratio, key=ratio.__getitem__)
    return Verdict(
        "found",
        f"In a computer the commands of PID move {ratio[most]:.0f} times as much as those of LQG for the {most}, and "
        f"those of LQG {1 / ratio[least]:.0f} times as much as those of PID for the {least}; PID's move more in "
        f"{sum(r > 1 for r in ratio.values())} of {COUNT} settings.",
        "A filtered derivative passes the noise of a reading on, a Kalman filter weighs it against its model.",
        estimand="Total variation of the first input over the run, at the instants of the computer, one start and one "
        "draw of the noise.",
        given=GIVEN,
        reversal="A lower bandwidth of the derivative filters, which costs phase.",
    )


def _order(results: Results, setting: Setting, where: str) -> str:
    one, other = (rms(results, setting, f"{law}{where}") for law in LAWS)
    return order(one, other)


def _parameters(results: Results) -> Verdict:
    spread = {s.name: [deviation(results, s, law) for law in LAWS] for s in SETTINGS}
    wider = [name for name, (one, other) in spread.items() if one > other]
    worst = max(spread, key=lambda name: spread[name][0] / spread[name][1])
    deciding = indices(BY_NAME[worst], results)[LQG]
    first = int(np.argmax(deciding.ST.value))
    lost = sum(results.sample(called(s, law)).failed for s in SETTINGS for law in LAWS)
    return Verdict(
        "found",
        f"Where the plant is another than the designer believes, the RMSE scatters more under LQG than under PID in "
        f"{len(wider)} of {COUNT} settings, most so for the {worst}: by {100 * spread[worst][0]:.0f} % and "
        f"{100 * spread[worst][1]:.0f} %.",
        f"There {deciding.factors[first]} decides it under LQG (ST = {deciding.ST.value[first]:.2f}, from "
        f"{deciding.ST.low[first]:.2f} to {deciding.ST.high[first]:.2f}). LQG has no integral here, so that a plant "
        f"that needs another input than was believed is left off its level. Of all runs {lost} diverged.",
        estimand="Standard deviation of the RMSE of one output over its mean, over the ranges of the parameters, in "
        "continuous time.",
        given=GIVEN,
        reversal="An integral of the error in LQG, or narrower ranges.",
    )


def settled(results: Results, setting: Setting, law: str) -> bool:
    """Whether the main output settles in the run."""
    return bool(np.isfinite(results[setting.name, law].score(f"settling time of {setting.main}", 0)[0]))


def rms(results: Results, setting: Setting, law: str) -> tuple[float, float]:
    """The RMSE of the main output and its error."""
    return results[setting.name, law].score(f"RMSE of {setting.main}", 0)


def errors(results: Results, setting: Setting, law: str) -> Array:
    """The RMSE of each run of the sweep of a plant and a law."""
    return results.sample(called(setting, law)).outputs(f"RMSE of {setting.main}")


def deviation(results: Results, setting: Setting, law: str) -> float:
    """The standard deviation of the RMSE over the parameters of a plant, over its mean."""
    values = errors(results, setting, law)
    return float(np.nanstd(values) / np.nanmean(values))


def indices(setting: Setting, results: Results) -> SobolIndices:
    """Sobol indices of the RMSE, an output a law."""
    sample = results.sample(called(setting, LQG))
    outputs = np.stack([errors(results, setting, law) for law in LAWS], axis=1)
    return sobol(sample.design, outputs, LAWS, factors=sample.factors, control=True)
