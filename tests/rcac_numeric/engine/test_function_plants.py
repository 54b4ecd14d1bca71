"""Compiled plants, and plants whose functions fail."""

import ctypes
import shutil
import subprocess

import numpy as np
import pytest
from scipy import LowLevelCallable

import rcac_numeric as rn
from compensator_theory.errors import FunctionFailedError
from tests.support.function_plants import TWO_STATES, as_functions
from tests.support.signals import noise

C_CODE = """
#include <stdint.h>
static int calls = 0;
int advance(int64_t k, double* x, double* u, double* w, double* next, void* data) {
    if (data && k == *(int64_t*)data) return 7;
    next[0] = 0.5 * x[0] + 0.25 * x[1] + 1.0 * u[0] + 1.0 * w[0];
    next[1] = -0.125 * x[0] + 0.75 * x[1] + 0.5 * u[0] + 0.0 * w[0];
    return 0;
}
int output(int64_t k, double* x, double* w, double* y, double* z, void* data) {
    y[0] = z[0] = 1.0 * x[0] + -0.5 * x[1];
    return 0;
}
"""
SETTINGS = rn.ControllerSettings(
    structure=rn.iir(2), target=rn.TargetModel([0, 1.0]), update=rn.UD(R_theta=1.0)
)
SIZES = {"n": 2, "l_u": 1, "l_w": 1, "l_y": 1, "l_z": 1}


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """The C functions above, compiled."""
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("no C compiler named cc is installed")
    folder = tmp_path_factory.mktemp("plant")
    (folder / "plant.c").write_text(C_CODE)
    command = [
        compiler,
        "-O1",
        "-ffp-contract=off",
        "-shared",
        "-fPIC",
        "plant.c",
        "-o",
        "plant.so",
    ]
    subprocess.run(command, cwd=folder, check=True)
    loaded = ctypes.CDLL(str(folder / "plant.so"))
    pointer = ctypes.POINTER(ctypes.c_double)
    for function in (loaded.advance, loaded.output):
        function.argtypes = [ctypes.c_int64, *4 * [pointer], ctypes.c_void_p]
        function.restype = ctypes.c_int
    return loaded


def test_a_compiled_plant_is_the_plant(library):
    w = noise(3, 200, 1)
    compiled = rn.FunctionPlant(
        advance=LowLevelCallable(library.advance), output=LowLevelCallable(library.output), **SIZES
    )
    run, same = rn.simulate(TWO_STATES, SETTINGS, w), rn.simulate(compiled, SETTINGS, w)
    assert compiled.is_compiled and same.outcome == "completed"
    assert np.abs(same.theta_final - run.theta_final).max() < 1e-12
    assert np.abs(same.z - run.z).max() < 1e-12


def test_a_compiled_plant_has_the_same_name_every_time(library):
    """A state that was saved in one process can be restored in the next."""
    once, again = (
        rn.FunctionPlant(
            advance=LowLevelCallable(library.advance),
            output=LowLevelCallable(library.output),
            **SIZES,
        )
        for _ in range(2)
    )
    w = noise(3, 20, 1)
    state = rn.simulate(once, SETTINGS, w[:9]).state
    rest = rn.simulate(again, SETTINGS, w[9:], start=state)
    assert np.array_equal(rest.theta_final, rn.simulate(once, SETTINGS, w).theta_final)


def test_a_ctypes_callback_counts_as_compiled():
    pointer = ctypes.POINTER(ctypes.c_double)
    kind = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_int64, *4 * [pointer], ctypes.c_void_p)

    def advance(k, x, u, w, x_next, data):
        x_next[0], x_next[1] = TWO_STATES.A @ [x[0], x[1]] + TWO_STATES.B[:, 0] * u[0] + [w[0], 0]
        return 0

    def output(k, x, w, y, z, data):
        y[0] = z[0] = x[0] - 0.5 * x[1]
        return 0

    callbacks = [LowLevelCallable(kind(advance)), LowLevelCallable(kind(output))]
    plant = rn.FunctionPlant(advance=callbacks[0], output=callbacks[1], **SIZES)
    w = noise(4, 20, 1)
    exact = rn.simulate(TWO_STATES, SETTINGS, w)
    assert rn.simulate(plant, SETTINGS, w).z == pytest.approx(exact.z, abs=1e-12)


def test_a_compiled_function_may_end_the_run(library):
    stop = ctypes.c_int64(9)
    data = ctypes.cast(ctypes.pointer(stop), ctypes.c_void_p)
    plant = rn.FunctionPlant(
        advance=LowLevelCallable(library.advance, data),
        output=LowLevelCallable(library.output),
        **SIZES,
    )
    run = rn.simulate(plant, SETTINGS, noise(5, 20, 1))
    assert run.outcome == "plant failed" and run.steps == 9 and run.state is None


