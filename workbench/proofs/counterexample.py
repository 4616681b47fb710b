"""Counter-examples: a run that breaks a claim, or the worst run found, as plain numbers that can be run again."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import NamedTuple

import casadi as ca
import numpy as np

from workbench.core import Ode
from workbench.core.claim import BlockClaim
from workbench.core.layout import Layout
from workbench.core.validation.places import other_kind
from workbench.core.validation.refusals import Array, describe, known_name, nearest, refusal
from workbench.core.validation.signatures import check_arguments
from workbench.engine import StepLimit
from workbench.engine.metrics import AbstractMetric, measure
from workbench.engine.reference import reference_run
from workbench.proofs.claim_margins import Largest, violation, with_violations

# A run counts if its error of the step is no more than this share of its value, and one that diverges if it does so
# at both steps at the same time, to this share of it and as many steps as an overflow may take.
CREDIBLE, STEPS = 0.1, 20
TOO_LONG = "the step is too long"
# Two machines may round a run differently: beyond its own error a replay may differ by this share of the value.
ROUNDING = 1e-6


class StepPair(NamedTuple):
    """A run at h and at h / 2: `value` is the metric, the largest over its components, with its `error`.

    `excess` is the largest violation of a hypothesis with its error added, and minus infinity without a hypothesis.
    `diverged_at` has the times in s at which the two runs diverged. `doubt` is the reason why the run cannot refute a
    claim, and is empty if it can.
    """

    value: float
    error: float
    excess: float
    diverged_at: tuple[float, float]
    doubt: str

    @property
    def refutes(self) -> bool:
        """True if the violation exceeds its error, the hypotheses hold, and there is no doubt of the run's accuracy."""
        return self.value - self.error > 0 and self.excess <= 0 and not self.doubt


@dataclass(frozen=True)
class CounterExampleReplay:
    """A counter-example that was run again, at its step and at half of it.

    `value` is that at the step, `error` twice its change to half of it; it is the `same` as the stored value within
    both errors. `keeps_hypotheses` is True if it keeps its hypotheses. It diverged at half the step and at the whole
    one at these times in s; NaN where it stayed finite.
    """

    value: float
    error: float
    same: bool
    keeps_hypotheses: bool
    diverged_at: tuple[float, float]


@dataclass(frozen=True)
@check_arguments
class CounterExample:
    """One run of the equation with a stated fingerprint, and the value of the metric named `about` on it.

    `sought` holds the numbers that a search with `seed` chose; they are among `p` (parameters) and `x0` (the initial
    state). Horizon and step are in s. `value` is the metric at the step, largest over its components, and `error`
    twice its change to half of it; infinity and zero where the run diverged.
    """

    about: str
    fingerprint: str
    sought: Mapping[str, float]
    p: Mapping[str, float]
    x0: Mapping[str, float]
    until: float
    h: float
    seed: int
    value: float
    error: float

    @check_arguments
    def write(self, path: Path | str) -> None:
        """Store it as JSON."""
        if kind := other_kind(path):
            raise refusal("CounterExample.write(path=...)", "a file that can be written", path, f": that is {kind}")
        fields = asdict(self) | {"value": float(self.value).hex(), "error": float(self.error).hex()}
        try:
            Path(path).write_text(json.dumps(fields, indent=1) + "\n", encoding="utf-8")
        except (OSError, ValueError) as error:  # the second where a name holds what none can
            why = error.strerror if isinstance(error, OSError) else error
            raise refusal("CounterExample.write(path=...)", "a file that can be written", path, f": {why}") from None

    @staticmethod
    @check_arguments
    def read(path: Path | str) -> CounterExample:
        """The counter-example that `write` has stored."""
        file = Path(path)
        call = f"CounterExample.read({describe(file.name)})"
        try:
            if not file.is_file():
                raise LookupError(f"`{call}`: there is no such file.")
            text = file.read_bytes()
        except OSError as error:
            raise ValueError(f"`{call}` must be a file that can be read: {error.strerror}.") from None
        try:
            fields = json.loads(text.decode())
            sought, p, x0 = ({str(k): float(v) for k, v in fields[name].items()} for name in ("sought", "p", "x0"))
            value, change = (float.fromhex(fields[name]) for name in ("value", "error"))
            until, h = float(fields["until"]), float(fields["h"])
            if not np.isfinite([until, h, *sought.values(), *p.values(), *x0.values()]).all():
                raise ValueError("a number that is not finite")
            about, fingerprint, seed = str(fields["about"]), str(fields["fingerprint"]), int(fields["seed"])
            return CounterExample(about, fingerprint, sought, p, x0, until, h, seed, value, change)
        except (ValueError, TypeError, KeyError, AttributeError, RecursionError, OverflowError) as error:
            got = describe(str(error))
            raise ValueError(f"`{call}` must hold a counter-example as `write` stores it; got {got}.") from None

    @check_arguments
    def rows(self, ode: Ode) -> tuple[Array, Array]:
        """The parameters (1, np) and the initial state (1, nx), as rows of the equation that it was found for."""
        if ode.fingerprint != self.fingerprint:
            must = f"must be given the equation it was found for, of fingerprint {self.fingerprint[:12]}..."
            raise ValueError(f"`CounterExample.rows(ode)` {must}; got '{ode.name}' of {ode.fingerprint[:12]}...")
        return _row(ode.parameters, self.p), _row(ode.states, self.x0)

    @check_arguments
    def compare(self, again: StepPair) -> CounterExampleReplay:
        """The same run, computed again, beside the stored one."""
        both = np.array([again.value, self.value])
        if np.isfinite(both).all():
            same = abs(again.value - self.value) <= self.error + again.error + ROUNDING * abs(self.value)
        else:
            same = not np.isfinite(both).any()
        return CounterExampleReplay(again.value, again.error, bool(same), again.excess <= 0, again.diverged_at)


