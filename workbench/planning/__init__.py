"""Planning: laws that look ahead within limits.

`linear_mpc` has the problem of linear predictive control, the numbers of its law, and its exact solution. The package
takes matrices, linear systems and equations, and makes none. Read `linear_mpc/linear_problem.py` first.

Examples
--------
>>> from workbench.planning import MpcLimits, exact_mpc, mpc_problem
>>> limits = MpcLimits(inputs=(-1.0, 1.0))
>>> problem = mpc_problem([[1.0, 0.1], [0.0, 1.0]], [[0.0], [0.1]], np.eye(2), [[0.1]], 20, limits)
>>> exact_mpc(problem).first_move([3.0, 0.0]).round(9)
array([-1.])
"""

from workbench.core.lazy_names import lazy_names

_FILES = {
    "linear_mpc": "ExactMpc InfeasibilityProof KktCertificate LimitRows LinearMpc MpcConflictError MpcLimits "
    "MpcSolution OffsetFree OperationCount PredictionMaps PredictiveDesign RecursionNumbers SampledLoss "
    "SplittingAnswer SplittingNumbers SplittingTuning TerminalSet TuningRow dual_product exact_loops "
    "exact_mpc limited_target move_bound mpc_problem no_memory offset_free operation_count plan_gap "
    "prediction_maps predictive_design recursion_numbers sampled_loss sampled_mpc solve_period splitting_numbers "
    "terminal_set tune_splitting"
}
__all__, __getattr__, __dir__ = lazy_names(__name__, _FILES)
