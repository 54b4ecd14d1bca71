"""The command `rcac schema`: the format of experiment files, for editors."""

from __future__ import annotations

import json

import click

from rcac_numeric.experiments.files.schema import json_schema


@click.command("schema")
def schema() -> None:
    """Print the JSON Schema of experiment files.

    An editor that knows it completes keys and marks misspelt ones while a file is written; for
    instance Even Better TOML in VS Code, or taplo, by a first line `#:schema rcac.schema.json`.
    """
    click.echo(json.dumps(json_schema(), indent=2))
