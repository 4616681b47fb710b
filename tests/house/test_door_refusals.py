"""Every door refuses what does not fit: the call, the argument, the rule and what came, in one line."""

import pytest

from tests.support.doors import doors

DOORS = doors()
LONGEST = 600  # characters: one that is longer is not read in a terminal
ARGUMENTS = 2_500  # there are more; with fewer the walk through the rooms has lost some


class Mute:
    """Raises whatever it is asked."""

    def _refuse(self, *args, **kwargs):
        raise RuntimeError("no")

    __repr__ = __str__ = __len__ = __iter__ = __array__ = __getitem__ = __float__ = __index__ = __eq__ = _refuse
    __hash__ = None


class Loud:
    """Prints as a terminal's escape sequence, in many lines."""

    def __repr__(self):
        return "\x1b[2J\n" * 1_000


ODD = (Mute(), Loud(), (value for value in ()), "\x1b[2J", 1j)


def refusal(argument, value):
    """The sentence with which a door refuses a value; None if its type hint takes it."""
    try:
        argument.ask(value)
    except ValueError as error:
        return str(error)
    return None


@pytest.mark.parametrize("room", DOORS)
def test_each_argument_of_a_door_that_does_not_fit_is_refused_in_one_sentence_with_its_name(room):
    for argument in DOORS[room]:
        for value in ODD:
            said = refusal(argument, value)
            if said is None:
                continue
            assert said.startswith(f"`{argument}` must be "), said
            assert "; got " in said
            assert said.endswith(".")
            assert said.isprintable()
            assert len(said) < LONGEST


def test_few_arguments_take_any_object_and_judge_it_themselves():
    """Matrices and systems of other libraries, say; the fuzz gives them odd values, too."""
    arguments = [argument for held in DOORS.values() for argument in held]
    judged_within = [argument for argument in arguments if refusal(argument, Mute()) is None]
    assert len(arguments) > ARGUMENTS
    assert len(judged_within) < 0.085 * len(arguments)  # some forty doors of designs take a system of python-control
