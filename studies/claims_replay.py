"""What the witnesses of a2 need: after `from claims_replay import *`, in this folder, each of their lines runs."""

from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np
from a1_paper_tables import comparison
from claims_hunts import hunt, replay, stored
from claims_identities import at, both
from claims_loops import I, beside_rest, observer_rate, printed_but_for_c, regulation, weighted
from paper_card import CARD
from paper_laws import ARM, PRINTED_ARM, proposed_as_printed, proposed_repaired

from workbench.controllers.promises import K_STAYS_DEFINITE
from workbench.core import Dynamics, Entry, Layout, Ode
from workbench.core.claim import Declared
from workbench.core.layout import Array
from workbench.metrics import measure
from workbench.metrics.integral import Integral
from workbench.simulate.reference import reference
from workbench.verify.counterexample import in_reference_mode
from workbench.verify.margins import SignalsOf, violation, watching
from workbench.verify.rest import RestPoint, growing_modes, rest_point

__all__ = [
    "I",
    "astray",
    "beside",
    "beside_rest",
    "both",
    "cost",
    "derived",
    "drift",
    "escape",
    "false_rest",
    "gain_lost",
    "growing_modes",
    "mismatch",
    "np",
    "offset",
    "printed",
    "replay",
    "rest_point",
    "skewness",
    "v1_rate",
]

STEP, FINE = 1e-4, 1e-3 / 12  # s, of the law as printed and as repaired
printed, derived = Dynamics.of(PRINTED_ARM, "as printed"), Dynamics.of(ARM, "derived")


def mismatch(q_hat: Any, tau: Any) -> float:
    """|Delta| of (14) in rad/s^2 for the arm hanging at rest, qd_hat = 0: (14) less its part in q_hat alone."""
    zero = ca.SX.zeros(2)
    M, _, G = at(zero, zero)
    M_hat, _, G_hat = at(ca.SX(q_hat), zero)
    return float(ca.evalf(ca.norm_2(ca.solve(M, tau - G) - ca.solve(M_hat, tau - G_hat))))


def v1_rate(q: Any, x2: Any) -> tuple[float, float]:
    """V1' of (17) beside the arm at rest at q, with P2 = I, x1~ = 0, and x2~ = x2 or -x2, in rad^2/s^3."""
    weight, error = at(ca.SX(q), ca.SX.zeros(2))[2], ca.SX(x2)
    there, back = (-ca.dot(e, observer_rate(ARM, ca.SX(q), -e, weight)) for e in (error, -error))
    return float(ca.evalf(there)), float(ca.evalf(back))


def skewness(arm: Dynamics, q: Any, qd: Any) -> Array:
    """M' - 2C plus its transpose, in kg m^2/s."""
    N = arm.mass_matrix_rate - 2 * arm.C
    return np.array(ca.Function("N", [arm.q, arm.qd, arm.symbols], [N + N.T])(q, qd, arm.p.default))


def false_rest(times: float = 1) -> RestPoint:
    """Where (10), with so many times the gains of section 5, rests beside the hanging arm: with errors, not at zero."""
    near = np.array([-2.65, 6.28])
    return rest_point(beside_rest(times * 30 * I, times * 50 * I), np.concatenate([near, times * 30 * near]))


def drift(until: float = 10.0) -> tuple[Array, Array]:
    """D_hat of (24) as printed, in N m s, for D = (0.5, 0.4) N m held so long: by its closed form and by a run."""
    l, D, ode = CARD["l"], np.array([0.5, 0.4]), hunt("printed_filter").ode
    held = {
        "disturbance.amplitude": D,
        "disturbance.frequency": np.zeros(2),
        "disturbance.phase": np.pi / 2 * np.ones(2),
    }
    run = reference(ode, ode.parameters.pack(held)[0], times=[until])
    return D * (until - (1 - np.exp(-l * until)) / l), ode.states.unpack(run.x[0])["D_hat"]


