"""Signals of experiment files are those of the library."""

import numpy as np

from rcac_experiments.files._builder import build
from rcac_numeric import FilteredCommand, Step


def test_a_file_and_its_loop_take_it_as_any_other_command():
    command = FilteredCommand(Step(), omega=0.1, zeta=1.0, rate=0.02)
    file = {
        "plant": {"problem": "servo", "G": "(q - 0.5)/((q - 0.8)*(q - 0.9))"},
        "signals": {"r": {"filtered": 1.0, "omega": 0.1, "zeta": 1.0, "rate": 0.02}},
        "target": {"model": "fir"},
        "controller": {"n_c": 2, "R_theta": 1e-3, "k_w": 20},
        "run": {"steps": 300},
    }
    (run,) = build(file, "climb").runs.values()
    recorded = run.execute().first.run
    assert np.array_equal(recorded.w[:, 0], command.samples(300))
