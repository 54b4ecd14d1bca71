"""Experiment files whose controller is predictive cost adaptive control."""

import copy
import tomllib
from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from click.testing import CliRunner

from compensator_theory import InputError
from rcac_experiments import ExperimentBudget, check_arguments, json_schema, load_experiment, verify
from rcac_experiments.cli._main import main
from rcac_experiments.explorer._case import case_of
from rcac_experiments.files._builder import build
from rcac_experiments.sweeps import Axis, Metric, Study, run_study
from rcac_experiments.sweeps._cells import Cells
from rcac_experiments.sweeps._worker import run_in_full
from rcac_numeric import (
    ControlLimits,
    PredictiveCost,
    Step,
    exogenous,
    load_run,
    predictive_cost_limit,
    simulate,
)
from rcac_numeric.export._tables import core_tables

EXAMPLE = Path(__file__).resolve().parents[3] / "examples" / "predictive_cost.toml"
TABLE = {
    "plant": {"problem": "servo", "G": "(q - 13/10)/(q**2 - 7/5*q + 3/10)"},
    "signals": {"r": {"step": 1}},
    "controller": {
        "structure": "predictive cost", "order": 2, "horizon": 20, "Q": 2, "P": 5,
        "problem": "servo", "R_theta": 1e-6, "limits": {"low": -5, "high": 5},
    },
    "run": {"steps": 60},
}  # fmt: skip
TARGET = {"model": "pole placement", "poles": ["1/2"]}
VALIDATOR = jsonschema.Draft202012Validator(json_schema())


def table(**changes):
    return copy.deepcopy(TABLE) | changes


def controller(**keys):
    return table(controller={**TABLE["controller"], **keys})


def test_a_file_runs_what_simulate_runs():
    specification = build(table(), "case").main_run
    settings = PredictiveCost(
        2, 20, Q=2, P=5, problem="servo", R_theta=1e-6, limits=ControlLimits(low=-5, high=5)
    )
    assert specification.settings == settings and specification.algorithm == "predictive cost"
    run = specification.execute().first.run
    w = exogenous([Step(), Step(0), Step(0)], 60)
    expected = simulate(specification.plant, settings, w)
    for name in ("u", "y", "z", "theta"):
        assert np.array_equal(getattr(run, name), getattr(expected, name))


def test_seeds_and_perturbations_are_runs_of_their_own():
    noisy = table(signals={"r": 1, "v": {"white_noise": 0.01}}, run={"steps": 30, "seeds": 3})
    runs = [one.run for one in build(noisy, "case").main_run.execute().repetitions]
    assert len({run.z.tobytes() for run in runs}) == 3


def test_every_setting_is_a_key():
    keys = {
        "weighs": "u", "R": 0.5, "lambda": 0.99, "theta_0": [0.0, 1.0, 0.0, 0.0],
        "limits": {"low": -1, "high": 2, "rise": 0.5, "fall": 0.25},
        "limited_by": "least squares",
    }  # fmt: skip
    settings = build(controller(**keys), "case").main_run.settings
    assert settings == PredictiveCost(
        2, 20, Q=2, P=5, R=0.5, weighs="u", problem="servo", R_theta=1e-6, lambda_=0.99,
        theta_0=[0, 1, 0, 0], limits=ControlLimits(-1, 2, 0.5, 0.25), limited_by="least squares",
    )  # fmt: skip
    assert not list(VALIDATOR.iter_errors(controller(**keys)))


def test_sizes_are_those_of_the_plant():
    matrices = {"problem": "standard", "A": [[0.5, 0.1], [0, 0.3]], "B": [[1, 0], [0, 1]],
                "D_1": [[1], [1]], "C": [[1, 0], [0, 1]]}  # fmt: skip
    case = table(plant=matrices, signals={"w": [0.1]})
    case["controller"] |= {"problem": "standard", "limits": {"low": -5}}
    settings = build(case, "case").main_run.settings
    assert (settings.l_u, settings.l_y, settings.l_theta) == (2, 2, 16)


def test_a_target_model_is_the_reference_of_the_comparison_and_not_needed():
    assert build(table(), "case").main_run.target is None
    beside = build(table(target=TARGET), "case").main_run
    assert beside.target is not None and beside.settings == build(table(), "case").main_run.settings
    rcac = {"structure": "iir", "n_c": 3, "R_theta": 1e-4}
    runs = [{"name": "RCAC"}, {"name": "PCAC", "controller": TABLE["controller"]}]
    both = build(table(target=TARGET, controller=rcac, runs=runs), "case")
    assert [run.algorithm for run in both.runs.values()] == ["ud", "predictive cost"]
    pid = {"name": "PID", "controller": {"structure": "pid"}}
    assert build(table(target=TARGET, controller=rcac, runs=[pid]), "case").main_run.settings
    with pytest.raises(InputError, match=r"table \[target\]"):
        build(table(controller=rcac), "case")


