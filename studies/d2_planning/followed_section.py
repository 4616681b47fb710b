"""The section on planned motions: the plans, and the share of loops that arrive when they are runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

import workbench as wb
from studies.d2_planning.followers import (
    ALONG,
    CAUGHT,
    CONDITIONS,
    DRAWS,
    FEW,
    FOLLOWERS,
    FORWARD,
    HARDEST,
    NONLINEAR,
    SPREADS,
    STAGES,
    USUAL,
    end_errors,
    spreads_of,
    sweep_name,
)
from studies.d2_planning.motions import FUNNEL_RUNS, JUDGED, MOTIONS, REST, PlannedMotion

FEW_LOOPS = f"of {FEW} loops"
SHORT = {"cart": "cart-pole", "furuta": "Furuta pendulum", "arm": "the paper's arm"}
NOBODY = "no way to follow"
NEAR = {"half the distance": 0.5, "twice the distance": 2.0}


@dataclass(frozen=True)
class Share:
    """The share of runs that arrive, with its interval at 95 % (Clopper and Pearson)."""

    arrivals: wb.Array  # (N,), true where a run arrives

    @cached_property
    def value(self) -> float:
        """The share."""
        return float(self.arrivals.mean())

    @cached_property
    def interval(self) -> tuple[float, float]:
        """The interval of the share of all draws, by that of a sampled funnel."""
        none = np.empty((len(self.arrivals), 0))
        return wb.planning.Funnel(none, none, none, self.arrivals, 0.95).interval

    @property
    def words(self) -> str:
        """The share and its interval in per cent."""
        low, high = self.interval
        return f"{100 * self.value:.0f} % ({100 * low:.0f} to {100 * high:.0f} %)"


@dataclass(frozen=True)
class Arrivals:
    """The plans, and the errors at the end of all runs that follow them."""

    plans: Mapping[str, PlannedMotion]
    errors: Mapping[tuple[str, str, str, float], wb.Array]  # by motion, follower, condition and spread

    def share(self, motion: str, follower: str, spread: float = USUAL, condition: str = "", near: float = 1.0) -> Share:
        """The share of runs that arrive; a run that diverged does not."""
        errors = self.errors[motion, follower, condition, spread]
        return Share(np.asarray(errors <= near * MOTIONS[motion].near))

    def best(self, motion: str, spread: float = USUAL, condition: str = "", near: float = 1.0) -> set[str]:
        """The ways to follow below which no other way's whole interval lies."""
        shares = {name: self.share(motion, name, spread, condition, near) for name in FOLLOWERS}
        most = max(one.interval[0] for one in shares.values())
        return {name for name, one in shares.items() if one.interval[1] >= most and one.value > 0}

    def hardest(self) -> dict[str, Share]:
        """The shares where the nonlinear predictive law was run, on its draws alone."""
        key, spread = HARDEST
        errors = {name: self.errors[key, name, "", spread][:FEW] for name in (*FOLLOWERS, NONLINEAR)}
        return {name: Share(np.asarray(one <= MOTIONS[key].near)) for name, one in errors.items()}

    def answer(
        self, motions: Sequence[str] = tuple(MOTIONS), spread: float = USUAL, condition: str = "", near: float = 1.0
    ) -> str:
        """The ways to follow that no other way surpasses on any of some motions."""
        common = set(FOLLOWERS)
        for motion in motions:
            common &= self.best(motion, spread, condition, near)
        return wb.document.join_names([name for name in FOLLOWERS if name in common]) or NOBODY

    def detail(
        self, motions: Sequence[str] = tuple(MOTIONS), spread: float = USUAL, condition: str = "", near: float = 1.0
    ) -> str:
        """The shares in words."""
        return "; ".join(
            f"{name} "
            + ", ".join(f"{100 * self.share(one, name, spread, condition, near).value:.0f} %" for one in motions)
            for name in FOLLOWERS
        )


def gather(results: wb.Results) -> Arrivals:
    """The plans and the errors in the results of the study."""
    errors = dict[tuple[str, str, str, float], wb.Array]()
    for key, motion in MOTIONS.items():
        for follower in FOLLOWERS:
            for condition in CONDITIONS:
                all_ends = end_errors(results.sample(sweep_name(motion, follower, condition)).measurement)
                for i, spread in enumerate(spreads_of(follower, condition)):
                    errors[key, follower, condition, spread] = all_ends[i * DRAWS : (i + 1) * DRAWS]
    key, spread = HARDEST
    sample = results.sample(sweep_name(MOTIONS[key], NONLINEAR))
    errors[key, NONLINEAR, "", spread] = end_errors(sample.measurement)
    return Arrivals(dict(zip(MOTIONS, results.work("plans"), strict=True)), errors)


