"""Estimation examples: the true system by hand, measures by hand, and files refused by name."""

import copy

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory import InputError
from rcac_experiments import FigureRequest, verify
from rcac_experiments.cli._main import main
from rcac_experiments.dissertation import load_example
from rcac_experiments.dissertation._examples import absent_examples, example_ids, read_example
from rcac_experiments.experiments._estimation_studies import MEASURES, EstimatedRun
from rcac_experiments.experiments._true_systems import TrueSystem
from rcac_experiments.files._builder import build
from rcac_numeric import Ramp
from rcac_numeric.estimation import refine
from tests.support.estimation_cases import relative_error
from tests.support.refinement_cases import spring

CHAPTER = [f"8.{i}" for i in range(1, 8)]


def test_chapter_8_is_all_here():
    result = [number for number in example_ids() if "estimation" in read_example(number)[0]]
    assert result == CHAPTER and not set(CHAPTER) & dict(absent_examples()).keys()


@given(seed=st.integers(0, 10_000))
def test_a_record_is_the_recursion(seed):
    """Matrices that move with the parameter, bias, noise and initial state, in plain NumPy."""
    rng = np.random.default_rng(seed)
    A, A_then = (0.4 * rng.standard_normal((3, 3)) for _ in range(2))
    D, D_then = rng.standard_normal((3, 2)), rng.standard_normal((3, 2))
    C, x_0 = rng.standard_normal((2, 3)), rng.standard_normal(3)
    truth = [(0, 1.0), (5, 1.0), (20, 3.0)]
    quiet, noisy = (
        TrueSystem(A, D, C, truth, A_then, D_then, Ramp(0.1), x_0=x_0, **noise).record(40, seed)
        for noise in ({}, {"bias": 0.5, "deviation": 0.1})
    )
    assert np.array_equal(quiet.truth, np.interp(np.arange(40), [5, 20], [1, 3]))
    x, y = x_0, []
    for k in range(40):
        part = (quiet.truth[k] - 1) / 2
        y.append(C @ x)
        x = ((1 - part) * A + part * A_then) @ x
        x = x + ((1 - part) * D + part * D_then) @ [0.1 * k, 0.1 * k]
    assert relative_error(quiet.y, np.array(y)) < 1e-12
    v = noisy.y - quiet.y
    assert abs(v.mean() - 0.5) < 0.06 and 0.07 < v.std() < 0.13


def test_example_8_2_is_the_spring_of_the_text():
    study = load_example("8.2").studies["RCMR"]
    record = study.system.record(600, 3)
    assert relative_error(record.y[:, 0], spring(record.truth, record.w[:, 0])) < 1e-12
    run = study.estimator.execute(study.system, 600, 3)
    assert np.array_equal(
        run.estimate, refine(study.estimator.model, record.w, record.y).theta[:, 0]
    )


RUN = EstimatedRun(
    np.array([1.0, 2, 4, 8]), np.array([2.0, 2, 2, 2]), np.array([[3.0], [-4], [1], [0]]), 0.25
)


@pytest.mark.parametrize(
    ("name", "arguments", "value"),
    [
        ("mean_error", {}, 9 / 4),
        ("mean_error", {"start": 2}, 4),
        ("median_error", {}, 1.5),
        ("mean_deviation", {"stop": 2}, -0.5),
        ("final_estimate", {}, 8),
        ("initial_estimate_left", {}, 0.25),
        ("largest_z", {}, 4),
        ("largest_z", {"start": 2, "stop": 99}, 1),
        ("completed", {}, 1),
    ],
)
def test_measures_by_hand(name, arguments, value):
    assert MEASURES[name](RUN, **arguments) == pytest.approx(value)


def test_every_measure_is_tested_and_an_empty_window_is_refused():
    with pytest.raises(InputError, match="the run has no step between start = 4"):
        MEASURES["mean_error"](RUN, start=4)


def test_no_verdict_is_typed_in():
    table = copy.deepcopy(read_example("8.3")[0])
    recorded = [claim.pop("verdict") for claim in table["claims"]]
    assert [v.verdict for v in verify(build(table, "8.3")).verdicts] == recorded
    table["claims"][0]["checks"][0]["at_most"] = 1.1
    assert verify(build(table, "8.3")).verdicts[0].verdict == "reproduced"


@pytest.fixture(scope="module")
def verification():
    return verify(load_example("8.3"))


