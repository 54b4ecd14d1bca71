"""Whatever is out of range or does not fit is named, by one of this project's own errors."""

from fractions import Fraction

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given
from hypothesis import strategies as st

import rcac_numeric as rn
from compensator_theory import InputError
from compensator_theory.errors import ImproperError
from rcac_numeric.arrays._definite_matrices import constant_weight, inverse

GOOD = {"structure": rn.iir(1), "target": rn.TargetModel([0, 1.0]), "update": rn.UD(R_theta=1.0)}
SETTINGS = rn.ControllerSettings(**GOOD)
PLANT = rn.standard_plant("1/(q - 0.5)")
TWO = rn.Plant(A=np.eye(2) / 2, B=np.ones((2, 1)), D_1=np.ones((2, 1)), C=np.ones((1, 2)))
BOTH = rn.Decentralized([SETTINGS] * 2)
ONES = np.ones((5, 1))
RATE = rn.VariableRateForgetting(1, 2, 1.0)
NAN = float("nan")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"freeze": 5}, "freeze = 5 must be a list"),
        ({"freeze": (5, 6)}, "freeze has the entry 5; pairs"),
        ({"freeze": [(3, 3)]}, r"empty interval \(3, 3\)"),
        ({"freeze": [(-1, 2)]}, "start of freeze = -1"),
        ({"freeze": [(1, 2.5)]}, "stop of freeze must be an integer, not 2.5"),
        ({"target_changes": {3: 5}}, "target = 5: use fir_target"),
        ({"target_changes": {3: rn.TargetModel(np.ones((2, 2, 1)))}}, "have 1 and 2 rows"),
        ({"target_changes": {3: rn.TargetModel([0, 0, 1.0])}, "k_w": 1}, "k_w = 1 is shorter than"),
        ({"R_z": None}, "R_z must be an array of real numbers, not None"),
        ({"R_z": rn.SignalWeight(1.0)}, "not positive definite at z = 0"),
        ({"update": rn.UD(R_theta=np.eye(3))}, r"R_theta has shape \(3, 3\)"),
        ({"update": rn.SlidingWindow(np.eye(3), window=2)}, r"R_theta has shape \(3, 3\)"),
        ({"update": rn.Instantaneous(np.eye(3))}, r"R_theta has shape \(3, 3\)"),
        ({"update": rn.UD(1.0, process_noise=np.eye(3))}, r"process_noise has shape \(3, 3\)"),
        ({"update": rn.UD}, r"update = <class .*UD'>: use UD\(R_theta=...\)"),
        ({"update": "ud"}, r"update = 'ud': use UD\(R_theta=...\)"),
        ({"form": "smoother"}, "form = 'smoother' is not known; choose one of predictor, filter"),
        ({"form": "filter", "target": rn.TargetModel([1.0])}, "must be strictly proper"),
        (
            {"form": "filter", "target_changes": {3: rn.TargetModel([1.0])}},
            "must be strictly proper",
        ),
        (
            {"reflect_poles": True, "structure": rn.fir(1), "theta_0": [0]},
            r"has the lags \[\] of u",
        ),
        (
            {"reflect_poles": True, "structure": rn.Structure([rn.Tap("u", 0, 2)])},
            r"the lags \[2\] of u",
        ),
        ({"reflect_poles": "no"}, "reflect_poles = 'no' is not a bool"),
        ({"k_filter": -1}, "k_filter = -1 must be at least 0"),
        ({"structure": 5}, r"structure = 5: use iir\(...\)"),
    ],
)
def test_a_setting_that_does_not_fit(change, message):
    with pytest.raises((InputError, ImproperError), match=message):
        rn.ControllerSettings(**{**GOOD, **change})


@pytest.mark.parametrize("kind", [rn.UD, rn.Covariance])
@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"R_theta": rn.SignalWeight(1.0)}, "R_theta must be an array"),
        ({"R_theta": np.ones(3)}, r"R_theta has shape \(3,\)"),
        ({"reset": 5}, "reset = 5 is not a CovarianceReset"),
        ({"lambda_": "0.9"}, "lambda_ must be a real number"),
        ({"lambda_": None}, "lambda_ must be a real number"),
        ({"lambda_": {3: 0.9}}, "lambda_ must be a real number"),
        ({"process_noise": -1.0}, "process_noise has the eigenvalue -1"),
        ({"process_noise": 1.0, "lambda_": 0.9}, r"process_noise belongs to \(2.46\)"),
        (
            {"process_noise": 1.0, "lambda_": rn.ScheduledForgetting({3: 0.9})},
            "process_noise belongs",
        ),
        ({"process_noise": 1.0, "lambda_": RATE}, "process_noise belongs"),
        ({"stop_where_unsupported": 1}, "stop_where_unsupported = 1 is not a bool"),
    ],
)
def test_a_setting_of_a_recursion_that_does_not_fit(kind, change, message):
    with pytest.raises(InputError, match=message):
        kind(**{"R_theta": 1.0, **change})