def changed_answers(runs: Arrivals) -> tuple[wb.Variation, ...]:
    """The answers on each motion, at each spread, under each condition and within other distances."""
    words = {key: motion.name for key, motion in MOTIONS.items()}
    variations = [wb.Variation(f"{words[key]} alone", runs.answer((key,)), runs.detail((key,))) for key in MOTIONS]
    variations += [
        wb.Variation(f"numbers off by up to {100 * s:g} %", runs.answer(spread=s), runs.detail(spread=s))
        for s in SPREADS
        if s != USUAL
    ]
    variations += [
        wb.Variation(
            f"{words[key]}, numbers off by up to {100 * s:g} %",
            runs.answer((key,), spread=s),
            runs.detail((key,), spread=s),
        )
        for key in MOTIONS
        for s in SPREADS
        if s != USUAL
    ]
    variations += [
        wb.Variation(name, runs.answer(condition=name), runs.detail(condition=name)) for name in CONDITIONS if name
    ]
    variations += [
        wb.Variation(f"arrived within {name}", runs.answer(near=factor), runs.detail(near=factor))
        for name, factor in NEAR.items()
    ]
    return (*variations, with_nonlinear(runs))


def finding(runs: Arrivals) -> wb.Finding:
    """The worth of feedback along a plan."""
    along = "; ".join(f"{MOTIONS[key].name} {runs.share(key, ALONG).words}" for key in MOTIONS)
    others = "; ".join(
        f"{name}: " + ", ".join(f"{100 * runs.share(key, name).value:.0f} %" for key in MOTIONS)
        for name in FOLLOWERS
        if name != ALONG
    )
    return wb.Finding(
        name="followed_plans",
        statement=f"With gains along the plan, and numbers that are off by up to {100 * USUAL:g} %, these shares of "
        f"loops arrive: {along}.",
        evidence=f"The shares of the other ways, in the same order: {others}. Feedforward alone cannot hold an end "
        "that is unstable, nor an arm against gravity. The swing-up of the Furuta pendulum was tried with nonlinear "
        f"MPC, too, which previews the plan: with numbers off by up to {100 * HARDEST[1]:g} %, {FEW_LOOPS}, "
        f"{nonlinear_words(runs)}.",
        statistic="The share of runs that arrive: the root mean square distance from the goal over the last "
        f"{JUDGED:g} s is at most {', '.join(f'{m.near:g}' for m in MOTIONS.values())} rad. A way counts unless the "
        "whole interval of its share lies below that of another.",
        sample=f"{DRAWS} draws of four numbers of each plant, of the start and of the noise, the same for all ways; "
        "intervals at 95 % for each share.",
        information="All ways read the same coarse and noisy positions through the same extended Kalman filter with "
        "the model's numbers, and their command comes a period of 10 ms late.",
        assumptions="The plans keep narrower limits than those of the drives, so that feedback has room; the weights "
        "of the gains are ours.",
        fitted_numbers="None.",
        answer=runs.answer(),
        variations=changed_answers(runs),
        limitations="Plans for other durations and weights, plans that are made again on the way, and friction that "
        "the model lacks.",
    )


def nonlinear_words(runs: Arrivals) -> str:
    """The shares of the nonlinear predictive law and of the gains along the plan, on the same draws."""
    shares = runs.hardest()
    return f"{shares[NONLINEAR].words} arrive, beside {shares[ALONG].words} with gains along the plan"


def with_nonlinear(runs: Arrivals) -> wb.Variation:
    """The answer with the nonlinear predictive law among the ways, where it was run."""
    shares = runs.hardest()
    most = max(one.interval[0] for one in shares.values())
    best = [name for name, one in shares.items() if one.interval[1] >= most]
    key, spread = HARDEST
    return wb.Variation(
        f"{MOTIONS[key].name}, numbers off by up to {100 * spread:g} %, with {NONLINEAR}, {FEW} draws",
        wb.document.join_names(best),
        "; ".join(f"{name} {one.words}" for name, one in shares.items()),
    )


def section(runs: Arrivals) -> wb.Section:
    """The planned motions in pictures and tables."""
    words = (
        "Each motion is planned for the model, and followed by a computer with a period of 10 ms, whose command acts a "
        "period late. The computer reads positions alone, with noise and in steps, and an extended Kalman filter "
        f"estimates the velocities. After the plan, its end is held for {REST:g} s. The first way to follow has gains "
        f"along the plan, by the time-varying LQR. The second, '{CAUGHT}', feeds the input forward and closes the loop "
        "with the gain of the end in the last tenth of the plan. The third has this gain throughout. The fourth, "
        f"'{FORWARD}', has no feedback. Most loops are lost at the {MOTIONS[HARDEST[0]].name} with numbers off "
        f"by up to {100 * HARDEST[1]:g} %. There a nonlinear predictive law with the same weights, which previews "
        f"{STAGES} periods of the plan, was tried, too: {FEW_LOOPS} {nonlinear_words(runs)}."
    )
    blocks = (wb.Paragraph(words), plan_figure(runs), share_figure(runs), plan_table(runs))
    return wb.Section("Planned and followed", blocks)


