"""The command `rcac errata`: where the dissertation's text is wrong, and what is true."""

from __future__ import annotations

import click
import numpy as np

from rcac_numeric.cli.output import as_json_option, show
from rcac_numeric.dissertation.errata.checking import can_run, check_erratum
from rcac_numeric.dissertation.errata.reading import find_errata
from rcac_numeric.dissertation.errata.sheet import errata_sheet


@click.command("errata")
@click.argument("where", nargs=-1)
@click.option("--check", "checks", is_flag=True, help="Run the checks that show them.")
@as_json_option
def errata(where: tuple[str, ...], checks: bool, as_json: bool) -> int:
    """List where the dissertation's text is wrong, what is true, and how that is known.

    WHERE is a chapter (8, A), an equation ("(2.31)"), an example (Example 7.1), a number that
    several bear (7.1), or the name of an erratum; without it all are listed.
    """
    place = " ".join(where)
    entries = find_errata(place)
    with np.errstate(all="ignore"):
        found = {entry.name: check_erratum(entry) for entry in entries if checks and can_run(entry)}
    show(errata_sheet(entries, place, found), as_json)
    return 0 if all(checked.holds for checked in found.values()) else 1
