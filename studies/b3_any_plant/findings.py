"""The findings of b3, each a sentence with its figures."""

from __future__ import annotations

import numpy as np

from studies.b3_any_plant.loops import COMPUTER, LAWS, LQG, LQR, PID, all_margins, errors, indices
from studies.b3_any_plant.settings import EASY, HARD, SETTINGS
from workbench.study import Results, Verdict
from workbench.study.evidence.law_tables import order

BY_NAME = {setting.name: setting for setting in SETTINGS}
COUNT = len(SETTINGS)
GIVEN = "Both laws: the same outputs. LQG: the linear model with its true numbers too. PID: no model."


def findings(results: Results) -> tuple[Verdict, ...]:
    """All findings: of the runs, then of the linear loops, then over the parameters."""
    runs = (*error_findings(results), command_finding(results))
    return (*runs, margin_finding(results), parameter_finding(results), tank_finding(results), mass_finding(results))


def error_findings(results: Results) -> tuple[Verdict, Verdict]:
    """The errors of the runs, in continuous time and in a computer."""
    pairs = [(setting, law) for setting in SETTINGS for law in LAWS]
    ends = [results[s.name, f"{law} {COMPUTER}"].score(f"settling time of {s.main}").pair[0] for s, law in pairs]
    # the RMSE with its error, of a plant and a law: in continuous time, in a computer
    rms = {
        (s.name, law): [
            results[s.name, f"{law}{where}"].score(f"RMSE of {s.main}").pair for where in ("", f" {COMPUTER}")
        ]
        for s, law in pairs
    }
    growth = [there[0] / here[0] for here, there in rms.values()]
    orders = [[order(rms[s.name, LQG][i], rms[s.name, PID][i]) for s in SETTINGS] for i in (0, 1)]
    (less, more), (less_there, more_there) = ([one.count(word) for word in ("below", "above")] for one in orders)
    return (
        Verdict(
            "found",
            f"{np.isfinite(ends).sum()} of {len(ends)} loops come to rest in a computer, where the RMSE is "
            f"{min(growth):.2f} to {max(growth):.2f} times that in continuous time.",
            "A computer reads with noise, keeps the commands within limits, and acts a period late; in continuous time "
            "readings are exact and nothing is limited. A limit may even help, where it cuts what a law would overdo.",
            estimand="Whether the error stays within 5 % of that of the start from some instant on, and RMSE of one "
            f"output over the run, for {COUNT} settings and two laws, one start and one draw of the noise each.",
            given=GIVEN,
            reversal="Longer periods: the summary has the delay that each loop stands, in periods.",
        ),
        Verdict(
            "depends",
            f"LQG has the smaller RMSE in {less} of {COUNT} settings and PID in {more}; in a computer LQG in "
            f"{less_there} and PID in {more_there}. In {sum(a == b for a, b in zip(*orders, strict=True))} the order "
            "is the same in both.",
            "No law is called the better one: the two are given unlike things, and none was tuned for this error.",
            estimand="RMSE of one output over the run, one start, and in a computer one draw of the noise; a gap "
            "within the errors of the step is not counted.",
            given=GIVEN,
            reversal="Other weights of LQG or other gains of PID: neither was searched for.",
        ),
    )


def command_finding(results: Results) -> Verdict:
    """The total variation of the commands in a computer."""
    busy = {s.name: [results[s.name, f"{law} {COMPUTER}"].score("TV").pair[0] for law in LAWS] for s in SETTINGS}
    ratio = {name: other / one for name, (one, other) in busy.items()}
    most, least = max(ratio, key=ratio.__getitem__), min(ratio, key=ratio.__getitem__)
    return Verdict(
        "found",
        f"In a computer the commands of PID move {ratio[most]:.0f} times as much as those of LQG for the {most}, "
        f"and those of LQG {1 / ratio[least]:.0f} times as much as those of PID for the {least}; PID's move more "
        f"in {sum(r > 1 for r in ratio.values())} of {COUNT} settings.",
        "A filtered derivative passes the noise of a reading on, a Kalman filter weighs it against its model.",
        estimand="Total variation of the first input over the run, at the instants of the computer, one start and "
        "one draw of the noise.",
        given=GIVEN,
        reversal="A lower bandwidth of the derivative filters, which costs phase.",
    )


