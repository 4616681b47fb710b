"""Other ways to run W that a user could pick."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any
from unittest.mock import patch

import casadi as ca
import numpy as np

import workbench as wb
from studies.paper.workload import PARAMETERS, STATES, H, loop, rmse, workload
from studies.performance.right_hand_sides import in_matrices, in_scalars

# Parameters (B, 40) of B runs to the RMSE (B, 2) of their joints at the horizon.
Runner = Callable[[wb.Array], wb.Array]


@dataclass(frozen=True)
class Peer:
    """One way to run W, of a package: `bar` is how many times as fast we must be.

    `runs` are as many as one measurement needs for full speed; `runner` makes of the horizon in s what runs them.
    """

    name: str
    package: str
    bar: float
    runs: int
    runner: Callable[[float], Runner]

    @property
    def is_installed(self) -> bool:
        """True where the package is here."""
        return find_spec(self.package) is not None


def python_control(horizon: float) -> Runner:
    """One run after the other, with the torque as output at every step of W, as its total variation asks for."""
    import control

    times = np.linspace(0.0, horizon, round(horizon / H) + 1)

    def run(p: wb.Array) -> wb.Array:
        rate = in_matrices(p)
        system = control.nlsys(
            lambda t, x, u, params: rate(t, x)[0],
            lambda t, x, u, params: rate(t, x)[1],
            inputs=0,
            outputs=2,
            states=STATES.size,
        )
        response = control.input_output_response(system, times, 0.0, STATES.default)
        return rmse(np.asarray(response.states)[:, -1], horizon)

    return lambda rows: np.array([run(p) for p in rows])


def control_plant(num: Sequence[float], den: Sequence[float]) -> Any:
    """The transfer function num/den of python-control."""
    import control

    return control.tf(list(num), list(den))


def control_responses(systems: Sequence[Any], frequencies: wb.Array) -> Any:
    """The answers (N, m, ny, nu) of python-control to one system after the other, at frequencies in rad/s."""
    import control

    answers = [control.frequency_response(system, frequencies, squeeze=False).frdata for system in systems]
    return np.moveaxis(np.array(answers), -1, 1)


def has_slycot() -> bool:
    """True where slycot is here, which the H-infinity synthesis of python-control needs."""
    return find_spec("slycot") is not None


def control_hinfsyn(plant: wb.synthesis.GeneralizedPlant) -> float:
    """The gamma of the H-infinity synthesis of python-control with slycot."""
    import control

    p = plant.parts
    direct = np.block([[p.D11, p.D12], [p.D21, p.D22]])
    whole = control.ss(p.A, np.hstack([p.B1, p.B2]), np.vstack([p.C1, p.C2]), direct)
    return float(control.hinfsyn(whole, len(p.C2), p.B2.shape[1])[2])


def scipy_lsoda(horizon: float, tolerance: float = 1e-6) -> Runner:
    """One run after the other by `solve_ivp`."""
    from scipy.integrate import solve_ivp

    def run(p: wb.Array) -> wb.Array:
        rate, span = in_matrices(p), (0.0, horizon)
        options: dict[str, Any] = {"t_eval": [horizon], "rtol": tolerance, "atol": tolerance}
        return rmse(solve_ivp(lambda t, x: rate(t, x)[0], span, STATES.default, "LSODA", **options).y[:, -1], horizon)

    return lambda rows: np.array([run(p) for p in rows])


def casadi_machine(horizon: float) -> Runner:
    """The step of W on CasADi's virtual machine, one after the other by `mapaccum`."""
    step, steps = workload(), round(horizon / H)
    k, x, p = step.rule.k, step.rule.x, step.rule.p
    one = ca.Function("one", [x, k, p], [step.F(k, x, p, [])], {"cse": True})
    begin, numbers = ca.MX.sym("x", step.states.size), ca.MX.sym("p", step.parameters.size)
    end = one.mapaccum(steps)(begin, ca.DM(range(steps)).T, ca.repmat(numbers, 1, steps))[:, -1]
    march = ca.Function("march", [begin, numbers], [end])
    start = step.states.default
    return lambda rows: rmse(np.array([np.array(march(start, row)).ravel() for row in rows]), horizon)


def casadi_cvodes(horizon: float, tolerance: float) -> Runner:
    """CVODES of SUNDIALS with the exact sparse Jacobian, one run after the other."""
    ode = loop()
    equations = {"x": ode.x, "t": ode.t, "p": ode.p, "ode": ode.rate}
    options = {"reltol": tolerance, "abstol": tolerance, "max_num_steps": 1_000_000}  # it gives up at 10,000
    march = ca.integrator("march", "cvodes", equations, 0.0, horizon, options)
    start = ode.states.default
    return lambda rows: rmse(np.array([np.array(march(x0=start, p=row)["xf"]).ravel() for row in rows]), horizon)


