"""Signals and target models of experiment files."""

import numpy as np
import pytest

from compensator_theory import InputError
from rcac_experiments import load_experiment
from rcac_experiments.files._builder import build
from rcac_numeric import DataDriven, Plant, servo_plant, standard_plant
from rcac_numeric.targets import high_authority_target, markov_target, output_subspace_target

G = "(q - 1.2)/((q - 0.5)*(q - 0.2))"


def experiment(tmp_path, target, signals="", problem="standard", plant=f'G = "{G}"', steps=20):
    path = tmp_path / "case.toml"
    path.write_text(
        f'[plant]\nproblem = "{problem}"\n{plant}\n[signals]\n{signals}\n[target]\n{target}\n'
        f"[controller]\nn_c = 2\nk_w = 8\nR_theta = 1\n[run]\nsteps = {steps}\n"
    )
    return load_experiment(path).main_run


def test_markov(tmp_path):
    run = experiment(tmp_path, 'model = "markov"\nn_bar = 5')
    expected = markov_target(standard_plant(G), 5)
    assert np.array_equal(run.settings.target.numerator, expected.numerator)
    argument = 'model = "markov"\nmarkov_parameters = [0.0, -1.0, 0.5]'
    run = experiment(tmp_path, argument, problem="servo")
    assert run.settings.target.numerator.ravel().tolist() == [0, -1, 0.5]


def test_high_authority(tmp_path):
    target = experiment(tmp_path, 'model = "high authority"').settings.target
    assert target.exact == high_authority_target(standard_plant(G)).exact


def test_output_subspace(tmp_path):
    matrices = {"A": [[0.5, 0.0], [0.0, 0.9]], "B": [[1.0], [2.0]], "C": [[1.0, 0.0], [0.0, 1.0]]}
    text = "\n".join(f"{name} = {value}" for name, value in matrices.items()) + "\nD_1 = [[1], [0]]"
    target = experiment(tmp_path, 'model = "output subspace"', plant=text).settings.target
    expected = output_subspace_target(Plant(**matrices, D_1=[[1], [0]]))
    assert np.array_equal(target.numerator, expected.numerator)


def test_every_model_runs(tmp_path):
    for target in ('model = "markov"\nn_bar = 5', 'model = "high authority"'):
        run = experiment(tmp_path, target, "w = { white_noise = 0.1 }")
        assert run.execute().repetitions[0].run.outcome == "completed"


def test_signals_of_a_file(tmp_path):
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "flight.csv").write_text(
        "r,d\n" + "\n".join(f"{k},{-k}" for k in range(9))
    )
    signals = (
        "r = { sum = [{ ramp = 0.5, start = 3 }, "
        '{ recorded = "data/flight.csv", column = "d" }] }\n'
        "d = { pulse = 2, start = 1, length = 3 }\n"
        f"v = {{ recorded = {[0.25] * 9} }}"
    )
    run = experiment(tmp_path, 'model = "fir"', signals, problem="servo", steps=9)
    k = np.arange(9)
    assert run.signals[0].samples(9) == pytest.approx(0.5 * np.maximum(k - 3, 0) - k)
    assert run.signals[1].samples(9).tolist() == [0, 2, 2, 2, 0, 0, 0, 0, 0]
    assert run.signals[2].samples(9).tolist() == [0.25] * 9


FIR = 'model = "fir"'


@pytest.mark.parametrize(
    ("target", "signals", "message"),
    [
        ('model = "markov"', "", r"\[target\] needs the key 'markov_parameters', or instead n_bar"),
        ('model = "markov"\nn_bar = 0', "", "relative degree d_zu = 1"),
        ('model = "markov"\nmarkov_parameters = [0, 0, 1.0]', "", "has relative degree 2"),
        ('model = "markov"\nH = 1', "", "'H', which model = \"markov\" does not read"),
        ('model = "high authority"\npoles = []', "", 'which model = "high authority"'),
        ('model = "filter"\nG_f = "1/(q - 2)"', "", "1 pole outside the unit circle"),
        (FIR, 'w = { recorded = "no.csv" }', "no.csv cannot be read"),
        (FIR, "w = { recorded = [1, 2] }", "known for 2 steps, but 20 are requested"),
        (FIR, "w = { recorded = [1, 2], column = 1 }", "column is for a file"),
        (FIR, "w = { recorded = [1, 2], hold = 1 }", r"unknown key 'hold' in .signals.w."),
        (FIR, "w = { recorded = 3 }", "a record needs shape"),
        (FIR, "w = { ramp = true }", "ramp must be a real number"),
        (FIR, "w = { pulse = 1, width = 2 }", r"unknown key 'width' in .signals.w."),
    ],
)
def test_bad_files_are_named(tmp_path, target, signals, message):
    with pytest.raises(InputError, match=message) as caught:
        experiment(tmp_path, target, signals)
    assert str(caught.value).startswith(str(tmp_path / "case.toml"))


def test_high_authority_refuses_the_servo_problem(tmp_path):
    assert servo_plant(G).l_w == 3
    with pytest.raises(InputError, match="scalar u, w, y and z"):
        experiment(tmp_path, 'model = "high authority"', problem="servo")


def test_the_input_of_a_model_from_data_is_said_and_why_not_another():
    """The two inputs are the schema's; asking for the literal one gives the reason."""
    table = {
        "plant": {"problem": "standard", "G": "(q - 1.5)/(q*(q - 0.5))"},
        "signals": {"w": {"white_noise": 0.01}},
        "target": {"model": "data driven", "order": 9, "start": 100, "input": "frozen u~", "n": 2},
        "controller": {"n_c": 6, "R_theta": 0.5},
        "run": {"steps": 300},
    }
    settings = build(table, "case").main_run.settings
    assert settings.learning == DataDriven(order=9, start=100, input="frozen u~", n=2)
    table["target"]["input"] = "literal u~"
    with pytest.raises(InputError, match="fades as theta converges"):
        build(table, "case")
    table["target"]["input"] = "frozen u"
    with pytest.raises(InputError, match=r"must be one of u, frozen u~.*Did you mean"):
        build(table, "case")
