"""The command `rcac place`: exact pole placement on the command line."""

from __future__ import annotations

import click

import compensator_theory as exact
from rcac_numeric.cli.output import as_json_option, show
from rcac_numeric.reports.placement import placement_sheet


@click.command("place")
@click.option("--plant", required=True, help='N/D, for instance "4/((s + 1)*(s + 3))".')
@click.option(
    "--poles", required=True,
    help='The roots wanted, between commas or spaces: "-6, -5, -4, -2" or "-1+2j -1-2j".',
)  # fmt: skip
@click.option(
    "--order", "n_c", type=int, default=None,
    help="Order of the compensator; default: number of poles minus order of the plant.",
)  # fmt: skip
@click.option(
    "--feedback", type=click.Choice(["-1", "+1", "1"]), default="-1", show_default=True,
    help="-1 for u = -G_c y as in section 7.3, +1 for u = G_c y.",
)  # fmt: skip
@as_json_option
def place(plant: str, poles: str, n_c: int | None, feedback: str, as_json: bool) -> None:
    """Place closed-loop poles exactly, and say what float64 would have kept.

    Everything is a rational number: 0.1 is 1/10, and j is the imaginary unit. Where there is no
    solution the status is 2.
    """
    placement = exact.place_poles(plant, exact.read_roots(poles), n_c, feedback=int(feedback))
    show(placement_sheet(placement), as_json)
