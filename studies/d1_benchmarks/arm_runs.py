"""The runs of the paper's six laws and of linear laws with their crossovers, in the scenarios of report a8."""

from __future__ import annotations

from collections.abc import Mapping

import workbench as wb
from studies.d1_benchmarks.arm_designs import DESIGNS, TUNED, law_loop, matching_design
from studies.paper.costs import cost_of, judge_laws, judge_means, weighted_cost
from studies.paper.scenarios import HELD_OUT, HORIZON, Scenario, metrics, uncertain

DRAWS, SEED = 160, 35
KEYS = {law: law.lower().replace("-", "_") for law in TUNED}
DESIGN_KEYS = {design: design.split()[-1].lower() for design in DESIGNS}


def sweep_name(scenario: Scenario, law: str, design: str = "") -> str:
    """The name of the sweep of a law in a scenario, or of a linear design with its crossovers."""
    return f"{scenario.name}_{KEYS[law]}" + (f"_{DESIGN_KEYS[design]}" if design else "")


def sweeps(_: Mapping[str, wb.tuning.TuningResult] | None = None) -> tuple[wb.Sweep, ...]:
    """Each law, and each linear design with its crossovers, over the same draws in each scenario."""
    made = []
    for scenario in HELD_OUT:
        loops = {sweep_name(scenario, law): law_loop(law, scenario) for law in TUNED}
        loops |= {
            sweep_name(scenario, law, design): matching_design(design, law).loop(scenario)
            for law in TUNED
            for design in DESIGNS
        }
        made += [_sweep(name, loop, scenario) for name, loop in loops.items()]
    return tuple(made)


def _sweep(name: str, loop: wb.DigitalLoop, scenario: Scenario) -> wb.Sweep:
    factors = uncertain(scenario, loop)
    design = wb.uncertainty.MonteCarlo(len(factors), DRAWS, SEED)
    return wb.Sweep(name, wb.Run(loop, metrics(scenario), HORIZON, h=scenario.period, seed=SEED), factors, design)


def standings(results: wb.Results, law: str) -> wb.evidence.Standings:
    """A law and both linear designs with its crossovers, judged by their costs in each scenario."""
    return wb.evidence.Standings({name: judge_laws(cost_of(held)) for name, held in _samples(results, law).items()})


def weighted_standings(results: wb.Results, law: str, weights: tuple[float, ...]) -> wb.evidence.Standings:
    """The same, judged by the mean of the cost with other weights of its terms."""
    return wb.evidence.Standings(
        {name: judge_means(weighted_cost(held, weights)) for name, held in _samples(results, law).items()}
    )


def _samples(results: wb.Results, law: str) -> dict[str, dict[str, wb.study.Sample]]:
    """The runs of a law and of both linear designs, by scenario and name."""
    return {
        scenario.name: {law: results.sample(sweep_name(scenario, law))}
        | {design: results.sample(sweep_name(scenario, law, design)) for design in DESIGNS}
        for scenario in HELD_OUT
    }
