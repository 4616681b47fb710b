"""The rate of frequency answers of many draws of a loop, beside python-control, and their error."""

from __future__ import annotations

from functools import cache

import numpy as np

import workbench as wb
from studies.paper.card import PROPOSED_LAW
from studies.paper.linearization import HELD_STATES, LEVEL, POSES, still
from studies.paper.workload import SEED
from studies.performance.measurements import Effort, Row, alternate_rates, cpu_seconds
from studies.performance.peers import control_responses

FREQUENCIES = np.geomspace(0.1, 1e3, 200)  # rad/s
DRAWN_NUMBERS = ("controller.K", "observer.state.L1", "observer.state.L2")
SPREAD = 0.2  # of each number, to both sides
RATE, ERROR = "frequency answers of 1,000 draws, beside python-control", "largest error of these answers"


@cache
def loop_at_rest() -> wb.linear_loops.LinearLoop:
    """The repaired AOSMC-RGS loop of the paper at rest, cut at the torques, its adapting gains frozen."""
    return wb.linear_loop(still(PROPOSED_LAW, POSES[LEVEL]), freeze=HELD_STATES[PROPOSED_LAW])


def draws(count: int) -> dict[str, wb.Array]:
    """The gains of the law and of the observer, each number drawn evenly about its own."""
    linear, even = loop_at_rest(), np.random.default_rng(SEED)
    own = linear.parameters.unpack(linear.p0[np.newaxis])
    return {
        name: own[name][0] * even.uniform(1 - SPREAD, 1 + SPREAD, (count, *own[name][0].shape))
        for name in DRAWN_NUMBERS
    }


def frequency_rows(effort: Effort) -> tuple[Row, ...]:
    """The row of the rate and that of the error, of the loop gain at all frequencies."""
    linear, values = loop_at_rest(), draws(effort.draws)
    rows = linear.rows(values)
    response = rows.response(FREQUENCIES)
    model = rows.models.kind("frequency_rows", "L")
    systems = [model.row(i).system() for i in range(min(effort.peer_draws, effort.draws))]

    def rate(seconds: float, count: int) -> float:
        return count / seconds

    with wb.study.one_core():
        mine, theirs = alternate_rates(
            effort,
            lambda: rate(cpu_seconds(lambda: rows.response(FREQUENCIES)), effort.draws),
            lambda: rate(cpu_seconds(lambda: control_responses(systems, FREQUENCIES)), len(systems)),
        )
        chain = cpu_seconds(lambda: linear.rows(values).response(FREQUENCIES))
    sound = ~response.flagged_rows
    sizes = np.abs(response.values[sound])
    error = float((response.errors[sound] / sizes).max())
    apart = np.abs(control_responses(systems, FREQUENCIES) - response.values[: len(systems)])
    rounding = apart / (np.finfo(float).eps * response.sensitivities[: len(systems)])
    note = (
        f"samples/s of CPU time, medians by turns: {mine:,.0f}, and {theirs:,.0f} for frequency_response in a loop "
        f"over given systems; {effort.draws:,} samples at {len(FREQUENCIES)} frequencies, with Jacobians and "
        f"equilibria, take {chain:.2g} s"
    )
    said = (
        "relative; a bound to first order for each answer; the answers of python-control differ by up to "
        f"{float((apart / np.abs(response.values[: len(systems)])).max()):.1e}, at most {float(rounding.max()):.1f} "
        "times the change by the rounding of the entries"
    )
    return (Row(RATE, 30.0, mine / theirs, note=note), Row(ERROR, 1e-10, error, "", at_most=True, note=said))
