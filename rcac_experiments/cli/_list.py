"""The command `rcac list`: the examples that can be verified, and those that cannot yet."""

from __future__ import annotations

import click

from rcac_experiments.dissertation._examples import absent_examples, example_titles, in_order
from rcac_numeric.arrays._wording import printable


@click.command("list")
def list_examples() -> None:
    """List the numbered examples: what can be verified, and what cannot yet and why."""
    titles = dict(example_titles())
    absent = {number: f"(not here yet: {reason})" for number, reason in absent_examples()}
    for number, title in sorted({**titles, **absent}.items(), key=lambda item: in_order(item[0])):
        click.echo(f"{number:<5} {printable(title)}")
