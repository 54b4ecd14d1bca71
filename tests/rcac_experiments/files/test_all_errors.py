"""Everything that is wrong with a file is said at once, each error with its table and its run."""

import copy
from fractions import Fraction

import pytest

from compensator_theory import InputError
from rcac_experiments import load_experiment
from rcac_experiments.files._builder import build

CASE = {
    "plant": {"problem": "servo", "G": "(q - 0.5)/((q - 0.9)*(q - 0.3))"},
    "signals": {"r": 1},
    "target": {"model": "fir"},
    "controller": {"n_c": 3, "R_theta": 0.1},
    "run": {"steps": 100},
}


def messages_of(**tables):
    """What is said of CASE with the entries of some tables added."""
    table = copy.deepcopy(CASE)
    for name, entries in tables.items():
        table[name] = {**table.get(name, {}), **entries} if isinstance(entries, dict) else entries
    with pytest.raises(InputError) as error:
        build(table, "case.toml")
    return str(error.value)


def lines_of(text):
    head, *lines = text.splitlines()
    assert head == f"case.toml: {len(lines)} errors."
    return [line.partition(". ")[2] for line in lines]


def test_errors_of_every_table_are_said_in_one_go():
    lines = lines_of(
        messages_of(
            plant={"sample_tiem": 0.1},
            signals={"d": {"pulse": 1, "length": 0}},
            target={"poles": []},
            controller={"lambda": 2, "terms": "PI"},
            saturation={"low": 1, "high": -1},
            run={"steps": 0, "seed": "x"},
            figures=[{"kind": "pole", "caption": "c"}],
        )
    )
    expected = [
        "unknown key 'sample_tiem' in [plant]",
        "[signals.d]: length = 0 must be at least 1",
        "[controller] lambda = 2.0 is not in (0, 1]",
        "[run] steps = 0 must be at least 1",
        "[run] seed must be an integer, not 'x'",
        "[figures] kind = 'pole' must be one of",
        "[target] sets 'poles', which model = \"fir\" does not read",
        "[controller] sets 'terms', which structure = \"iir\" does not read",
        "[saturation]: low = [1.] exceeds high = [-1.]",
    ]
    for part in expected:
        assert sum(line.startswith(part) for line in lines) == 1, part
    assert len(lines) == len(expected), "what only one table says is not said of another"


def test_each_run_is_named_and_what_runs_share_is_said_once():
    runs = [
        {"name": "a", "run": {"sed": 1}},
        {"name": "b", "controller": {"structure": "pid", "n_c": 4}, "signals": {"r": {"stpe": 1}}},
    ]
    lines = lines_of(messages_of(runs=runs, target={"poles": []}))
    assert [line.partition(".")[0] for line in lines[:2]] == [
        "unknown key 'sed' in [runs",
        "[runs",
    ]
    assert "[runs.run] of run 'a'" in lines[0]
    assert lines[1].startswith("[runs.signals] of run 'b' r = {'stpe': 1} is not a signal")
    assert lines[2].startswith("[target] sets 'poles'"), "once, though both runs take it"
    assert lines[3].startswith("[controller] of run 'b' sets 'n_c'")
    assert len(lines) == 4


def test_a_run_without_a_name_has_its_number():
    text = messages_of(runs=[{"name": "a"}, {"run": {"seed": 0.5}}])
    assert "[runs.run] no. 2 seed must be an integer" in text
    assert "[runs] no. 2 needs the key 'name'" in text


def test_runs_that_cannot_be_made_are_said_together():
    runs = [{"name": "a", "controller": {"k_w": 1}}, {"name": "b", "run": {"x_0": [1, 2, 3]}}]
    first, second = lines_of(messages_of(runs=runs))
    assert first.startswith("run 'a': k_w = 1 is shorter than")
    assert second.startswith("run 'b': x_0 has 3 entries")


def test_a_misspelt_key_is_no_missing_one_too():
    text = messages_of(controller={"R_teta": 1, "R_theta": 1})
    assert "unknown key 'R_teta'" in text and "errors." not in text
    table = copy.deepcopy(CASE)
    table["run"] = {"stesp": 100}
    with pytest.raises(InputError) as error:
        build(table, "case.toml")
    assert "unknown key 'stesp' in [run]" in str(error.value)
    assert "needs the key" not in str(error.value)


def test_many_errors_have_a_length_that_a_reader_can_bear():
    runs = [{"name": f"r{i}", "run": {f"seed_{i}": 1}} for i in range(200)]
    text = messages_of(runs=runs)
    assert text.startswith("case.toml: 200 errors.") and len(text) < 1500
    assert text.splitlines()[-1].startswith("... and ") and text.endswith(" more.")


@pytest.mark.parametrize("digits", ["0.10000000000000000555", "0.1", "1e-30", "12345.678"])
def test_a_number_of_a_matrix_is_the_decimal_that_was_written(digits, tmp_path):
    file = tmp_path / "case.toml"
    file.write_text(
        f"""
        [plant]
        problem = "standard"
        A = [[{digits}]]
        B = [[1]]
        D_1 = [[1]]
        C = [[1]]
        [target]
        model = "fir"
        H = 1
        d_zu = 1
        [controller]
        n_c = 1
        R_theta = {digits}
        [run]
        steps = 10
        """
    )
    run = load_experiment(file).main_run
    assert Fraction(str(run.plant.exact.A[0, 0])) == Fraction(digits)
    assert run.plant.A[0, 0] == float(digits), "rounded once"
    assert run.settings.update.R_theta == float(digits)
