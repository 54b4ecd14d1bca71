"""The command `rcac schema`: by it an editor checks experiment files while they are written."""

from __future__ import annotations

import json

import click

from rcac_numeric.experiments.files.schema import json_schema


@click.command("schema")
def schema() -> None:
    """Print the JSON Schema of experiment files, for an editor."""
    click.echo(json.dumps(json_schema(), indent=2))
