"""Every door that takes a plant takes a system of another package, of several signals too."""

import control
import numpy as np
import pytest
import scipy.signal
import sympy
from sympy.physics.control import MIMOFeedback, MIMOSeries, TransferFunction, TransferFunctionMatrix

import compensator_theory as exact
from compensator_theory.errors import InputError
from rcac_numeric import (
    ClosedLoop,
    Compensator,
    FixedController,
    SimulationCase,
    Simulator,
    check_controller,
    fir_target,
    h2_cost,
    lqg_controller,
    plant_of,
    pole_placement_target,
    servo_plant,
    simulate,
    simulate_many,
    standard_plant,
)
from rcac_numeric.targets import (
    direction_information,
    high_authority_target,
    markov_parameters,
    markov_target,
    modelling_information,
    output_subspace_target,
    zero_direction_target,
)
from tests.support.foreign_systems import POINTS, of_control, random_system

z = sympy.Symbol("z")
G = TransferFunction(1, z - sympy.Rational(1, 2), z)
H = TransferFunction(z - 2, z**2 - z / 4, z)


def test_a_servo_plant_of_what_was_sampled_or_of_rows():
    system = control.tf([1.0, 3.0], [1.0, 0.4, 2.0])
    with pytest.raises(InputError, match=r"servo_plant\(plant_of\(system, sample_time=0.01\)\)"):
        servo_plant(system)
    plant = servo_plant(plant_of(system, sample_time=0.1), performance="true")
    maps = plant.C @ np.linalg.solve(POINTS[:, None, None] * np.eye(2) - plant.A, plant.B[None])
    assert np.allclose(maps, -of_control(control.c2d(system, 0.1))) and plant.sample_time == 0.1
    assert plant.blocks == {"r": 1, "d": 1, "v": 1} and plant.problem.to_control().dt == 0.1
    row = servo_plant([[control.tf([1], [1, -0.5], 0.1), control.tf([1], [1, -0.2], 0.1)]])
    assert row.sample_time == 0.1


JOINED = TransferFunctionMatrix([[G, H], [H, G]])
SEVERAL = {
    "state space": random_system(2, 3, 2, 2), "dlti": scipy.signal.dlti(
        *(getattr(random_system(2, 3, 2, 2), name) for name in "ABCD"), dt=0.01),
    "transfer functions": control.tf([[[1], [1]], [[0.0], [1]]],
                                     [[[1, -0.5], [1, -0.7, 0.1]], [[1], [1, -1.2]]], 0.01),
    "interconnect": control.interconnect(
        [control.ss([[0.5, 1], [0, 0.2]], np.eye(2), np.eye(2), np.zeros((2, 2)), 0.01,
                    inputs=["a", "b"], outputs=["c", "d"], name="P"),
         control.summing_junction(["r", "-d"], "a"), control.summing_junction(["s", "c"], "b")],
        inputs=["r", "s"], outputs=["c", "d"]),
}  # fmt: skip


def system_of_several_signals(name):
    """SymPy takes seconds to join systems, which no collection of tests has to wait for."""
    joins = {"series": MIMOSeries, "feedback": MIMOFeedback}
    return joins[name](JOINED, JOINED) if name in joins else SEVERAL[name]


@pytest.mark.costly
@pytest.mark.cases(3)
@pytest.mark.parametrize("name", [*SEVERAL, "series", "feedback"])
def test_every_door_takes_systems_of_several_signals(name):
    """Each answers as it does for the plant that `plant_of` makes of the system."""
    system = system_of_several_signals(name)
    plant = plant_of(system)
    law = Compensator(np.zeros((0, 2, 2)), [[[-0.1, 0], [0.05, -0.1]]])
    w = np.random.default_rng(1).standard_normal((30, 2))
    cases = [SimulationCase(argument, FixedController(law), w) for argument in (system, plant)]
    assert cases[0].plant == plant and len({run.z.tobytes() for run in simulate_many(cases)}) == 1
    assert (
        simulate(system, FixedController(law), w).z.tobytes() == simulate_many(cases)[0].z.tobytes()
    )
    assert ClosedLoop(system, law) == ClosedLoop(plant, law)
    assert h2_cost(system, law).value == h2_cost(plant, law).value
    body = Simulator(system)
    assert [len(signal) for signal in body.output(u=np.zeros(2), w=np.zeros(2))] == [2, 2]
    y = np.zeros((9, 2))
    check = check_controller(y, y, compensator=law, plant=system)
    assert np.array_equal(check.poles, check_controller(y, y, compensator=law, plant=plant).poles)
    assert np.array_equal(markov_parameters(system, 3), markov_parameters(plant, 3))
    assert servo_plant(system).sample_time == plant.sample_time
    dt = True if plant.sample_time is None else 0.01
    assert exact.transfer_matrix(system).to_control().dt == dt


def test_lqg_of_several_signals_goes_out_with_its_sample_time():
    for name in ("state space", "transfer functions", "interconnect"):
        design, ours = lqg_controller(SEVERAL[name]), lqg_controller(plant_of(SEVERAL[name]))
        assert design.to_control().dt == 0.01 and design.cost.value == ours.cost.value


@pytest.mark.exact_data
def test_target_models_are_built_from_foreign_plants():
    system, ours = control.tf([1, -1.3], [1, -1.1, 0.3], True), standard_plant(
        "(q - 1.3)/(q**2 - 1.1*q + 0.3)")  # fmt: skip
    for build in (
        fir_target, high_authority_target, output_subspace_target, direction_information,
        lambda p: pole_placement_target(p, ["1/2"]), lambda p: markov_target(p, 5),
        modelling_information, zero_direction_target,
    ):  # fmt: skip
        assert build(system) == build(ours)


@pytest.mark.parametrize("door", [lqg_controller, markov_target, lambda p: h2_cost(p, None)])
def test_what_needs_a_linear_plant_says_so(door):
    system = control.nlsys(
        lambda t, x, u, p: x**2, lambda t, x, u, p: x, inputs=1, outputs=1, states=1, dt=1
    )
    with pytest.raises(InputError, match=r"nonlinear.*control\.linearize"):
        door(system)


def test_a_sample_time_beside_matrices_is_that_of_the_servo_plant():
    """The shape of (A, B, C, D, dt) was once asked in s, which has no sample time."""
    A, B, C, D = [[0, 1], [-0.5, 0]], [[0], [1]], [[2, 1]], [[0]]
    plant, same = servo_plant((A, B, C, D, 0.1)), servo_plant((A, B, C, D), variable="z")
    assert plant.sample_time == 0.1 and same.sample_time is None
    assert all(np.array_equal(getattr(plant, name), getattr(same, name)) for name in "ABC")
