"""The commands about studies: `rcac sweep`, `rcac show`, `rcac replay` and `rcac store`."""

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
from rcac_experiments.cli._output import as_json_option, picture_option, show, silence
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

CONNECTING = 10  # seconds that a scheduler has to answer


@click.command("sweep")
@click.argument("file", type=click.Path(dir_okay=False, path_type=Path))
@click.option(
    "-o", "--output", "store", required=True, type=click.Path(path_type=Path),
    help="The store: a folder, made where there is none.",
)  # fmt: skip
@click.option("--workers", type=click.IntRange(0), help="Processes; 0: this one alone. "
              "Default: as many as there are processors.")  # fmt: skip
@click.option("--yes", is_flag=True, help="More than a million runs are meant.")
@click.option("--mixed", is_flag=True, help="Go on although versions or instructions differ.")
@click.option("--scheduler", metavar="ADDRESS", default="",
              help="Of a dask cluster, whose workers run the study.")  # fmt: skip
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
    scheduler: str,
    time_limit: float | None,
    retries: int,
    retry_failed: bool,
    as_json: bool,
) -> int:
    """Run the study FILE, a TOML file with a table [study], and store each run when it ends.

    Stopped by whatever, the same command goes on, and computes again what is damaged. Loops that
    diverge are results; where a run failed (time or memory ran out, its process died, a function
    raised), or a result has an error recorded, the status is 1.
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
                progress=line or silence,
                many=yes,
                mixed=mixed,
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


@contextmanager
def _cluster(address: str, workers: int | None) -> Iterator[Executor | None]:
    """The executor of a dask cluster; None without an address."""
    if not address:
        yield None
        return
    if workers is not None:
        raise InputError("--workers are processes of this machine; the scheduler has its own.")
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
    changed; or the path of a folder that `rcac sweep` wrote, whole or still growing. The options
    are those of a store.

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


@click.command("replay")
@click.argument("store", type=click.Path(path_type=Path))
@click.argument("run", type=click.IntRange(0))
@click.option(
    "--measures", "functions", type=click.Path(dir_okay=False, path_type=Path),
    help="A Python file with the functions of the study. It is run: give only one that you trust.",
)  # fmt: skip
@click.option(
    "--data", type=click.Path(file_okay=False, path_type=Path),
    help="The folder of the data files that the study names.",
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
    """Run RUN of a STORE again, bit for bit.

    A store chooses no code and no files: functions of its own study come from --measures, and data
    files from --data. The status is 1 where what comes out is not what is stored.
    """
    measures = {} if functions is None else functions_in(functions)
    replayed = replay_run(store, run, measures, data)
    show(replay_sheet(replayed), as_json, picture, replayed.plot)
    return DONE if replayed.is_identical else NO


def functions_in(path: Path) -> dict[str, Callable[..., Any]]:
    """What a Python file that somebody named on the command line calls by a name; it is run."""
    name = f"rcac_measures_{path.stem}"
    specification = importlib.util.spec_from_file_location(name, path)
    if specification is None or specification.loader is None or not path.is_file():
        raise InputError(f"{path} is no file of Python; its name must end in .py.")
    module = importlib.util.module_from_spec(specification)
    sys.modules[name] = module  # dataclasses of it look there
    try:
        specification.loader.exec_module(module)
    except Exception as error:
        words = printable(shortened(f"{type(error).__name__}: {error}", 400))
        raise InputError(f"{path} cannot be run: {words}.") from None
    return {key: value for key, value in vars(module).items() if callable(value)}


# A word that was a command of `rcac store`, and what is given in its place.
INSTEAD = {
    "repair": "`rcac sweep FILE -o FOLDER`, the command that made the store, computes again what "
    "is missing or damaged in it; `rcac store check FOLDER` names that",
}


class StoreCommands(click.Group):
    """A group that says of an earlier command what does its work now."""

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        """As click does it."""
        if args[0] in INSTEAD:
            raise click.UsageError(f"There is no `rcac store {args[0]}`: {INSTEAD[args[0]]}.", ctx)
        return super().resolve_command(ctx, args)


@click.group("store", cls=StoreCommands)
def store() -> None:
    """Check the store of a study, or make one of an SQLite file of an earlier version."""


@store.command(epilog=EXIT_STATUS)
@click.argument("folder", type=click.Path(path_type=Path))
@as_json_option
def check(*, folder: Path, as_json: bool) -> int:
    """Hold everything in the store FOLDER against its digests and its plan.

    The status is 1 where something is damaged. Nothing is changed; `rcac sweep` computes again what
    is damaged.
    """
    report = check_store(folder)
    show(store_sheet(report), as_json)
    return DONE if report.is_whole else NO


@store.command(epilog=EXIT_STATUS)
@click.argument("old", type=click.Path(dir_okay=False, path_type=Path))
@click.option(
    "-o", "--output", "folder", required=True, type=click.Path(path_type=Path),
    help="The store that is made: a folder that is not there, or an empty one.",
)  # fmt: skip
@as_json_option
def convert(*, old: Path, folder: Path, as_json: bool) -> int:
    """Make a store of OLD, an SQLite file that `rcac sweep` of an earlier version wrote.

    OLD is read only. The status is 1 where some of its runs are not what was stored: they are left
    out, and `rcac sweep` computes them.
    """
    converted = convert_store(old, folder)
    show(store_sheet(converted), as_json)
    return DONE if converted.is_whole else NO
