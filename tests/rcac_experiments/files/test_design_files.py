"""The experiment file of a design says what the design says, and a design reads such files."""

import numpy as np
import pytest
from scipy.signal import lfilter

import rcac_numeric as rn
from compensator_theory.errors import InputError, PrecisionError
from rcac_experiments import load_experiment
from rcac_experiments.files import _design_files as files
from rcac_experiments.files._builder import build
from rcac_experiments.files._design_files import design_arguments, design_toml, save_design
from rcac_experiments.files._documents import parsed
from rcac_numeric.arrays._values import equal, replaced
from rcac_numeric.designing._trials import RCAC

QUICK = {"seeds": 1, "steps": 300}
STRUCTURE = rn.Structure(
    [rn.Tap("y", 0, 1), rn.Tap("y", 0, 3), rn.Tap("derived", 0, 1)], 1, 1,
    derived=[rn.DerivedSignal((1.0,), (0.0,), 0.9)],
)  # fmt: skip


def load_of(designed):
    return build(parsed(design_toml(designed)), "design.toml")


@pytest.mark.costly
@pytest.mark.parametrize(
    "arguments",
    [
        {"disturbance": rn.Step(0.5), "noise": 0.01},
        {
            "disturbance": rn.Harmonic(0.3, 0.5, 0.1) + rn.WhiteNoise(0.1),
            "command": 2 * rn.Step(1.0),
        },
        {"u_limits": rn.Saturation(low=-1.0, high=2.0, rate=0.5)},
        {"disturbance": 0.3, "command": rn.Levels([1.0, -1.0], hold=50)},
        {"disturbance": 0.5, "noise": 0.02, "kept": "certified"},
    ],
)
def test_the_file_says_the_same(arguments, tmp_path):
    designed = rn.design("1/(8*s + 1)", sample_time=0.5, dead_time=0.5, **QUICK, **arguments)
    path = tmp_path / "tuned.toml"
    save_design(designed, path)
    experiment = load_experiment(path)
    run = experiment.runs[RCAC]
    assert equal(run.settings, designed.settings)
    assert np.array_equal(run.plant.A, designed.plant.A) and run.plant.sample_time == 0.5
    assert experiment.main_run.name == ("RCAC" if designed.verdict.use == RCAC else "fixed")
    assert np.allclose(run.cases()[0].w, designed.expected.w(300, run.seed))
    assert equal(run.saturation, designed.saturation)
    assert path.read_text(encoding="utf-8").startswith(f"# {designed.verdict}")


def test_the_file_of_a_design_that_is_kept_in_an_ellipsoid_says_so():
    designed = rn.design("1/(8*s + 1)", sample_time=0.5, **QUICK)
    theta_0 = designed.settings.theta_0
    factor = 0.1 * np.eye(len(theta_0)) + 0.01 * np.tri(len(theta_0))
    bounded = replaced(designed.settings, bounds=rn.CertifiedBounds(theta_0, factor))
    experiment = load_of(replaced(designed, settings=bounded))
    assert equal(experiment.runs[RCAC].settings, bounded)


def test_a_file_is_read_for_a_design(tmp_path):
    file = tmp_path / "plant.toml"
    file.write_text(
        '[plant]\nproblem = "servo"\nG = "1/(8*s + 1)"\nsample_time = 0.5\n[signals]\n'
        "r = 1\nd = { step = 0.3 }\nv = { white_noise = 0.02 }\n[saturation]\nlow = -1\nhigh = 1\n"
    )
    designed = rn.design(**design_arguments(file), **QUICK)
    assert designed.model.continuous is not None and designed.plant.sample_time == 0.5
    assert (designed.expected.noise, designed.expected.disturbance.height) == (0.02, 0.3)
    assert {question.name for question in designed.questions} == {"plant", "dead_time"}
    file.write_text('[plant]\nproblem = "servo"\nG = "1/(q - 0.5)"\n[signals]\nv = { step = 1 }\n')
    with pytest.raises(InputError, match="white"):
        design_arguments(file)


def test_a_file_whose_signals_are_not_those_of_the_design_is_not_handed_out(monkeypatch):
    designed = rn.design("1/(q - 0.9)", disturbance=rn.Step(1.0), noise=0.1, **QUICK)
    monkeypatch.setattr(files, "_signal", lambda *_: "{ step = 2.0 }")
    with pytest.raises(PrecisionError, match="cannot represent this design exactly"):
        design_toml(designed)


def test_a_signal_that_is_longer_than_a_file_is_refused_by_name():
    with pytest.raises(InputError, match="a file holds at most 2000 values"):
        files._signal(rn.Levels([0.0, 1.0], hold=900), 3000)


def test_the_file_of_a_design_from_a_log_has_both_controllers(tmp_path):
    u = np.random.default_rng(4).standard_normal(1500)
    y = lfilter([0, 0, -0.1], [1, -0.9], u)
    y += 0.05 * np.random.default_rng(5).standard_normal(1500)
    save_design(rn.design(rn.ControllerLog(u, y), **QUICK), tmp_path / "log.toml")
    assert set(load_experiment(tmp_path / "log.toml").runs) == {"RCAC", "fixed"}


@pytest.mark.costly
@pytest.mark.parametrize(
    "options",
    [
        {"structure": rn.pid("DI")},
        {"structure": rn.fir(6)},
        {"structure": rn.fir_integrator(5)},
        {"structure": STRUCTURE},
        {"command": rn.Step(1.0), "feedforward": True},
    ],
    ids=["DI", "FIR", "FIR and integrator", "taps", "feedforward"],
)
def test_the_file_of_a_design_of_a_structure_says_the_same(options):
    G = "1/((20*s + 1)*(3*s + 1))"
    designed = rn.design(G, sample_time=1.0, disturbance=0.5, noise=0.01, **QUICK, **options)
    read = load_of(designed)
    assert equal(read.runs[RCAC].settings, designed.settings)
    assert equal(read.runs["fixed"].settings, designed.frozen)
