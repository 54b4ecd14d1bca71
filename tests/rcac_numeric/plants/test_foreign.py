"""Systems of other packages as plants: the same responses, the same sample time, or a refusal."""

import control
import numpy as np
import pytest
import scipy.signal
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st
from sympy.physics.control import (
    Feedback,
    MIMOFeedback,
    Parallel,
    Series,
    StateSpace,
    TransferFunction,
    TransferFunctionMatrix,
)

import compensator_theory as exact
from compensator_theory.errors import InputError
from rcac_numeric import (
    UD,
    Compensator,
    ControllerSettings,
    FixedController,
    Plant,
    TargetModel,
    check_controller,
    iir,
    lqg_controller,
    plant_of,
    servo_plant,
    simulate,
    standard_plant,
)
from rcac_numeric.plants._zero_order_hold import zero_order_hold
from tests.support.foreign_systems import POINTS, of_control, random_system

pytestmark = pytest.mark.exact_data  # a system that is read keeps every digit

z, s = sympy.symbols("z s")
HALF = sympy.Rational(1, 2)
G, H = TransferFunction(1, z - HALF, z), TransferFunction(z - 2, z**2 - z / 4, z)


def response(plant):
    """From u, and the same from w, in y and z: the standard problem."""
    pencils = POINTS[:, None, None] * np.eye(plant.n) - plant.A
    maps = [
        (C @ np.linalg.solve(pencils, B[None]) + D)
        for C, B, D in (
            (plant.C, plant.B, plant.D_0), (plant.C, plant.D_1, plant.D_2),
            (plant.E_1, plant.B, plant.E_2), (plant.E_1, plant.D_1, plant.E_0),
        )
    ]  # fmt: skip
    assert all(np.allclose(one, maps[0], rtol=1e-12, atol=0) for one in maps)
    return maps[0]


@settings(max_examples=25)
@given(st.integers(0, 10**6), st.integers(1, 4), st.integers(1, 3), st.integers(1, 3))
def test_state_spaces_of_any_size_keep_their_response(seed, n, inputs, outputs):
    system = random_system(seed, n, inputs, outputs)
    plant = plant_of(system)
    assert np.allclose(response(plant), of_control(system), rtol=1e-9, atol=1e-9)
    assert plant.sample_time == 0.01 and np.array_equal(plant.A, system.A)
    parts = [getattr(system, name) for name in "ABCD"]
    discrete = scipy.signal.dlti(*parts, dt=0.01)
    assert plant_of(discrete) == plant and plant_of(discrete).sample_time == 0.01


def test_what_interconnect_joins_is_read():
    plant = control.ss([[0.5, 1], [0, 0.2]], np.eye(2), np.eye(2), np.zeros((2, 2)), 0.01,
                       inputs=["a", "b"], outputs=["c", "d"], name="P")  # fmt: skip
    law = control.ss([[0.1]], [[1, 0]], [[1], [0.2]], np.zeros((2, 2)), 0.01,
                     inputs=["c", "d"], outputs=["e", "f"], name="C")  # fmt: skip
    sums = [control.summing_junction(["e", "r1"], "a"), control.summing_junction(["f", "r2"], "b")]
    joined = control.interconnect([plant, law, *sums], inputs=["r1", "r2"], outputs=["c", "d"])
    assert isinstance(joined, control.LinearICSystem)
    assert np.allclose(response(plant_of(joined)), of_control(joined))


def test_transfer_functions_with_several_signals_are_realised_minimally():
    rows = [[[1], [2, 1]], [[3], [1]]], [[[1, -0.5], [1, -0.7, 0.1]], [[1, -0.5], [1, -0.2]]]
    system = control.tf(*rows, 0.1)
    plant = plant_of(system)
    assert np.allclose(response(plant), of_control(system))
    assert plant.n == 3 and plant.sample_time == 0.1  # modes .5 (shared by three entries), .5, .2


def value_of(system, point):
    """Without doit of SymPy 1.14, which may answer with what an earlier system was joined to."""
    if isinstance(system, TransferFunction):
        return complex((system.num / system.den).subs(z, point))
    if isinstance(system, TransferFunctionMatrix):
        return np.array([[value_of(e, point) for e in row] for row in system.args[0]])
    if isinstance(system, Series):
        return np.prod([value_of(part, point) for part in system.args])
    if isinstance(system, Parallel):
        return sum(value_of(part, point) for part in system.args)
    through, back = value_of(system.sys1, point), value_of(system.sys2, point)
    if isinstance(system, Feedback):
        return through / (1 - int(system.sign) * through * back)
    return np.linalg.solve(np.eye(2) - int(system.sign) * through @ back, through)


@pytest.mark.costly
@pytest.mark.parametrize(
    "system",
    [G, Series(G, H), Parallel(G, H), Feedback(G, H), Feedback(Series(G, H), G, 1),
     TransferFunctionMatrix([[G, H]]), MIMOFeedback(
         TransferFunctionMatrix([[G, H], [H, G]]), TransferFunctionMatrix([[G, H], [H, G]]))],
    ids=lambda system: type(system).__name__,
)  # fmt: skip
def test_sympy_joins_without_doit(system):
    """Against the values of the parts, joined by hand."""
    expected = [np.atleast_2d(value_of(system, complex(point))) for point in POINTS]
    assert np.allclose(response(plant_of(system)), expected)