def margin_finding(results: Results) -> Verdict:
    """The disk margin with all states read, behind a filter, and under PID."""
    by = all_margins(results)
    disks = {s.name: [by[s.name, law].disk for law in (LQR, LQG, PID)] for s in SETTINGS}
    worst = min(disks, key=lambda name: disks[name][1] / disks[name][0])
    return Verdict(
        "found",
        f"The Kalman filter takes from the disk margin of its regulator in "
        f"{sum(behind < full for full, behind, _ in disks.values())} of {COUNT} settings, most for the {worst}: "
        f"{disks[worst][0]:.2f} with all states read, {disks[worst][1]:.2f} with the filter.",
        f"A regulator that reads all states has margins that are guaranteed; behind a filter it has none that are "
        f"(Doyle 1978). In {sum(behind < pid for _, behind, pid in disks.values())} of {COUNT} settings LQG has the "
        "smaller disk margin of the two laws.",
        estimand="The disk margin of all inputs at once of the linear loop at rest.",
        given=f"The regulator alone: all states. {GIVEN}",
        reversal="More noise that is assumed at the inputs, which brings the margins back where the plant has no zero "
        "in the right half-plane.",
    )


def parameter_finding(results: Results) -> Verdict:
    """The scatter of the error where the plant is another than was believed, and the parameter that decides it."""
    runs = {s.name: [errors(results, s, law) for law in LAWS] for s in SETTINGS}
    spread = {name: [100 * np.nanstd(e) / np.nanmean(e) for e in both] for name, both in runs.items()}
    worst = max(spread, key=lambda name: spread[name][0] / spread[name][1])
    deciding = indices(BY_NAME[worst], results)[LQG]
    first = int(np.argmax(deciding.ST.value))
    return Verdict(
        "found",
        f"Where the plant is another than the designer believes, the RMSE scatters more under LQG than under PID in "
        f"{sum(one > other for one, other in spread.values())} of {COUNT} settings, most so for the {worst}: by "
        f"{spread[worst][0]:.0f} % and {spread[worst][1]:.0f} %.",
        f"There {deciding.factors[first]} decides it under LQG (ST = {deciding.ST.value[first]:.2f}, from "
        f"{deciding.ST.low[first]:.2f} to {deciding.ST.high[first]:.2f}). LQG has no integral here, so that a plant "
        "that needs another input than was believed is left off its level. Of all runs "
        f"{sum(sample.failed for sample in results.samples)} diverged.",
        estimand="Standard deviation of the RMSE of one output over its mean, over the ranges of the parameters, in "
        "continuous time.",
        given=GIVEN,
        reversal="An integral of the error in LQG, or narrower ranges.",
    )


def tank_finding(results: Results) -> Verdict:
    """The slowest pole of the four tanks at both settings of the valves."""
    tanks = [BY_NAME[name] for name in (EASY, HARD)]
    slow = [all_margins(results)[tank.name, PID].decay for tank in tanks]
    optimal = [-tank.design.poles.real.max() for tank in tanks]
    return Verdict(
        "found",
        f"Under two PI controllers the slowest mode of the four tanks decays {slow[0] / slow[1]:.0f} times more "
        "slowly at P+ than at P\N{MINUS SIGN}, as the publication says of its settling times.",
        f"At P+ a zero at {tanks[1].model.zeros().real.max():+.4f} 1/s bounds what any law can reach: LQG, given the "
        f"model, decays with {optimal[1]:.4f} 1/s there and with {optimal[0]:.4f} 1/s at P\N{MINUS SIGN}, by the same "
        "weights.",
        estimand="The slowest pole of the linear loop at rest, for both settings of the valves.",
        given="The published gains of both settings, of two PI controllers that read one level each.",
        reversal="Other gains, within what the zero allows.",
    )


def mass_finding(results: Results) -> Verdict:
    """The two masses, which no PID with a simple filter makes stable."""
    pd, filtered = (all_margins(results)["two masses", law].disk for law in (PID, LQG))
    return Verdict(
        "holds",
        "No PID of x_2 whose derivative has a filter of first order makes the two masses stable.",
        "The characteristic polynomial begins with a, a N, b, b N, whatever the gains: N is the filter's bandwidth, "
        "a = m_1 m_2, b = k (m_1 + m_2). Its second Hurwitz determinant, a N b \N{MINUS SIGN} a b N, is zero and would "
        f"have to be positive. A PD with a filter of second order is stable: its disk margin is {pd:.2f}, that of LQG "
        f"{filtered:.2f}.",
        estimand="The characteristic polynomial of the linear loop, for all masses, stiffnesses, gains and filters.",
        given="The position of the second mass alone.",
        reversal="Friction, or a reading of the first mass.",
    )
