"""The commands `rcac store check` and `rcac store repair`."""

from __future__ import annotations

from pathlib import Path

import click

from rcac_numeric.cli.exits import DONE, EXIT_STATUS, NO
from rcac_numeric.cli.output import as_json_option, show
from rcac_numeric.reports.studies.store import store_sheet
from rcac_numeric.sweeps.store.care import check_store, repair_store

FILE = click.argument("file", type=click.Path(dir_okay=False, path_type=Path))


@click.group("store")
def store() -> None:
    """Check the store of a study, or repair it."""


@store.command(epilog=EXIT_STATUS)
@FILE
@as_json_option
def check(*, file: Path, as_json: bool) -> int:
    """Hold everything in the store FILE against its digests and its plan.

    The status is 1 where something is damaged. Nothing is changed.
    """
    found = check_store(file)
    show(store_sheet(found), as_json)
    return DONE if found.is_whole else NO


@store.command(epilog=EXIT_STATUS)
@FILE
@as_json_option
def repair(*, file: Path, as_json: bool) -> int:
    """Keep what is right in the store FILE, so that `rcac sweep` runs the rest again.

    The damaged file stays beside it, its name followed by .damaged.
    """
    show(store_sheet(repair_store(file)), as_json)
    return DONE
