"""The fingerprint of a study that was saved: who changes it refuses the stores that exist."""

import pytest

from rcac_experiments.sweeps import Axis, Metric, Study


def study():
    base = {
        "plant": {"problem": "standard", "G": "1/(q - 0.9)", "sample_time": 0.1},
        "signals": {"w": {"white_noise": 1}},
        "target": {"model": "fir"},
        "controller": {"n_c": 2, "R_theta": 1e-20, "lambda": 0.99},
        "run": {"steps": 200},
    }
    return Study(
        base, [Axis("R_theta", [0.01, 1, 100], sets="controller.R_theta")], [Metric("rms")]
    )


STUDY = "3647be7414e81284"


@pytest.mark.exact_data
def test_the_fingerprint_of_a_study_is_what_it_was():
    assert study().fingerprint == STUDY
