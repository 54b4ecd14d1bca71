"""The command `rcac schema`: the JSON Schema by which an editor checks experiment files."""

from __future__ import annotations

import json

import click

from rcac_experiments.sweeps._files import study_schema


@click.command("schema")
def schema() -> None:
    """Print the JSON Schema of experiment files and studies, by which an editor checks them."""
    click.echo(json.dumps(study_schema(), indent=2))
