"""Planning: trajectories of least cost within limits, feedback along them, and laws that plan in each period.

`plan` finds a trajectory by collocation or shooting, and the simulator judges it. `linear_mpc` has the problem of
linear predictive control, the numbers of its law, and its exact solution; `nonlinear_mpc` designs a law that plans with
the nonlinear plant. The package takes equations, matrices and linear systems, and makes none: `wb.PlannedReference`,
`wb.TrajectoryFeedback`, `wb.ModelPredictive` and `wb.NonlinearPredictive` are the blocks.
Read `trajectories/plan_trajectory.py` and `linear_mpc/linear_problem.py` first.

Examples
--------
>>> motor = wb.open_loop(wb.DCMotor())
>>> turn = wb.plan(motor, 1.0, cost="energy", end={"omega": 0.1, "i": 0.5}, limits={"v": (-24.0, 24.0)})
>>> turn.certificate.is_passed
True
"""

from workbench.core.lazy_names import lazy_names

_FILES = {
    "linear_mpc": "ConeLimit ExactMpc InfeasibilityProof KktCertificate LimitRows LinearMpc MpcConflictError MpcLimits "
    "MpcSolution OffsetFree OperationCount PredictionMaps PredictiveDesign RecursionNumbers SampledLoss "
    "SplittingAnswer SplittingNumbers SplittingTuning SweepEvidence TerminalSet TuningRow dual_product "
    "exact_loops exact_mpc limited_target move_bound mpc_problem no_memory offset_free operation_count plan_gap "
    "prediction_maps predictive_design recursion_numbers sampled_loss sampled_mpc solve_period splitting_numbers "
    "terminal_set tune_splitting",
    "nonlinear_mpc": "NonlinearPredictiveDesign nonlinear_predictive_design",
    "trajectories": "Funnel Phase Plan PlanCertificate PlanConflictError PlanItem PlanOptions TrajectoryRegulator "
    "funnel plan trajectory_lqr",
}
__all__, __getattr__, __dir__ = lazy_names(__name__, _FILES)
