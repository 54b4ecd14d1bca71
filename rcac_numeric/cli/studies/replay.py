"""The command `rcac replay`: one run of a study again, with all that the store did not keep."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from compensator_theory.errors import InputError
from rcac_numeric.arrays.wording import printable, shortened
from rcac_numeric.cli.exits import DONE, NO
from rcac_numeric.cli.output import as_json_option, picture_option, show
from rcac_numeric.reports.studies.replay import replay_sheet
from rcac_numeric.sweeps.results.replay import replay_run


@click.command("replay")
@click.argument("store", type=click.Path(dir_okay=False, path_type=Path))
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
