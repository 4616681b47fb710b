"""One call of IPOPT on a transcribed plan, with what it says of its answer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from workbench.core.validation.refusals import Array
from workbench.planning.trajectories.plan_values import Values
from workbench.planning.trajectories.transcription import Transcription

GOOD = ("Solve_Succeeded", "Solved_To_Acceptable_Level")
QUIET = {
    "ipopt.print_level": 0,
    "print_time": False,
    "ipopt.sb": "yes",
    "error_on_fail": False,
    "show_eval_warnings": False,
}
EXACT = {"ipopt.bound_relax_factor": 0.0, "ipopt.honor_original_bounds": "yes"}


@dataclass(frozen=True, eq=False)
class ProgramEnd:
    """The end of a search: the trajectory, its objective, multipliers of bounds and constraints, and the residuals."""

    transcription: Transcription
    values: Values
    objective: float
    bound_multipliers: Array  # (nw,), of the scaled variables
    constraint_multipliers: Array  # (nc,)
    status: str
    iterations: int
    kkt: float  # the largest residual of the optimality conditions, with the objective and constraints scaled

    @property
    def is_solved(self) -> bool:
        """True if IPOPT met its tolerance."""
        return self.status in GOOD


def call_ipopt(
    transcription: Transcription, start: Values, objective_size: float, warm: bool, most: int, tolerance: float = 1e-9
) -> ProgramEnd:
    """Solve the program from a trajectory on the same meshes."""
    constraints, low, high = constraints_of(transcription)
    size = max(abs(objective_size), 1e-12)
    program = {"x": transcription.w, "f": transcription.cost / size, "g": constraints}
    options = {**QUIET, **EXACT, "ipopt.tol": tolerance, "ipopt.max_iter": most, "calc_lam_x": True}
    options |= {"ipopt.acceptable_tol": 1e-6, "ipopt.acceptable_iter": 25}
    if warm:
        options |= {"ipopt.mu_init": 1e-4, "ipopt.bound_push": 1e-5, "ipopt.bound_frac": 1e-5}
    else:
        options |= {"ipopt.mu_init": 1.0}
    solver = ca.nlpsol("plan", "ipopt", program, options)  # type: ignore[arg-type]  # the stub knows no MX here
    lower, upper = transcription.bounds()
    w0 = np.clip(transcription.pack(start), lower, upper)
    answer = solver(x0=w0, lbx=lower, ubx=upper, lbg=low, ubg=high)
    stats = solver.stats()
    w, lam_x, lam_g = (np.array(answer[name]).ravel() for name in ("x", "lam_x", "lam_g"))
    return ProgramEnd(
        transcription,
        transcription.unpack(np.clip(w, lower, upper)),
        float(answer["f"]) * size,
        lam_x * size,
        lam_g * size,
        str(stats["return_status"]),
        int(stats["iter_count"]),
        _residual(stats),
    )


def _residual(stats: Mapping[str, object]) -> float:
    iterations = stats.get("iterations")
    if not isinstance(iterations, dict) or not iterations.get("inf_du"):
        return float("nan")
    return float(max(iterations["inf_du"][-1], iterations["inf_pr"][-1]))


def constraints_of(transcription: Transcription) -> tuple[ca.MX, Array, Array]:
    """The constraints (nc, 1) with their bounds: defects, links, limited signals and rates of inputs."""
    parts, lows, highs = [transcription.links], [np.zeros(transcription.links.numel())], []
    highs.append(lows[0])
    problem, scales = transcription.problem, transcription.scales
    for phase, terms, mesh in zip(problem.phases, transcription.terms, transcription.meshes, strict=True):
        zeros = np.zeros(terms.defects.numel())
        parts.append(ca.vec(terms.defects))
        lows.append(zeros)
        highs.append(zeros)
        if phase.path_names:
            low, high = transcription.signal_bounds(phase, len(mesh))
            parts.append(ca.vec(terms.signals))
            lows.append(low)
            highs.append(high)
        if problem.has_slopes:
            for _, end, sign in phase.slope.ends:
                bound = ca.DM(np.where(np.isfinite(end), end / scales.u, 0.0)) @ terms.h
                rows = [i for i in range(problem.nu) if np.isfinite(end[i])]
                excess = sign * (terms.slopes - bound)[rows, :]
                parts.append(ca.vec(excess))
                lows.append(np.full(excess.numel(), -np.inf))
                highs.append(np.zeros(excess.numel()))
    return ca.vertcat(*parts), np.concatenate(lows), np.concatenate(highs)
