"""Numbers are replaced by path: in matrices, in parts of parts and in equations, and all others keep theirs."""

import numpy as np
import pytest

import workbench as wb
from workbench.core.number_replacement import replace_numbers
from workbench.core.symbolic_twin import lift


@wb.block
class Sheet:
    K: np.ndarray = wb.parameter(default=np.arange(6.0).reshape(2, 3), unit="", shape=("2", "3"))
    gain: float = wb.parameter(default=1.0, unit="", low=0)


@wb.block
class Pile:
    sheets: tuple[Sheet, ...]
    top: Sheet


def test_every_number_of_a_block_can_be_replaced_by_its_path():
    pile = Pile((Sheet(), Sheet(gain=3.0)), Sheet())
    layout = lift(pile).layout
    values = dict(zip(layout.labels, np.arange(10.0, 10.0 + layout.size).tolist(), strict=True))
    assert lift(replace_numbers(pile, values)).layout.default.tolist() == list(values.values())
    one = replace_numbers(pile, {"sheets[1].K[0,2]": 7.0})
    assert one.sheets[1].K.tolist() == [[0.0, 1.0, 7.0], [3.0, 4.0, 5.0]]
    assert (one.sheets[0].K.tolist(), one.sheets[1].gain) == (pile.sheets[0].K.tolist(), 3.0)
    assert pile.sheets[1].K[0, 2] == 2.0


def test_other_equations_keep_their_name_and_all_other_numbers():
    motor = wb.open_loop(wb.DCMotor())
    heavy = replace_numbers(motor, {"J": 0.5})
    changed = heavy.parameters.default != motor.parameters.default
    assert [label for label, is_other in zip(motor.parameters.labels, changed, strict=True) if is_other] == ["J"]
    assert heavy.name == motor.name


@pytest.mark.parametrize(
    ("target", "values", "words"),
    [
        (Sheet(), {"K": 1.0}, "There is no 'K'"),
        (Sheet(), {"gian": 1.0}, "Did you mean 'gain'"),
        (Sheet(), {"gain": -1.0}, "gain"),
        (Sheet(), {"gain": np.nan}, "finite"),
        (3.0, {}, "a block or an `Ode`"),
    ],
)
def test_a_path_or_a_number_that_does_not_fit_is_refused(target, values, words):
    with pytest.raises((LookupError, ValueError), match=words):
        replace_numbers(target, values)
