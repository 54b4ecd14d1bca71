"""The command `rcac schema`."""

import json

from click.testing import CliRunner

from rcac_numeric import json_schema
from rcac_numeric.cli.main import main


def test_the_schema_is_printed_as_it_is():
    result = CliRunner().invoke(main, ["schema"])
    assert result.exit_code == 0 and json.loads(result.stdout) == json_schema()
