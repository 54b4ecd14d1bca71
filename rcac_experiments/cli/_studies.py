"""The commands for studies: `rcac sweep`, `rcac show`, `rcac replay` and `rcac store`."""

from __future__ import annotations

import gc
import importlib.util
import shlex
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click

from compensator_theory.errors import InputError
from rcac_experiments.cli._cases import complete_case, is_example
from rcac_experiments.cli._exits import DONE, EXIT_STATUS, NO
from rcac_experiments.cli._output import as_json_option, no_progress, picture_option, show
from rcac_experiments.dissertation._examples import example_text
from rcac_experiments.reports._studies import replay_sheet, store_sheet, sweep_sheet
from rcac_experiments.sweeps._check import check_store
from rcac_experiments.sweeps._convert import convert_store
from rcac_experiments.sweeps._export import export_table
from rcac_experiments.sweeps._files import load_study
from rcac_experiments.sweeps._overview import sweep_overview
from rcac_experiments.sweeps._progress import ProgressLine
from rcac_experiments.sweeps._replay import replay_run
from rcac_experiments.sweeps._sweep import StudyInterrupted, run_study
from rcac_numeric.arrays._frames import imported
from rcac_numeric.arrays._wording import printable, shortened

CONNECTING = 10  # seconds until a scheduler must answer


@click.command("sweep")
@click.argument("file", type=click.Path(dir_okay=False, path_type=Path))
@click.option(
    "-o", "--output", "store", required=True, type=click.Path(path_type=Path),
    help="The folder of the stored runs; it is made if it does not exist.",
)  # fmt: skip
@click.option("--workers", type=click.IntRange(0), help="Number of processes; 0: this process. "
              "Default: number of processors.")  # fmt: skip
@click.option("--yes", is_flag=True, help="Confirm more than a million runs.")
@click.option(
    "--mixed", is_flag=True, help="Continue a store of other versions or processor instructions."
)
@click.option("--scheduler", metavar="ADDRESS", default="",
              help="Address of a dask cluster to run the study.")  # fmt: skip
@click.option(
    "--time-limit", type=click.FloatRange(0, min_open=True), metavar="SECONDS",
    help="Time limit of one run; a longer run counts as failed.",
)  # fmt: skip
@click.option("--retries", type=click.IntRange(0), default=0, show_default=True,
              help="Number of immediate retries of a failed run.")  # fmt: skip
@click.option("--retry-failed", is_flag=True, help="Repeat the stored failed runs.")
@as_json_option
def sweep(
    *,
    file: Path,
    store: Path,
    workers: int | None,
    yes: bool,
    mixed: bool,
    scheduler: str,
    time_limit: float | None,
    retries: int,
    retry_failed: bool,
    as_json: bool,
) -> int:
    """Run the study FILE, a TOML file with a table [study], and store each completed run.

    After an interruption the same command continues, and repeats damaged runs. A diverged loop is a
    result. The status is 1 if a run failed (time or memory limit, lost process, exception of a
    function), or if a result has a recorded error.
    """
    study = load_study(file)
    line = ProgressLine() if sys.stderr.isatty() else None
    try:
        with _cluster(scheduler, workers) as executor:
            run_study(
                study,
                store,
                workers=workers,
                executor=executor,
                progress=line or no_progress,
                many=yes,
                mixed=mixed,
                time_limit=time_limit,
                retries=retries,
                retry_failed=retry_failed,
            )
    except KeyboardInterrupt as stopped:
        if isinstance(stopped, StudyInterrupted):
            click.echo(f"\n{stopped.done} of {stopped.total} runs are stored in {store}; the store "
                       "is intact.", err=True)  # fmt: skip
        again = shlex.join(["rcac", *sys.argv[1:]])
        gc.freeze()  # garbage collection would delay the exit
        click.echo(f"Continue with:  {printable(again)}", err=True)
        raise
    finally:
        if line is not None:
            line.end()
    overview = sweep_overview(store)
    show(sweep_sheet(overview), as_json)
    return NO if overview.errors or overview.failed else DONE


@contextmanager
def _cluster(address: str, workers: int | None) -> Iterator[Executor | None]:
    """Connect to a dask cluster; None without an address."""
    if not address:
        yield None
        return
    if workers is not None:
        raise InputError(
            "--workers counts local processes; --scheduler uses the workers of its cluster. "
            "Remove one."
        )
    distributed = imported("distributed")
    try:
        client = distributed.Client(address, timeout=CONNECTING, set_as_default=False)
    except (OSError, ValueError) as error:
        words = printable(shortened(f"{type(error).__name__}: {error}", 200))
        raise InputError(f"--scheduler {address} does not answer ({words}).") from None
    with client:
        yield client.get_executor(pure=False)