def test_a_simulator_of_compiled_functions_names_the_failing_one(library):
    stop = ctypes.c_int64(2)
    data = ctypes.cast(ctypes.pointer(stop), ctypes.c_void_p)
    plant = rn.FunctionPlant(
        advance=LowLevelCallable(library.advance, data),
        output=LowLevelCallable(library.output),
        **SIZES,
    )
    body = rn.Simulator(plant)
    body.advance(0, 0)
    body.advance(0, 0)
    with pytest.raises(FunctionFailedError, match="advance of the plant failed at step 2: it ret"):
        body.advance(0, 0)
    assert body.k == 2 and np.array_equal(body.x, np.zeros(2))


def test_a_simulator_of_functions_is_the_linear_plant_and_keeps_what_failed():
    plant, body = as_functions(TWO_STATES), rn.Simulator(TWO_STATES, x_0=[1.0, -1.0])
    same = rn.Simulator(plant, x_0=[1.0, -1.0])
    for k in range(5):
        for one, other in zip(body.output(k, 1), same.output(k, 1), strict=True):
            assert one == pytest.approx(other, abs=1e-14)
        body.advance(k, 1)
        same.advance(k, 1)
    assert same.k == 5 and same.x == pytest.approx(body.x, abs=1e-14)
    broken = rn.Simulator(failing(3, ValueError("no sensor"), of="output"))
    for _ in range(3):
        broken.output(0, 0)
        broken.advance(0, 0)
    for _ in range(2):  # it fails again where it has failed, and says why each time
        with pytest.raises(
            FunctionFailedError, match=r"output of the plant .* step 3: ValueError: no sensor"
        ):
            broken.output(0, 0)
    assert repr(broken).startswith("Simulator(k=3")


def failing(k_bad, answer, of="advance"):
    """TWO_STATES as functions of which one answers `answer` (or raises it) at step k_bad."""

    def spoil(function):
        def spoiled(k, *arguments):
            if k != k_bad:
                return function(k, *arguments)
            if isinstance(answer, Exception):
                raise answer
            return answer

        return spoiled

    good = as_functions(TWO_STATES)
    functions = {"advance": good.advance, "output": good.output}
    functions[of] = spoil(functions[of])
    return rn.FunctionPlant(**functions, **SIZES)


@pytest.mark.parametrize(
    ("of", "answer", "message"),
    [
        ("advance", ValueError("no such gust"), "at step 6: ValueError: no such gust"),
        ("advance", [1.0], "advance returned 1 numbers as x.k.1.; 2 are needed"),
        ("advance", None, "advance returned"),
        ("advance", ["a", "b"], "what advance returned as x"),
        ("advance", ["1", "2"], "what advance returned as x"),
        ("advance", [1j, 0.0], "what advance returned as x"),
        ("advance", np.array([1j, 0.0]), "what advance returned as x"),
        ("advance", [True, False], "what advance returned as x"),
        ("output", TypeError("bad table"), "at step 6: TypeError: bad table"),
        ("output", ([1.0, 2.0], [1.0]), "output returned 2 numbers as y; 1 are needed"),
        ("output", ([1.0], []), "output returned 0 numbers as z; 1 are needed"),
        ("output", 3.0, "output must return the pair"),
        ("output", None, "output must return the pair"),
    ],
)
@pytest.mark.parametrize("stride", [1, 4])
def test_a_function_that_fails_is_named_and_the_steps_before_are_kept(of, answer, message, stride):
    w = noise(6, 20, 1)
    with pytest.raises(FunctionFailedError, match=message) as caught:
        rn.simulate(failing(6, answer, of), SETTINGS, w, stride=stride)
    run, good = (
        caught.value.run,
        rn.simulate(as_functions(TWO_STATES), SETTINGS, w[:6], stride=stride),
    )
    assert run.outcome == "plant failed" and run.steps == 6 and run.state is None
    for name in ("w", "u", "y", "z", "theta", "theta_final"):
        assert np.array_equal(getattr(run, name), getattr(good, name)), name


@pytest.mark.parametrize(
    ("of", "answer"),
    [("advance", [np.nan, 0.0]), ("advance", [np.inf, 0.0]), ("output", ([np.nan], [1.0])),
     ("output", ([1.0], [-np.inf]))],
)  # fmt: skip
@pytest.mark.parametrize("stride", [1, 4])
@pytest.mark.parametrize("form", ["predictor", "filter"])
def test_a_plant_that_is_not_finite(of, answer, stride, form):
    from attrs import evolve as replace

    settings, w = replace(SETTINGS, form=form), noise(7, 20, 1)
    run = rn.simulate(failing(6, answer, of), settings, w, stride=stride)
    good = rn.simulate(as_functions(TWO_STATES), settings, w[:6], stride=stride)
    assert run.outcome == "plant not finite" and run.steps == 6
    for name in ("u", "y", "z", "theta", "theta_final"):
        assert np.array_equal(getattr(run, name), getattr(good, name)), name