@pytest.mark.parametrize(
    ("make", "setting"),
    [
        (
            lambda **given: rn.SlidingWindow(1.0, window=2, **given),
            {"reset": rn.CovarianceReset(every=2)},
        ),
        (lambda **given: rn.SlidingWindow(1.0, window=2, **given), {"process_noise": 1.0}),
        (lambda **given: rn.Instantaneous(1.0, **given), {"lambda_": 0.9}),
        (lambda **given: rn.Instantaneous(1.0, **given), {"process_noise": 1.0}),
        (lambda **given: rn.Gradient(1.0, **given), {"R_theta": 1.0}),
        (lambda **given: rn.UD(1.0, **given), {"step_size": 1.0}),
        (lambda **given: rn.Covariance(1.0, **given), {"window": 3}),
        (lambda **given: rn.ControllerSettings(**GOOD, **given), {"R_theta": 1.0}),
        (lambda **given: rn.ControllerSettings(**GOOD, **given), {"lambda_": 0.9}),
    ],
)
def test_a_setting_that_belongs_elsewhere_cannot_be_given(make, setting):
    make()
    with pytest.raises(TypeError, match=f"unexpected keyword argument '{next(iter(setting))}'"):
        make(**setting)


@pytest.mark.parametrize(
    "make", [rn.UD, rn.Covariance, rn.Instantaneous, rn.Gradient, rn.SlidingWindow]
)
def test_an_update_needs_its_own_settings(make):
    with pytest.raises(TypeError, match=r"missing 1 required positional argument"):
        make(**({"window": 3} if make is rn.SlidingWindow else {}))
    if make is rn.SlidingWindow:
        with pytest.raises(TypeError, match="'window'"):
            make(1.0)