def test_a_state_space_of_sympy_is_what_it_is_told_to_be():
    system = StateSpace(*(sympy.Matrix([[value]]) for value in (HALF, 2, 3, 0)))
    assert plant_of(system, variable="z").A.item() == 0.5
    A, B = zero_order_hold([[0.5]], [[2.0]], 0.1)
    sampled = plant_of(system, sample_time=0.1)
    assert (sampled.A, sampled.B) == (A, B) and sampled.sample_time == 0.1
    with pytest.raises(InputError, match=r'sample_time=0\.01, method="zoh"'):
        plant_of(system)


@pytest.mark.parametrize("method", ["zoh", "bilinear"])
@pytest.mark.parametrize("package", ["control", "scipy"])
def test_a_continuous_system_is_sampled_only_where_it_is_told_how(package, method):
    numerator, denominator = [1.0, 3.0], [1.0, 0.4, 2.0]
    of = {"control": control.tf, "scipy": scipy.signal.lti}[package](numerator, denominator)
    with pytest.raises(InputError, match="continuous time"):
        plant_of(of)
    plant = plant_of(of, sample_time=0.1, method=method)
    oracle = control.c2d(control.tf(numerator, denominator), 0.1, method)
    assert np.allclose(response(plant), of_control(oracle)) and plant.sample_time == 0.1


def test_a_nonlinear_update_runs_as_the_loop_written_out():
    def update(t, x, u, params):
        return np.array([0.9 * x[0] + 0.1 * np.sin(x[0]) + u[0]])

    system = control.nlsys(update, lambda t, x, u, p: x, inputs=1, outputs=1, states=1, dt=0.01)
    controller = ControllerSettings(
        structure=iir(2), target=TargetModel([0.0, 1.0]), update=UD(R_theta=1.0)
    )
    run = simulate(system, controller, 0.1 * np.ones((200, 1)))
    x = 0.0
    for k in range(run.steps):
        assert run.y[k, 0] == x
        x = 0.9 * x + 0.1 * np.sin(x) + (run.u[k, 0] + 0.1)
    assert run.outcome == "completed" and run.steps == 200
    direct = control.nlsys(update, lambda t, x, u, p: x + u, inputs=1, outputs=1, states=1, dt=1)
    with pytest.raises(InputError, match="depends directly on its input"):
        plant_of(direct)
    flow = control.nlsys(lambda t, x, u, p: -x, lambda t, x, u, p: x, inputs=1, outputs=1, states=1)
    with pytest.raises(InputError, match="cannot be sampled here"):
        plant_of(flow, sample_time=0.1)


def test_every_door_takes_foreign_systems_and_gives_their_sample_time_back():
    system = control.tf([1], [1, -1.5], 0.01)
    ours = standard_plant("1/(q - 1.5)")
    law = Compensator(np.zeros((0, 1, 1)), [[[-1.0]]])
    runs = [simulate(p, FixedController(law), np.ones((50, 1))) for p in (system, ours)]
    assert np.allclose(runs[0].z, runs[1].z, rtol=1e-12)
    assert [run.sample_time for run in runs] == [0.01, None]
    assert runs[0].compensator.to_control(runs[0].sample_time).dt == 0.01
    design = lqg_controller(system)
    assert design.to_control().dt == 0.01 and design.cost.value == pytest.approx(
        lqg_controller(ours).cost.value
    )
    check = check_controller(np.zeros(9), np.zeros(9), compensator=law, plant=system)
    assert check.loop.poles() == pytest.approx([0.5])
    placed = exact.place_poles(system, ["1/2", "1/4"], feedback=-1)
    assert placed.to_control().dt == 0.01 and placed.compensator.to_control().dt == 0.01
    for read in (exact.transfer_function(system), exact.realisation(system).transfer_function()):
        assert read.to_control().dt == 0.01 and read.reduced().to_control().dt == 0.01
    assert law.to_control(0.01).dt == 0.01 and law.to_control().dt is True
    assert exact.transfer_function(control.tf([1], [1, -1.5], True)).to_control().dt is True


def test_a_servo_plant_of_several_inputs_and_outputs():
    system = random_system(4, 3, 2, 2)
    plant = servo_plant(system)
    assert dict(plant.blocks) == {"r": 2, "d": 2, "v": 2} and plant.sample_time == 0.01
    assert np.array_equal(plant.B, system.B) and np.array_equal(plant.D_1[:, 2:4], system.B)
    maps = plant.C @ np.linalg.solve(POINTS[:, None, None] * np.eye(3) - plant.A, plant.B[None])
    assert np.allclose(maps, -of_control(system))  # y = r - y_0 - v


@pytest.mark.parametrize(
    ("system", "options", "words"),
    [
        (control.tf([1], [1, -0.5], 0.1), {"sample_time": 0.2}, "sampled every 0.1 s"),
        (control.tf([1], [1, 1]), {"sample_time": -1}, "must be positive"),
        (control.tf([1], [1, 1]), {"sample_time": 0.1, "method": "foh"}, "method"),
        (control.frd([1], [1]), {}, "no rational transfer function"),
        (control.ss([[0.5]], [[1]], [[1]], [[0]], None), {}, "time base is unspecified"),
    ],
)
def test_what_cannot_be_read_says_why(system, options, words):
    with pytest.raises(InputError, match=words):
        plant_of(system, **options)


def test_our_own_plants_pass():
    plant = Plant(A=[[0.5]], B=[[1.0]], D_1=[[1.0]], C=[[2.0]])
    assert plant_of(plant) is plant
