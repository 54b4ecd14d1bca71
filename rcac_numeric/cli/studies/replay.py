"""The command `rcac replay`: one run of a study again, with all that the store did not keep."""

from __future__ import annotations

from pathlib import Path

import click

from rcac_numeric.cli.exits import DONE, NO
from rcac_numeric.cli.output import as_json_option, picture_option, show
from rcac_numeric.reports.studies.replay import replay_sheet
from rcac_numeric.sweeps.results.replay import replay_run


@click.command("replay")
@click.argument("store", type=click.Path(dir_okay=False, path_type=Path))
@click.argument("run", type=click.IntRange(0))
@picture_option("Draw response, poles and zeros, and the intercalated match into this file.")
@as_json_option
def replay(*, store: Path, run: int, picture: Path | None, as_json: bool) -> int:
    """Run RUN of a STORE again, bit for bit.

    The status is 1 where what comes out is not what is stored.
    """
    replayed = replay_run(store, run)
    show(replay_sheet(replayed), as_json, picture, replayed.plot)
    return DONE if replayed.is_identical else NO
