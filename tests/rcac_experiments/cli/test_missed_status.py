"""The exit status of `rcac check` where poles are reached, and where they are missed."""

import pytest
from click.testing import CliRunner

from rcac_experiments.cli._exits import DONE, MISSED
from rcac_experiments.cli._main import main
from tests.support.placed_loops import delayed_run


@pytest.mark.costly
@pytest.mark.parametrize(("case", "status"), [({}, DONE), ({"R_theta": 1e4, "steps": 300}, MISSED)])
def test_it_goes_by_the_backward_error(tmp_path, case, status):
    """Six poles at 0 and 1/2: RCAC matches its target to 1e-5, and a pole is off by 0.2."""
    file = tmp_path / "run.npz"
    delayed_run(**case).save(file)
    result = CliRunner().invoke(main, ["check", str(file)])
    assert result.exit_code == status, result.output
    assert ("NOT reached" in result.output) == (status == MISSED)