def gain_lost(reading: str, until: float = 4.0, Q: float = 1.0, R: float = 1.0) -> tuple[float, float, int]:
    """The least leading minor of K, (33) as printed, in the second scenario; its change by h / 2; its order.

    The weights are Q I and R I. The unit is (N m)^order.
    """
    loop = weighted(proposed_as_printed("SS", reading), Q, R)
    ode, gain = loop.ode(), Declared(K_STAYS_DEFINITE, "controller.")
    score = measure(watching(ode, [gain]), (violation(gain.claim),), until=until, h=STEP)
    found = score.scores[violation(gain.claim).name]
    worst = int(np.argmax(found.value[0]))
    return -float(found.value[0, worst]), float(found.error[0, worst]), worst + 1


def cost(riccati: str, Q: float, R: float, until: float = 10.0) -> tuple[float, float]:
    """J of (32) over a horizon for the repaired law in the first scenario, P' by (34) or zero; its change by h / 2.

    The weights are Q I and R I, in (34) and in (32).
    """
    loop = weighted(proposed_repaired("FS"), Q, R)
    if riccati == "frozen":
        loop = replace(loop, controller=replace(loop.controller, riccati="frozen", Q=None, R=None))
    ode = loop.ode()
    y = SignalsOf(ode)
    rate = Q * ca.sumsqr(y["s"]) + R * ca.sumsqr(y["observer.state.qd_hat"] - y["qd_ref"])
    watched = _with_output(ode, "cost", rate)
    J = Integral("J", "", "the cost (32)", lambda t, y: y["cost"], lambda value, horizon: value, ("cost",))
    score = measure(watched, (J,), until=until, h=FINE).scores["J"]
    return float(score.value[0, 0]), float(score.error[0, 0])


def beside(metric: str) -> dict[str, list[float]]:
    """A metric of the six laws in both scenarios, joint by joint, as a1 measures it."""
    cases = [case for scenario in ("FS", "SS") for case in comparison(scenario)]
    found = {}
    for case in cases:
        mine = tuple(m for m in case.metrics if m.name == metric)
        if mine:
            score = measure(case.loop.ode(), mine, until=case.until, h=case.h).scores[metric]
            found[case.name] = score.value[0].tolist()
    return found


def astray() -> tuple[float, float]:
    """|q - q_hat| in rad at the end of the stored run of the free arm, by variable steps, and its error."""
    task, example = hunt("swinging_arm"), stored("swinging_arm")
    p, x0 = example.rows(task.ode)
    y, error = in_reference_mode(task.watched, "q_error", p[0], x0[0], [example.until])
    return float(np.linalg.norm(y[0])), float(np.linalg.norm(error))


def escape() -> tuple[float, float, float]:
    """When the law as printed, with C as derived, diverges in the first scenario, reading `outer` of (33).

    In s: at h / 2, at h, and, at h / 2, when K has first been seen to be definite no more; NaN for never.
    """
    gain = Declared(K_STAYS_DEFINITE, "controller.")
    ode = watching(printed_but_for_c().ode(), [gain])
    found = measure(ode, (), until=5.0, h=STEP, every=100 * STEP)
    broken = (found.trajectories[violation(gain.claim).signal][0] > 0).any(axis=1)
    turned = found.trajectories.t[np.argmax(broken)] if broken.any() else np.nan
    return float(found.trajectories.diverged_at[0]), float(found.coarse_diverged_at[0]), float(turned)


def offset(until: float = 20.0) -> tuple[Array, Array]:
    """q - q_d at the end of a long rest under D = (0.5, 0.4) N m, by the repaired law, and its change by h / 2."""
    runs = [measure(regulation().ode(), (), until=until, h=h, every=until).trajectories for h in (FINE, FINE / 2)]
    coarse, fine = (run["e"][0, -1] for run in runs)
    return fine, np.abs(fine - coarse)


def _with_output(ode: Ode, name: str, value: ca.SX) -> Ode:
    return replace(ode, outputs=ode.outputs + Layout((Entry(name, np.zeros(1)),)), output=ca.vertcat(ode.output, value))
