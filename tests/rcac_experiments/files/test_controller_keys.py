"""The additions of published settings from a file, and what is wrong with a file said by name."""

import math

import pytest

from compensator_theory import InputError
from rcac_experiments.files._builder import build
from rcac_numeric import (
    CertifiedBounds,
    CoefficientBounds,
    Compensator,
    Normalization,
    SignalWeight,
    pid,
)

PLANT = {"problem": "standard", "G": "1/(q - 0.9)"}


def controller(**keys):
    table = {"structure": "pid", "R_theta": 1.0, **keys}
    run = {"steps": 10}
    case = {"plant": PLANT, "target": {"model": "fir"}, "controller": table, "run": run}
    return build(case, "case.toml").main_run.settings


@pytest.mark.exact_data
def test_every_addition_has_its_key():
    settings = controller(
        k_c=0,
        integral_limit=0.5,
        R_z={"constant": 1, "nu": 0.25},
        R_u_unfiltered=0.01,
        z_normalization={"limit": 5, "function": "tanh"},
        bounds={"low": -1, "gains": {"K_D": [0, 2]}, "method": "clip"},
        fixed={"past_u": [[[0.5]]], "past_y": [[[0]], [[0.25]]]},
    )
    assert settings.structure == pid(k_c=0, integral_limit=0.5)
    assert [signal.limit for signal in settings.structure.derived] == [0.5, math.inf]
    assert settings.R_z == SignalWeight(constant=1.0, nu=0.25)
    assert settings.R_u_unfiltered.tolist() == [[0.01]]
    assert settings.z_normalization == Normalization(5.0, function="tanh")
    assert settings.bounds == CoefficientBounds(-1, gains={"K_D": (0, 2)}, method="clip")
    assert settings.fixed == Compensator([[[0.5]]], [[[0]], [[0.25]]])


def test_bounds_are_a_box_or_an_ellipsoid():
    factor = [[0.5, 0, 0], [0.1, 0.5, 0], [0, 0, 2.0]]
    settings = controller(k_c=0, bounds={"center": [0.1, 0, 0], "factor": factor})
    assert settings.bounds == CertifiedBounds([0.1, 0.0, 0.0], factor)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"bounds": {"low": 1, "hight": 2}}, "Did you mean 'high'"),
        ({"bounds": {"gains": {"K_X": [0, 1]}}}, "no coefficient is called 'K_X'"),
        ({"bounds": {"low": 1.0}}, "start inside them"),
        ({"bounds": {"center": [0, 0, 0]}}, "factor"),
        ({"bounds": {"center": [0], "factor": [[1]]}}, "a center of 1 entries"),
        ({"bounds": {"center": [0, 0], "factor": [[1, 2], [0, 1]]}}, "lower triangular"),
        ({"bounds": {"center": [0, 0, 0], "low": 1}}, "low"),
        ({"z_normalization": {"limit": -1}}, "must be positive"),
        ({"z_normalization": {"limit": 1, "function": "cube"}}, "function"),
        ({"R_u_unfiltered": [[1, 0], [0, 1]]}, "R_u_unfiltered"),
        ({"fixed": {"past_u": [[[1]]]}}, "past_y"),
        ({"integral_limit": 0}, "must be positive"),
        ({"k_c": 2}, "k_c"),
        ({"R_z": {"nu": 1}}, "give constant"),
    ],
)
def test_what_is_wrong_with_a_key_is_said(keys, message):
    with pytest.raises(InputError, match=message):
        controller(**keys)
