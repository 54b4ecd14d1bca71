"""Runs of every kind that examples have come back from their files bit for bit."""

import numpy as np
import pytest

from rcac_experiments.dissertation import load_example
from rcac_numeric import load_run

SPECIFICATIONS = {
    (number, name): spec
    for number in ("2.4", "2.6", "2.7", "4.7", "5.2", "5.6")
    for name, spec in load_example(number).reduced(1).runs.items()
    if not spec.reference
}


@pytest.mark.costly
@pytest.mark.cases(15)
@pytest.mark.parametrize("of", SPECIFICATIONS, ids=str)
def test_every_kind_of_run_comes_back_bit_for_bit(of, tmp_path):
    """Schedules, saturations, several controllers, fixed ones, divergences."""
    with np.errstate(all="ignore"):
        run = SPECIFICATIONS[of].execute().first.run
    run.save(tmp_path / "run.npz")
    again = load_run(tmp_path / "run.npz")
    assert again == run
    for name in ("u", "y", "z", "w", "theta", "theta_final", "u_applied"):
        assert getattr(again, name).tobytes() == getattr(run, name).tobytes()
