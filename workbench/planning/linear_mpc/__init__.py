from workbench.planning.linear_mpc.exact_solution import ExactMpc, exact_mpc
from workbench.planning.linear_mpc.infeasibility import MpcConflictError
from workbench.planning.linear_mpc.mpc_problem import LinearMpc, linear_mpc
from workbench.planning.linear_mpc.splitting_metric import splitting_numbers
from workbench.planning.linear_mpc.splitting import *
from workbench.planning.linear_mpc.offset_free import *
