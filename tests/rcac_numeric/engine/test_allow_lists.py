"""What nobody has registered is refused by name, and never run as something it is derived from."""

from copy import copy
from dataclasses import dataclass

import pytest

import rcac_numeric as rn
from compensator_theory import InputError
from rcac_numeric.arrays._values import replaced as replace
from rcac_numeric.compiled._updates import ARGUMENTS
from rcac_numeric.controllers._recursive import RecursiveLeastSquares
from rcac_numeric.controllers._update import Update
from rcac_numeric.engine._ball_updates import BALL_UPDATES
from tests.support.ellipsoids import ellipsoid
from tests.support.function_plants import as_functions
from tests.support.lane_cases import GOOD, PLANT
from tests.support.signals import white

W = white(8)
LOOPS = {
    "simulate": lambda plant, settings: rn.simulate(plant, settings, W),
    "simulate_reference": lambda plant, settings: rn.simulate_reference(plant, settings, W),
    "lanes": lambda plant, settings: rn.simulate_many(
        [rn.SimulationCase(plant, settings, W)] * 8, lanes=True
    ),
}
DOORS = {name: lambda settings, loop=loop: loop(PLANT, settings) for name, loop in LOOPS.items()}
DOORS["Controller"] = rn.Controller
doors = pytest.mark.parametrize("door", DOORS)


@dataclass(frozen=True, eq=False, repr=False)
class NewUpdate(Update):
    """An update of somebody's own."""

    size: float = 1.0


class NewRecursion(RecursiveLeastSquares):
    """The recursion with something that the engine has not heard of."""

    name = "ud"


class LeakyUD(rn.UD):
    """UD that would leak, if anybody looked."""


class LeakyCovariance(rn.Covariance):
    """The same with another covariance."""


class LongWindow(rn.SlidingWindow):
    """A window that would be longer."""


class LeakyInstantaneous(rn.Instantaneous):
    """One that would forget."""


class NormalisedGradient(rn.Gradient):
    """A gradient that would be normalised."""


class JumpyForgetting(rn.ScheduledForgetting):
    """A schedule that would jump."""


class DirectionalForgetting(rn.VariableRateForgetting):
    """A rule that would forget in some directions only."""


class NewForgetting:
    """A rule that no update knows."""

    lambda_ = 0.9

    def __repr__(self):
        return "NewForgetting()"


class RandomReset(rn.CovarianceReset):
    """Resets that would come by chance."""


@doors
@pytest.mark.parametrize(
    "update",
    [
        NewUpdate(),
        NewRecursion(1.0),
        LeakyUD(1.0),
        LeakyCovariance(1.0),
        LongWindow(1.0, window=3),
        LeakyInstantaneous(1.0),
        NormalisedGradient(0.1),
    ],
    ids=lambda update: type(update).__name__,
)
def test_an_update_that_nobody_registered(door, update):
    settings = replace(GOOD, update=update)
    with pytest.raises(InputError, match=type(update).__name__):
        DOORS[door](settings)


def past_the_door(**setting):
    """UD with a setting that its own reader would have refused."""
    update = rn.UD(1.0)
    for name, value in setting.items():
        object.__setattr__(update, name, value)
    return update


@doors
@pytest.mark.parametrize(
    ("name", "update"),
    [
        ("JumpyForgetting", rn.UD(1.0, lambda_=JumpyForgetting({3: 0.9}))),
        ("DirectionalForgetting", rn.UD(1.0, lambda_=DirectionalForgetting(1, 2, 1.0))),
        ("NewForgetting", past_the_door(lambda_=NewForgetting())),
        ("RandomReset", rn.Covariance(1.0, reset=RandomReset(every=3))),
    ],
)
def test_a_rule_that_nobody_registered(door, name, update):
    settings = replace(GOOD, update=update)
    with pytest.raises(InputError, match=name):
        DOORS[door](settings)


def test_a_rule_that_no_update_knows_is_refused_where_it_is_given():
    with pytest.raises(InputError, match=r"lambda_ .*NewForgetting"):
        rn.UD(1.0, lambda_=NewForgetting())


