"""Sample times compare with one tolerance, and two that differ are refused at every door."""

import inspect

import control
import numpy as np
import pytest

import rcac_numeric as rcac
from compensator_theory import InputError
from rcac_numeric import ClosedLoop, Compensator, FixedController, Plant, PlantChange, PlantSchedule
from rcac_numeric.arrays._values import replaced
from tests.support.public import public_objects

# 0.3 s as it comes: a product, a difference of times, a mean, a decimal of nine digits.
TIMES = np.arange(10) * 0.3
SAME = [0.1 * 3, TIMES[4] - TIMES[3], np.diff(TIMES).mean(), 3 / 10, 0.3000000001]
OTHERS = [0.7, 0.300001, 0.2999999, 3.0]
FOREIGN = control.tf([0.5], [1, -0.5], 0.3)
PLANT = Plant(A=[[0.5]], B=[[1.0]], C=[[1.0]], D_1=[[1.0]], sample_time=0.3)
UNTIMED = Plant(A=[[0.5]], B=[[1.0]], C=[[1.0]], D_1=[[1.0]])
SCHEDULE = PlantSchedule([PlantChange(start=0, plant=PLANT)])
GAIN = Compensator([[[0.0]]], [[[0.0]], [[-0.1]]], sample_time=0.3)
W = np.ones((20, 1))
RUN = rcac.simulate(PLANT, FixedController(GAIN), W)


def checked(plant, sample_time, G_c=GAIN):
    return rcac.check_controller(
        RUN.u, RUN.y, compensator=G_c, plant=plant, sample_time=sample_time
    )


def designed(plant, sample_time):
    return rcac.design(plant, sample_time=sample_time, seeds=1, steps=100)


def exported(controller, sample_time, path):
    try:
        rcac.export_fmu(controller, path / "made.fmu", sample_time=sample_time)
    except InputError as error:  # without a C compiler, but the times were compared
        assert "compiler" in str(error) or "sampled every" in str(error), error
        if "sampled every" in str(error):
            raise


LOOPS = {"closed loop": ClosedLoop(PLANT, GAIN), "plant's": ClosedLoop(UNTIMED, GAIN), "run": RUN,
         "pair": (PLANT, GAIN), "foreign": FOREIGN}  # fmt: skip
DOORS = {
    "plant_of": {name: lambda h, path, one=one: rcac.plant_of(one, sample_time=h)
                 for name, one in {"foreign": FOREIGN, "own": PLANT, "schedule": SCHEDULE}.items()},
    "stability_margins": {
        name: lambda h, path, one=one: rcac.stability_margins(
            one, sample_time=h, feedback=-1 if one is FOREIGN else None, disk=False)
        for name, one in LOOPS.items()
    },
    "check_controller": {
        "plant": lambda h, path: checked(PLANT, h),
        "compensator": lambda h, path: checked(UNTIMED, h),
        "run": lambda h, path: rcac.check_controller(RUN, sample_time=h),
    },
    "design": {"foreign": lambda h, path: designed(FOREIGN, h),
               "own": lambda h, path: designed(PLANT, h),
               "rows": lambda h, path: designed([[FOREIGN]], h)},
    "export_fmu": {"compensator": lambda h, path: exported(GAIN, h, path),
                   "fixed": lambda h, path: exported(FixedController(GAIN), h, path),
                   "run": lambda h, path: exported(RUN, h, path)},
    "Compensator": {
        "loop": lambda h, path: ClosedLoop(PLANT, Compensator(GAIN.past_u, GAIN.past_y, h)),
        "simulate": lambda h, path: rcac.simulate(
            PLANT, FixedController(Compensator(GAIN.past_u, GAIN.past_y, h)), W),
        "h2_cost": lambda h, path: rcac.h2_cost(PLANT, Compensator(GAIN.past_u, GAIN.past_y, h)),
    },
    "ControllerLog": {
        "check_controller": lambda h, path: rcac.check_controller(
            rcac.ControllerLog(RUN.u, RUN.y, sample_time=h), compensator=GAIN, plant=PLANT),
    },
    "Compensator.to_control": {"itself": lambda h, path: GAIN.to_control(h)},
    "Plant": {
        "schedule": lambda h, path: PlantSchedule([
            PlantChange(start=0, plant=PLANT),
            PlantChange(start=5, plant=replaced(PLANT, sample_time=h)),
        ]),
    },
}  # fmt: skip
# Made by functions, or in seconds alone: with nothing to compare. A log's stamps beside
# `sample_time` are in signals/test_clock.py.
RESULTS = {
    "Margins", "Clock", "ProcessModel", "StepResponse", "identify_process",
    "identify_process_matrix", "ProcessMatrix",
    "identify_step_response", "read_log",
}  # fmt: skip
CASES = [(door, name) for door, cases in DOORS.items() for name in cases]


def test_every_public_name_that_takes_a_sample_time_is_a_door():
    result = set()
    for name, one in public_objects("rcac_numeric").items():
        members = inspect.getmembers(one, inspect.isfunction) if inspect.isclass(one) else []
        for label, each in [(name, one), *((f"{name}.{m}", f) for m, f in members if m[0] != "_")]:
            try:
                names = inspect.signature(each).parameters
            except (TypeError, ValueError):
                continue
            result |= {label} if {"sample_time", "dt"} & set(names) else set()
    assert result - RESULTS == set(DOORS)


@pytest.mark.parametrize(("door", "name"), CASES)
def test_another_sample_time_is_refused(door, name, tmp_path):
    for other in OTHERS:
        with pytest.raises(
            InputError, match=r"sampled every [\d.]+ s, not every [\d.]+ s;"
        ) as caught:
            DOORS[door][name](other, tmp_path)
        assert "0.3 s" in str(caught.value)
        one, two = (
            str(caught.value).split("sampled every ")[1].split(";")[0].split(" s, not every ")
        )
        assert one != two.removesuffix(" s"), caught.value


@pytest.mark.parametrize(
    ("door", "name"), [c for c in CASES if c[0] not in ("design", "export_fmu")]
)
@pytest.mark.parametrize("same", SAME)
def test_the_same_one_up_to_rounding_is_the_same(door, name, same, tmp_path):
    built = DOORS[door][name](same, tmp_path)
    period = getattr(built, "sample_time", None)
    assert period is None or period == pytest.approx(0.3, rel=1e-9)


def test_the_same_one_is_designed_and_exported(tmp_path):
    assert DOORS["design"]["foreign"](0.1 * 3, tmp_path).plant.sample_time == 0.3
    DOORS["export_fmu"]["compensator"](0.1 * 3, tmp_path)


def test_a_plant_without_a_sample_time_takes_the_one_that_is_named():
    assert rcac.plant_of(UNTIMED, sample_time=0.7).sample_time == 0.7
    assert rcac.stability_margins(FOREIGN, feedback=-1).sample_time == 0.3
    assert rcac.stability_margins(control.tf([0.5], [1, -0.5], 1), feedback=-1).sample_time == 1.0
