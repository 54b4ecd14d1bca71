"""The command `rcac check`: the analysis of a converged controller from a log."""

from __future__ import annotations

import json
import sys
import traceback
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from compensator_theory.errors import CompensatorError, InputError

if TYPE_CHECKING:
    from rcac_numeric.checks.check import ControllerCheck

KINDS = ("iir", "fir", "quasi-fir", "pid", "fir + integrator")


@click.command(
    "check",
    epilog="""
Exit status: 0 done; 1 the logged u is not the output of the logged theta or compensator; 2 bad
input; 4 a defect of rcac. An unstable loop or a theta that still moves is reported, and is no
error.
""",
)
@click.argument("log", type=click.Path(dir_okay=False, path_type=Path))
@click.option(
    "--plant",
    help="A .toml file with [plant] (its [controller] and [target] are read too), a .mat or .npz "
    'file with A, B, C, ..., or a transfer function such as "1/(q - 2)". Default: A, B, C of LOG.',
)
@click.option(
    "--problem", type=click.Choice(["standard", "servo"]), default="standard", show_default=True,
    help="What a transfer function is the plant of.",
)  # fmt: skip
@click.option(
    "--names", default="", help="What LOG calls its columns: u=input,y=output,theta=gains."
)
@click.option("--transpose", is_flag=True, help="LOG has one column, not one row, for each step.")
@click.option("--structure", type=click.Choice(KINDS), help="Of theta; default with --n-c: iir.")
@click.option("--n-c", type=int, help="Order of the controller.")
@click.option("--k-c", type=int, help="First lag of y: 1 by default, 0 for an exactly proper one.")
@click.option("--k-w", type=int, help="First step at which u came from theta.")
@click.option("--target", help='G_f, for instance "1/q".')
@click.option(
    "--noise", default="", help="Variances for the H2 cost: d=1,v=0.25. Default: 1 for all of w."
)
@click.option("--sample-time", type=float, help="In seconds, for the delay margin in time.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object instead of a report.")
@click.option(
    "--plot", "picture", type=click.Path(dir_okay=False, path_type=Path),
    help="Draw signals, coefficients, poles, match and Nyquist curve into this file.",
)  # fmt: skip
def check_command(picture: Path | None, as_json: bool, **options: Any) -> None:
    """Check the controller that a LOG (.csv, .mat, .npz) ended with.

    LOG holds u and y, and where there are any z, w and r, one row for each step; and theta (its
    rows over time, or the last one), or the polynomials D_c and N_c.
    """
    import numpy as np

    try:
        with np.errstate(all="ignore"):  # what leaves float64 is reported, not warned of
            check = _check(picture, **options)
            _show(check, as_json, picture)
    except CompensatorError as error:
        click.echo(f"rcac: {error}", err=True)
        sys.exit(2)
    except Exception:  # never let a defect of ours look like a finding
        traceback.print_exc()
        click.echo("rcac: this is a defect of rcac itself; please report it.", err=True)
        sys.exit(4)
    sys.exit(0 if check.is_consistent else 1)


def _check(
    picture: Path | None,
    *,
    log: Path,
    plant: str | None,
    problem: str,
    names: str,
    transpose: bool,
    structure: str | None,
    n_c: int | None,
    k_c: int | None,
    k_w: int | None,
    target: str | None,
    noise: str,
    sample_time: float | None,
) -> ControllerCheck:
    # Imported here, after the command line is known to be right: they take most of a second.
    from rcac_numeric.checks.check import check_controller
    from rcac_numeric.checks.logs import read_log
    from rcac_numeric.cli.check_inputs import (
        parse_names,
        parse_noise,
        plant_in,
        read_case,
        read_structure,
        read_target,
    )
    from rcac_numeric.plots.formats import require_picture_format
    from rcac_numeric.signals.data_files import read_variables

    if picture is not None:
        require_picture_format(picture)
    recorded = read_log(log, parse_names(names), transpose=transpose)
    model, table = read_case(plant, problem)
    if model is None and log.suffix.lower() != ".csv":
        model = plant_in(read_variables(log), str(log))
    widths = (recorded.u.shape[1], recorded.y.shape[1])
    if k_w is None and isinstance(table.get("controller"), dict):
        k_w = table["controller"].get("k_w")
    made = read_structure(table, model, kind=structure, n_c=n_c, k_c=k_c, widths=widths)
    if recorded.theta is not None and made is None and recorded.D_c is None:
        raise InputError(
            f"{log}: theta has {recorded.theta.shape[-1]} coefficients; say which structure they "
            f"belong to. For --structure iir, {sum(widths)} coefficients go with each order: "
            f"--n-c {max(recorded.theta.shape[-1] // (widths[0] * sum(widths)), 1)}?"
        )
    return check_controller(
        recorded,
        structure=made,
        plant=model,
        target=read_target(table, model, target),
        noise=parse_noise(noise),
        k_w=k_w,
        sample_time=sample_time,
    )


def _show(check: ControllerCheck, as_json: bool, picture: Path | None) -> None:
    from rcac_numeric.reports.check import print_check
    from rcac_numeric.reports.check_record import as_dict

    if as_json:
        click.echo(json.dumps(as_dict(check), indent=2, allow_nan=False))
    else:
        print_check(check)
    if picture is None:
        return
    try:
        check.plot().savefig(picture, dpi=130)
    except OSError as error:
        raise InputError(f"--plot {picture} cannot be written: {error.strerror}.") from None
    if not as_json:
        click.echo(f"\nPicture: {picture}")
