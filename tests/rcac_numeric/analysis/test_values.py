"""Targets, loops, margins and costs are values: equal by content, pickled to equal objects."""

import pickle
import subprocess
import sys
from dataclasses import fields, is_dataclass

import numpy as np
import pytest

from rcac_numeric import (
    ClosedLoop,
    Compensator,
    ModellingInformation,
    Plant,
    TargetModel,
    compare_exactly,
    fir_target,
    h2_cost,
    intercalated_match,
    lqg_controller,
    multivariable_disk_margin,
    observer_forms,
    placement_conditioning,
    pole_placement_target,
    solve_riccati,
    split_residual,
    stability_margins,
    standard_plant,
    target_model,
)
from rcac_numeric.analysis._internal_models import drift_of, internal_models
from rcac_numeric.analysis._loop_costs import loop_costs
from rcac_numeric.analysis._noise import noise_inputs
from rcac_numeric.arrays._values import replaced as replace
from rcac_numeric.identification import eigensystem_realisation, identify_markov_parameters
from rcac_numeric.targets import output_subspace_zeros

PLANT = standard_plant("1/(q - 2)")
COMPENSATOR = Compensator(past_u=[[[-1.0]]], past_y=[[[0.0]], [[-2.5]]])
LOOP = ClosedLoop(PLANT, COMPENSATOR)
TALL = Plant(A=np.diag([0.5, 0.9]), B=[[1.0], [2.0]], D_1=[[1.0], [0.0]], C=np.eye(2))
SIGNALS = dict(zip("uyzw", np.random.default_rng(0).standard_normal((4, 30, 1)), strict=True))

MAKERS = {
    "ModellingInformation": lambda: ModellingInformation(1, "3/2", ["6/5", 1.5]),
    "TargetModel": lambda: TargetModel([0.0, 2.0], [1.0, -0.5]),
    "exact target": lambda: target_model("(q - 2)/(q**2 - 1/4)"),
    "fir_target": lambda: fir_target(PLANT),
    "OutputSubspaceZeros": lambda: output_subspace_zeros(TALL),
    "EigensystemRealisation": lambda: eigensystem_realisation([0, 1, 0.5, 0.25, 0.125]),
    "IdentifiedMarkovParameters": lambda: identify_markov_parameters(
        SIGNALS["u"], SIGNALS["y"], mu=2, n_mod=1
    ),
    "IntercalatedMatch": lambda: intercalated_match(LOOP, fir_target(PLANT), 9),
    "ResidualSplit": lambda: split_residual(PLANT, COMPENSATOR, fir_target(PLANT), **SIGNALS),
    "Drift": lambda: drift_of(np.ones((9, 2))),
    "NumericObserverForms": lambda: observer_forms("1/s**2", "-(4*s + 2)/(s**2 + 4*s + 5)"),
    "PlacementConditioning": lambda: placement_conditioning("1/(s - 1)", [-1, -2], feedback=-1),
    "InternalModel": lambda: internal_models(Compensator([[[1.0]]], [[[0.0]], [[-0.5]]]), None)[0],
    "Margins": lambda: stability_margins(LOOP),
    "DiskMargin": lambda: multivariable_disk_margin(LOOP),  # with a radius that is NaN
    "H2Cost": lambda: h2_cost(PLANT, COMPENSATOR),
    "LoopCosts": lambda: loop_costs(LOOP),
    "StabilisingSolution": lambda: solve_riccati(
        [[2.0]], [[1.0]], [[1.0]], [[1.0]], time="discrete"
    ),
    "NoiseInputs": lambda: noise_inputs(PLANT, {"w": 2.0}),
    "ClosedLoop": lambda: ClosedLoop(PLANT, COMPENSATOR),
    "ExactComparison": lambda: compare_exactly(
        PLANT, COMPENSATOR, pole_placement_target(PLANT, ["1/2", "1/4"])
    ),
    "LQG": lambda: lqg_controller(PLANT, noise={"w": 1.0}),
    "ExactAgreement": lambda: lqg_controller(PLANT).agreement,
}
values = pytest.mark.parametrize("name", MAKERS)


@values
def test_equal_by_content_and_pickled_to_an_equal_object(name):
    value, again = MAKERS[name](), MAKERS[name]()
    assert value == again and hash(value) == hash(again)
    copy = pickle.loads(pickle.dumps(value))
    assert copy == value and type(copy) is type(value) and hash(copy) == hash(value)


@values
def test_a_field_that_differs_makes_a_difference(name):
    value = MAKERS[name]()
    changed = 0
    for field in fields(value):
        remaining = getattr(value, field.name)
        if isinstance(remaining, np.ndarray) and remaining.size and remaining.dtype.kind in "fc":
            other = remaining.copy()
            other.flat[-1] += 1.0
        elif isinstance(remaining, bool) or not isinstance(remaining, int | float):
            continue
        else:
            other = remaining + 1 if np.isfinite(remaining) else 7.0
        twin = pickle.loads(pickle.dumps(value))
        object.__setattr__(twin, field.name, other)
        assert twin != value, field.name
        changed += 1
    assert changed or not any(
        isinstance(getattr(value, f.name), np.ndarray | int | float) for f in fields(value)
    )


@pytest.mark.parametrize("name", ["ModellingInformation", "TargetModel", "exact target"])
def test_what_reads_its_arguments_can_be_replaced(name):
    value = MAKERS[name]()
    assert is_dataclass(value) and replace(value) == value
    if name == "ModellingInformation":
        assert replace(value, H=2).H == 2
        assert replace(value, nmp_zeros=[]).nmp_zeros == ()
    else:
        assert replace(value, numerator=[0.0, 0.0, 3.0], exact=None).relative_degree == 2


@pytest.mark.costly
def test_in_a_fresh_process():
    built = {name: make() for name, make in MAKERS.items()}
    code = "import sys, pickle as p; sys.stdout.buffer.write(p.dumps(p.load(sys.stdin.buffer)))"
    done = subprocess.run(
        [sys.executable, "-c", code], input=pickle.dumps(built), capture_output=True, check=True
    )
    assert pickle.loads(done.stdout) == built