FILE = click.Path(dir_okay=False, path_type=Path)


@click.command("show")
@click.argument("what", shell_complete=complete_case)
@click.option("--by", default="", help="Axes that define the groups: R_theta,k_w. Default: all.")
@click.option("--measure", default="", help="Measure of the medians. Default: the first.")
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
    """Show the results of a study, or the TOML file of an example.

    WHAT is the number of an example (see `rcac list`), whose file is printed; or a folder written
    by `rcac sweep`, complete or still running. The options apply to a folder.

    The report gives for each group of runs the number that did not complete, with the 95 % interval
    of their share, and the median and quantiles of a measure over the completed runs.
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
            f"{number} is an example; the options of `rcac show` apply to a store. "
            f"Run the example with `rcac verify {number}`."
        )
    click.echo(example_text(number), nl=False)


@click.command("replay")
@click.argument("store", type=click.Path(path_type=Path))
@click.argument("run", type=click.IntRange(0))
@click.option(
    "--measures", "functions", type=click.Path(dir_okay=False, path_type=Path),
    help="A Python file with the functions of the study. It is executed: use only trusted files.",
)  # fmt: skip
@click.option(
    "--data", type=click.Path(file_okay=False, path_type=Path),
    help="The folder of the data files of the study.",
)  # fmt: skip
@picture_option("Draw response, poles and zeros, and the intercalated match into this file.")
@as_json_option
def replay(
    *,
    store: Path,
    run: int,
    functions: Path | None,
    data: Path | None,
    picture: Path | None,
    as_json: bool,
) -> int:
    """Repeat RUN of a STORE, bit for bit.

    A store cannot name code or files: functions of the study come from --measures, and data files
    from --data. The status is 1 if the result differs from the stored one.
    """
    measures = {} if functions is None else functions_in(functions)
    replayed = replay_run(store, run, measures, data)
    show(replay_sheet(replayed), as_json, picture, replayed.plot)
    return DONE if replayed.is_identical else NO


def functions_in(path: Path) -> dict[str, Callable[..., Any]]:
    """Execute a Python file of the command line, and return its functions by name."""
    name = f"rcac_measures_{path.stem}"
    specification = importlib.util.spec_from_file_location(name, path)
    if specification is None or specification.loader is None or not path.is_file():
        raise InputError(f"{path} must be a Python file with a name that ends in .py.")
    module = importlib.util.module_from_spec(specification)
    sys.modules[name] = module  # its dataclasses need this
    try:
        specification.loader.exec_module(module)
    except Exception as error:
        words = printable(shortened(f"{type(error).__name__}: {error}", 400))
        raise InputError(f"{path} cannot be run: {words}.") from None
    return {key: value for key, value in vars(module).items() if callable(value)}


# A former command of `rcac store`, and its replacement.
INSTEAD = {
    "repair": "`rcac sweep FILE -o FOLDER`, the command that made the store, repeats missing and "
    "damaged runs; `rcac store check FOLDER` lists them",
}


class StoreCommands(click.Group):
    """A group that names the replacement of a former command."""

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        """Resolve as click does."""
        if args[0] in INSTEAD:
            raise click.UsageError(f"There is no `rcac store {args[0]}`: {INSTEAD[args[0]]}.", ctx)
        return super().resolve_command(ctx, args)


@click.group("store", cls=StoreCommands)
def store() -> None:
    """Check the stored runs of a study, or convert an SQLite file of an earlier version."""


@store.command(epilog=EXIT_STATUS)
@click.argument("folder", type=click.Path(path_type=Path))
@as_json_option
def check(*, folder: Path, as_json: bool) -> int:
    """Compare the files of the store FOLDER with their digests and with the plan of the study.

    The status is 1 if a file is damaged. The store is not changed; `rcac sweep` repeats damaged
    runs.
    """
    report = check_store(folder)
    show(store_sheet(report), as_json)
    return DONE if report.is_whole else NO


@store.command(epilog=EXIT_STATUS)
@click.argument("old", type=click.Path(dir_okay=False, path_type=Path))
@click.option(
    "-o", "--output", "folder", required=True, type=click.Path(path_type=Path),
    help="The folder of the new store; it must be empty or not exist.",
)  # fmt: skip
@as_json_option
def convert(*, old: Path, folder: Path, as_json: bool) -> int:
    """Convert OLD, an SQLite file of an earlier version of `rcac sweep`, to a store.

    OLD is not changed. The status is 1 if some of its runs are damaged: they are omitted, and
    `rcac sweep` repeats them.
    """
    converted = convert_store(old, folder)
    show(store_sheet(converted), as_json)
    return DONE if converted.is_whole else NO
