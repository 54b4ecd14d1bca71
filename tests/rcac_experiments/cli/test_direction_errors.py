"""`rcac verify` says which target model loses a zero, in its lines and in JSON."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from benchmarks.yardsticks.directed_plants import plant_of_fractions
from rcac_experiments.cli._main import main

H = np.array([[1.0, 0.5], [-0.3, 1.2]])
V = np.array([[1.0, 0.4], [0.7, 1.0]])
X = V @ np.diag([1.5, 0.3]) @ np.linalg.inv(V)
PLANT = plant_of_fractions([(0.6, 0.8), (0.6, 0.8)], H, X)


@pytest.mark.costly
def test_verify_says_it_in_its_lines_and_in_json(tmp_path):
    """A user's file whose target model is a delay and the matrix H."""
    file = tmp_path / "case.toml"
    file.write_text(
        f"""
title = "two inputs, a delay as the target"
[plant]
problem = "standard"
A = {PLANT.A.tolist()}
B = {PLANT.B.tolist()}
D_1 = {PLANT.B.tolist()}
C = {PLANT.C.tolist()}
[signals]
w = [{{ white_noise = 0.01 }}, {{ white_noise = 0.01 }}]
[target]
model = "filter"
numerator = [[[0, 0], [0, 0]], {H.tolist()}]
[controller]
structure = "iir"
n_c = 8
R_theta = 1e-3
[run]
steps = 60
"""
    )
    message = CliRunner().invoke(main, ["verify", str(file)])
    assert "Warning (unmodelled zero)" in message.output.replace("\n", " ")
    record = json.loads(CliRunner().invoke(main, ["verify", str(file), "--json"]).output)
    assert "unmodelled zero" in {warning["code"] for warning in record["warnings"]}
