"""The cases of a command line, their changed values, and shell completion."""

from __future__ import annotations

import difflib
import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import click
from click.shell_completion import CompletionItem

from compensator_theory.errors import InputError
from rcac_experiments.dissertation._examples import example_ids, example_titles, read_example
from rcac_experiments.dissertation._load import load_example
from rcac_experiments.experiments._budgets import ExperimentBudget
from rcac_experiments.experiments._experiment import Experiment
from rcac_experiments.files._builder import build, load_experiment
from rcac_experiments.files._documents import Raw, read_file
from rcac_experiments.files._schema import json_schema
from rcac_experiments.sweeps._study import with_value

values_option = click.option(
    "--set", "values", multiple=True, metavar="KEY=VALUE",
    shell_complete=lambda context, parameter, incomplete: complete_key(incomplete),
    help="Change a value, written as in TOML: --set controller.R_theta=1e-6. Repeatable.",
)  # fmt: skip


def is_file(case: str) -> bool:
    """Return whether a case is the path of a file, and not the number of an example.

    Examples
    --------
    >>> from rcac_experiments.cli._cases import is_file
    >>> is_file("4.7"), is_file("boost.toml")
    (False, True)
    """
    return case.endswith(".toml") or "/" in case or Path(case).is_file()


def read_case_table(case: str) -> tuple[Raw, str]:
    """Return the tables of a case and the name of its file."""
    return read_file(case) if is_file(case) else read_example(case)


def case_experiment(case: str, values: Sequence[str], budget: ExperimentBudget) -> Experiment:
    """Return the experiment of a case, with changed values if there are any."""
    if values:
        table, file = read_case_table(case)
        return build(with_values(table, values), file, budget)
    return load_experiment(case, budget) if is_file(case) else load_example(case, budget)


def with_values(table: Mapping[str, Any], values: Sequence[str]) -> Raw:
    """Change values of tables, and remove verdicts of record, which hold for the old values.

    Examples
    --------
    >>> from rcac_experiments.cli._cases import with_values
    >>> with_values({"controller": {"R_theta": 1, "n_c": 2}}, ["controller.R_theta=1e-6"])
    {'controller': {'R_theta': 1e-06, 'n_c': 2}}
    """
    changed = dict(table)
    for text in values:
        key, equals, value = text.partition("=")
        if not equals or not key.strip():
            raise InputError(f"--set {text}: write KEY=VALUE, such as controller.R_theta=1e-6.")
        typed = _typed(text, value.strip())
        try:
            changed = with_value(changed, key.strip(), typed)
        except InputError as error:
            hint = _full_key(key.strip(), value, changed)
            raise InputError(f"--set {text}: ", *error.args, hint) from None
    if "claims" in changed and isinstance(changed["claims"], list):
        changed["claims"] = [
            {k: v for k, v in claim.items() if k != "verdict"} if isinstance(claim, dict) else claim
            for claim in changed["claims"]
        ]
    return changed


def _full_key(key: str, value: str, table: Raw) -> str:
    """Propose full keys with a similar last part; keys of the file first."""
    known = [name for name, _ in known_keys() if name.partition(".")[0] in table]
    ends = {name.rpartition(".")[2] for name in known}
    close = difflib.get_close_matches(key.rpartition(".")[2][:80], sorted(ends), n=1, cutoff=0.8)
    matches = [name for name in known if close and name.endswith(f".{close[0]}")]
    in_use = [name for name in matches if _is_set(table, name)]
    proposals = [f"--set {name}={value.strip()[:80]}" for name in in_use or matches[:3]]
    return f" Did you mean {' or '.join(proposals)}?" if proposals else ""


def _is_set(table: Raw, name: str) -> bool:
    first, _, rest = name.partition(".")
    around = table.get(first)
    return isinstance(around, dict) and rest in around


def _typed(text: str, value: str) -> Any:
    try:
        read = tomllib.loads(f"value = {value}")
    except (ValueError, RecursionError) as error:
        quoted = f" Text needs quotes: --set '{text.partition('=')[0]}=\"{value}\"'."
        hint = quoted if re.fullmatch(r"[\w .,+*/()^-]+", value) else ""
        raise InputError(f"--set {text}: {value!r} must be a TOML value ({error}).{hint}") from None
    if list(read) != ["value"]:
        raise InputError(f"--set {text} must have one value.")
    return read["value"]


def complete_case(
    context: click.Context, parameter: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Complete the numbers of examples, with their titles, or the names of files."""
    cases = [
        CompletionItem(number, help=title)
        for number, title in example_titles()
        if number.startswith(incomplete)
    ]
    return cases or [CompletionItem(incomplete, type="file")]


def complete_key(incomplete: str) -> list[CompletionItem]:
    """Complete the keys of an experiment file, with their descriptions."""
    return [
        CompletionItem(f"{key}=", help=words)
        for key, words in known_keys()
        if key.startswith(incomplete)
    ]


def known_keys() -> Iterator[tuple[str, str]]:
    """Yield the dotted keys of an experiment file, with their descriptions."""
    for name, table in json_schema()["properties"].items():
        for key, entry in table.get("properties", {}).items():
            yield f"{name}.{key}", str(entry.get("description", "")).partition(".")[0]


def is_example(name: str) -> bool:
    """Return whether this is the number of an example and no local file has that name."""
    looks_like = re.fullmatch(r"(\d|[A-Z])\.\d{1,2}", name)
    return not Path(name).exists() and (name in example_ids() or bool(looks_like))
