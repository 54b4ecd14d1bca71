"""The command `rcac schema`: by it an editor checks experiment files while they are written."""

from __future__ import annotations

import json

import click

from rcac_experiments.sweeps._files import study_schema


@click.command("schema")
def schema() -> None:
    """Print the JSON Schema of experiment files and studies, for an editor."""
    click.echo(json.dumps(study_schema(), indent=2))