@doors
def test_what_is_registered_runs(door):
    """Else the refusals above would show nothing."""
    for update in (
        rn.UD(1.0),
        rn.Covariance(1.0, lambda_=rn.ScheduledForgetting({3: 0.9})),
        rn.Gradient(0.1),
    ):
        DOORS[door](replace(GOOD, update=update))


@doors
def test_a_registered_update_is_run(door, monkeypatch):
    """Registration is one line in each table, and the lanes need none."""
    monkeypatch.setitem(ARGUMENTS, LeakyUD, ARGUMENTS[rn.UD])
    monkeypatch.setitem(BALL_UPDATES, LeakyUD, BALL_UPDATES[rn.UD])
    DOORS[door](replace(GOOD, update=LeakyUD(1.0)))


def derived(value):
    """The same value as one of a class `Stranger` that is derived from its own."""
    built = copy(value)
    object.__setattr__(built, "__class__", type("Stranger", (type(value),), {}))
    return built


def with_parts(**parts):
    """A structure with other parts."""
    s = GOOD.structure
    return rn.Structure(
        **{"taps": s.taps, "l_u": s.l_u, "l_y": s.l_y, "derived": s.derived} | parts
    )


STRANGERS = {
    "settings": derived(GOOD),
    "structure": replace(GOOD, structure=derived(GOOD.structure)),
    "tap": replace(
        GOOD, structure=with_parts(taps=(derived(GOOD.structure.taps[0]), *GOOD.structure.taps[1:]))
    ),
    "target": replace(GOOD, target=derived(GOOD.target)),
    "later target": replace(GOOD, target_changes={4: derived(GOOD.target)}),
    "R_z": replace(GOOD, R_z=derived(rn.SignalWeight(0.1, 1.0))),
    "R_u": replace(GOOD, R_u=derived(rn.SignalWeight(0.1))),
    "z_normalization": replace(GOOD, z_normalization=derived(rn.Normalization(1.0))),
    "bounds": replace(GOOD, bounds=derived(rn.CoefficientBounds(-1.0, method="clip"))),
    "ellipsoid": replace(GOOD, bounds=derived(ellipsoid(0, GOOD.l_theta, center=GOOD.theta_0))),
    "fixed": replace(GOOD, fixed=derived(rn.Compensator([[[0.5]]], [[[0.0]], [[0.1]]]))),
}


@doors
@pytest.mark.parametrize("settings", STRANGERS.values(), ids=STRANGERS)
def test_settings_or_parts_of_them_that_somebody_derived(door, settings):
    with pytest.raises(InputError, match="Stranger"):
        DOORS[door](settings)


SCHEDULE = rn.PlantSchedule(
    [rn.PlantChange(start=0, plant=PLANT), rn.PlantChange(start=4, plant=PLANT)]
)
PLANTS = {
    "plant": derived(PLANT),
    "schedule": derived(SCHEDULE),
    "plant of a schedule": rn.PlantSchedule([rn.PlantChange(start=0, plant=derived(PLANT))]),
    "change": rn.PlantSchedule([derived(rn.PlantChange(start=0, plant=PLANT))]),
    "functions": derived(as_functions(PLANT)),
}


@pytest.mark.parametrize("loop", LOOPS)
@pytest.mark.parametrize("plant", PLANTS.values(), ids=PLANTS)
def test_a_plant_that_somebody_derived(loop, plant):
    with pytest.raises(InputError, match=r"Stranger|needs a linear plant"):
        LOOPS[loop](plant, GOOD)


def test_a_fixed_controller_that_somebody_derived():
    fixed = rn.FixedController(rn.simulate(PLANT, GOOD, W).compensator)
    for settings in (derived(fixed), replace(fixed, compensator=derived(fixed.compensator))):
        with pytest.raises(InputError, match="Stranger"):
            rn.simulate(PLANT, settings, W)
    assert rn.simulate(PLANT, fixed, W).outcome == "completed"
