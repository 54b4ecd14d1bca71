"""The command `rcac sweep`: run a study into its store, or go on with it."""

from __future__ import annotations

import gc
import shlex
import sys
from pathlib import Path

import click

from rcac_numeric.arrays.wording import printable
from rcac_numeric.cli.exits import DONE, NO
from rcac_numeric.cli.output import as_json_option, show
from rcac_numeric.reports.studies.sweep import sweep_sheet
from rcac_numeric.sweeps.results.overview import sweep_overview
from rcac_numeric.sweeps.running.progress import Progress, ProgressLine
from rcac_numeric.sweeps.running.sweep import StudyInterrupted, run_study
from rcac_numeric.sweeps.study.files import load_study


@click.command("sweep")
@click.argument("file", type=click.Path(dir_okay=False, path_type=Path))
@click.option(
    "-o", "--output", "store", required=True, type=click.Path(dir_okay=False, path_type=Path),
    help="The store: an SQLite file, made where there is none.",
)  # fmt: skip
@click.option("--workers", type=click.IntRange(0), help="Processes; 0: this one alone. "
              "Default: as many as there are processors.")  # fmt: skip
@click.option("--yes", is_flag=True, help="More than a million runs are meant.")
@click.option("--mixed", is_flag=True, help="Go on although versions or instructions differ.")
@click.option(
    "--journal", type=click.Choice(["wal", "rollback"]), default="wal", show_default=True,
    help="rollback: for a store on a network file system, and one process at a time.",
)  # fmt: skip
@click.option(
    "--time-limit", type=click.FloatRange(0, min_open=True), metavar="SECONDS",
    help="What one run may take; one that takes longer has failed.",
)  # fmt: skip
@click.option("--retries", type=click.IntRange(0), default=0, show_default=True,
              help="How often a run that failed is run again at once.")  # fmt: skip
@click.option("--retry-failed", is_flag=True, help="Run those again that had failed before.")
@as_json_option
def sweep(
    *,
    file: Path,
    store: Path,
    workers: int | None,
    yes: bool,
    mixed: bool,
    journal: str,
    time_limit: float | None,
    retries: int,
    retry_failed: bool,
    as_json: bool,
) -> int:
    """Run the study FILE, a TOML file with a table [study], and store each run when it ends.

    Stopped by whatever, the same command goes on. Loops that diverge are results; where a run
    failed (time or memory ran out, its process died, a function raised), or a result has an error
    recorded, the status is 1.
    """
    study = load_study(file)
    line = ProgressLine() if sys.stderr.isatty() else None
    try:
        run_study(
            study,
            store,
            workers=workers,
            progress=line or _silence,
            many=yes,
            mixed=mixed,
            journal=journal,
            time_limit=time_limit,
            retries=retries,
            retry_failed=retry_failed,
        )
    except KeyboardInterrupt as stopped:
        if isinstance(stopped, StudyInterrupted):
            click.echo(f"\n{stopped.done} of {stopped.total} runs are stored in {store}, which is "
                       "whole.", err=True)  # fmt: skip
        again = shlex.join(["rcac", *sys.argv[1:]])
        gc.freeze()  # the process ends at once: nothing is collected on the way out
        click.echo(f"Go on with:  {printable(again)}", err=True)
        raise
    finally:
        if line is not None:
            line.end()
    overview = sweep_overview(store)
    show(sweep_sheet(overview), as_json)
    return NO if overview.errors or overview.failed else DONE


def _silence(progress: Progress) -> None:
    """Say nothing of how far it is."""