@pytest.mark.parametrize("kind", ["estimates", "responses", "distribution"])
def test_figures(verification, kind):
    measure = "mean_error" if kind == "distribution" else ""
    (axis,) = verification.plot(FigureRequest(kind, "Seen.", measure=measure)).axes
    runs = len(verification.estimates)
    expected = {"estimates": runs + 1, "responses": runs, "distribution": 2 * runs}
    assert len(axis.lines) == expected[kind]


def test_what_it_is_not(verification):
    with pytest.raises(InputError, match="no figure of the kind 'poles'"):
        verification.plot(FigureRequest("poles", "None."))
    with pytest.raises(InputError, match=r"8\.3 estimates: no controller ran"):
        verification.main  # noqa: B018
    with pytest.raises(InputError, match=r"'8\.3' estimates: no controller"):
        verification.experiment.main_run  # noqa: B018
    with pytest.raises(InputError, match="no run estimates anything"):
        verify(load_example("2.2")).plot(FigureRequest("estimates", "None."))


@pytest.mark.costly
def test_the_command_and_its_page(tmp_path):
    page = tmp_path / "page.html"
    result = CliRunner().invoke(
        main, ["verify", "8.3", "--page", str(page), "--figures", str(tmp_path)]
    )
    assert result.exit_code == 0, result.output
    assert "the data do not determine the parameter" in result.output
    assert "true final" in result.output and "0.9000" in result.output
    assert page.read_text().count("<svg") == 2 == len(list(tmp_path.glob("8.3-*.svg")))


TABLE = {
    "estimation": {"A": [[0.5]], "D_1": [1], "C": [1], "truth": [[0, 0.5]], "steps": 50},
    "estimator": {"kind": "rcmr", "A": [[0.0]], "D_1": [1], "C": [1], "B": [1], "E_1": [1],
                  "delays": [1]},
    "runs": [{"name": "main"}],
    "claims": [{"text": "found", "checks": [{"measure": "final_estimate", "at_most": 1}]}],
}  # fmt: skip


def changed(**changes):
    table = copy.deepcopy(TABLE)
    for path, value in changes.items():
        *inner, last = path.split("__")
        there = table
        for key in inner:
            there = there[int(key)] if key.isdigit() else there[key]
        there[last] = value
    return table


def test_a_file_of_ones_own():
    (verdict,) = verify(build(TABLE, "own.toml")).verdicts
    assert verdict.verdict == "holds"
    assert verdict.results[0].values[0] == pytest.approx(0.5, abs=0.03)


def test_a_loop_that_diverges_has_no_value_and_no_claim_holds():
    """A free-running model with a large initial gain leaves float64."""
    table = changed(estimator__theta_0=50.0, estimator__k_update=10_000, estimation__steps=500)
    (verdict,) = verify(build(table, "own.toml")).verdicts
    assert np.isnan(verdict.results[0].values[0]) and verdict.verdict == "does not hold"


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"estimation__A": [[1, 2]]}, "A has shape"),
        ({"estimation__truth": [[1, 2]]}, "must begin at step 0"),
        ({"estimation__truth": []}, "truth"),
        ({"estimation__A_then": [[0.2]]}, "the last value of truth is its first"),
        ({"estimation__deviation": -1}, "cannot be negative"),
        ({"estimation__w": {"white": 1}}, "is not an excitation"),
        ({"estimation__stepz": 3}, "unknown key 'stepz'.*Did you mean 'steps'"),
        ({"estimation__steps": 10**8}, "the runs need"),
        ({"estimator__kind": "rcrm"}, "Did you mean 'rcmr'"),
        ({"estimator__Q": 1}, "does not read"),
        ({"estimator__E_1": [[1], [1]]}, "theta_0 has 1 entries where 2"),
        ({"runs": []}, "runs"),
        ({"runs": [{"name": "a"}, {"name": "a"}]}, "two runs have the name 'a'"),
        ({"runs": [{"name": "a", "like": "b"}]}, "refers to the run 'b'"),
        ({"claims__0__checks__0__measure": "margin"}, "measure = 'margin' must be one of"),
        ({"claims__0__run": "mian"}, "Did you mean 'main'"),
        ({"figures": [{"kind": "poles", "caption": "no"}]}, "kind = 'poles' must be one of"),
        ({"plant": {"A": 1}}, "unknown key 'plant'"),
    ],
)
def test_bad_files_are_refused_by_name(changes, says):
    with pytest.raises(InputError, match=f"(?s)own.toml.*{says}"):
        build(changed(**changes), "own.toml")
