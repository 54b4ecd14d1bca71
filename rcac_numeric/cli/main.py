"""The command `rcac`: list the examples, verify one of them or a case of one's own."""

from __future__ import annotations

import json
import sys
import traceback
from pathlib import Path
from typing import TYPE_CHECKING

import click

from compensator_theory.errors import CompensatorError, InputError
from rcac_numeric.cli.check import check_command
from rcac_numeric.cli.observer import observer_command
from rcac_numeric.cli.place import place

if TYPE_CHECKING:
    from rcac_numeric.experiments.verdicts import Verification

EXIT_STATUS = """
Exit status: 0 done, and every verdict of record holds; 1 a verdict has changed; 2 bad input;
3 a loop diverged unexpectedly, which goes before 1 (what came before it is kept and drawn); 4 a
defect of rcac.
"""


@click.group(epilog=EXIT_STATUS)
@click.version_option(package_name="compensator-theory", prog_name="rcac")
def main() -> None:
    """Retrospective cost adaptive control, held against exact compensator theory."""


main.add_command(check_command)
main.add_command(observer_command)
main.add_command(place)


@main.command("list")
def list_command() -> None:
    """List the examples that can be verified."""
    from rcac_numeric.experiments.files.documents import example_titles

    for number, title in example_titles():
        click.echo(f"{number:<5} {title}")


@main.command(epilog=EXIT_STATUS)
@click.argument("case")
@click.option(
    "--plot", "picture", type=click.Path(dir_okay=False, path_type=Path),
    help="Draw response, poles and zeros, and the intercalated match into this file.",
)  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object instead of a report.")
def verify(case: str, picture: Path | None, as_json: bool) -> None:
    """Run CASE and hold it against the exact prediction.

    CASE is the number of an example (see `rcac list`) or the path of a TOML file.
    """
    import numpy as np

    try:
        with np.errstate(all="ignore"):  # a loop that leaves float64 is reported, not warned of
            status = _verify(case, picture, as_json)
    except CompensatorError as error:
        click.echo(f"rcac: {error}", err=True)
        status = 2
    except Exception:  # never let a defect of ours look like a changed verdict
        traceback.print_exc()
        click.echo("rcac: this is a defect of rcac itself; please report it.", err=True)
        status = 4
    sys.exit(status)


def _verify(case: str, picture: Path | None, as_json: bool) -> int:
    # Imported here, after the command line is known to be right: NumPy, SciPy and SymPy take
    # most of a second to load.
    from rcac_numeric.experiments.files.builder import load_example, load_experiment
    from rcac_numeric.experiments.verdicts import verify
    from rcac_numeric.plots.formats import require_picture_format

    if picture is not None:
        require_picture_format(picture)
    is_file = case.endswith(".toml") or "/" in case or Path(case).is_file()
    experiment = load_experiment(case) if is_file else load_example(case)
    interactive = sys.stderr.isatty()
    verification = verify(
        experiment, lambda name: click.echo(f"\rrunning {name} ...\033[K", err=True, nl=False)
        if interactive else None
    )  # fmt: skip
    if interactive:
        click.echo("\r\033[K", err=True, nl=False)
    if as_json:
        from rcac_numeric.reports.verification import as_dict

        click.echo(json.dumps(as_dict(verification), indent=2))
    else:
        from rcac_numeric.reports.verification import print_report

        print_report(verification)
    if picture is not None:
        _draw(verification, picture)
        if not as_json:
            click.echo(f"\nPicture: {picture}")
    return verification.exit_status


def _draw(verification: Verification, picture: Path) -> None:
    from rcac_numeric.plots.run import plot_sheet

    experiment = verification.experiment
    title = f"{experiment.id}: {experiment.title}".strip(": ")
    try:
        plot_sheet(verification.main.first, title).savefig(picture, dpi=130)
    except OSError as error:
        raise InputError(f"--plot {picture} cannot be written: {error.strerror}.") from None
