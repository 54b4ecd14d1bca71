"""Every public door that takes arrays, called as in its own example with what it must not trust."""

import pickle
import warnings

import numpy as np
import pytest

import rcac_numeric as rcac
from compensator_theory.errors import CompensatorError
from docs.reference_pages import public_path
from rcac_numeric import Plant
from rcac_numeric.arrays._values import replaced
from rcac_numeric.results import ContinuousSolution, StabilisingSolution
from tests.support.example_calls import doors, is_array, numeric_array


def of(package, takes):
    """The doors of a package but the results, which nobody makes: what they hold is computed."""
    result = doors(package, takes)
    return {k: v for k, v in result.items() if ".results." not in public_path(package, k)}


DOORS = of("rcac_numeric", is_array)
# Both packages have some of them under one name.
EXACT = {
    f"compensator_theory.{name}": door for name, door in of("compensator_theory", is_array).items()
}
PLANTS = of("rcac_numeric", lambda value: isinstance(value, Plant))
# What is read when it is used only.
USED = {"SimulationCase": lambda case: list(rcac.simulate_many([case]))}
SLOW = {"fit_noises", "identify_process_matrix", "identify_step_response"}
CASES = [(name, array) for name, (_, _, arrays) in DOORS.items() for array in arrays]
SENTINEL = -9999.0  # of a data logger


def answer(name, **changed):
    """What a door answers, or the error of ours that refuses."""
    function, call, _ = next(table[name] for table in (DOORS, PLANTS, EXACT) if name in table)
    try:
        return USED.get(name, lambda result: result)(function(**{**call, **changed}))
    except CompensatorError as error:
        return error


def test_the_doors_are_many():
    assert len(DOORS) > 40 and {"solve_riccati", "ControllerLog", "identify_output_error"} <= set(
        DOORS
    )
    assert len(EXACT) > 10


@pytest.mark.parametrize(
    ("name", "array"), [*CASES, *((name, array) for name in EXACT for array in EXACT[name][2])]
)
def test_a_mask_is_a_gap_or_refused(name, array):
    value = np.array(numeric_array((DOORS if name in DOORS else EXACT)[name][1][array]))
    at = tuple(size // 2 for size in value.shape)
    nan, sentinel, mask = value.copy(), value.copy(), np.zeros(value.shape, dtype=bool)
    nan[at], sentinel[at], mask[at] = np.nan, SENTINEL, True
    result = answer(name, **{array: np.ma.masked_array(sentinel, mask)})
    if isinstance(result, CompensatorError):
        return
    as_nan = answer(name, **{array: nan})
    assert not isinstance(as_nan, CompensatorError), "NaN is refused and a mask is not"
    assert pickle.dumps(result) == pickle.dumps(as_nan) or repr(result) == repr(as_nan)


def hostile(shape):
    """Arrays of a shape that are legal, and hard: what rounding or float64 itself cannot hold."""
    rng = np.random.default_rng(0)
    normal = rng.standard_normal(shape)
    yield "zero", np.zeros(shape)
    yield "ones", np.ones(shape)
    yield "huge", 1e200 * normal
    yield "tiny", 1e-200 * normal
    yield "badly scaled", normal * 10.0 ** rng.integers(-12, 12, shape)
    if len(shape) == 2:
        yield "strongly non-normal", np.triu(1e6 * normal, 1) + 0.5 * np.eye(*shape)
        weights = 10.0 ** -np.arange(0.0, 30 * shape[0], 30)
        yield "graded", np.eye(*shape) * weights[: shape[0], None]


def hostile_plants(plant):
    """The plant with one of its matrices replaced, and strongly non-normal but stable."""
    for name in ("A", "B", "C"):
        for kind, argument in hostile(getattr(plant, name).shape):
            changed = {
                name: argument,
                **({"E_1": argument} if name == "C" and plant.l_z == plant.l_y else {}),
            }
            yield f"{name} {kind}", replaced(plant, exact=None, **changed)
    n = plant.n
    yield (
        "stable",
        replaced(plant, exact=None, A=np.triu(np.full((n, n), 1e9), 1) + 0.9 * np.eye(n)),
    )


def answered(name, kind, argument, value):
    """A door given something hostile has a solution or refuses by an error of ours."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        warnings.simplefilter("error", RuntimeWarning)
        try:
            result = answer(name, **{argument: value})
        except (RuntimeWarning, np.linalg.LinAlgError, ArithmeticError) as error:
            raise AssertionError(f"{kind}: {type(error).__name__}: {error}") from error
    if isinstance(result, StabilisingSolution | ContinuousSolution):
        assert result.residual < 1e-8 and result.margin > 0, kind
        assert np.isfinite(result.P).all() and np.isfinite(result.K).all(), kind


@pytest.mark.parametrize(
    ("name", "array"),
    [pytest.param(*c, marks=pytest.mark.costly if c[0] in SLOW else ()) for c in CASES],
)
def test_hostile_arrays_have_an_answer_or_an_error_of_ours(name, array):
    value = np.array(numeric_array(DOORS[name][1][array]))
    for kind, argument in hostile(value.shape):
        answered(name, kind, array, argument)


@pytest.mark.parametrize(
    ("name", "argument"), [(name, one) for name, (_, _, names) in PLANTS.items() for one in names]
)
def test_hostile_plants_have_an_answer_or_an_error_of_ours(name, argument):
    for kind, value in hostile_plants(PLANTS[name][1][argument]):
        answered(name, kind, argument, value)