@pytest.mark.exact_data  # messages quote the number that was given
@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: rn.ScheduledForgetting(5), "changes = 5 must map steps to values"),
        (lambda: rn.ScheduledForgetting({0: 0.9}), "a step of changes = 0 must be at least 1"),
        (
            lambda: rn.ScheduledForgetting({"a": 0.9, 1: 0.5}),
            "a step of changes must be an integer",
        ),
        (lambda: rn.ScheduledForgetting({3: 2.0}), r"lambda_ = 2.0 is not in \(0, 1\]"),
        (lambda: rn.ScheduledForgetting({3: 0.9}, 0.0), r"initial = 0.0 is not in \(0, 1\]"),
        (lambda: rn.Gradient(np.inf), "step_size has the entry inf"),
        (lambda: rn.Gradient(0.0), "step_size = 0.0 must be positive"),
        (lambda: rn.SlidingWindow(1.0, window=0), "window = 0 must be at least 1"),
        (lambda: rn.SlidingWindow(1.0, window=-2), "window = -2 must be at least 1"),
        (
            lambda: rn.SlidingWindow(1.0, window=2, lambda_=rn.ScheduledForgetting({1: 0.9})),
            "lambda_ must be a real number",
        ),
        (lambda: rn.SlidingWindow(-1.0, window=2), "R_theta has the eigenvalue -1"),
        (lambda: rn.Instantaneous(0.0), "R_theta has the eigenvalue 0"),
        (lambda: rn.CovarianceReset(at=5), "at = 5 must be a list"),
        (lambda: rn.CovarianceReset(at=[1.5]), "the step of a covariance reset must be an integer"),
        (lambda: rn.CovarianceReset(every=-1), "every = -1"),
        (lambda: rn.CovarianceReset(trace_below=1.0), "reset at every step"),
        (lambda: rn.CovarianceReset(trace_below=NAN), "trace_below has the entry nan"),
        (lambda: rn.CovarianceReset(growth=0.5), "growth = 0.5 must exceed 1"),
        (lambda: rn.CovarianceReset(short=5, long=5), "short = 5 must be less than long = 5"),
        (lambda: rn.VariableRateForgetting(3, 2, 1.0), "short = 3 must be less than long = 2"),
        (lambda: rn.VariableRateForgetting(1, 2, 0.0), "gain = 0.0 must be positive"),
        (lambda: rn.VariableRateForgetting(1, 2, 1.0, 0.0), r"smallest = 0.0 is not in \(0, 1\]"),
        (lambda: rn.SignalWeight(-1.0), "z_squared = -1.0 must not be negative"),
        (lambda: rn.SignalWeight(1.0, "x"), "constant must be a real number"),
        (lambda: rn.iir(10**9), "n_c = 1000000000 must be at most 100000"),
        (
            lambda: rn.TargetModel([0, 1.0], []),
            r"denominator of the target model has shape \(0, 1, 1\)",
        ),
        (lambda: rn.TargetModel([0, 1.0]).frequency_response("fast"), "omega must be an array"),
        (lambda: rn.Structure([]), "no taps"),
        (lambda: rn.Structure(5), "taps = 5 must be a list"),
        (lambda: rn.Structure([("u", 0, 1)]), "is not a Tap"),
        (lambda: rn.Structure([rn.Tap("u", 0, 0)]), r"reads u\(k\) to compute u\(k\)"),
        (lambda: rn.Structure([rn.Tap("v", 0, 0)]), "the signal of a tap = 'v' is not known"),
        (lambda: rn.Structure([rn.Tap("y", 1, 0)]), "component 1 of y, which has 1"),
        (lambda: rn.Structure([rn.Tap("y", 0, -1)]), "the delay of a tap = -1"),
        (lambda: rn.Structure([rn.Tap("y", 0, 1)] * 2), "the same entry twice"),
        (lambda: rn.Structure([rn.Tap("derived", 0, 1)], derived=[5]), "5 is not a DerivedSignal"),
        (
            lambda: rn.Structure([rn.Tap("derived", 0, 1)], derived=[rn.integral([1, 2])]),
            "weighs 2 comp",
        ),
        (lambda: rn.Structure([rn.Tap("y", 0, 3)], n_c=2), "less than the longest delay 3"),
        (lambda: rn.DerivedSignal(5, 5), "now = 5 must be a list of numbers"),
        (lambda: rn.DerivedSignal([1], [1, 2]), "1 weights now and 2 before"),
        (lambda: rn.DerivedSignal([1], [0], 1.5), r"pole 1.5 of a derived signal is outside"),
        (lambda: rn.difference(5), "weights = 5 must be a list"),
        (lambda: rn.integral("ab"), "now must be an array of real numbers"),
        (lambda: rn.pid(5), "name each of the terms"),
        (lambda: rn.pid("PP"), "at most once"),
        (lambda: rn.iir(1, k_c=2), "k_c = 2 exceeds n_c = 1"),
        (lambda: rn.quasi_fir(2, 3), "free_poles = 3 must be at most 2"),
        (lambda: rn.fir_integrator(2, F=np.ones((1, 2))), r"F has shape \(1, 2\)"),
        (lambda: rn.fir_integrator(2, F=np.zeros((0, 1))), "F has no rows"),
        (lambda: rn.feedforward(2, feedback="pid"), "feedback = 'pid' is not known"),
        (lambda: rn.feedforward(2, first_r=3), "first_r = 3 must be at most 2"),
        (rn.Saturation, "needs low, high or rate"),
        (lambda: rn.Saturation(low=1, high=0), "low = .* exceeds high"),
        (lambda: rn.Saturation(low=[1, 2], high=[1, 2, 3]), r"different sizes: \[2, 3\]"),
        (lambda: rn.Saturation(rate=0), "rate = .* must be positive"),
        (lambda: rn.Saturation(low=NAN), "low has the entry nan"),
        (lambda: rn.Decentralized(5), "controllers = 5 must be a list"),
        (lambda: rn.Decentralized([]), "needs a list of ControllerSettings"),
        (lambda: rn.Decentralized(SETTINGS), "must be a list"),
        (lambda: rn.Decentralized([SETTINGS]).compensator_of([1.0]), "theta has 1 entries; 2"),
    ],
)
def test_a_rule_or_a_structure_that_does_not_fit(make, message):
    with pytest.raises(InputError, match=message):
        make()


@pytest.mark.parametrize("name", ["R_theta", "R_z"])
@pytest.mark.parametrize(
    "weight",
    [
        scipy.linalg.hilbert(12),
        np.full((12, 12), 1e-200),
        np.ones((12, 12)) + 2**-51 * np.eye(12),
    ],
)
def test_a_weight_whose_definiteness_is_decided_by_rounding(name, weight):
    """Its inverse has no UD factors, or none that mean anything."""
    change = {"structure": rn.iir(6)}
    if name == "R_z":
        change |= {"R_z": weight, "target": rn.TargetModel(np.ones((2, 12, 1)))}
    with pytest.raises(
        InputError, match=f"{name} (is singular to working precision|has the eigenv)"
    ):
        if name == "R_theta":
            change["update"] = rn.UD(weight)
        rn.ControllerSettings(**{**GOOD, **change})


