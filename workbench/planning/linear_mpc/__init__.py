"""Linear predictive control: its problem, the numbers of a law with a fixed number of sweeps, and the exact solution.

This package takes matrices and linear systems, and knows no plant. Read `linear_problem.py` and `prediction_maps.py`
first, then `splitting.py`, which is the law, and `exact_solution.py`, which judges it.

Examples
--------
>>> from workbench.planning.linear_mpc import MpcLimits, exact_mpc, mpc_problem
>>> from workbench.planning.linear_mpc import no_memory, solve_period, splitting_numbers
>>> limits = MpcLimits(inputs=(-1.0, 1.0))
>>> problem = mpc_problem([[1.0, 0.1], [0.0, 1.0]], [[0.0], [0.1]], np.eye(2), [[0.1]], 20, limits)
>>> numbers, x = splitting_numbers(problem), np.array([1.0, 0.0])
>>> law, exact = solve_period(numbers, no_memory(numbers), x), exact_mpc(problem).solve(x)
>>> law.u.round(3), exact.u[0].round(3)
(array([-1.]), array([-1.]))
"""

from workbench.planning.linear_mpc.cone_limits import ConeLimit
from workbench.planning.linear_mpc.disturbance_observer import OffsetFree, limited_target, offset_free
from workbench.planning.linear_mpc.dual_recursion import (
    OperationCount,
    RecursionNumbers,
    dual_product,
    operation_count,
    recursion_numbers,
)
from workbench.planning.linear_mpc.exact_solution import ExactMpc, KktCertificate, MpcSolution, exact_mpc
from workbench.planning.linear_mpc.infeasibility import InfeasibilityProof, MpcConflictError
from workbench.planning.linear_mpc.limit_rows import LimitRows, MpcLimits
from workbench.planning.linear_mpc.linear_problem import LinearMpc, mpc_problem
from workbench.planning.linear_mpc.loss_samples import SampledLoss, exact_loops, move_bound, plan_gap, sampled_loss
from workbench.planning.linear_mpc.prediction_maps import PredictionMaps, prediction_maps
from workbench.planning.linear_mpc.predictive_design import PredictiveDesign, predictive_design
from workbench.planning.linear_mpc.sampled_problem import sampled_mpc
from workbench.planning.linear_mpc.splitting import SplittingAnswer, SplittingNumbers, no_memory, solve_period
from workbench.planning.linear_mpc.splitting_metric import splitting_numbers
from workbench.planning.linear_mpc.splitting_tuning import SplittingTuning, TuningRow, tune_splitting
from workbench.planning.linear_mpc.sweep_choice import SweepEvidence
from workbench.planning.linear_mpc.terminal_ellipsoid import TerminalSet, terminal_set

__all__ = [
    "ConeLimit",
    "ExactMpc",
    "InfeasibilityProof",
    "KktCertificate",
    "LimitRows",
    "LinearMpc",
    "MpcConflictError",
    "MpcLimits",
    "MpcSolution",
    "OffsetFree",
    "OperationCount",
    "PredictionMaps",
    "PredictiveDesign",
    "RecursionNumbers",
    "SampledLoss",
    "SplittingAnswer",
    "SplittingNumbers",
    "SplittingTuning",
    "SweepEvidence",
    "TerminalSet",
    "TuningRow",
    "dual_product",
    "exact_loops",
    "exact_mpc",
    "limited_target",
    "move_bound",
    "mpc_problem",
    "no_memory",
    "offset_free",
    "operation_count",
    "plan_gap",
    "prediction_maps",
    "predictive_design",
    "recursion_numbers",
    "sampled_loss",
    "sampled_mpc",
    "solve_period",
    "splitting_numbers",
    "terminal_set",
    "tune_splitting",
]
