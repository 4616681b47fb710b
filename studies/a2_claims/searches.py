"""The loops that a2 asks, the claims that a run can break, each with its margin, and the search that breaks (42).

`python -m studies.a2_claims.searches` searches again and stores the worst run, which is due whenever an equation
has changed: a stored run replays on the equation it was found for, and on no other.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

import workbench as wb
from studies.paper.card import CARD
from studies.paper.laws import ARM, paper_observer, proposed_as_printed, proposed_repaired, state_observer

I, REST = np.eye(2), np.zeros(2)
D_MAX, L_D = 0.65, 2.2  # N m, N m/s: Assumption 4 in numbers, just above the needs of both scenarios
FLOOR = 2.0  # N m, a c that lambda_min(K) - delta keeps in the runs that count
CONSTANT_D = (0.5, 0.4)  # N m, the amplitudes of section 5, held
CONSTANT_TORQUE = wb.SineTorque(CONSTANT_D, REST, np.full(2, np.pi / 2))

Margins = Mapping[str, ca.SX]


def beside_rest(L1: Any, L2: Any, zero: str = "down") -> wb.Ode:
    """Observer (10) beside the arm at rest at q = 0, hanging (`down`) or upright (`up`), where no torque is needed."""
    observer = wb.arms.observers.Luenberger(replace(ARM, zero=zero), L1, L2, q_hat=REST)
    lifted, states = wb.core.lift(observer), observer.memory
    t, x = ca.SX.sym("t"), states.symbols()
    z, zero_q = states.view(x), ca.SX.zeros(2)
    y = wb.Signals(q=zero_q, qd=zero_q)
    rates = lifted.block.rate(t, z, y, lifted.block.estimate(t, z, y), wb.Signals(tau=ca.SX.zeros(2)))
    errors = {"q_error": -z["q_hat"], "qd_error": -z["qd_hat"]}
    return wb.Ode.of(
        "observer (10) beside the arm at rest", states, lifted.layout, (t, x, lifted.symbols), rates, errors
    )


def free_loop(q: Any = REST, qd: Any = REST) -> wb.ClosedLoop:
    """The arm without torque and disturbance from (q, qd)(0), watched by (10) with the gains of section 5."""
    arm = wb.Manipulator(ARM, q=np.array(q), qd=np.array(qd))
    return wb.ClosedLoop(arm, paper_observer(), wb.ArmPID(REST, REST, REST), wb.Constant("q", "rad", REST))


def free_arm() -> wb.Ode:
    """The equations of `free_loop`."""
    return free_loop().ode("arm without torque, watched by (10)")


def printed_filter() -> wb.Ode:
    """(24) as printed beside the arm without torque, under a constant disturbance."""
    observer = wb.arms.observers.StateAndDisturbanceObserver(
        paper_observer(), wb.arms.observers.PrintedFilter(2, CARD["l"])
    )
    return wb.ClosedLoop(
        wb.Manipulator(ARM, q=REST, disturbance=CONSTANT_TORQUE),
        observer,
        wb.ArmPID(REST, REST, REST),
        wb.Constant("q", "rad", REST),
    ).ode()


def regulation() -> wb.ClosedLoop:
    """The repaired law at a constant reference, under a constant disturbance: as plain as Assumption 4 allows."""
    at_rest = wb.Manipulator(ARM, q=REST, disturbance=CONSTANT_TORQUE)
    return replace(proposed_repaired("FS"), plant=at_rest, reference=wb.Constant("q", "rad", REST))


def printed_but_for_c() -> wb.ClosedLoop:
    """The law as printed in the first scenario on the derived arm, whose C obeys Assumption 3, in law and observer."""
    loop = proposed_as_printed("FS")
    state = replace(state_observer(loop), model=ARM)
    return replace(loop, controller=replace(loop.controller, model=ARM), observer=replace(loop.observer, state=state))


def on_path() -> wb.ClosedLoop:
    """The law as printed but for C where its estimates obey (35) and start on the desired path of the first scenario.

    (35) is (1) with the estimates for q and qd, so that is the arm itself, known exactly.
    """
    loop = printed_but_for_c()
    arm = replace(loop.plant, q=REST, qd=np.array([2.0, 1.5]))  # q_d(0), qd_d(0)
    return replace(loop, plant=arm, observer=replace(loop.observer, state=wb.ArmFullState(2)))


def with_weights(loop: wb.ClosedLoop, Q: float, R: float) -> wb.ClosedLoop:
    """The same loop with the weights Q I and R I in (34)."""
    return replace(loop, controller=replace(loop.controller, Q=Q * I, R=R * I))


def gain_left(y: Margins) -> ca.SX:
    """lambda_min(K) - |D - D_hat|, in N m: the c of (40) at an instant."""
    K = (y["controller.K"] + y["controller.K"].T) / 2
    least = (K[0, 0] + K[1, 1]) / 2 - ca.sqrt(((K[0, 0] - K[1, 1]) / 2) ** 2 + K[0, 1] ** 2)
    return least - ca.norm_2(y["d_error"])


def V2(y: Margins) -> ca.SX:
    """(36)."""
    s, M = y["s"], ARM.mass_matrix(y["observer.state.q_hat"])
    return ca.dot(s, M @ s) / 2 + ca.trace(y["controller.P"]) / 2


ODE = printed_but_for_c().ode("as printed but for C")
# In J: the estimates start at zero wherever the arm does, so it is the same in all runs.
V2_AT_START = float(
    ca.Function("V2", [ODE.t, ODE.x, ODE.p], [V2(wb.proofs.SignalsOf(ODE))])(
        0, ODE.states.default, ODE.parameters.default
    )
)


ASSUMPTION_4 = wb.core.Claim(
    "Assumption 4",
    "|D(t)| <= D_max and |D'(t)| <= L_D in both scenarios.",
    "(8)",
    margin=lambda y: ca.vertcat(D_MAX**2 - ca.sumsqr(y["d"]), L_D**2 - ca.sumsqr(y["d'"])),
)
ABOVE = wb.core.Claim("lambda_min(K) > delta", "lambda_min(K) >= |D - D_hat| at all times.", "(40)", margin=gain_left)
GAIN_FLOOR = wb.core.Claim(
    "c", f"lambda_min(K) - |D - D_hat| >= {FLOOR:g} N m.", "(40)", (), lambda y: gain_left(y) - FLOOR
)
REACHES = wb.core.Claim(
    "s is reached",
    "t |s(t)| <= V2(0) / c.",
    "(42)",
    (GAIN_FLOOR,),
    lambda y: V2_AT_START / FLOOR - y["t"] * ca.norm_2(y["s"]),
)
WITHIN_4 = wb.core.BlockClaim(ASSUMPTION_4)
PROOF_HYPOTHESES = (WITHIN_4, wb.core.BlockClaim(ABOVE))  # what the proof of Theorem 2 asks of each run

WITNESS = Path(__file__).with_name("finite_time.json")  # the worst run of the search
SEED = 1
REACH = {"plant.q": (-np.pi, np.pi), "plant.qd": (-3.0, 3.0)}  # rad, rad/s: Assumption 1, as the searches take it
BOX = REACH | {
    "plant.disturbance.amplitude": (0.0, D_MAX),
    "plant.disturbance.frequency": (0.0, 5.0),
    "plant.disturbance.phase": (-np.pi, np.pi),
}
STEP = 1e-4  # s, of the law as printed
RUN_SEARCH = wb.proofs.RunSearch(ODE, wb.core.BlockClaim(REACHES), BOX, 2.0, STEP, PROOF_HYPOTHESES)


@dataclass(frozen=True, eq=False)
class WorstRun:
    """The outcome of the search, and |s| [rad/s] along its worst run at times t [s]."""

    result: wb.proofs.SearchResult
    t: wb.Array
    s: wb.Array


def search(seed: int) -> wb.proofs.SearchResult:
    """The outcome of the search with a seed, its worst run in as few decimals as show it."""
    return RUN_SEARCH.shorten(RUN_SEARCH.search(seed, wb.proofs.Budget(32, 6, 0)))


def worst_of(result: wb.proofs.SearchResult) -> wb.proofs.CounterExample:
    """The worst run of a search that found one."""
    if result.worst is None:
        raise ValueError("The search for (42) found no run that keeps its hypotheses.")
    return result.worst


def worst_run(seed: int) -> WorstRun:
    """The outcome of the search with a seed, and the sliding variable along the worst run."""
    found = search(seed)
    worst = worst_of(found)
    p, x0 = worst.rows(RUN_SEARCH.ode)
    runs = wb.simulate(wb.rk4(RUN_SEARCH.violation_equation, STEP), p, x0, until=worst.until, every=5e-3)
    return WorstRun(found, runs.t, np.linalg.norm(runs["s"][0], axis=1))


def rerun(numbers: Mapping[str, Sequence[float]]) -> wb.proofs.StepPair:
    """A run of the search: the metric, its error, and the worst of its hypotheses, negative where all are kept."""
    return RUN_SEARCH.at(numbers)


if __name__ == "__main__":
    worst_of(search(SEED)).write(WITNESS)
