"""The command `rcac show`: the file of an example, or what a store holds."""

from __future__ import annotations

from pathlib import Path

import click

from compensator_theory.errors import InputError
from rcac_numeric.cli.cases import complete_case, is_example
from rcac_numeric.cli.output import as_json_option, picture_option, show
from rcac_numeric.dissertation.examples import example_text
from rcac_numeric.reports.studies.sweep import sweep_sheet
from rcac_numeric.sweeps.results.export import export_table
from rcac_numeric.sweeps.results.overview import sweep_overview

FILE = click.Path(dir_okay=False, path_type=Path)


@click.command("show")
@click.argument("what", shell_complete=complete_case)
@click.option("--by", default="", help="The axes that groups differ in: R_theta,k_w. Default: all.")
@click.option("--measure", default="", help="Of which the median is taken. Default: the first.")
@click.option("--export", type=FILE, help="Write all runs into this .csv or .parquet file.")
@picture_option("Draw shares and medians over the axes of --by, one or two, into this file.")
@as_json_option
def show_store(
    *,
    what: str,
    by: str,
    measure: str,
    export: Path | None,
    picture: Path | None,
    as_json: bool,
) -> None:
    """Show WHAT: the TOML file of an example, or what the store of a study holds.

    WHAT is the number of an example (see `rcac list`), whose file is printed as it is, ready to be
    changed; or the path of an SQLite file that `rcac sweep` wrote, whole or still growing. The
    options are those of a store.

    Of every group of runs: how many did not complete, with the 95 % interval of their share, and
    the median and quantiles of a measure over the others.
    """
    if is_example(what):
        _print_example(what, by or measure or export or picture or as_json)
        return
    store = Path(what)
    axes = tuple(name.strip() for name in by.split(",")) if by else None
    overview = sweep_overview(store, measure, axes)
    if export is not None:
        export_table(store, export)
    show(sweep_sheet(overview), as_json, picture, overview.summary.plot)


def _print_example(number: str, option: object) -> None:
    if option:
        raise InputError(
            f"{number} is an example, and the options of `rcac show` are those of a store; "
            f"`rcac verify {number}` runs it."
        )
    click.echo(example_text(number), nl=False)
