"""What an experiment file without a run says of a log: the door of rcac check --plant."""

import pytest

from compensator_theory.errors import CompensatorError, InputError
from rcac_experiments import check_arguments, load_experiment
from rcac_experiments.dissertation import load_example
from rcac_numeric import check_controller, iir, read_log

CASE = "examples/octave/example_4_7.toml"


def test_the_file_of_the_octave_log_says_what_the_numbered_example_says():
    run = load_example("4.7").main_run
    report = check_arguments(CASE)
    assert report["plant"] == run.plant and report["target"] == run.settings.target
    assert report["structure"] == iir(n_c=4) and report["k_w"] == run.settings.k_w
    check = check_controller(read_log("examples/octave/rcac_loop.mat"), **report)
    assert check.is_consistent and check.replay.start == 50


def test_what_wants_a_run_names_the_door_that_needs_none():
    with pytest.raises(InputError, match=r"the table \[run\].*'steps'.*check_arguments"):
        load_experiment(CASE)


def test_a_file_with_a_plant_alone(tmp_path):
    file = tmp_path / "plant.toml"
    file.write_text('[plant]\nproblem = "standard"\nG = "1/(q - 0.5)"\n')
    report = check_arguments(file)
    assert report["plant"].n == 1
    assert report["structure"] is report["target"] is report["k_w"] is None


@pytest.mark.parametrize(
    "words",
    ['[plnt]', '[controller]\nn_c = 2', '[plant]\nproblem = "standard"\nG = "1/(q - "',
     '[plant]\nproblem = "standard"\nG = "1/(q - 0.5)"\n[controller]\nn_c = -1',
     '[plant]\nproblem = "standard"\nG = "1/(q - 0.5)"\n[target]\nmodel = "none"'],
)  # fmt: skip
def test_refusals_name_the_file(tmp_path, words):
    file = tmp_path / "case.toml"
    file.write_text(words + "\n")
    with pytest.raises(CompensatorError, match=r"case\.toml"):
        check_arguments(file)
