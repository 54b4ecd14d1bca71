"""The command `rcac verify`: run a case and compare it with the exact prediction."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path
from typing import Any

import click
import numpy as np

from compensator_theory.errors import InputError
from compensator_theory.libraries import require_library
from rcac_experiments.cli._cases import case_experiment, complete_case, is_file, values_option
from rcac_experiments.cli._output import (
    as_json_option,
    budget_option,
    no_progress,
    picture_option,
    show,
    writable,
    writable_page,
)
from rcac_experiments.dissertation._pages import example_page
from rcac_experiments.experiments._budgets import ExperimentBudget
from rcac_experiments.experiments._experiment import Verification
from rcac_experiments.experiments._experiment import verify as verified
from rcac_experiments.reports._cases import case_of, case_page
from rcac_experiments.reports._verification import verification_sheet
from rcac_numeric.arrays._files import member
from rcac_numeric.plots._formats import save
from rcac_numeric.reports._rendering import write_page


def _checked_page(context: click.Context, option: click.Parameter, value: Path | None) -> Any:
    """Check the file of --page before the computation starts."""
    if value is not None:
        require_library("matplotlib")
    return writable_page(context, option, value)


def _figures_folder(context: click.Context, option: click.Parameter, value: Path | None) -> Any:
    """Make the folder of --figures before the computation starts."""
    if value is not None:
        require_library("matplotlib")
        try:
            value.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"--figures {value} cannot be made: {error.strerror}.") from None
    return value


@click.command("verify")
@click.argument("case", shell_complete=complete_case)
@picture_option("Draw response, poles and zeros, and the intercalated match into this file.")
@click.option("--figures", "folder", type=click.Path(file_okay=False, path_type=Path),
              help="Draw the figures that the case requests into this folder.",
              callback=_figures_folder)  # fmt: skip
@click.option("--page", type=click.Path(dir_okay=False, path_type=Path),
              help="Write a web page of the case into this .html file; it works offline.",
              callback=_checked_page)  # fmt: skip
@click.option("--save", "run_file", type=click.Path(dir_okay=False, path_type=Path),
              help="Save the main run in this .npz file, for load_run and `rcac check`.",
              callback=writable(".npz"))  # fmt: skip
@values_option
@click.option("--completions", is_flag=True,
              help="Run also the other values of settings that the source leaves "
                   "open.")  # fmt: skip
@click.option("--seeds", "group", type=click.IntRange(0), metavar="GROUP",
              help="Group of test seeds, by which no setting and no bound was chosen: 0, 1, ... "
              "Default: group 0 for an example, the seeds of the file otherwise.")  # fmt: skip
@budget_option(of_runs=True)
@as_json_option
def verify(
    case: str,
    picture: Path | None,
    folder: Path | None,
    page: Path | None,
    run_file: Path | None,
    values: tuple[str, ...],
    completions: bool,
    group: int | None,
    as_json: bool,
    budget: ExperimentBudget,
) -> int:
    """Run CASE and compare it with the exact prediction.

    CASE is the number of an example (see `rcac list`) or the path of a TOML file.
    """
    with np.errstate(all="ignore"):  # an overflow is reported, without a warning of NumPy
        experiment = case_experiment(case, values, budget)
        if group is not None or not is_file(case):
            experiment = experiment.held_out(group or 0)
        if completions:
            experiment = experiment.completed()
        verification = verified(experiment, _progress if sys.stderr.isatty() else no_progress)
        if sys.stderr.isatty():
            click.echo("\r\033[K", err=True, nl=False)
        write = partial(_written, verification, folder, run_file, page, is_file(case))
        show(verification_sheet(verification), as_json, picture, verification.plot, write)
    return verification.exit_status


def _written(
    verification: Verification,
    folder: Path | None,
    run_file: Path | None,
    page: Path | None,
    is_local: bool,
) -> list[str]:
    """Write the requested files, and return one line about each."""
    written = []
    if folder is not None:
        requests = verification.figure_requests
        for number, request in enumerate(requests, 1):
            save(
                verification.plot(request),
                member(folder, f"{verification.experiment.id}-{number}.svg"),
            )
        written.append(
            f"Figures: {f'{len(requests)} in {folder}' if requests else 'none; nothing ran.'}"
        )
    if run_file is not None:
        verification.main.first.run.save(run_file)
        written.append(f"Run: {run_file}")
    if page is not None:
        write_page((case_page if is_local else example_page)(case_of(verification)), page)
        written.append(f"Page: {page}")
    return written


def _progress(name: str) -> None:
    click.echo(f"\rrunning {name} ...\033[K", err=True, nl=False)
