"""What every command does with a report: print it, as words or as JSON, and save a picture."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

from rcac_numeric.arrays import figures
from rcac_numeric.plots.formats import require_picture_format, save
from rcac_numeric.reports.json_record import as_json as json_of
from rcac_numeric.reports.sheet import Sheet
from rcac_numeric.reports.terminal import print_sheet

Command = TypeVar("Command", bound=Callable[..., Any])

as_json_option = click.option(
    "--json", "as_json", is_flag=True, help="Print one JSON object instead of a report."
)


def picture_option(what: str) -> Callable[[Command], Command]:
    """The option --plot, whose file is refused before anything long is run."""

    def checked(context: click.Context, option: click.Parameter, value: Path | None) -> Any:
        if value is not None:
            require_picture_format(value)
        return value

    kind = click.Path(dir_okay=False, path_type=Path)
    return click.option("--plot", "picture", type=kind, help=what, callback=checked)


def show(
    sheet: Sheet,
    as_json: bool,
    picture: Path | None = None,
    draw: Callable[[], figures.Figure] | None = None,
) -> None:
    """Print a report, and draw its picture where one is asked for."""
    if as_json:
        click.echo(json_of(sheet))
    else:
        print_sheet(sheet)
    if picture is None or draw is None:
        return
    save(draw(), picture)
    if not as_json:
        click.echo(f"\nPicture: {picture}")
