"""The time of thousands of closed loops of a predictive law, beside solvers of quadratic programs.

A peer is timed along the states of closed loops under its own moves, with nothing but its update and its solution in a
loop of Python: the steps of the plant are no part of its time, and are a part of ours.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from statistics import median

import numpy as np

import workbench as wb
from studies.performance.measurements import Effort, Row, cpu_seconds
from studies.performance.predictive_loops import PERIOD, PredictiveCase, Runs, Starts
from studies.performance.predictive_peers import PREDICTIVE_PEERS, PredictivePeer, Solver, daqp, daqp_clock

INPUTS: Mapping[str, tuple[float, float]] = {"F": (-3.0, 3.0)}
STATES: Mapping[str, tuple[float, float]] = {**INPUTS, "phi": (-0.06, 0.06)}
SOFT_WEIGHT = 1e4
WITH_STATES = PredictivePeer("DAQP", "daqp", 8.0, daqp)
SEED = 37
SPARE = 1.2  # starts that are drawn for each one that is wanted
AT_ONCE = 500  # loops whose states are kept at the same time
LEAST_ACTIVE, LEAST_EXCESS = 0.2, 0.05  # of the periods, and of the cost under clipped LQR
MOST_LOSS = 0.1  # %, of the cost under the exact law


@dataclass(frozen=True, eq=False)
class HardLoops:
    """Starts at which limits act and clipped LQR is bad, and what was found of them.

    Parameters
    ----------
    starts, ends
        The starts, and the states (B, nx) at the ends of the loops under the law.
    cost, active
        The costs (B,) under the law, infinite where it is lost, and the shares (B,) of periods in which a limit acts.
    excess
        The excesses (B,) of the cost under clipped LQR over that, infinite where clipped LQR is lost.
    share
        The share of these starts among those that were drawn.
    """

    case: PredictiveCase
    starts: Starts
    ends: wb.Array
    cost: wb.Array
    active: wb.Array
    excess: wb.Array
    share: float

    @property
    def words(self) -> str:
        """The two figures that say that the limits matter."""
        lost = np.isinf(self.excess)
        rest = f", and costs at least {self.excess.min():.0%} more in the others" if not lost.all() else ""
        return (
            f"{len(self.starts):,} loops of {self.case.periods} periods, {self.share:.0%} of the starts that were "
            f"drawn; limits act in {self.active.min():.0%} of the periods or more, in {self.active.mean():.0%} on "
            f"average; clipped LQR is lost in {lost.mean():.1%} of them{rest}"
        )


def hard_loops(case: PredictiveCase, count: int) -> HardLoops:
    """The first so many of the drawn starts at which limits matter; fewer if there are no more.

    A start at which the law itself is lost stays.
    """
    drawn = Starts.draw(round(SPARE * count), SEED)
    cost, active, excess = (np.empty(len(drawn)) for _ in range(3))
    ends = np.empty((len(drawn), case.step.states.size))
    for first in range(0, len(drawn), AT_ONCE):
        part = slice(first, first + AT_ONCE)
        runs, clipped = case.run(case.step, drawn.part(part)), case.run(case.clipped_step, drawn.part(part))
        cost[part], active[part], ends[part] = case.costs(runs), case.active(runs), runs.last
        own = np.where(runs.is_lost, 1.0, cost[part])
        excess[part] = np.where(runs.is_lost, np.inf, case.costs(clipped) / own - 1)
    is_hard = (active >= LEAST_ACTIVE) & (excess >= LEAST_EXCESS)
    kept = np.flatnonzero(is_hard)[:count]
    return HardLoops(case, drawn.part(kept), ends[kept], cost[kept], active[kept], excess[kept], float(is_hard.mean()))


def exact_runs(case: PredictiveCase, starts: Starts) -> Runs:
    """Closed loops under the exact law, each move of which has a certificate."""
    exact = case.design.exact
    return peer_runs(case, starts, lambda problem: lambda x: np.array([exact.first_move(row)[0] for row in x]))


def peer_runs(case: PredictiveCase, starts: Starts, solver: Callable[[wb.planning.LinearMpc], Solver]) -> Runs:
    """Closed loops with a solver for each loop and the plant by one step of RK4 in each period."""
    plant = wb.rk4(wb.open_loop(case.plant), PERIOD)
    solvers = [solver(case.design.problem) for _ in range(len(starts))]
    references, x = case.references(starts), starts.states.copy()
    e, F = np.empty((len(starts), case.periods, 4)), np.empty((len(starts), case.periods))
    for k in range(case.periods):
        e[:, k] = x
        e[:, k, 0] -= references[:, k]
        F[:, k] = [move(row)[0] for move, row in zip(solvers, e[:, k : k + 1], strict=True)]
        p = plant.parameters.pack({"F": F[:, k]})
        x = wb.simulate(plant, p, x, until=PERIOD).x[:, -1]
    return Runs(e, F, x)


def same_bits(loops: HardLoops, many: wb.Array) -> bool:
    """True if the last states of loops are the same bits alone, in parts, and all in one call (B, nx)."""
    case, last = loops.case, len(loops.starts) - 1
    alone = [0, last // 2, last]
    single = np.concatenate([case.ends(case.step, loops.starts.part(slice(i, i + 1))) for i in alone])
    return bool(np.array_equal(loops.ends, many) and np.array_equal(single, many[alone]))


def predictive_rows(
    effort: Effort, peers: tuple[PredictivePeer, ...] = PREDICTIVE_PEERS, with_states: PredictivePeer = WITH_STATES
) -> tuple[Row, ...]:
    """The rows of both cases: with limits of the force alone, and with soft limits of the angle, too."""
    periods = max(1, round(effort.horizon / PERIOD))
    return (
        *case_rows("limits on the input", PredictiveCase(INPUTS, None, periods), effort, peers),
        *case_rows("soft limits on a state", PredictiveCase(STATES, SOFT_WEIGHT, periods), effort, (with_states,)),
    )


def case_rows(about: str, case: PredictiveCase, effort: Effort, peers: tuple[PredictivePeer, ...]) -> tuple[Row, ...]:
    """The rows of the ratios to the peers, in turns, and of the loss of the law."""
    loops = hard_loops(case, effort.loops)
    if not len(loops.starts):
        return tuple(Row(row_name(about, peer), peer.bar, note="no start is hard enough") for peer in peers)
    few = loops.starts.part(slice(effort.peer_loops))
    exact = case.costs(exact_runs(case, few.part(slice(effort.exact_loops))))
    loss = 100 * (float(loops.cost[: len(exact)].sum() / exact.sum()) - 1)
    here = [peer for peer in peers if peer.is_installed]
    runs = {peer.name: peer_runs(case, few, peer.solver) for peer in here}
    solvers = {peer.name: peer.solver(case.design.problem) for peer in here}
    many: list[wb.Array] = []

    def ours() -> float:
        return cpu_seconds(lambda: many.append(case.ends(case.step, loops.starts)))

    def theirs(name: str) -> float:
        return cpu_seconds(lambda: solvers[name](along(runs[name])))

    with wb.study.one_core():
        turns = [(ours(), [theirs(peer.name) for peer in here]) for _ in range(effort.repetitions)]
    own = median(turn[0] for turn in turns) / (len(loops.starts) * case.periods)
    bits = "alone and in all batches, the bits are the same" if same_bits(loops, many[-1]) else "THE BITS DIFFER"
    first = Row(
        f"cost of MPC over the exact law, {about}",
        MOST_LOSS,
        loss,
        "%",
        at_most=True,
        note=f"{loops.words}. A period with the plant takes {1e6 * own:.3f} us of CPU, with "
        f"{case.design.numbers.sweeps} sweeps; {bits}. The cost is that of {len(exact)} loops; each move of the exact "
        f"law has a certificate",
    )
    times = {peer.name: median(turn[1][i] for turn in turns) / runs[peer.name].F.size for i, peer in enumerate(here)}
    return (
        first,
        *(
            peer_row(row_name(about, peer), peer, case, (times[peer.name], own), runs[peer.name], exact)
            if peer in here
            else Row(row_name(about, peer), peer.bar, note=f"{peer.package} is not installed")
            for peer in peers
        ),
    )


def along(runs: Runs) -> wb.Array:
    """The errors (M, 4) of loops, one loop after the other."""
    return runs.e.reshape(-1, runs.e.shape[-1])


def row_name(about: str, peer: PredictivePeer) -> str:
    """The name of the row of a peer."""
    return f"loops of MPC, {about}, {peer.name}"


def peer_row(
    name: str, peer: PredictivePeer, case: PredictiveCase, times: tuple[float, float], runs: Runs, exact: wb.Array
) -> Row:
    """The row of a peer from `times` of a period, its own and ours in s."""
    theirs, ours = times
    cost = 100 * (float(case.costs(runs)[: len(exact)].sum() / exact.sum()) - 1)
    note = (
        f"{1e6 * theirs:.2f} us of CPU for a solution from Python, without the plant, along {len(runs.F)} loops of its "
        f"own; the cost of the first {len(exact)} is {cost:.2g} % over the exact law"
    )
    if peer.package == "daqp" and case.soft_weight is None:
        clock = float(np.min([daqp_clock(case.design.problem, along(runs)) for _ in range(5)], axis=0).mean())
        note += (
            f". By its own clock, the least of five times of each solution, the C code without the update takes "
            f"{1e6 * clock:.2f} us, {clock / ours:.1f} times ours"
        )
    return Row(name, peer.bar, theirs / ours, note=note)
