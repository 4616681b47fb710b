"""The one list of what the paper leaves open, against the card, against a1 and against a6."""

import pytest

from studies.a6_unstated_choices import draws, loops
from studies.paper.card import CARD, LAWS
from studies.paper.readings import Choice
from studies.paper.unstated_choices import CHOICES, choices_of, omitted_choices, varied_choices


def test_each_number_that_the_card_assumes_for_a_law_of_the_paper_is_in_the_list_once():
    names = [choice.name for choice in CHOICES]
    assert len(set(names)) == len(names)
    for given in CARD:
        if given.mark == "assumed" and not given.name.startswith("super-twisting: "):
            shown = given.label if isinstance(given.label, str) and given.label else given.name
            assert shown.removesuffix(" as printed") in names
        elif given.mark != "assumed":
            assert given.name not in names


def test_each_factor_of_a6_varies_exactly_one_choice_of_the_list():
    for factor in draws.NAMES:
        owners = [choice for choice in varied_choices([factor]) if choice.law in (*LAWS, "rivals", "")]
        shared = {choice.name.partition(": ")[2] for choice in owners}
        # ASMC, Fuzzy-ASMC and RBF-ASMC share their first gain and its rate
        assert len(owners) == 1 or shared in ({"K(0)"}, {"gamma"}), factor


def test_the_readings_that_a6_draws_are_the_options_of_the_list():
    options = {choice.factors[0]: choice.readings for choice in CHOICES if choice.readings}
    readings = [
        factor for law in LAWS for factor in loops.FACTORS[law] if isinstance(factor.distribution, loops.Reading)
    ]
    assert readings
    for factor in readings:
        assert set(factor.distribution.names) == set(options[factor.name]), factor.name


def test_a_choice_is_varied_or_left_out_and_never_both():
    inside, outside = varied_choices(draws.NAMES), omitted_choices(draws.NAMES)
    assert set(inside) | set(outside) == set(CHOICES)
    assert not set(inside) & set(outside)
    assert {"torque limit", "sat of (29)"} <= {choice.name for choice in outside}


@pytest.mark.parametrize("law", LAWS)
def test_the_choices_of_a_law_are_its_own_and_those_of_the_experiment(law):
    ours: tuple[Choice, ...] = choices_of(law, "FS")
    assert {choice.law for choice in ours} <= {law, "", "rivals"}
    assert not any(choice.scenario == "SS" for choice in ours)
    assert any(choice.name == "FS: horizon" for choice in ours)