@pytest.mark.parametrize(
    ("case", "words"),
    [
        (controller(n_c=3), "sets 'n_c', which structure = \"predictive cost\" does not read"),
        (controller(order=0), "order"),
        (controller(horizn=3), "Did you mean 'horizon'"),
        (controller(problem="both"), "problem"),
        (controller(limited_by="least squares", limits={"low": 1, "high": 0}), "exceeds high"),
        (controller(theta_0=0), "theta_0 has b = 0"),
        (controller(update="ud"), "sets 'update'"),
        (table(run={"steps": 60, "arithmetic": "reference"}), "the reference runs one adaptive"),
        (table(run={"steps": 60, "arithmetic": "ud"}), "does not read"),
        (table(saturation={"low": -1, "high": 1}), r"Remove \[saturation\]"),
        (table(controllers=[TABLE["controller"]], target=TARGET), "structure"),
    ],
)
def test_what_makes_no_sense_is_refused_by_name(case, words):
    with pytest.raises(InputError, match=words):
        build(case, "case")


@pytest.mark.parametrize(
    "case",
    [
        controller(n_c=3),
        controller(limited_by="both"),
        table(controller={"structure": "predictive cost", "order": 2}),
        table(controller={"structure": "iir", "n_c": 2, "R_theta": 1}),
    ],
)
def test_the_schema_refuses_it_too(case):
    assert not list(VALIDATOR.iter_errors(table()))
    assert list(VALIDATOR.iter_errors(case))
    with pytest.raises(InputError):
        build(case, "case")


def test_a_long_horizon_counts_for_the_budget():
    long = controller(horizon=1000)
    long["run"] = {"steps": 100_000}
    with pytest.raises(InputError, match="operations"):
        build(long, "case")
    with pytest.raises(InputError, match="bytes"):
        build(controller(order=100), "case", ExperimentBudget(memory=1e5))


def test_export_and_explorer_refuse_it_by_name():
    with pytest.raises(InputError, match="a PredictiveCost cannot be exported"):
        core_tables(build(table(), "case").main_run.settings)
    with pytest.raises(InputError, match="no control for a PredictiveCost"):
        case_of(table(), "case")


@pytest.mark.costly
def test_a_study_runs_each_case_as_simulate_does(tmp_path):
    axis = Axis("horizon", [10, 20], sets="controller.horizon")
    study = Study(table(), [axis], [Metric("rms"), Metric("limit_pole_distance")])
    cells = Cells(study)
    for horizon in axis.values:
        run = run_in_full(cells, {"horizon": horizon}, 0).run
        alone = build(controller(horizon=horizon), "case").main_run.execute().first.run
        assert np.array_equal(run.z, alone.z)
    result = run_study(study, tmp_path / "study", workers=0)
    assert result.failed == 0 and result.done == 2


@pytest.mark.costly
def test_the_published_plants_are_judged_and_saved(tmp_path):
    verification = verify(load_experiment(EXAMPLE))
    assert verification.exit_status == 0
    assert {verdict.verdict for verdict in verification.verdicts} == {"holds"}
    run = verification.main_loop.run
    assert str(predictive_cost_limit(run)).splitlines()[0] in verification.report()
    file = tmp_path / "run.npz"
    done = CliRunner().invoke(main, ["verify", str(EXAMPLE), "--save", str(file), "--json"])
    assert done.exit_code == 0, done.output
    assert load_run(file).settings == run.settings
    tables = tomllib.loads(EXAMPLE.read_text())
    assert not list(VALIDATOR.iter_errors(tables))


@pytest.mark.parametrize("structure", ["predictive cost", "lqg"])
def test_a_log_of_signals_alone_is_not_replayed(structure, tmp_path):
    """The error names the controller, and the saved run, which can be checked."""
    file = tmp_path / "case.toml"
    file.write_text(
        '[plant]\nproblem = "servo"\nG = "1/(q - 9/10)"\n[controller]\n'
        f'structure = "{structure}"\n' + "order = 1\nhorizon = 5\n" * (structure != "lqg")
    )
    with pytest.raises(InputError, match=f"{structure}.*saved run"):
        check_arguments(file)


def test_a_saved_run_is_checked_from_the_command_line(tmp_path):
    run = build(table(), "case").main_run.execute().first.run
    run.save(tmp_path / "run.npz")
    result = CliRunner().invoke(main, ["check", str(tmp_path / "run.npz")])
    assert result.exit_code != 1 and "u is the output of" in result.output
    run = replace(run, u=run.u * np.where(np.arange(run.steps)[:, None] == 30, 1.01, 1))
    run.save(tmp_path / "changed.npz")
    assert CliRunner().invoke(main, ["check", str(tmp_path / "changed.npz")]).exit_code == 1
