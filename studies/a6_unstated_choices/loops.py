"""Each law of the tables as a loop, with the numbers and readings that the paper leaves open as its factors."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

import workbench as wb
from studies.a6_unstated_choices.blocks import EitherAosmcRgs, EitherArm, EitherObserver, EitherReference, PlacedPid
from studies.paper.card import CARD, INERTIA, LAWS, POLES
from studies.paper.laws import ARM, PRINTED_ARM, RIVALS, SINES, SQUARE_WAVE, plant

PROPOSED_LAW, PID = "AOSMC-RGS", "PID"
SCENARIOS = {"FS": "first scenario", "SS": "second scenario"}
PERIOD = 2e-3  # s
# N m/(rad s): below it P' = -P Lambda R^-1 Lambda P of (34) falls from P(0) too fast for the step, which then diverges
STIFF = 0.3
SIGNS = ("plus", "minus")  # the second is printed
SHORTEST, LONGEST = 5, 60  # s, the horizons that are drawn and searched
RMSE = wb.metrics.sampled_rmse(CARD["sample time of (43)"])
STEPS = {law: 1e-3 if law == PROPOSED_LAW else PERIOD for law in LAWS}  # s


@dataclass(frozen=True)
class Reading(wb.uncertainty.AbstractDistribution):
    """The place, counted from 0, of one of some readings, each as likely as the others, or always that of `only`."""

    names: tuple[str, ...]
    only: str | None = None
    low: float = field(default=0.0, init=False)
    high: float = field(default=0.0, init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "high", len(self.names) - 1.0)

    def _formula(self, u: wb.Array) -> wb.Array:
        if self.only is not None:
            return np.full(np.shape(u), float(self.names.index(self.only)))
        return np.minimum(np.floor(np.asarray(u) * len(self.names)), self.high)

    def words(self) -> str:
        if self.only is not None:
            return f"always {self.only}"
        return f"one of: {', '.join(self.names)}"


def _card(name: str, *paths: str, words: str = "", orders: bool = False) -> wb.Factor:
    return replace(next(g for g in CARD if g.name == name).factor(paths, log_scale=orders), name=words or name)


def _reading(name: str, names: Sequence[str], *paths: str) -> wb.Factor:
    return wb.Factor(name, paths, Reading(tuple(names)))


def _share(name: str, path: str, low: float, high: float) -> wb.Factor:
    return wb.Factor(name, (path,), wb.Uniform(low, high), share=True)


LEARNING = (_card("ASMC: K(0)", "controller.K", words="K(0)"), _card("ASMC: gamma", "controller.gamma", words="gamma"))
MEASUREMENT_READING = _reading("rivals' measurements", ("exact", "by (10)"), "observer.inside")
SQUARE = (
    _card("SS: a1, a2", "reference.square.amplitude[0]", words="a1"),
    _card("SS: a1, a2", "reference.square.amplitude[1]", words="a2"),
    _card("SS: f", "reference.square.frequency", words="f"),
)

# What the paper leaves open of each law; where two laws have a factor of one name, it is the same number.
FACTORS: Mapping[str, tuple[wb.Factor, ...]] = {
    PROPOSED_LAW: (
        _card("Q", "controller.Q", orders=True),
        wb.Factor("R", ("controller.R",), wb.LogUniform(STIFF, 1000.0)),
        _card("l", "observer.l", orders=True),
        _reading("sign of (33)", SIGNS, "controller.minus"),
        _reading("shape of (33)", list(wb.arms.laws.SHAPES), "controller.shape"),
        _reading("velocity in (28)", ("reference", "printed"), "controller.printed"),
        _reading("D_hat of (24)", ("none", "eta", "its integral"), "observer.d_hat"),
        _reading("observer (10)", ("out", "in"), "observer.inside"),
        _reading("C of (3)", ("right", "printed"), "controller.model.misprint", "observer.state.model.misprint"),
    ),
    "ASMC": (*LEARNING, MEASUREMENT_READING),
    "Fuzzy-ASMC": (
        *LEARNING,
        _card("Fuzzy-ASMC: lag", "controller.lag", words="lag"),
        _share("rules", "controller.rules.scale", 0.1, 2.5),
        _share("centres of |s|", "controller.rules.sizes", 0.1, 2.0),
        _share("centres of the trend", "controller.rules.trends", 0.1, 2.0),
        _card("Fuzzy-ASMC: width of |s|", "controller.rules.size_width", words="width of |s|"),
        _card("Fuzzy-ASMC: width of the trend", "controller.rules.trend_width", words="width of the trend"),
        MEASUREMENT_READING,
    ),
    "RBF-ASMC": (
        *LEARNING,
        _card("RBF-ASMC: Gamma", "controller.Gamma", words="Gamma"),
        _card("RBF-ASMC: sigma", "controller.sigma", words="sigma"),
        _share("centres", "controller.centres", 0.1, 2.0),
        _card("RBF-ASMC: widths", "controller.widths", words="widths"),
        MEASUREMENT_READING,
    ),
    PID: (
        _card("PID: poles", "controller.poles[0]", words="poles of joint 1"),
        _card("PID: poles", "controller.poles[1]", words="poles of joint 2"),
        _reading("G in PID", ("without", "with"), "controller.lifted"),
        MEASUREMENT_READING,
    ),
    "SMC": (
        _card("SMC: K", "controller.K[0]", words="K of joint 1"),
        _card("SMC: K", "controller.K[1]", words="K of joint 2"),
        MEASUREMENT_READING,
    ),
}


def factors_of(law: str, scenario: str) -> tuple[wb.Factor, ...]:
    """The open numbers of a law and a scenario, but for the horizon, which needs no run of its own."""
    return FACTORS[law] + (SQUARE if scenario == "SS" else ())


HORIZONS = {scenario: f"horizon of {scenario}" for scenario in SCENARIOS}
OPEN = dict.fromkeys(factor.name for law in LAWS for factor in factors_of(law, "SS"))
NAMES = (*OPEN, *HORIZONS.values())


def in_words(factors: Sequence[wb.Factor], values: Iterable[float]) -> str:
    """Factors with their values."""
    parts = []
    for factor, value in zip(factors, values, strict=True):
        spread = factor.distribution
        shown = spread.names[round(value)] if isinstance(spread, Reading) else f"{value:.4g}"
        parts.append(f"{factor.name} {shown}")
    return ", ".join(parts)


def loop(law: str, scenario: str, limit: tuple[float, float] | None = None) -> wb.ClosedLoop:
    """A law in a scenario, with all its readings and the boundary layer of the paper.

    A drive limits the torques to `limit` in N m, if given, and the observer (10) reads the limited torques.
    """
    ours = law == PROPOSED_LAW
    model = EitherArm(ARM, PRINTED_ARM)
    state = wb.arms.observers.Luenberger(model, CARD["L1"], CARD["L2"], CARD["q_hat(0)"], CARD["qd_hat(0)"])
    observer = EitherObserver(state, CARD["l"], inside=float(ours), d_hat=float(ours))
    reference = EitherReference(SINES, SQUARE_WAVE, jumps=float(scenario == "SS"))
    controller: wb.Controller = RIVALS.get(law, RIVALS[PID])
    if law == PID:
        controller = PlacedPid(ARM, np.full(2, POLES), INERTIA)
    if ours:
        Q, R = (float(CARD[name][0, 0]) for name in ("Q", "R"))
        controller = EitherAosmcRgs(model, CARD["Lambda"], CARD["phi"], CARD["K(0)"], CARD["P(0)"], Q=Q, R=R)
    arm = plant(scenario)
    if limit is not None:
        arm = replace(arm, actuator=wb.arms.DirectDrive(np.array(limit)))
        observer = replace(observer, limit=np.array(limit))
        if isinstance(controller, PlacedPid):
            controller = replace(controller, limit=np.array(limit))
    return wb.ClosedLoop(arm, observer, controller, reference)


def with_relay(law: str, one: wb.ClosedLoop) -> wb.ClosedLoop | wb.DigitalLoop:
    """A loop as searches and draws run it: a rival that switches by a computer, as an implicit relay once in `PERIOD`.

    That keeps s as near to zero as the boundary layer does, whatever the gain, at steps at which the layer chatters.
    """
    if law in (PROPOSED_LAW, PID):
        return one
    return wb.DigitalLoop(replace(one, controller=replace(one.controller, saturation="implicit")), PERIOD)


def slug(*words: str) -> str:
    """A name for files."""
    return "_".join(word.lower().replace("-", "_") for word in words)
