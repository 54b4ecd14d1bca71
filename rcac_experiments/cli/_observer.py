"""The command `rcac observer`: the observer-based forms of a compensator."""

from __future__ import annotations

import click

from compensator_theory.systems._conversions import transfer_function
from rcac_experiments.cli._output import as_json_option, budget_option, show, variable_option
from rcac_numeric.reports._observer import observer_sheet


@click.command("observer")
@click.option("--plant", required=True, help='Transfer function, for instance "4/((s+1)*(s+3))".')
@click.option("--compensator", required=True, help="G_c, a transfer function.")
@click.option(
    "--feedback", type=click.Choice(["-1", "+1"]), default="-1", show_default=True,
    help="Sign f of the loop u = f G_c y.",
)  # fmt: skip
@variable_option
@budget_option()
@as_json_option
def observer(
    plant: str, compensator: str, feedback: str, variable: str | None, as_json: bool
) -> None:
    """Test whether a compensator is observer-based, and list its observer-based forms.

    The answers are exact, and are given for three objects: the pair of polynomials as it is
    written, its transfer function, and its controllable canonical realisation.
    """
    if variable is None:
        sheet = observer_sheet(plant, compensator, int(feedback))
    else:
        G, G_c = (transfer_function(text, variable) for text in (plant, compensator))
        sheet = observer_sheet(G, G_c, int(feedback))
    show(sheet, as_json)
