"""Poles listed in a text with commas are those of the list, at every door that takes poles."""

import pytest

import compensator_theory as exact

A, B, C = [[0, 1], [0, 0]], [[0], [1]], [[1, 0]]
DOORS = {
    "place_poles": lambda poles: exact.place_poles("1/s**2", poles, feedback=-1),
    "least order": lambda poles: exact.place_poles("1/s**2", poles, "least", feedback=-1),
    "gain family": lambda poles: exact.state_feedback_family(A, B, poles).gain(),
    "regulator": lambda poles: exact.regulator_gain(A, B, poles),
    "observer": lambda poles: exact.observer_gain(A, C, poles),
    "Youla": lambda poles: exact.stabilising_compensators("1/s**2", poles, poles, feedback=-1),
}
COUNTS = {"place_poles": 3, "least order": 4}


@pytest.mark.parametrize("door", DOORS)
def test_a_text_is_as_good_as_the_list(door):
    poles = ["-1 + 2j", "-1 - 2j", "-3", "-1/2"][: COUNTS.get(door, 2)]
    expected = DOORS[door](poles)
    for text in (", ".join(poles), ";".join(poles)):
        assert DOORS[door](text) == expected


@pytest.mark.parametrize("door", DOORS)
@pytest.mark.parametrize("text", ["-1, -2,", ",", "-1, , -2", "-1, x y, -3", "-1, nan, -2"])
def test_what_is_no_list(door, text):
    with pytest.raises(exact.InputError, match=r"entry|cannot read|finite"):
        DOORS[door](text)
