"""The command `rcac step`: gain, time constants and dead time of a step test."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from rcac_experiments.cli._check import parse_names
from rcac_experiments.cli._exits import DONE
from rcac_experiments.cli._output import (
    as_json_option,
    log_arguments,
    log_options,
    picture_option,
    show,
    with_log,
)
from rcac_numeric.checks._logs import read_log
from rcac_numeric.identification._step_response import identify_step_response
from rcac_numeric.reports._step_response import design_command, step_response_sheet

PLACEHOLDERS = (
    "Replace SIZE by the disturbance in units of u, or unknown; LOW,HIGH by the limits of u from "
    "the operating point, or none."
)


@click.command("step")
@click.argument("file", type=click.Path(dir_okay=False, path_type=Path))
@log_options
@click.option("--sample-time", type=float, help="In seconds, if the file has no times.")
@picture_option("Draw the record with the response of the model into this file.")
@as_json_option
def step(
    *, file: Path, names: str, transpose: bool, sample_time: float | None, picture: Path | None,
    as_json: bool, **options: Any,
) -> int:  # fmt: skip
    """Identify gain, time constants and dead time in seconds from a step test in a log FILE.

    The record must begin before the first step; several steps are better than one. Intervals are
    of 95 %. The last lines are the rcac design command for the plant. The status is 1 if the record
    does not determine the plant. rcac log FILE shows which columns are u and y; --names chooses.
    """
    log = read_log(
        file, parse_names(names), transpose=transpose, sample_time=sample_time,
        **log_arguments(**options),
    )  # fmt: skip
    result = identify_step_response(log)
    show(
        with_log(step_response_sheet(result), log), as_json, picture, result.plot,
        lambda: [
            f"Next: {design_command(result)}",
            *([PLACEHOLDERS] if result.sample_time else []),
        ],
    )  # fmt: skip
    return DONE
