"""Options and output of all commands: reports, pictures, budgets."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from typing import Any, TypeVar

import click

import compensator_theory as exact
from compensator_theory import figures
from compensator_theory.errors import InputError
from rcac_experiments.experiments._budgets import ExperimentBudget
from rcac_numeric.checks._logs import ControllerLog
from rcac_numeric.plots._formats import require_picture_format, save
from rcac_numeric.reports._sheet import Block, Section, Sheet, Text
from rcac_numeric.reports._sheet import as_json as json_of
from rcac_numeric.reports._terminal import print_sheet

Command = TypeVar("Command", bound=Callable[..., Any])

LIMIT = r"[1-9]\d{0,17}(\.\d{0,17})?([eE]\+?\d{1,2})?"  # of bytes or operations

as_json_option = click.option(
    "--json", "as_json", is_flag=True, help="Print one JSON object instead of a report."
)

variable_option = click.option(
    "--variable", type=click.Choice(["s", "z", "q"]),
    help="Variable of the transfer functions, if they do not contain it.",
)  # fmt: skip


def picture_option(description: str) -> Callable[[Command], Command]:
    """The option --plot, whose file is checked before the computation starts."""

    def checked(context: click.Context, option: click.Parameter, value: Path | None) -> Any:
        if value is not None:
            require_picture_format(value)
        return value

    kind = click.Path(dir_okay=False, path_type=Path)
    return click.option("--plot", "picture", type=kind, help=description, callback=checked)


def log_options(command: Command) -> Command:
    """The options that say how a log is read: --names, --columns, --time, --resample."""
    options = (
        click.option(
            "--names", default="",
            help="Names of the columns of a log: u=input,y=output,theta=gains; u=a+b for two.",
        ),
        click.option("--columns", default="", help="Names for a table without a head: t,u,y."),
        click.option(
            "--time", help='Column of the times of a log, or "none": the rows are equal steps.'
        ),
        click.option(
            "--resample", type=float, metavar="SECONDS",
            help="Bring irregular times to steps of this distance; the report states the error.",
        ),
        click.option(
            "--transpose", is_flag=True, help="The log has one column per step, not one row."
        ),
    )  # fmt: skip
    for option in reversed(options):
        command = option(command)
    return command


def log_arguments(columns: str, time: str | None, resample: float | None) -> dict[str, Any]:
    """Return the options of a log as arguments of `read_log`."""
    names = [name.strip() for name in columns.split(",")] if columns.strip() else []
    return {"columns": names, "time": time, "resample": resample}


def with_log(sheet: Sheet, log: Any) -> Sheet:
    """Add the clock of a log, and what was done to its signals, to the report of its plant."""
    if not isinstance(log, ControllerLog) or not (log.clock or log.notes):
        return sheet
    blocks: list[Block] = [Text(f"Clock: {log.clock}")] if log.clock else []
    blocks += [Text(note, "warning") for note in log.notes]
    record = {"log": {"clock": log.clock or None, "notes": list(log.notes)}}
    return replace(sheet, sections=(*sheet.sections, Section("Log", tuple(blocks), record)))


def budget_option(*, of_runs: bool = False) -> Callable[[Command], Command]:
    """The option --budget: limits of the exact half, and with `of_runs` those of an experiment.

    The limits of the exact half hold until the command ends. The other limits are passed to the
    command as its argument `budget`.
    """
    exact_names = [field.name for field in fields(exact.Budget)]
    run_names = [field.name for field in fields(ExperimentBudget)] if of_runs else []

    def checked(context: click.Context, option: click.Parameter, text: str) -> ExperimentBudget:
        of_exact: dict[str, int] = {}
        of_run: dict[str, float] = {}
        for part in filter(None, (part.strip() for part in text.split(","))):
            name, _, value = (piece.strip() for piece in part.partition("="))
            if name not in (*exact_names, *run_names):
                raise InputError(
                    f"--budget has the entry {part!r}; write NAME=LIMIT, where NAME is one of "
                    f"{', '.join([*exact_names, *run_names])}."
                )
            if not re.fullmatch(r"[1-9]\d{0,17}" if name in exact_names else LIMIT, value):
                raise InputError(f"--budget {part}: {value!r} must be a positive number.")
            if name in exact_names:
                of_exact[name] = int(value)
            else:
                of_run[name] = float(value)
        context.with_resource(exact.budget(**of_exact))
        return ExperimentBudget(**of_run)

    example = "operations=1e13,degree=2000" if of_runs else "degree=2000,field_degree=32"
    return click.option(
        "--budget", metavar="NAME=LIMIT,...", default="", callback=checked, expose_value=of_runs,
        help=f"Raise limits, for instance {example}; errors name the limit.",
    )  # fmt: skip


def show(
    sheet: Sheet,
    as_json: bool,
    picture: Path | None = None,
    draw: Callable[[], figures.Figure] | None = None,
    write: Callable[[], list[str]] | None = None,
) -> None:
    """Print a report, draw its picture, and write other files, whose lines `write` returns.

    The files are written even if the reader closes the pipe, as ``| head`` does.
    """
    closed = None
    try:
        if as_json:
            click.echo(json_of(sheet))
        else:
            print_sheet(sheet)
    except BrokenPipeError as error:
        closed = error
    lines = []
    if picture is not None and draw is not None:
        save(draw(), picture)
        lines.append(f"Picture: {picture}")
    if write is not None:
        lines += write()
    if closed is not None:
        raise closed
    if not as_json:
        click.echo("".join(f"\n{line}\n" for line in lines), nl=False)


def writable(*suffixes: str) -> Callable[[click.Context, click.Parameter, Path | None], Any]:
    """The callback of an option whose file is checked before the computation starts."""

    def checked(context: click.Context, option: click.Parameter, value: Path | None) -> Any:
        name = option.opts[-1]
        if value is not None and value.suffix.lower() not in suffixes:
            raise InputError(f"{name} {value}: the name must end in {suffixes[0]}.")
        if value is not None and not value.parent.is_dir():
            raise InputError(f"{name} {value}: there is no folder {value.parent}.")
        return value

    return checked


writable_page = writable(".html", ".htm")


def no_progress(*progress: object) -> None:
    """Report no progress."""
