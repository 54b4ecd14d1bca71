"""The command `rcac show`: what a store holds, as a report, a picture or a file."""

from __future__ import annotations

from pathlib import Path

import click

from rcac_numeric.cli.output import as_json_option, picture_option, show
from rcac_numeric.reports.studies.sweep import sweep_sheet
from rcac_numeric.sweeps.results.export import export_table
from rcac_numeric.sweeps.results.overview import sweep_overview

FILE = click.Path(dir_okay=False, path_type=Path)


@click.command("show")
@click.argument("store", type=FILE)
@click.option("--by", default="", help="The axes that groups differ in: R_theta,k_w. Default: all.")
@click.option("--measure", default="", help="Of which the median is taken. Default: the first.")
@click.option("--export", type=FILE, help="Write all runs into this .csv or .parquet file.")
@picture_option("Draw shares and medians over the axes of --by, one or two, into this file.")
@as_json_option
def show_store(
    *,
    store: Path,
    by: str,
    measure: str,
    export: Path | None,
    picture: Path | None,
    as_json: bool,
) -> None:
    """Show what the STORE of a study holds, whole or still growing.

    Of every group of runs: how many did not complete, with the 95 % interval of their share, and
    the median and quantiles of a measure over the others.
    """
    axes = tuple(name.strip() for name in by.split(",")) if by else None
    overview = sweep_overview(store, measure, axes)
    if export is not None:
        export_table(store, export)
    show(sweep_sheet(overview), as_json, picture, overview.summary.plot)
