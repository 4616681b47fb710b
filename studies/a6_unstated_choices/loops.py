"""Each law of the tables as a loop with factors over the ranges of the card, and draws of all that is open."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from studies.a6_unstated_choices.blocks import EitherAosmcRgs, EitherArm, EitherObserver, EitherReference, PlacedPid
from studies.paper.card import CARD, INERTIA, LAWS, POLES
from studies.paper.laws import ARM, PRINTED_ARM, REFERENCES, RIVALS, plant
from workbench.controllers.aosmc_rgs import SHAPES
from workbench.loop import AbstractController, ClosedLoop, DigitalLoop
from workbench.metrics import sampled_rmse
from workbench.observers import Luenberger
from workbench.study.contract import Run, Sweep
from workbench.study.sample import Sample
from workbench.study.study import Results
from workbench.study.uncertainty import Listed, MonteCarlo, SobolDesign
from workbench.study.uncertainty.distributions import AbstractDistribution, LogUniform, Uniform
from workbench.study.uncertainty.factors import Factor
from workbench.validation.refusals import Array, Integers

PROPOSED, PID = "AOSMC-RGS", "PID"
SCENARIOS = {"FS": "first scenario", "SS": "second scenario"}
PERIOD = 2e-3  # s
# N m/(rad s): below it P' = -P Lambda R^-1 Lambda P of (34) falls from P(0) too fast for the step, which then diverges
STIFF = 0.3
STEPS = {law: 1e-3 if law == PROPOSED else PERIOD for law in LAWS}  # s


@dataclass(frozen=True)
class Reading(AbstractDistribution):
    """The place, counted from 0, of one of some readings, each as likely as the others."""

    names: tuple[str, ...]

    @property
    def low(self) -> float:
        return 0.0

    @property
    def high(self) -> float:
        return len(self.names) - 1.0

    def _formula(self, u: Array) -> Array:
        return np.minimum(np.floor(np.asarray(u) * len(self.names)), self.high)

    def words(self) -> str:
        return f"one of: {', '.join(self.names)}"


def _card(name: str, *paths: str, words: str = "", orders: bool = False) -> Factor:
    return replace(Factor.of(next(g for g in CARD if g.name == name), paths, log_scale=orders), name=words or name)


def _reading(name: str, names: Sequence[str], *paths: str) -> Factor:
    return Factor(name, paths, Reading(tuple(names)))


def _share(name: str, path: str, low: float, high: float) -> Factor:
    return Factor(name, (path,), Uniform(low, high), share=True)


LEARNING = (_card("ASMC: K(0)", "controller.K", words="K(0)"), _card("ASMC: gamma", "controller.gamma", words="gamma"))
MEASURED = _reading("rivals' measurements", ("exact", "by (10)"), "observer.inside")
SQUARE = (
    _card("SS: a1, a2", "reference.square.amplitude[0]", words="a1"),
    _card("SS: a1, a2", "reference.square.amplitude[1]", words="a2"),
    _card("SS: f", "reference.square.frequency", words="f"),
)

# What the paper leaves open of each law; where two laws have a factor of one name, it is the same number.
FACTORS: Mapping[str, tuple[Factor, ...]] = {
    PROPOSED: (
        _card("Q", "controller.Q", orders=True),
        Factor("R", ("controller.R",), LogUniform(STIFF, 1000.0)),
        _card("l", "observer.l", orders=True),
        _reading("shape of (33)", list(SHAPES), "controller.shape"),
        _reading("velocity in (28)", ("reference", "printed"), "controller.printed"),
        _reading("D_hat of (24)", ("none", "eta", "its integral"), "observer.d_hat"),
        _reading("observer (10)", ("out", "in"), "observer.inside"),
        _reading("C of (3)", ("right", "printed"), "controller.model.misprint", "observer.state.model.misprint"),
    ),
    "ASMC": (*LEARNING, MEASURED),
    "Fuzzy-ASMC": (
        *LEARNING,
        _card("Fuzzy-ASMC: lag", "controller.lag", words="lag"),
        _share("rules", "controller.rules.scale", 0.1, 2.5),
        _share("centres of |s|", "controller.rules.sizes", 0.1, 2.0),
        _card("Fuzzy-ASMC: width of |s|", "controller.rules.size_width", words="width of |s|"),
        _card("Fuzzy-ASMC: width of the trend", "controller.rules.trend_width", words="width of the trend"),
        MEASURED,
    ),
    "RBF-ASMC": (
        *LEARNING,
        _card("RBF-ASMC: Gamma", "controller.Gamma", words="Gamma"),
        _card("RBF-ASMC: sigma", "controller.sigma", words="sigma"),
        _share("centres", "controller.centres", 0.1, 2.0),
        _card("RBF-ASMC: widths", "controller.widths", words="widths"),
        MEASURED,
    ),
    PID: (
        _card("PID: poles", "controller.poles[0]", words="poles of joint 1"),
        _card("PID: poles", "controller.poles[1]", words="poles of joint 2"),
        _reading("G in PID", ("without", "with"), "controller.lifted"),
    ),
    "SMC": (
        _card("SMC: K", "controller.K[0]", words="K of joint 1"),
        _card("SMC: K", "controller.K[1]", words="K of joint 2"),
        MEASURED,
    ),
}


def factors_of(law: str, scenario: str) -> tuple[Factor, ...]:
    """The open numbers of a law and a scenario, but for the horizon, which needs no run of its own."""
    return FACTORS[law] + (SQUARE if scenario == "SS" else ())


def in_words(factors: Sequence[Factor], values: Iterable[float]) -> str:
    """Factors with their values."""
    parts = []
    for factor, value in zip(factors, values, strict=True):
        spread = factor.distribution
        shown = spread.names[round(value)] if isinstance(spread, Reading) else f"{value:.4g}"
        parts.append(f"{factor.name} {shown}")
    return ", ".join(parts)


def loop(law: str, scenario: str) -> ClosedLoop:
    """A law in a scenario, with all its readings, as the paper has it: with the boundary layer."""
    ours = law == PROPOSED
    model = EitherArm(ARM, PRINTED_ARM)
    state = Luenberger(model, CARD["L1"], CARD["L2"], CARD["q_hat(0)"], CARD["qd_hat(0)"])
    observer = EitherObserver(state, CARD["l"], inside=float(ours), d_hat=float(ours))
    reference = EitherReference(REFERENCES["FS"], REFERENCES["SS"], jumps=float(scenario == "SS"))
    controller: AbstractController = RIVALS.get(law, RIVALS[PID])
    if law == PID:
        controller = PlacedPid(ARM, np.full(2, POLES), INERTIA)
    if ours:
        Q, R = (float(CARD[name][0, 0]) for name in ("Q", "R"))
        controller = EitherAosmcRgs(model, CARD["Lambda"], CARD["phi"], CARD["K(0)"], CARD["P(0)"], Q=Q, R=R)
    return ClosedLoop(plant(scenario), observer, controller, reference)


def relayed(law: str, one: ClosedLoop) -> ClosedLoop | DigitalLoop:
    """A loop as searches and draws run it: a rival that switches by a computer, as an implicit relay once in `PERIOD`.

    That keeps s as near to zero as the boundary layer does, whatever the gain, at steps at which the layer chatters.
    """
    if law in (PROPOSED, PID):
        return one
    return DigitalLoop(replace(one, controller=replace(one.controller, saturation="implicit")), PERIOD)


Scale: TypeAlias = Literal["linear", "log"]
RMSE = sampled_rmse(CARD["sample time of (43)"])
SHORTEST, LONGEST = 5, 30  # s, the horizons of the card
HORIZONS = {scenario: f"horizon of {scenario}" for scenario in SCENARIOS}
OPEN = dict.fromkeys(factor.name for law in LAWS for factor in factors_of(law, "SS"))
NAMES = (*OPEN, *HORIZONS.values())
RANDOM = MonteCarlo(len(NAMES), 512, seed=6)
PAIRED = SobolDesign(len(NAMES), 128, seed=6)
DESIGNS: Mapping[str, MonteCarlo | SobolDesign] = {"random": RANDOM, "paired": PAIRED}
RANGES = {"linear": Uniform, "log": LogUniform}


@dataclass(frozen=True)
class Prior:
    """On which scale each number is drawn evenly: those of the proposed law, and all others with the experiment's."""

    ours: Scale
    rest: Scale

    def scales(self, law: str, scenario: str) -> tuple[Scale, ...]:
        """Those of a law's own numbers and, where there is one, of the square wave."""
        return (self.ours if law == PROPOSED else self.rest, *((self.rest,) if scenario == "SS" else ()))

    def factors(self, law: str, scenario: str) -> tuple[Factor, ...]:
        """The open numbers of a law and a scenario, spread on these scales."""
        own, *square = self.scales(law, scenario)
        return tuple(on_scale(factor, square[0] if factor in SQUARE else own) for factor in factors_of(law, scenario))

    def horizons(self, u: Array) -> Integers:
        """Whole seconds for numbers (N,) from 0 to 1."""
        spread = RANGES[self.rest](SHORTEST, LONGEST + 1)
        return np.minimum(spread.quantile(u).astype(int), LONGEST)


