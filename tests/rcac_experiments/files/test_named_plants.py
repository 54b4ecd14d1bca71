"""Every plant of the gallery can be named in a file."""

import pytest

from compensator_theory import InputError
from rcac_experiments.files._plants import PROBLEMS, read_plant
from rcac_experiments.format._places import Location
from rcac_numeric.gallery import (
    BoostConverter,
    CartPendulum,
    MassSpringDamper,
    aircraft_plant,
    aircraft_transition,
    limited_delay_margin,
    no_guaranteed_margins_standard,
    rohrs_plant,
)

boost, pendulum = BoostConverter(supply=10), CartPendulum(length=0.5)
TABLES = {
    "aircraft": ({"condition": "off-nominal", "measured": "state"},
                 aircraft_plant("off-nominal", "state")),
    "aircraft transition": ({"start": 3, "duration": 1}, aircraft_transition(3, 1)),
    "boost converter": ({"h": 1e-5, "duty": 0.4, "supply": 10},
                        boost.linearised(boost.operating_point(0.4)).servo(1e-5)),
    "cart pendulum": ({"h": 0.02, "length": 0.5, "kind": "hanging"},
                      pendulum.linearised(pendulum.operating_point("hanging")).servo(0.02)),
    "limited delay margin": ({"loop": "standard"}, limited_delay_margin().sampled(0.1)),
    "mass-spring-damper": ({"h": 0.1, "mass": 2}, MassSpringDamper(2.0).continuous().servo(0.1)),
    "no guaranteed margins": ({}, no_guaranteed_margins_standard()),
    "rohrs": ({"h": 0.04, "loop": "standard"}, rohrs_plant().sampled(0.04)),
}  # fmt: skip


def plant(**table):
    return read_plant(table, Location("case", "plant")).build()


@pytest.mark.parametrize("name", sorted(set(PROBLEMS.kinds) - {"standard", "servo"}))
def test_a_named_plant_is_that_of_the_gallery(name):
    table, expected = TABLES[name]
    assert plant(problem=name, **table) == expected


def test_a_named_plant_may_change_its_gain_and_delay():
    schedule = plant(problem="rohrs", h=0.1, changes=[{"start": 5, "gain": 2, "delay": 3}])
    first, last = schedule.changes
    assert last.delay == 3 and (last.plant.B == 2 * first.plant.B).all()


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"problem": "aircarft"}, "Did you mean 'aircraft'"),
        ({"problem": "rohrs"}, "needs the key 'h'"),
        ({"problem": "rohrs", "h": -1}, "h = -1 must be positive"),
        ({"problem": "rohrs", "h": 0.1, "duty": 0.5}, "sets 'duty'"),
        ({"problem": "aircraft", "condition": "inverted"}, "condition"),
        ({"problem": "aircraft transition", "duration": 0}, "duration = 0"),
        (
            {"problem": "aircraft transition", "changes": [{"start": 4, "gain": 2}]},
            "this plant has its own changes",
        ),
    ],
)
def test_what_names_no_plant_is_refused(table, message):
    with pytest.raises(InputError, match=message):
        plant(**table)
