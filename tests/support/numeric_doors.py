"""A call of each numeric function that takes a plant or a loop: of the system, and its variable."""

import numpy as np

import rcac_numeric as rcac
from rcac_numeric.designing._plants import read_plant
from tests.support.public import public_objects

PUBLIC = public_objects("rcac_numeric")
LAW = rcac.Compensator(np.zeros((1, 1, 1)), [[[0.0]], [[-0.1]]])
ADAPTIVE = rcac.ControllerSettings(
    structure=rcac.iir(n_c=1), target=rcac.fir_target(rcac.standard_plant("1/(q - 0.5)")),
    update=rcac.UD(R_theta=1.0),
)  # fmt: skip
FIXED, W = rcac.FixedController(LAW), np.random.default_rng(0).standard_normal((12, 1))
Y = np.random.default_rng(1).standard_normal((30, 1))
TARGET = PUBLIC["fir_target"](rcac.standard_plant("1/(q - 0.5)"))
OWN_PLANT = rcac.standard_plant("1/(q - 0.5)")
DOORS = {
    "plant_of": lambda G, v: rcac.plant_of(G, variable=v),
    "standard_plant": lambda G, v: rcac.standard_plant(G, variable=v),
    "servo_plant": lambda G, v: rcac.servo_plant(G, **({} if v is None else {"variable": v})),
    "stability_margins": lambda G, v: rcac.stability_margins(G, feedback=-1, disk=False),
    "design": lambda G, v: read_plant(G, None, 0.0),  # what it reads with, without its runs
    "certified_set": lambda G, v: PUBLIC["certified_set"](G, ADAPTIVE).factor,
    "ClosedLoop": lambda G, v: rcac.ClosedLoop(G, LAW),
    "ClosedLoop.compensator": lambda G, v: rcac.ClosedLoop(OWN_PLANT, G),
    "LoopAnalysis": lambda G, v: PUBLIC["LoopAnalysis"]((G, LAW)).loop,
    "SimulationCase": lambda G, v: rcac.simulate_many(
        [rcac.SimulationCase(G, FIXED, W)])[0].z,
    "Simulator": lambda G, v: rcac.Simulator(G).output(u=np.zeros(1), w=np.zeros(1)),
    "simulate": lambda G, v: rcac.simulate(G, FIXED, W).z,
    "simulate_batch": lambda G, v: rcac.simulate_batch(G, FIXED, W[None]).z,
    "FixedController": lambda G, v: rcac.FixedController(G),
    "check_controller": lambda G, v: rcac.check_controller(Y, Y, compensator=LAW, plant=G).poles,
    "compare_exactly": lambda G, v: PUBLIC["compare_exactly"](G, LAW, TARGET).plant,
    "direction_information": lambda G, v: PUBLIC["direction_information"](G),
    "h2_cost": lambda G, v: rcac.h2_cost(G, LAW).value,
    "lqg_controller": lambda G, v: rcac.lqg_controller(G).compensator,
    "fir_target": lambda G, v: PUBLIC["fir_target"](G),
    "pole_placement_target": lambda G, v: PUBLIC["pole_placement_target"](G, ["1/2"]),
    "high_authority_target": lambda G, v: PUBLIC["high_authority_target"](G),
    "markov_parameters": lambda G, v: PUBLIC["markov_parameters"](G, 3),
    "markov_target": lambda G, v: PUBLIC["markov_target"](G, 3),
    "modelling_information": lambda G, v: PUBLIC["modelling_information"](G),
    "multivariable_disk_margin": lambda G, v: PUBLIC["multivariable_disk_margin"]((G, LAW)),
    "observer_forms": lambda G, v: PUBLIC["observer_forms"](
        G, "-0.3/(z - 0.1)").plant,
    "output_subspace_target": lambda G, v: PUBLIC["output_subspace_target"](G),
    "output_subspace_zeros": lambda G, v: PUBLIC["output_subspace_zeros"](G),
    "placement_conditioning": lambda G, v: PUBLIC["placement_conditioning"](
        G, ["1/2", "1/3", "1/4"], feedback=-1).exact,
    "plant_zeros": lambda G, v: PUBLIC["plant_zeros"](G),
    "simulate_reference": lambda G, v: PUBLIC["simulate_reference"](G, ADAPTIVE, W).u,
    "split_residual": lambda G, v: PUBLIC["split_residual"](
        G, LAW, TARGET, u=Y, y=Y, z=Y, w=Y),
    "target_model": lambda G, v: PUBLIC["target_model"](G),
    "transmission_zero_polynomial": lambda G, v: PUBLIC["transmission_zero_polynomial"](G),
    "with_bias": lambda G, v: PUBLIC["with_bias"](
        G, "w", pole=0.5, mean_square=1.0),
    "zero_direction_target": lambda G, v: PUBLIC["zero_direction_target"](G),
    "check_directions": lambda G, v: PUBLIC["check_directions"](TARGET, G),
    "plant_residual": lambda G, v: PUBLIC["plant_residual"](
        PUBLIC["ControllerLog"](Y, Y), G),
    "intercalated_match": lambda G, v: PUBLIC["intercalated_match"](G, TARGET),
    "critical_period": lambda G, v: PUBLIC["critical_period"](G, 0.1, 1.0),
    "sampling_zeros": lambda G, v: PUBLIC["sampling_zeros"](G, [0.1]),
    "load_run": lambda G, v: PUBLIC["load_run"]("no such file", plant=G),
}  # fmt: skip