# Logarithmic is what the card knows by its order of magnitude only: Q, R and l of the proposed law.
OF_CARD = Prior("log", "linear")
PRIORS: Mapping[str, Prior] = {
    "of the card": OF_CARD,
    "all linear": Prior("linear", "linear"),
    "all logarithmic": Prior("log", "log"),
    "exchanged": Prior("linear", "log"),
}


def on_scale(factor: Factor, scale: Scale) -> Factor:
    """The factor drawn evenly on a scale; a reading has none, and a range from 0 on no logarithmic one."""
    spread = factor.distribution
    if isinstance(spread, Reading) or spread.low <= 0:
        return factor
    return replace(factor, distribution=RANGES[scale](spread.low, spread.high))


def slug(*words: str) -> str:
    """A name for files."""
    return "_".join(word.lower().replace("-", "_") for word in words)


def named(kind: str, law: str, scenario: str, prior: Prior = OF_CARD) -> str:
    """The name of the runs of a law in a scenario: several priors share them."""
    return slug(kind, law, scenario, *prior.scales(law, scenario))


def part(kind: str, factors: Sequence[Factor]) -> tuple[Listed, Integers]:
    """The points of a design of all that is open that differ in some factors, and which of them stands at each (N,)."""
    columns = [NAMES.index(factor.name) for factor in factors]
    points, places = np.unique(DESIGNS[kind].points()[:, columns], axis=0, return_inverse=True)
    return Listed(points), places.ravel()


