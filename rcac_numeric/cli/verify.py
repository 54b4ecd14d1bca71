"""The command `rcac verify`: run a case and hold it against the exact prediction."""

from __future__ import annotations

import sys
from pathlib import Path

import click
import numpy as np

from rcac_numeric.cli.output import as_json_option, budget_option, picture_option, show
from rcac_numeric.experiments.budgets import Budget
from rcac_numeric.experiments.experiment import Experiment
from rcac_numeric.experiments.files.builder import load_example, load_experiment
from rcac_numeric.experiments.verdicts import verify as verified
from rcac_numeric.reports.verification import verification_sheet


@click.command("verify")
@click.argument("case")
@picture_option("Draw response, poles and zeros, and the intercalated match into this file.")
@budget_option(of_runs=True)
@as_json_option
def verify(case: str, picture: Path | None, as_json: bool, budget: Budget) -> int:
    """Run CASE and hold it against the exact prediction.

    CASE is the number of an example (see `rcac list`) or the path of a TOML file.
    """
    with np.errstate(all="ignore"):  # a loop that leaves float64 is reported, not warned of
        found = verified(_experiment(case, budget), _progress if sys.stderr.isatty() else _silence)
        if sys.stderr.isatty():
            click.echo("\r\033[K", err=True, nl=False)
        show(verification_sheet(found), as_json, picture, found.plot)
    return found.exit_status


def _experiment(case: str, budget: Budget) -> Experiment:
    is_file = case.endswith(".toml") or "/" in case or Path(case).is_file()
    return load_experiment(case, budget) if is_file else load_example(case, budget)


def _progress(name: str) -> None:
    click.echo(f"\rrunning {name} ...\033[K", err=True, nl=False)


def _silence(name: str) -> None:
    """Say nothing of what runs."""
