"""The tests of a plant: its derivatives, its start and its energy, beside the tests of any block."""

from __future__ import annotations

from abc import abstractmethod

import casadi as ca
import numpy as np

from workbench.blocks.loop import AbstractPlant, Instruments
from workbench.blocks.loop.contracts import is_recursion
from workbench.core import Ode, SampledSystem, Signals
from workbench.core.validation.refusals import Array
from workbench.design import linearize
from workbench.engine import simulate
from workbench.testing.block_equations import BlockEquations, same_equations
from workbench.testing.block_tests import POINTS, AbstractBlockTests
from workbench.testing.failure_sentences import fail, name_of_block, no_refusal, skip
from workbench.testing.live_checks import demand_live_page, demand_printed_page
from workbench.testing.shared_loops import driven_loop, ode_of_plant, sampled_of_loop

EXACT = 1e-5  # relative: differences of sixth digits against a derivative
NUDGE = 1e-4  # relative step of a difference, whose error falls with its fourth power
CONNECT = "correct its ports, states and methods"


class PlantTests(AbstractBlockTests):
    """Tests of a plant. Subclass it under a name that begins with `Test`, and return the plant.

    Attributes
    ----------
    period
        The period in s of a computer, unless the plant moves at its own.
    lossless
        True if `stored_energy` changes by the power of the inputs alone, and False if some of it may be lost.

    Examples
    --------
    >>> class TestMotor(wb.testing.PlantTests):
    ...     def plant(self):
    ...         return wb.DCMotor()
    >>> TestMotor().test_each_jacobian_is_exact()
    """

    period: float = 0.01
    lossless: bool = False

    @abstractmethod
    def plant(self) -> AbstractPlant:
        """The plant, made anew at each call."""

    def stored_energy(self, plant: AbstractPlant, x: Signals) -> ca.SX | None:
        """The stored energy at a state, or None if none is declared; its supply is the product of `plant.power`."""
        del plant, x
        return None

    def test_each_jacobian_is_exact(self) -> None:
        """The derivatives by all arguments are those of finite differences."""
        equations = same_equations(self._block())
        jacobian = ca.Function("J", [equations.symbols], [ca.densify(ca.jacobian(equations.values, equations.symbols))])
        rng = np.random.default_rng(4)
        for _ in range(POINTS):
            at = equations.random_arguments(rng)
            exact, seen = np.array(jacobian(at)), _differences(equations, at)
            size = np.maximum(np.abs(exact), np.abs(seen)) + 1e-6 * np.abs(seen).max(axis=1, initial=0, keepdims=True)
            wrong = np.abs(exact - seen) > EXACT * size + 1e-9
            if wrong.any():
                i, j = np.argwhere(wrong)[0]
                fail(
                    f"{name_of_block(equations.block)}.{equations.results.labels[i]}",
                    f"have the exact derivative by '{equations.arguments.labels[j]}'",
                    f"its derivative is {exact[i, j]:.6g}, and differences give {seen[i, j]:.6g}",
                    "write it with operations whose derivatives CasADi knows",
                )

    def test_its_linearisation_has_the_exact_matrices(self) -> None:
        """A, B, C and D of `wb.linearize` are the Jacobians of the block's own equations."""
        plant = self._block()
        if self._jumps(plant):
            skip("a plant in discrete time has no rate to linearise")
        equations, ode = same_equations(plant), self._equation()
        assert isinstance(ode, Ode)
        x, u = plant.states.default, plant.inputs.default
        with no_refusal(name_of_block(plant), "be linearised at its start", CONNECT):
            linear = linearize(ode, 0.0, x, u=u)
        at = np.array(equations.arguments.default)
        at[equations.arguments.slice("t")] = 0.0
        J = np.array(ca.Function("J", [equations.symbols], [ca.jacobian(equations.values, equations.symbols)])(at))
        rows, columns = _blocks(equations)
        for name, row, column in (("A", "rate", "states"), ("B", "rate", "inputs"), ("C", "outputs", "states")):
            found = getattr(linear, name)
            wanted = J[np.ix_(rows[row], columns[column])][: len(found)]
            if not np.allclose(found, wanted, rtol=1e-12, atol=1e-12 * np.abs(wanted).max(initial=0)):
                fail(name_of_block(plant), f"have the exact matrix {name}", "`wb.linearize` gives another", CONNECT)

    def test_it_starts_at_its_declared_state_with_finite_rates(self) -> None:
        """The first row of a run is the declared start, where each rate and output is a finite number."""
        plant, equations = self._block(), same_equations(self._block())
        values = equations.at(equations.arguments.default)
        if not np.isfinite(values).all():
            label = equations.results.labels[int(np.argmax(~np.isfinite(values)))]
            remedy = "declare a start at which its equations hold"
            fail(f"{name_of_block(plant)}.{label}", "be finite at the start", "it is not", remedy)
        start = self._equation().states.default[: plant.states.size]
        if (start != plant.states.default).any():
            fail(name_of_block(plant), "start at its declared state", f"its equations start at {start}", CONNECT)

    def test_its_energy_changes_by_the_power_that_it_is_given(self) -> None:
        """Where `stored_energy` is declared, it grows by no more than the power of the inputs."""
        plant = self._block()
        x, u = plant.states.symbols(), plant.inputs.symbols()
        parts, given = Signals(plant.states.view(x)), Signals(plant.inputs.view(u))
        energy = self.stored_energy(plant, parts)
        if energy is None:
            return
        rate = plant.states.flatten(plant.rate(ca.SX(0), parts, given))
        y = plant.measure(ca.SX(0), parts)
        supply = ca.SX(0)
        if len(plant.power) == 2:
            if plant.power[0] not in plant.inputs or plant.power[1] not in plant.outputs + plant.truths:
                remedy = "name one of its inputs and one of its outputs, whose product is a power"
                fail(name_of_block(plant), "have an input and an output in `power`", f"it is {plant.power}", remedy)
            supply = ca.dot(ca.vec(given[plant.power[0]]), ca.vec(y[plant.power[1]]))
        slope = ca.jacobian(energy, x)
        size = ca.fabs(slope) @ ca.fabs(rate) + ca.fabs(supply)
        parts_of_gain = ca.Function("gain", [x, u], [slope @ rate - supply, size])
        rng = np.random.default_rng(5)
        for _ in range(20 * POINTS):
            at = plant.states.default + rng.uniform(-1, 1, x.numel())
            pushed = rng.uniform(-1, 1, u.numel()) if plant.power else np.zeros(u.numel())
            made, scale = (float(part) for part in parts_of_gain(at, pushed))
            if made > 1e-9 * scale or (self.lossless and made < -1e-9 * scale):
                must = "keep its energy but for the power of its inputs" if self.lossless else "make no energy"
                remedy = "correct the equations, `power` or `stored_energy`"
                fail(name_of_block(plant), must, f"at x = {at} its energy changes by {made:.4g} W beside them", remedy)

    def test_it_moves_in_a_computer(self) -> None:
        """With noisy readings, limits of its inputs and a delay, in which its own inputs act first."""
        plant = self._block()
        first, usual = plant.inputs.names[0], plant.inputs.default
        noise = dict.fromkeys(plant.outputs.names[:1], 0.01)
        with no_refusal(name_of_block(plant), "move in a computer", CONNECT):
            gauges = Instruments.of(plant, noise=noise, limit={first: (-0.5, 0.5)})
            period = plant.period or self.period / 1000
            sampled = driven_loop(plant).digital(period, gauges, delay=True)
            run = simulate(sampled.step(1), until=10 * period, seed=1)
        acts = np.asarray(run[first][0]).reshape(11, -1)
        if (
            run.has_diverged.any()
            or (acts[0] != usual[plant.inputs.slice(first)]).any()
            or np.abs(acts[1:]).max() > 0.5
        ):
            came = f"'{first}' is {acts[0]} at first and then at most {np.abs(acts[1:]).max():.3g}"
            fail(name_of_block(plant), "move in a computer by its usual input, then by a limited one", came, CONNECT)

    def test_its_live_page_computes_the_same_numbers(self) -> None:
        """The page of the plant can be turned, and JavaScript gives the bits of the portable arithmetic."""
        demand = demand_live_page if self._block().exportable else demand_printed_page
        demand(name_of_block(self._block()), self._equation(), self.h)

    def _block(self) -> AbstractPlant:
        plant: object = self.plant()
        if not isinstance(plant, AbstractPlant):
            fail(f"{type(self).__name__}.plant()", "return a `wb.Plant`", f"it returned {plant!r}", "return the plant")
        return plant

    def _jumps(self, plant: AbstractPlant) -> bool:
        return bool(is_recursion(plant) or plant.noises or plant.sampled_states.size)

    def _equation(self) -> Ode | SampledSystem:
        plant = self._block()
        with no_refusal(name_of_block(plant), "be simulated", CONNECT):
            if not self._jumps(plant):
                return ode_of_plant(plant)
            return sampled_of_loop(driven_loop(plant), plant.period or self.period)


def _differences(equations: BlockEquations, at: Array) -> Array:
    """Central differences of fourth order of the values by each argument, (m, n)."""
    columns, scales = [], np.maximum(np.abs(at), np.where(equations.arguments.default == 0, 1e-2, 0.0))
    for j in range(at.size):
        step = np.zeros(at.size)
        step[j] = NUDGE * scales[j]
        ends = ((equations.at(at + k * step) - equations.at(at - k * step)) / (2 * k) for k in (1, 2))
        first, second = (end / step[j] for end in ends)
        columns.append((4 * first - second) / 3)
    return np.stack(columns, axis=1)


def _blocks(equations: BlockEquations) -> tuple[dict[str, list[int]], dict[str, list[int]]]:
    """The places of results and of arguments by the port that their names begin with."""
    places: list[dict[str, list[int]]] = []
    for layout in (equations.results, equations.arguments):
        found: dict[str, list[int]] = {"rate": [], "states": [], "inputs": [], "outputs": []}
        for entry in layout.entries:
            taken = layout.slice(entry.name)
            found.setdefault(entry.name.partition(".")[0], []).extend(range(taken.start, taken.stop))
        places.append(found)
    return places[0], places[1]
