"""The command `rcac list`: the numbered examples."""

from __future__ import annotations

import click

from rcac_experiments.dissertation._examples import absent_examples, example_titles, in_order
from rcac_numeric.arrays._wording import printable


@click.command("list")
def list_examples() -> None:
    """List the numbered examples of the dissertation; a missing one has its reason."""
    titles = dict(example_titles())
    absent = {number: f"(not available: {reason})" for number, reason in absent_examples()}
    for number, title in sorted({**titles, **absent}.items(), key=lambda item: in_order(item[0])):
        click.echo(f"{number:<5} {printable(title)}")