def plan_figure(runs: Arrivals) -> wb.document.Figure:
    """The planned states and inputs."""
    panels = []
    for key, motion in MOTIONS.items():
        plan, plant = runs.plans[key], motion.plant
        shown = plant.states.labels[:2] if key == "arm" else motion.plant.outputs.labels
        series: list[wb.document.Mark] = []
        for i, label in enumerate(shown):
            j = plant.states.labels.index(label)
            x = np.concatenate([plan.x_begins[:, j], plan.x_ends[-1:, j]])
            unit = "m" if label == "x" else "rad"
            series.append(wb.document.Series(f"{label} [{unit}]", plan.t, x, i))
        panels.append(wb.document.Panel("position", tuple(series), title=SHORT[key]))
    for motion in MOTIONS.values():
        plan, inputs = runs.plans[motion.key], motion.plant.inputs
        series = []
        for j, label in enumerate(inputs.labels):
            t = np.column_stack([plan.t[:-1], plan.t[1:]]).ravel()
            u = np.column_stack([plan.u_begins[:, j], plan.u_ends[:, j]]).ravel()
            series.append(wb.document.Series(label, t, u, j))
        unit = inputs.entries[0].unit.split(",")[0]
        panels.append(wb.document.Panel(f"input [{unit}]", tuple(series)))
    return wb.document.Figure("plans", "The planned motions and their inputs.", tuple(panels), columns=3)


def share_figure(runs: Arrivals) -> wb.document.Figure:
    """The share of loops that arrive, by what the designer does not know."""
    panels = []
    for key in MOTIONS:
        marks: list[wb.document.Mark] = []
        for i, name in enumerate(FOLLOWERS):
            shares = [runs.share(key, name, s) for s in SPREADS]
            low, high = (100 * np.array([one.interval[k] for one in shares]) for k in (0, 1))
            x = 100 * np.array(SPREADS) + 0.5 * (i - 1.5)
            y = 100 * np.array([one.value for one in shares])
            marks.append(wb.document.Points(name, x, y, style=i, ylow=low, yhigh=high))
        if key == HARDEST[0]:
            one = runs.hardest()[NONLINEAR]
            low, high = (100 * np.array([end]) for end in one.interval)
            at = np.array([100 * HARDEST[1] + 1.25])
            mark = wb.document.Points(NONLINEAR, at, 100 * np.array([one.value]), style=4, ylow=low, yhigh=high)
            marks.append(mark)
        panels.append(
            wb.document.Panel(
                "loops that arrive [%]",
                tuple(marks),
                "numbers off by up to [%]",
                ylim=(-3.0, 103.0),
                title=SHORT[key],
            )
        )
    caption = (
        "The share of loops that arrive, with intervals at 95 %, by half of the range of each unknown number. Points "
        "of one range stand side by side."
    )
    return wb.document.Figure("arrivals", caption, tuple(panels), columns=3)


def plan_table(runs: Arrivals) -> wb.document.ReportTable:
    """The plans and their certificates."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for key, motion in MOTIONS.items():
        one = runs.plans[key]
        funnel = f"{100 * one.funnel_share:.0f} ({100 * one.funnel_low:.1f} to {100 * one.funnel_high:.1f})"
        limits = wb.document.join_names(one.active_limits) or "none"
        rows.append((motion.name, float(one.t[-1]), f"{one.defect:.1g}", f"{one.run_defect:.1g}", limits, funnel))
    columns = (
        wb.document.TableColumn("motion"),
        wb.document.TableColumn("duration", "s", "right"),
        wb.document.TableColumn("defect", align="right"),
        wb.document.TableColumn("run defect", align="right"),
        wb.document.TableColumn("active limits", width=16),
        wb.document.TableColumn("funnel", "%", "right"),
    )
    notes = (
        "Defect: the largest distance of the simulator from the next node, as a share of each state's range. Run "
        f"defect: the distance from the plan in one run from the start. Funnel: the share of {FUNNEL_RUNS} drawn "
        "starts from which the loop stays near the plan, without noise and delay and with the model's numbers, with "
        "its interval at 95 %.",
    )
    return wb.document.ReportTable(
        "plan_certificates", "The plans, and what their certificates say.", columns, tuple(rows), notes
    )