def jax_scan(horizon: float) -> Runner:
    """`scan` over the steps and `vmap` over the runs, in double precision, on one core."""
    with patch.dict(os.environ, NPROC="1"):  # XLA's pool has one thread: others only wait at their own cost
        import jax
        import jax.numpy as jnp

        jax.config.update("jax_enable_x64", True)
        device = jax.devices("cpu")[0]
    scalars, h = in_scalars(jnp), H

    def rate(t: Any, x: Any, p: Any) -> tuple[Any, Any]:
        parts = scalars(t, x, p)
        return jnp.stack(parts[: STATES.size]), jnp.stack(parts[STATES.size :])

    def march(p: Any) -> Any:
        def step(carry: Any, k: Any) -> Any:
            (x, before, variation), t = carry, k * h
            k1, tau = rate(t, x, p)
            k2, _ = rate(t + h / 2, x + h / 2 * k1, p)
            k3, _ = rate(t + h / 2, x + h / 2 * k2, p)
            k4, _ = rate(t + h, x + h * k3, p)
            change = jnp.where(k > 0, jnp.abs(tau - before).sum(), 0.0)
            return (x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4), tau, variation + change), None

        start = (jnp.asarray(STATES.default), jnp.zeros(2), 0.0)
        (x, _, variation), _ = jax.lax.scan(step, start, jnp.arange(float(round(horizon / h))))
        return x, variation

    compiled = jax.jit(jax.vmap(march))

    def run(rows: wb.Array) -> wb.Array:
        with jax.default_device(device):
            return rmse(np.asarray(compiled(rows)[0]), horizon)

    return run


def numba_loop(horizon: float) -> Runner:
    """RK4 and the loop over steps and runs compiled, one run after the other, without an allocation in the loop."""
    march, steps = _numba_march(), round(horizon / H)
    march(PARAMETERS.default[np.newaxis], STATES.default, 1, H)
    return lambda rows: rmse(march(rows, STATES.default, steps, H)[0], horizon)


def _numba_march() -> Any:
    """The states (B, 21) and the total variations (B,) after so many steps."""
    import numba

    jit: Callable[[Any], Any] = numba.njit(fastmath=True, error_model="numpy")
    nx, rate = STATES.size, in_scalars(np, jit)

    @jit
    def put(to: wb.Array, t: float, x: wb.Array, p: wb.Array) -> None:
        # a tuple of unlike parts has no loop in numba, and an array made of it would be an allocation
        (to[0], to[1], to[2], to[3], to[4], to[5], to[6], to[7], to[8], to[9], to[10], to[11], to[12], to[13],
         to[14], to[15], to[16], to[17], to[18], to[19], to[20], to[21], to[22]) = rate(t, x, p)  # fmt: skip

    @jit
    def march(rows: wb.Array, start: wb.Array, steps: int, h: float) -> tuple[wb.Array, wb.Array]:
        states, variation = np.empty((len(rows), nx)), np.zeros(len(rows))
        k1, k2, k3, k4, y = np.empty(nx + 2), np.empty(nx + 2), np.empty(nx + 2), np.empty(nx + 2), np.empty(nx)
        for run in range(len(rows)):
            p, x = rows[run], states[run]
            x[:] = start
            before1 = before2 = 0.0
            for k in range(steps):
                t = k * h
                put(k1, t, x, p)
                for i in range(nx):
                    y[i] = x[i] + h / 2 * k1[i]
                put(k2, t + h / 2, y, p)
                for i in range(nx):
                    y[i] = x[i] + h / 2 * k2[i]
                put(k3, t + h / 2, y, p)
                for i in range(nx):
                    y[i] = x[i] + h * k3[i]
                put(k4, t + h, y, p)
                for i in range(nx):
                    x[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i])
                if k > 0:
                    variation[run] += abs(k1[nx] - before1) + abs(k1[nx + 1] - before2)
                before1, before2 = k1[nx], k1[nx + 1]
        return states, variation

    return march


IN_MATRICES = ("python-control nlsys, defaults", "SciPy LSODA 1e-6, NumPy")  # faster with a right-hand side in scalars
PEERS = (
    Peer(IN_MATRICES[0], "control", 8000.0, 1, python_control),
    Peer(IN_MATRICES[1], "scipy", 1300.0, 2, scipy_lsoda),
    Peer("CasADi VM mapaccum", "casadi", 110.0, 8, casadi_machine),
    Peer("JAX vmap + scan, x64", "jax", 50.0, 64, jax_scan),
    Peer("numba scalar loop", "numba", 14.0, 16, numba_loop),
)
