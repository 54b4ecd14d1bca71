"""The command `rcac list`: the examples that can be verified."""

from __future__ import annotations

import click

from rcac_numeric.arrays.wording import printable
from rcac_numeric.experiments.files.documents import example_titles


@click.command("list")
def list_examples() -> None:
    """List the examples that can be verified."""
    for number, title in example_titles():
        click.echo(f"{number:<5} {printable(title)}")