@check_arguments
def run(
    ode: Ode, metric: AbstractMetric, hypotheses: Sequence[Largest], p: Array, x0: Array, until: float, h: float
) -> StepPair:
    """One run at its step and at half of it, with the violations `hypotheses` of its hypotheses.

    Infinite is the metric of a run that diverges at both at the same time, within the stability limit of the step; of
    any other that diverges, the step itself may be what diverges, and it is not a number.
    """
    found = measure(ode, (metric, *hypotheses), p, x0, until=until, h=h)
    scores, runs = found.scores_of(metric.name), found.trajectories
    last = np.flatnonzero(np.isfinite(runs.x[0]).all(axis=1))[-1]
    state = runs.step.states.unpack(runs.x[0, last])
    reached = [
        float(state[f"{hypothesis.name}.largest"].max()) for hypothesis in hypotheses
    ]  # also of a run that is lost
    bounds = [
        float((one.value + one.error)[0]) for hypothesis in hypotheses for one in found.scores_of(hypothesis.name)
    ]
    excess = float(np.fmax.reduce([-np.inf, *reached, *bounds]))
    times = float(found.half_diverged_at[0]), float(found.diverged_at[0])
    doubt = _doubt(found.limit, times, h)
    if np.isfinite(times).any():
        return StepPair(np.nan, np.nan, excess, times, doubt) if doubt else StepPair(np.inf, 0.0, excess, times, "")
    value, error = max((score.pair for score in scores), key=lambda pair: pair[0])
    if not doubt and error > CREDIBLE * abs(value):
        doubt = f"{TOO_LONG}: at {h:.3g} s the value {value:.4g} has an error of {error:.2g}"
    return StepPair(value, error, excess, times, doubt)


def _doubt(limit: StepLimit, times: tuple[float, float], h: float) -> str:
    """The doubt in a step at which a mode that decays grows, or the run diverges at another time than at its half."""
    if not limit.holds:
        return f"{TOO_LONG}: of {limit.h:.3g} s, with a limit of stability of {limit.limit:.3g} s at {limit.at:.4g} s"
    fine, coarse = times
    if np.isfinite(fine) != np.isfinite(coarse):
        return f"{TOO_LONG}: the run diverges at one of {h:.3g} s and its half alone"
    if np.isfinite(fine) and abs(fine - coarse) > CREDIBLE * min(times) + STEPS * h:
        return f"{TOO_LONG}: at {h:.3g} s the run diverges at {coarse:.4g} s, and at half of it at {fine:.4g} s"
    return ""


@check_arguments
def hypotheses_kept(
    ode: Ode, claims: Sequence[BlockClaim], until: float, h: float, p: Array | None = None, x0: Array | None = None
) -> tuple[str, ...]:
    """The names of those claims that a run keeps at every step, at the step h and at half of it."""
    violations = [violation(each.claim) for each in claims]
    found = measure(with_violations(ode, claims), violations, p, x0, until=until, h=h)
    largest = [max(float((s.value + s.error).max()) for s in found.scores_of(each.name)) for each in violations]
    return tuple(each.claim.name for each, most in zip(claims, largest, strict=True) if most <= 0)


@check_arguments
def in_reference_mode(
    ode: Ode, signal: str, p: Array, x0: Array, times: Sequence[float], rtol: float = 1e-9
) -> tuple[Array, Array]:
    """An output (N, k) at N times by `reference_run`, and its error (N, k) from the error of the states."""
    found = reference_run(ode, p, x0, times=times, rtol=rtol)
    y = ode.outputs.view(ode.output)[known_name(signal, ode.outputs.names, f"outputs of '{ode.name}'")]
    slope = ca.Function("slope", [ode.t, ode.x, ode.p], [ca.vec(y), ca.densify(ca.jacobian(y, ode.x))])
    values = [slope(t, x, p) for t, x in zip(found.t, found.x, strict=True)]
    return (
        np.stack([np.array(y).ravel() for y, _ in values]),
        np.stack([np.abs(np.array(J)) @ error for (_, J), error in zip(values, found.error, strict=True)]),
    )


def _row(layout: Layout, values: Mapping[str, float]) -> Array:
    for label in layout.labels:
        if label not in values:
            raise LookupError(f"A counter-example must give '{label}' a number.{nearest(label, values)}")
    return layout.pack(values)
