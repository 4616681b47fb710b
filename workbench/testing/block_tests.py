"""The tests that plants, observers and laws share: declared numbers, purity, units, parameters and bits."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import fields

import numpy as np

from workbench.core import Ode, SampledSystem, lift
from workbench.testing.batch_bits import demand_same_bits
from workbench.testing.block_equations import PARAMETERS, Member, equations_of_block, same_equations, with_period_of
from workbench.testing.failure_sentences import fail, name_of_block, no_refusal
from workbench.testing.number_fields import demand_declared_numbers, demand_refusals, scaled_twin
from workbench.testing.unit_scaling import find_misfit

PURE = "let its methods use their arguments and the fields of the block alone"
METHODS = {"drives": "command", "gives": "estimate", "outputs": "measure"}  # that give the signals of a port
POINTS = 5
ROUNDING = 1e-9  # relative: two orders of the same operations


class AbstractBlockTests(ABC):
    """Tests of a block by itself, by its equations as expressions.

    Attributes
    ----------
    h
        The step in s of the runs in continuous time.
    """

    h: float = 1e-3

    @abstractmethod
    def _block(self) -> Member:
        """The block that is tested."""

    @abstractmethod
    def _equation(self) -> Ode | SampledSystem:
        """The equations of a loop with the block."""

    def test_each_number_is_declared_with_its_unit(self) -> None:
        """A bare number among the fields cannot be varied, and is printed without a unit."""
        demand_declared_numbers(self._block())

    def test_each_number_refuses_a_bad_value_by_its_name(self) -> None:
        """Text, NaN, infinity, too many numbers, and one beyond a bound are refused in one sentence with the name."""
        demand_refusals(self._block())

    def test_the_same_arguments_give_the_same_equations(self) -> None:
        """No method keeps a state, draws a random number or changes the block."""
        block = self._block()
        call, before = name_of_block(block), _fields_of(block)
        with no_refusal(call, "answer with the signals that its ports declare", "return each of them, in its shape"):
            first, second = (equations_of_block(block).fingerprint for _ in range(2))
        if first != second:
            fail(call, "give the same equations each time", "the second time it gave others", PURE)
        if _fields_of(block) != before:
            fail(call, "stay as it is", "a field has another value after its methods were called", PURE)
        other = self._block()
        if other is not block and equations_of_block(other).fingerprint != first:
            fail(call, "give the same equations each time", "a second one, made alike, gave others", PURE)

    def test_each_equation_has_the_units_of_its_ports(self) -> None:
        """Where there are more of a unit in each number that has it, each value grows as its unit says."""
        block = self._block()
        with no_refusal(name_of_block(block), "answer with the signals that its ports declare", "return each of them"):
            equations = same_equations(block)
        found, reason = find_misfit(equations, np.random.default_rng(2)), block.mixed_units
        if reason and not found:
            came, remedy = f"it declares '{reason}'", "take `mixed_units` out"
            fail(name_of_block(block), "have an equation that mixes units", came, remedy)
        if found and not reason:
            port, _, signal = found.value.partition(".")
            fail(
                f"{name_of_block(block)}.{METHODS.get(port, port)}(...)",
                f"give '{signal}' in [{found.unit or '1'}]",
                f"with {found.factor:.3g} times as many '{found.base}' everywhere it is {found.grew:.4g} times as "
                f"large and not {found.must_grow:.4g} times",
                "declare each number that has a unit as a `wb.parameter`, or say the reason in `mixed_units`",
            )

    def test_each_number_can_be_varied(self) -> None:
        """The equations with a number as a symbol are those of a block that is made with this number."""
        block = self._block()
        lifted = lift(block).layout
        twin, moved = scaled_twin(block, lifted.unpack(lifted.default))
        keep_nothing = "compute with the fields in the methods, and keep nothing that `__post_init__` has made of them"
        with no_refusal(name_of_block(block), "have equations with its numbers as symbols", keep_nothing):
            symbols, made = same_equations(block), equations_of_block(with_period_of(block, twin))
        usual = symbols.arguments.pack({f"{PARAMETERS}{path}": value for path, value in moved.items()})[0]
        rng = np.random.default_rng(3)
        for _ in range(POINTS):
            point = made.random_arguments(rng)
            numbers = np.concatenate([point[: point.size - lifted.size], usual[point.size - lifted.size :]])
            one, other = symbols.at(numbers), made.at(point)
            if not np.allclose(one, other, rtol=ROUNDING, atol=ROUNDING * np.abs(other).max(initial=0), equal_nan=True):
                i = int(np.argmax(np.abs(one - other)))
                fail(
                    f"{name_of_block(block)}.{symbols.results.labels[i]}",
                    "follow each number of the block when it is varied",
                    f"with the numbers as parameters it is {one[i]:.6g}, and of a block made with them {other[i]:.6g}",
                    keep_nothing,
                )

    def test_runs_have_the_same_bits_alone_and_in_any_batch(self) -> None:
        """Alone, in another order, in each arithmetic and each engine."""
        block = self._block()
        demand_same_bits(name_of_block(block), self._equation(), self.h, block.exportable)


def _fields_of(block: Member) -> str:
    """The fields of a block as text, numbers to the last bit."""
    with np.printoptions(floatmode="unique", threshold=10**6):
        return repr([(f.name, getattr(block, f.name)) for f in fields(block)])