@given(st.integers(2, 8), st.integers(0, 40), st.integers(0, 2**32 - 1))
def test_a_graded_weight_keeps_its_digits(size, decades, seed):
    """diag(g) C diag(g) with a well conditioned C: its inverse is that of C, scaled."""
    rng = np.random.default_rng(seed)
    root = np.eye(size) + 0.3 * rng.uniform(-1, 1, (size, size)) / size
    grade = 10.0 ** rng.uniform(-decades / 2, 0, size)
    correlation = root @ root.T
    weight = (correlation + correlation.T) / 2 * np.outer(grade, grade)
    result = inverse(constant_weight(weight, "R_theta", size, definite=True))
    assert np.array_equal(result, result.T)
    assert result * np.outer(grade, grade) @ correlation == pytest.approx(np.eye(size), abs=1e-11)


def test_a_setting_may_be_a_fraction():
    weight = rn.SignalWeight(z_squared=Fraction(1, 10), constant=Fraction(1, 3))
    run = rn.simulate(PLANT, rn.ControllerSettings(**{**GOOD, "R_u": weight}), ONES)
    floats = rn.ControllerSettings(**{**GOOD, "R_u": rn.SignalWeight(0.1, 1 / 3)})
    assert (run.u == rn.simulate(PLANT, floats, ONES).u).all()


def test_a_masked_entry_is_no_number():
    w = np.ma.masked_array(ONES, mask=[[0], [1], [0], [0], [0]])
    with pytest.raises(InputError, match="some of its entries are masked"):
        rn.simulate(PLANT, SETTINGS, w)


def at(start, plant=PLANT, **more):
    return rn.PlantChange(start=start, plant=plant, **more)


def functions(advance=abs, output=abs, n=1, blocks=None):
    return rn.FunctionPlant(
        advance=advance, output=output, n=n, l_u=1, l_w=1, l_y=1, l_z=1, blocks=blocks or {}
    )


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: rn.PlantSchedule([]), "needs a list of PlantChange"),
        (lambda: rn.PlantSchedule([PLANT]), "is not a PlantChange"),
        (lambda: rn.PlantSchedule([at(1)]), "first change must begin at step 0"),
        (lambda: rn.PlantSchedule([at(0.0)]), "start must be an integer, not 0.0"),
        (lambda: rn.PlantSchedule([at(0, 5)]), "the plant of a change = 5 is not a Plant"),
        (lambda: rn.PlantSchedule([at(0), at(0)]), "the change at 0 does not follow that at 0"),
        (lambda: rn.PlantSchedule([at(0, ramp=True)]), "no plant follows"),
        (lambda: rn.PlantSchedule([at(0), at(3, TWO)]), "has 2 states after 1; give state_map"),
        (lambda: rn.PlantSchedule([at(0), at(3, TWO, state_map=np.eye(2))]), "state_map has shape"),
        (
            lambda: rn.PlantSchedule([at(0, ramp=True), at(3, TWO, state_map=np.ones((2, 1)))]),
            "joins plants of different order",
        ),
        (lambda: rn.PlantSchedule([at(0, delay=-1)]), "delay = -1"),
        (lambda: rn.PlantSchedule([at(0), at(3, rn.servo_plant("1/(q-0.5)"))]), "other inputs"),
        (lambda: functions(advance=5), "advance = 5 is not a function"),
        (lambda: functions(n=-1), "n = -1"),
        (lambda: functions(blocks={"r": 2}), "do not add up to l_w = 1"),
        (lambda: functions(blocks=5), "blocks = 5 is not a Mapping"),
        (lambda: functions(blocks={"r": "wide"}), "the width of 'r' must be an integer"),
        (lambda: functions(blocks={"r": -1, "w": 2}), "the width of 'r' = -1 must be at least 0"),
        (lambda: rn.Plant(A=[[0]], B=[[1]], D_1=[[1]], C=[[1]], blocks=5), "is not a Mapping"),
        (lambda: rn.Plant(A=[[0]], B=[[1]], D_1=[[1]], C=[[1]], blocks={5: 1}), "5 is not a str"),
    ],
)
def test_a_plant_that_does_not_fit(make, message):
    with pytest.raises(InputError, match=message):
        make()
