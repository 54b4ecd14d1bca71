"""The command `rcac schema`."""

import json

from click.testing import CliRunner

from rcac_experiments.cli._main import main
from rcac_experiments.sweeps._files import study_schema


def test_the_schema_is_printed_as_it_is():
    result = CliRunner().invoke(main, ["schema"])
    assert result.exit_code == 0 and json.loads(result.stdout) == study_schema()
