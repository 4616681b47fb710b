"""The gains that a4 compares, the region in which it asks for them, and the audit of each, once."""

from collections.abc import Mapping
from functools import cache

import numpy as np

from studies.paper.card import CARD
from studies.paper.laws import ARM
from workbench.core import Dynamics
from workbench.design import observer_gains
from workbench.design.observer_gains import Audit, Frozen, Gains, Lipschitz, Mismatch, RateCertificate, Region
from workbench.study.document.phrases import raised
from workbench.validation.refusals import Array

I, REST = np.eye(2), np.zeros(2)
DYNAMICS = Dynamics.of(ARM)
MISMATCH = Mismatch.of(DYNAMICS)
REGION = Region(np.array([5.0, 5.0]), np.array([30.0, 30.0]))  # rad/s, N m, at any position
INNER = 0.8  # of the speeds are the arm's own, the rest is room for the error of its estimate
SURFACE = float(min(CARD["Lambda"]))  # 1/s, as fast as which the estimate should at least be
MODEST = 0.1  # 1/s, the rate that is asked of the paper's gains, as they keep no more
BOX = f"|qd_i| ≤ {REGION.speed[0]:g} rad/s, |tau_i| ≤ {REGION.torque[0]:g} N m, any position"
SCENARIOS = ("first scenario", "first scenario, from y(0)", "second scenario")
PAPER, CHOSEN, LMI = "paper", "double pole", "LMI"  # chosen: of those with a proof in the whole region
POLES = np.array([22.0, 26.0, 30.0, 35.0, 40.0, 50.0, 60.0])  # 1/s, of the curve beside the gains
HOW = {
    PAPER: "section 5",
    CHOSEN: f"the least double pole that is proved to decay at {SURFACE:g} 1/s in the whole region",
    "high gain": "a1 = 3, a2 = 2, epsilon = 25 ms: poles at -40 and -80 1/s",
    "Kalman": raised("beside the hanging arm; noise of 1e-4 rad^2 s, unknown accelerations of 1000 rad^2/s^3"),
    LMI: f"the least bound of noise with {SURFACE:g} 1/s in the whole region, all by one LMI",
}
STYLES = {name: i for i, name in enumerate(HOW)}


@cache
def proved() -> Mapping[str, RateCertificate]:
    """The gains that come with their certificate."""
    return {
        CHOSEN: observer_gains.least_double_pole(DYNAMICS, REGION, SURFACE),
        LMI: observer_gains.by_lmi(DYNAMICS, REGION, SURFACE),
    }


@cache
def gains() -> Mapping[str, Gains]:
    """The gains by name, in the order of HOW."""
    return {
        PAPER: Gains(CARD["L1"], CARD["L2"]),
        CHOSEN: proved()[CHOSEN].gains,
        "high gain": observer_gains.high_gain(2, 3.0, 2.0, 0.025),
        "Kalman": observer_gains.kalman(DYNAMICS, REST, REST, REST, 1e3 * I, 1e-4 * I),
        LMI: proved()[LMI].gains,
    }


@cache
def audits() -> Mapping[str, Audit]:
    """The audit of each: the paper's gains are asked for a modest rate, the others for the surface's."""
    return {
        name: observer_gains.audit(
            DYNAMICS, mine, REGION, INNER, MODEST if name == PAPER else SURFACE, proved().get(name)
        )
        for name, mine in gains().items()
    }


@cache
def lipschitz(share: float) -> Lipschitz:
    """The Lipschitz constants over a share of the region."""
    return observer_gains.lipschitz(MISMATCH, REGION.scaled(share))


@cache
def followed() -> Mapping[str, Frozen]:
    """The frozen poles along the desired motion of the first scenario."""
    t = np.linspace(0, 2 * np.pi, 601)
    a, w = (np.array(CARD[f"FS: reference {name}"]) for name in ("amplitude", "frequency"))
    q, qd, qdd = a * np.sin(np.outer(t, w)), a * w * np.cos(np.outer(t, w)), -a * w**2 * np.sin(np.outer(t, w))
    tau = np.array([DYNAMICS.torque(*state) for state in zip(q, qd, qdd, strict=True)])
    return {name: observer_gains.along(MISMATCH, mine, REGION, q, qd, tau) for name, mine in gains().items()}


@cache
def trade_off() -> tuple[Array, Array]:
    """The slowest frozen rate seen in the region, and the noise of the velocity, over double poles."""
    placed = [observer_gains.high_gain(2, 2.0, 1.0, 1 / p) for p in POLES]
    slowest = [observer_gains.over(MISMATCH, mine, REGION, 4000).slowest for mine in placed]
    return np.array(slowest), np.array([observer_gains.noise(mine).velocity for mine in placed])
