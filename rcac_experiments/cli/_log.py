"""The command `rcac log`: the contents of a log."""

from __future__ import annotations

from pathlib import Path

import click

from compensator_theory.errors import CompensatorError
from rcac_experiments.cli._check import parse_names
from rcac_experiments.cli._exits import DONE, NO, at_the_shell
from rcac_experiments.cli._output import as_json_option, log_arguments, show
from rcac_numeric.arrays._values import replaced
from rcac_numeric.checks._logs import read_log
from rcac_numeric.reports._log import log_sheet
from rcac_numeric.signals._log_signals import inspect_log


@click.command("log")
@click.argument("file", type=click.Path(dir_okay=False, path_type=Path))
@click.option("--names", default="", help="Names of the columns: u=input,y=output,theta=gains.")
@click.option("--columns", default="", help="Names for a table without a head: t,u,y.")
@click.option("--time", help='The column of the times, or "none".')
@as_json_option
def log(*, file: Path, names: str, columns: str, time: str | None, as_json: bool) -> int:
    """Show the columns of a log FILE, its clock, and what rcac check and rcac design use of it.

    Text (.csv, .txt, .tsv, .dat, also .gz), .mat, .npz and .npy; with the extra logs also .mat of
    version 7.3, .h5, .parquet, .ulg and .xlsx. The report gives units, types, missing entries and
    the rounding of every column, and the sample time with jitter, gaps, repeated and turning
    stamps. The status is 1 if rcac check and rcac design would refuse the log.
    """
    options = {"columns": log_arguments(columns, time, None)["columns"], "time": time}
    contents = inspect_log(file, parse_names(names), **options)
    try:
        read_log(file, parse_names(names), **options).longest_part()
    except CompensatorError as error:  # in the words of a shell
        contents = replaced(contents, unread=error.message_for(at_the_shell))
    show(log_sheet(contents), as_json)
    return NO if contents.unread else DONE
