"""The time of a plan with its certificate, from the start of Python, and beside CasADi and IPOPT called by hand."""

from __future__ import annotations

from statistics import median
from tempfile import TemporaryDirectory

import casadi as ca
import numpy as np

import workbench as wb
from studies.performance import processes
from studies.performance.least_time import GOAL, TORQUES, arm, least_time_plan
from studies.performance.measurements import Effort, Row, cpu_seconds
from studies.performance.processes import in_a_process

TIME, RATIO = "plan of the arm's least time, from the start of Python", "the same plan, CasADi with IPOPT by hand"
SECONDS = 5.0
SHARE = 0.5  # times as fast as one program on the last mesh: no more than twice its time, with all meshes before it
SAME = 1e-3  # relative, between both objectives


def by_hand(h: wb.Array) -> float:
    """The least time on intervals in the ratios h (N,), by Radau collocation of order 5 from a straight line in 1 s."""
    ode, N, d = arm(), len(h), 3
    p = ca.vertcat(ode.parameters.default[: -len(TORQUES)], u := ca.SX.sym("u", 2))
    x, X, T = ode.x, ca.SX.sym("X", 4, d + 1), ca.SX.sym("T")
    rate = ca.Function("rate", [x, u], [ca.substitute(ode.rate, ode.p, p)])
    C, _, _ = ca.collocation_coeff(ca.collocation_points(d, "radau"))
    slopes = X @ C
    defects = ca.vertcat(*(slopes[:, j] - T * rate(X[:, j + 1], u) for j in range(d)))
    interval = ca.Function("interval", [X[:, 0], X[:, 1:], u, T], [defects, X[:, -1]])
    duration, nodes = ca.MX.sym("T"), ca.MX.sym("nodes", 4, N + 1)
    inner, torques = ca.MX.sym("inner", 4 * d, N), ca.MX.sym("u", 2, N)
    points = ca.horzsplit(inner)
    shares = ca.DM(h / h.sum())
    each = [interval(nodes[:, k], ca.reshape(points[k], 4, d), torques[:, k], duration * shares[k]) for k in range(N)]
    g = ca.vertcat(*(ca.vertcat(gap, end - nodes[:, k + 1]) for k, (gap, end) in enumerate(each)))
    w = ca.veccat(duration, nodes, inner, torques)
    line = np.zeros((N + 1, 4))
    line[:, :2], line[:, 2:] = np.cumsum(np.r_[0.0, h / h.sum()])[:, np.newaxis], GOAL
    low, high = np.full((N + 1, 4), -np.inf), np.full((N + 1, 4), np.inf)
    low[0] = high[0] = 0.0
    low[-1] = high[-1] = [GOAL, GOAL, 0.0, 0.0]
    free, most = np.full(4 * d * N, np.inf), np.tile(TORQUES, N)
    quiet = {"ipopt.print_level": 0, "print_time": False, "ipopt.sb": "yes"}
    program = {"x": w, "f": duration, "g": g}
    solver = ca.nlpsol("by_hand", "ipopt", program, quiet)  # type: ignore[arg-type]  # the stub knows no MX here
    answer = solver(
        x0=np.r_[1.0, line.ravel(), np.repeat(line[1:], d, axis=0).ravel(), np.zeros(2 * N)],
        lbx=np.r_[0.1, low.ravel(), -free, -most],
        ubx=np.r_[10.0, high.ravel(), free, most],
        lbg=0.0,
        ubg=0.0,
    )
    return float(answer["f"])


def plan_rows(effort: Effort) -> tuple[Row, ...]:
    """The row of the time from the start of Python, and that of the ratio to a program on the same mesh, in turns."""
    starts = []
    for _ in range(effort.processes):
        with TemporaryDirectory() as folder:
            starts.append(in_a_process(processes.least_time, cache=folder))
    wall, cpu = (median(one[clock] for one in starts) for clock in ("wall", "cpu"))
    plans, times = [least_time_plan()], list[float]()

    def theirs() -> float:
        return cpu_seconds(lambda: times.append(by_hand(np.diff(plans[0].t))))

    with wb.study.one_core():
        turns = [(cpu_seconds(lambda: plans.append(least_time_plan())), theirs()) for _ in range(effort.repetitions)]
    mine, other = (median(turn[i] for turn in turns) for i in (0, 1))
    apart = abs(times[-1] / plans[-1].until - 1)
    note = (
        f"CPU time: {mine:.2f} s for `wb.plan`, with the choice of the mesh, three starts and the certificate, and "
        f"{other:.2f} s for one program on its last mesh of {len(plans[0].t) - 1} intervals, from a straight line; "
        f"both least times are {plans[-1].until:.4f} s and differ by {apart:.0e}"
    )
    ratio = Row(RATIO, SHARE, other / mine if apart <= SAME else None, note=note)
    passed = "" if plans[-1].certificate.is_passed else ", WITHOUT A CERTIFICATE"
    cold = f"wall time with no kernel on the disk; {cpu:.2f} s of CPU{passed}"
    return (Row(TIME, SECONDS, wall, "s", at_most=True, note=cold), ratio)