def draws(kind: str, law: str, scenario: str, prior: Prior = OF_CARD) -> Sweep:
    """A law in a scenario, over all that they leave open: the same points of the unit cube for every prior."""
    factors = prior.factors(law, scenario)
    run = Run(relayed(law, loop(law, scenario)), (RMSE,), LONGEST, every=1.0, h=STEPS[law])
    halved = 32 if kind == "random" else None
    return Sweep(named(kind, law, scenario, prior), run, factors, part(kind, factors)[0], halved=halved)


def at_draws(results: Results, kind: str, law: str, scenario: str, prior: Prior = OF_CARD) -> Sample:
    """The runs of a law in a scenario, one a point of the whole design."""
    sample, (_, places) = results.sample(named(kind, law, scenario, prior)), part(kind, factors_of(law, scenario))
    found = sample.measurement.only(np.empty(0, dtype=int))  # without errors
    values, lost = sample.values[places], sample.diverged_at[places]
    return replace(
        sample, drawn=sample.drawn[places], measurement=replace(found, values=values, diverged_at=lost), design=None
    )


def drawn(results: Results, kind: str, scenario: str, prior: Prior = OF_CARD) -> dict[str, Array]:
    """RMSE (N, 2) by law, in rad, over the same N draws of a scenario, each at its own horizon; NaN where a run
    diverged before it.
    """
    u = DESIGNS[kind].points()[:, NAMES.index(HORIZONS[scenario])]
    rmse = {}
    for law in LAWS:
        sample = at_draws(results, kind, law, scenario, prior)
        rows = np.round(sample.t).astype(int).searchsorted(prior.horizons(u))
        rmse[law] = sample.values[np.arange(len(sample)), rows]
    return rmse


def margin(rmse: Mapping[str, Array]) -> Array:
    """The RMSE of the proposed law as a share of its sum with that of the best rival, (N, 2).

    Below 1/2 the proposed law is first; 1 where it diverged.
    """
    ours, *rivals = (np.where(np.isnan(rmse[law]), np.inf, rmse[law]) for law in LAWS)
    return np.where(np.isinf(ours), 1.0, 1 / (1 + np.min(rivals, axis=0) / ours))
