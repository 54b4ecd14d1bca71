"""The experiment file of a design with several inputs and outputs."""

import numpy as np
import pytest

from compensator_theory.errors import InputError
from rcac_experiments.files._builder import build
from rcac_experiments.files._design_files import design_arguments, design_toml, save_design
from rcac_experiments.files._documents import parsed
from rcac_numeric import Step, WhiteNoise, design, exogenous, simulate
from rcac_numeric.arrays._values import equal
from rcac_numeric.designing._trials import RCAC

TWO = [["2/(10*s + 1)", "0.5/(6*s + 1)"], ["-0.4/(5*s + 1)", "1/(8*s + 1)"]]


@pytest.fixture(scope="module")
def two():
    return design(TWO, sample_time=1.0, dead_time=1.0, disturbance=Step(0.5), noise=0.01, seeds=1,
                  steps=300)  # fmt: skip


@pytest.mark.costly
def test_the_file_says_the_same(two):
    file = build(parsed(design_toml(two)), "design.toml")
    assert equal(file.runs[RCAC].settings, two.settings)
    w = exogenous([Step(0.0)] * 2 + [Step(0.5)] * 2 + [WhiteNoise(0.01)] * 2, 200, seed=5)
    ours = simulate(two.plant, file.runs["fixed"].settings, w)
    theirs = simulate(two.plant, two.fixed, w)
    assert np.allclose(ours.u, theirs.u, rtol=1e-9, atol=1e-12)


@pytest.mark.costly
def test_a_file_of_several_signals_is_read_for_a_design(two, tmp_path):
    file = tmp_path / "two.toml"
    save_design(two, file)
    arguments = design_arguments(file)
    again = design(**arguments, seeds=1, steps=100)
    assert again.expected.m == 2 and again.expected.size == two.expected.size
    assert np.allclose(again.settings.theta_0, two.settings.theta_0, rtol=1e-6, atol=1e-9)
    text = file.read_text().replace("d = [{ step = 0.5", "d = [{ step = 0.7")
    file.write_text(text)
    with pytest.raises(InputError, match="differ"):
        design_arguments(file)
